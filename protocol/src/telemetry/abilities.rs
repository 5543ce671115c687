//! Line I: the abilities of a robot that implements a part of the protocol.
//!
//! ```text
//! 1-3  5-6 8     10-12    14-22     24-27   29-33 35                       70-74 75-78
//! I02  07  3     040      PR.X.....  B.S.   00240 2                        BH5*' ^*"+
//! seq  id  level capacity modes     measured rate fields                   ack   CRC
//! ```

use super::columns::Columns;
use super::fields::{Fields, Parsed, Read, digits, robot_id, spaces};
use crate::status_codes::{Mode, status_codes};
use crate::{BYTES_PER_S, WAYPOINTS_MAX};
use nom::Parser;
use nom::character::complete::one_of;
use nom::combinator::verify;

/// Maximum number of a robot's own fields; line V has room for nine values.
pub const FIELDS_MAX: u8 = 9;

/// Highest level.
pub const LEVEL_MAX: u8 = 5;

/// Minimum rate, bytes per second.
pub const RATE_MIN_BYTES_PER_S: u32 = 30;

const RATE_MAX_BYTES_PER_S: u32 = 99_999;

status_codes! {
    /// A reading of lines A and B that a robot may lack.
    Reading {
        /// Battery, in line B.
        Battery = b'B',
        /// Wheel speeds, in line A.
        Wheels = b'W',
        /// Sonars, in line A.
        Sonars = b'S',
        /// `max_count` of infrared, in line B.
        MaxCount = b'I',
    }
}

/// Line I. A robot that sends no line I has the abilities [`Self::FULL`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct AbilitiesLine {
    /// Id of the robot, 1 to 99.
    pub robot_id: u8,
    /// Level of the robot, 1 to [`LEVEL_MAX`] (SPEC.md section 1).
    pub level: u8,
    /// Maximum number of waypoints in a list, up to [`WAYPOINTS_MAX`]; 0 for a robot without lists.
    pub capacity: u16,
    /// The modes that the robot has; bit *n* is the *n*-th of [`Mode::ALL`].
    pub modes: u16,
    /// The readings that the robot measures; bit *n* is the *n*-th of [`Reading::ALL`].
    pub measured: u8,
    /// Maximum rate at which the robot accepts bytes, bytes per second.
    pub rate_bytes_per_s: u32,
    /// Number of the robot's own fields, up to [`FIELDS_MAX`].
    pub fields: u8,
}

impl AbilitiesLine {
    /// All abilities of the protocol, at 2400 baud.
    pub const FULL: Self = Self {
        robot_id: 1,
        level: LEVEL_MAX,
        capacity: WAYPOINTS_MAX as u16,
        modes: (1 << Mode::ALL.len()) - 1,
        measured: (1 << Reading::ALL.len()) - 1,
        rate_bytes_per_s: BYTES_PER_S,
        fields: 0,
    };

    /// Whether the robot has the mode.
    #[must_use]
    pub fn has_mode(&self, mode: Mode) -> bool {
        holds(Mode::ALL, self.modes, &mode)
    }

    /// Whether the robot measures the reading.
    #[must_use]
    pub fn measures(&self, reading: Reading) -> bool {
        holds(Reading::ALL, u16::from(self.measured), &reading)
    }

    pub(super) fn write(&self, columns: &mut Columns) {
        columns.digits(5, 2, u32::from(self.robot_id.max(1)));
        columns.digits(8, 1, u32::from(self.level.clamp(1, LEVEL_MAX)));
        let capacity = u32::from(self.capacity).min(WAYPOINTS_MAX as u32);
        columns.digits(10, 3, capacity);
        for (bit, mode) in Mode::ALL.iter().enumerate() {
            columns.letter(14 + bit, letter_or_point(self.modes, bit, mode.letter()));
        }
        for (bit, reading) in Reading::ALL.iter().enumerate() {
            let letter = letter_or_point(self.measured.into(), bit, reading.letter());
            columns.letter(24 + bit, letter);
        }
        let rate = self.rate_bytes_per_s;
        columns.digits(
            29,
            5,
            rate.clamp(RATE_MIN_BYTES_PER_S, RATE_MAX_BYTES_PER_S),
        );
        columns.digits(35, 1, u32::from(self.fields.min(FIELDS_MAX)));
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let level = verify(digits::<1, u8>, |level| (1..=LEVEL_MAX).contains(level));
        let capacity = verify(digits::<3, u16>, |&count| count <= WAYPOINTS_MAX as u16);
        let rate = verify(digits::<5, u32>, |&rate| rate >= RATE_MIN_BYTES_PER_S);
        let abilities = Self {
            robot_id: line.field(robot_id)?,
            level: line.field(level)?,
            capacity: line.field(capacity)?,
            modes: line
                .fields(|input| letters(input, Mode::ALL.iter().map(|mode| mode.letter())))?,
            measured: line
                .fields(|input| letters(input, Reading::ALL.iter().map(|it| it.letter())))?
                as u8,
            rate_bytes_per_s: line.field(rate)?,
            fields: line.field(digits::<1, u8>)?,
        };
        line.next(spaces::<33>)?;
        Ok(abilities)
    }
}

