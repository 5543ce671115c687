//! Line C: the robot's id, version and counters.
//!
//! ```text
//! 1-3  5-6 8-13   15-17 19-23 25-42              44-46 48-50 52-54 56-59 61-64 66 70-74 75-78
//! C53  07  000412 004   01.00 `````3`````V*4``,0 133   002   000   0012  0030  G  !5:HS ^*"+
//! seq  id  uptime boots vers. ticks won          heard bad   late  bumps failsafe ack   CRC
//! ```
//!
//! Ticks won (in which a holder controlled the motors): two 6-bit characters for each of [`HOLDERS`] holders.

use super::columns::Columns;
use super::fields::{
    Fields, Read, character, digits, each, letter, optional, robot_id, sixbits, spaces,
};
use crate::failsafe::{Failsafe, SILENCE_MAX_S, SILENCE_MIN_S};
use crate::status_codes::Mode;
use nom::Parser;
use nom::combinator::verify;
use nom::sequence::separated_pair;

/// Number of holders of the motors: layers 0 to 7 and prowl.
pub const HOLDERS: usize = 9;

/// Line C.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CountersLine {
    /// Id of the robot, 1 to 99.
    pub robot_id: u8,
    /// Time since boot by the robot's clock, seconds, modulo 1,000,000.
    pub uptime_s: u32,
    /// Boot counter, modulo 1000.
    pub boots: u16,
    /// Firmware version.
    pub version: FirmwareVersion,
    /// Number of ticks since boot in which each of layers 0 to 7 and prowl controlled the motors, modulo 4096.
    pub ticks_won: [u16; HOLDERS],
    /// Number of intact frames received since boot, modulo 1000.
    pub frames_heard: u16,
    /// Number of frames rejected since boot, modulo 1000.
    pub frames_rejected: u16,
    /// Number of ticks that began late since boot, modulo 1000.
    pub ticks_late: u16,
    /// Bumper contacts since boot, modulo 10,000.
    pub bumps: u16,
    /// Failsafe against a silent ground; `None` if it is off.
    pub failsafe: Option<Failsafe>,
}

/// Version of the robot's program, two numbers of two digits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FirmwareVersion {
    /// First number of the version; increases when the robot's behaviour changes for the operator.
    pub major: u8,
    /// Second number of the version; increases with every other change.
    pub minor: u8,
}

impl CountersLine {
    pub(super) fn write(&self, columns: &mut Columns) {
        columns.digits(5, 2, u32::from(self.robot_id.max(1)));
        columns.digits(8, 6, self.uptime_s % 1_000_000);
        columns.digits(15, 3, u32::from(self.boots % 1000));
        columns.digits(19, 2, u32::from(self.version.major));
        columns.letter(21, b'.');
        columns.digits(22, 2, u32::from(self.version.minor));
        for (i, &ticks) in self.ticks_won.iter().enumerate() {
            columns.sixbit(25 + 2 * i, 2, u32::from(ticks % 4096));
        }
        columns.digits(44, 3, u32::from(self.frames_heard % 1000));
        columns.digits(48, 3, u32::from(self.frames_rejected % 1000));
        columns.digits(52, 3, u32::from(self.ticks_late % 1000));
        columns.digits(56, 4, u32::from(self.bumps % 10_000));
        let failsafe = self.failsafe.filter(Failsafe::is_valid);
        columns.optional(61, 4, failsafe.map(|failsafe| failsafe.silence_s.into()));
        columns.letter(66, failsafe.map_or(b'-', |failsafe| failsafe.mode.letter()));
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let version = separated_pair(digits::<2, u8>, character(b'.'), digits::<2, u8>);
        let counters = Self {
            robot_id: line.field(robot_id)?,
            uptime_s: line.field(digits::<6, u32>)?,
            boots: line.field(digits::<3, u16>)?,
            version: line.field(version.map(|(major, minor)| FirmwareVersion { major, minor }))?,
            ticks_won: line.fields(each(sixbits::<2, u16>))?,
            frames_heard: line.field(digits::<3, u16>)?,
            frames_rejected: line.field(digits::<3, u16>)?,
            ticks_late: line.field(digits::<3, u16>)?,
            bumps: line.field(digits::<4, u16>)?,
            failsafe: read_failsafe(line)?,
        };
        line.next(spaces::<2>)?;
        Ok(counters)
    }
}