fn holds<T: PartialEq>(all: &[T], bits: u16, one: &T) -> bool {
    let bit = all.iter().position(|other| other == one);
    bit.is_some_and(|bit| bits >> bit & 1 == 1)
}

const fn letter_or_point(bits: u16, bit: usize, letter: u8) -> u8 {
    if bits >> bit & 1 == 1 { letter } else { b'.' }
}

/// Parses a column for each letter, with the letter or a full stop; bit *n* of the result is the *n*-th letter.
fn letters(mut input: &[u8], letters: impl Iterator<Item = u8>) -> Parsed<'_, u16> {
    let mut bits = 0;
    for (bit, letter) in letters.enumerate() {
        let found;
        (input, found) = one_of(&[b'.', letter][..]).parse(input)?;
        bits |= u16::from(found != '.') << bit;
    }
    Ok((input, bits))
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn abilities() -> impl Strategy<Value = AbilitiesLine> {
        let sets = (
            0..=AbilitiesLine::FULL.modes,
            0..=AbilitiesLine::FULL.measured,
        );
        let rate = RATE_MIN_BYTES_PER_S..=RATE_MAX_BYTES_PER_S;
        let numbers = (1..=99_u8, 1..=LEVEL_MAX, 0..=300_u16, rate, 0..=FIELDS_MAX);
        (numbers, sets).prop_map(
            |((robot_id, level, capacity, rate_bytes_per_s, fields), (modes, measured))| {
                AbilitiesLine {
                    robot_id,
                    level,
                    capacity,
                    modes,
                    measured,
                    rate_bytes_per_s,
                    fields,
                }
            },
        )
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(line in abilities()) {
            prop_assert_eq!(read_back(Body::Abilities(line)), Body::Abilities(line));
        }

        #[test]
        fn any_value_makes_a_readable_line(
            (robot_id, level, capacity) in any::<(u8, u8, u16)>(),
            (modes, measured, rate_bytes_per_s, fields) in any::<(u16, u8, u32, u8)>(),
        ) {
            read_back(Body::Abilities(AbilitiesLine {
                robot_id, level, capacity, modes, measured, rate_bytes_per_s, fields,
            }));
        }

        #[test]
        fn readable_lines_have_one_form(line in abilities(), edits in edits()) {
            has_one_form(Body::Abilities(line), &edits);
        }
    }

    #[test]
    fn modes_and_readings_are_identified_by_their_letters() {
        let line = AbilitiesLine {
            modes: 0b1001,
            measured: 0b10,
            ..AbilitiesLine::FULL
        };
        let fitted = Mode::ALL.iter().filter(|mode| line.has_mode(**mode));
        assert!(fitted.eq(&[Mode::Prowl, Mode::Stop]));
        assert!(line.measures(Reading::Wheels) && !line.measures(Reading::Battery));
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let bad: &[(usize, &[u8], u8)] = &[
            (5, b"00", 5),
            (8, b"0", 8),
            (8, b"6", 8),
            (9, b"x", 9),
            (10, b"301", 10),
            (10, b" 40", 10),
            (14, b"p", 14),
            (15, b"P", 15),
            (22, b" ", 22),
            (24, b"W", 24),
            (27, b"-", 27),
            (29, b"00029", 29),
            (29, b"0024x", 29),
            (35, b"-", 35),
            (36, b"0", 36),
            (69, b"x", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::Abilities(AbilitiesLine::FULL), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