/// Reads silence and mode; both or neither are hyphens.
fn read_failsafe(line: &mut Fields) -> Read<Option<Failsafe>> {
    let silence_s = verify(digits::<4, u16>, |silence_s| {
        (SILENCE_MIN_S..=SILENCE_MAX_S).contains(silence_s)
    });
    let Some(silence_s) = line.field(optional(b"----", silence_s))? else {
        line.field(character(b'-'))?;
        return Ok(None);
    };
    let failsafe = letter(Mode::from_letter).map(|mode| Failsafe { silence_s, mode });
    line.field(verify(failsafe, Failsafe::is_valid)).map(Some)
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn counters(wild: bool) -> impl Strategy<Value = CountersLine> {
        let upto = move |tame: u16| 0..=if wild { u16::MAX } else { tame };
        let uptime = 0..=if wild { u32::MAX } else { 999_999 };
        (
            (upto(98), uptime, upto(999), upto(99), upto(99)),
            prop::array::uniform9(upto(4095)),
            (upto(999), upto(999), upto(999), upto(9999)),
            failsafe(wild),
        )
            .prop_map(
                move |(
                    (robot_id, uptime_s, boots, major, minor),
                    ticks_won,
                    (frames_heard, frames_rejected, ticks_late, bumps),
                    failsafe,
                )| CountersLine {
                    robot_id: (if wild { robot_id } else { robot_id + 1 }) as u8,
                    uptime_s,
                    boots,
                    version: FirmwareVersion {
                        major: major as u8,
                        minor: minor as u8,
                    },
                    ticks_won,
                    frames_heard,
                    frames_rejected,
                    ticks_late,
                    bumps,
                    failsafe,
                },
            )
    }

    fn failsafe(wild: bool) -> impl Strategy<Value = Option<Failsafe>> {
        let any = (any::<u16>(), prop::sample::select(Mode::ALL));
        let any = any.prop_map(|(silence_s, mode)| Failsafe { silence_s, mode });
        prop::option::of(any)
            .prop_map(move |failsafe| failsafe.filter(|failsafe| wild || failsafe.is_valid()))
    }

    fn blank() -> CountersLine {
        CountersLine {
            robot_id: 7,
            uptime_s: 412,
            boots: 4,
            version: FirmwareVersion { major: 1, minor: 0 },
            ticks_won: [0; HOLDERS],
            frames_heard: 133,
            frames_rejected: 2,
            ticks_late: 0,
            bumps: 12,
            failsafe: Some(Failsafe {
                silence_s: 30,
                mode: Mode::GoHome,
            }),
        }
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(line in counters(false)) {
            prop_assert_eq!(read_back(Body::Counters(line)), Body::Counters(line));
        }

        #[test]
        fn any_value_makes_a_readable_line(line in counters(true)) {
            read_back(Body::Counters(line));
        }

        #[test]
        fn readable_lines_have_one_form(line in counters(false), edits in edits()) {
            has_one_form(Body::Counters(line), &edits);
        }
    }

    #[test]
    fn counters_wrap_and_identities_saturate() {
        let line = CountersLine {
            robot_id: 100,
            uptime_s: 1_000_007,
            boots: 2001,
            version: FirmwareVersion {
                major: 100,
                minor: 255,
            },
            ticks_won: [4097; HOLDERS],
            frames_heard: 1001,
            frames_rejected: 65_000,
            ticks_late: 1000,
            bumps: 10_001,
            failsafe: Some(Failsafe {
                silence_s: 9,
                mode: Mode::Stop,
            }),
        };
        let expected = CountersLine {
            robot_id: 99,
            uptime_s: 7,
            boots: 1,
            version: FirmwareVersion {
                major: 99,
                minor: 99,
            },
            ticks_won: [1; HOLDERS],
            frames_heard: 1,
            frames_rejected: 0,
            ticks_late: 0,
            bumps: 1,
            failsafe: None,
        };
        assert_eq!(read_back(Body::Counters(line)), Body::Counters(expected));
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let bad: &[(usize, &[u8], u8)] = &[
            (5, b"00", 5),
            (8, b"00041x", 8),
            (8, b"------", 8),
            (15, b"+04", 15),
            (19, b"01,00", 19),
            (19, b"0x.00", 19),
            (19, b"01.0x", 19),
            (25, b" `", 25),
            (41, b"`a", 41),
            (44, b"1 3", 44),
            (48, b"-02", 48),
            (52, b"  0", 52),
            (56, b"001x", 56),
            (60, b"0", 60),
            (61, b"0009", 61),
            (61, b"3x00", 61),
            (61, b"----", 66),
            (66, b"-", 66),
            (66, b"U", 66),
            (66, b"?", 66),
            (67, b"0", 67),
            (69, b"x", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::Counters(blank()), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
