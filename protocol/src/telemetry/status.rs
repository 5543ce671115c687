//! Line B: battery, target, route and settings.
//!
//! ```text
//! 1-3  5-6 8-11  13-17 19-23 25-31   33-38  40-41 43-45 47-49 51-58    60-62 64-65  70-74 75-78
//! B47  07  12.4  +0120 -0036 003/040 "Q8.Z` 12    155   122   UB.IS..D 004   00     !5:HS ^*"+
//! seq  id  volts target X Y  list    digest max   photo L R   layers   boots odom.  ack   CRC
//!                                           count                            resets
//! ```

use super::columns::Columns;
use super::fields::{
    Fields, Parsed, Read, character, digits, optional, robot_id, signed, sixbits, spaces,
};
use crate::status_codes::{Layer, LayerMask};
use nom::Parser;
use nom::bytes::complete::tag;
use nom::character::complete::one_of;
use nom::combinator::{peek, verify};
use nom::sequence::{preceded, separated_pair};

/// Line B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusLine {
    /// Id of the robot, 1 to 99.
    pub robot_id: u8,
    /// Battery voltage, tenths of a volt, up to 999.
    pub battery_dv: u16,
    /// X and Y of the robot's target, inches; `None` if there is none (0, 0 is home).
    pub target_in: Option<(i16, i16)>,
    /// Progress in the active list.
    pub list: ListPlace,
    /// [`crate::digest::digest`] of the active list.
    pub digest: u32,
    /// The infrared layer's current `max_count`, 0 to 99.
    pub max_count: u8,
    /// Left photocell, 0 very bright to 255 dark; `None` when not fitted.
    pub photo_left: Option<u8>,
    /// Right photocell, 0 very bright to 255 dark; `None` when not fitted.
    pub photo_right: Option<u8>,
    /// Layers that are fitted.
    pub fitted: LayerMask,
    /// Fitted layers that the operator allows.
    pub allowed: LayerMask,
    /// Boot counter, modulo 1000.
    pub boots: u16,
    /// Odometer resets since boot, modulo 100.
    pub odometer_resets: u8,
}

/// Progress in the active list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListPlace {
    /// Number of waypoints reached.
    pub driven: u16,
    /// Number of waypoints in the list.
    pub count: u16,
}

impl StatusLine {
    pub(super) fn write(&self, columns: &mut Columns) {
        columns.digits(5, 2, u32::from(self.robot_id.max(1)));
        let battery_dv = u32::from(self.battery_dv.min(999));
        columns.digits(8, 2, battery_dv / 10);
        columns.letter(10, b'.');
        columns.digits(11, 1, battery_dv % 10);
        if let Some((x_in, y_in)) = self.target_in {
            columns.signed(13, 5, i32::from(x_in));
            columns.signed(19, 5, i32::from(y_in));
        } else {
            columns.optional(13, 5, None);
            columns.optional(19, 5, None);
        }
        columns.digits(25, 3, u32::from(self.list.driven.min(self.list.count)));
        columns.letter(28, b'/');
        columns.digits(29, 3, u32::from(self.list.count));
        columns.sixbit(33, 6, self.digest);
        columns.digits(40, 2, u32::from(self.max_count));
        columns.optional(43, 3, self.photo_left.map(u32::from));
        columns.optional(47, 3, self.photo_right.map(u32::from));
        for (column, layer) in (51..).zip(Layer::ALL) {
            columns.letter(
                column,
                if self.allowed.and(self.fitted).contains(layer) {
                    layer.letter()
                } else if self.fitted.contains(layer) {
                    b'-'
                } else {
                    b'.'
                },
            );
        }
        columns.digits(60, 3, u32::from(self.boots % 1000));
        columns.digits(64, 2, u32::from(self.odometer_resets % 100));
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let volts = separated_pair(digits::<2, u16>, character(b'.'), digits::<1, u16>);
        let list = separated_pair(digits::<3, u16>, character(b'/'), digits::<3, u16>);
        let list = list.map(|(driven, count)| ListPlace { driven, count });
        let at_most_32_bits = peek(one_of("`!\"#"));

        let robot_id = line.field(robot_id)?;
        let battery_dv = line.field(volts.map(|(volts, tenths)| volts * 10 + tenths))?;
        let target_in = read_target(line)?;
        let list = line.field(verify(list, |list| list.driven <= list.count))?;
        let digest = line.field(preceded(at_most_32_bits, sixbits::<6, u32>))?;
        let max_count = line.field(digits::<2, u8>)?;
        let photo_left = line.field(optional(b"---", digits::<3, u8>))?;
        let photo_right = line.field(optional(b"---", digits::<3, u8>))?;
        let (fitted, allowed) = line.fields(layers)?;
        let boots = line.field(digits::<3, u16>)?;
        let odometer_resets = line.field(digits::<2, u8>)?;
        line.next(spaces::<3>)?;
        Ok(Self {
            robot_id,
            battery_dv,
            target_in,
            list,
            digest,
            max_count,
            photo_left,
            photo_right,
            fitted,
            allowed,
            boots,
            odometer_resets,
        })
    }
}

/// Reads X and Y; both or neither are hyphens.
fn read_target(line: &mut Fields) -> Read<Option<(i16, i16)>> {
    let Some(x_in) = line.field(optional(b"-----", signed(digits::<4, i16>)))? else {
        line.field(tag("-----"))?;
        return Ok(None);
    };
    Ok(Some((x_in, line.field(signed(digits::<4, i16>))?)))
}

/// Parses a letter for each layer; returns the fitted layers and the allowed ones.
fn layers(mut input: &[u8]) -> Parsed<'_, (LayerMask, LayerMask)> {
    let (mut fitted, mut allowed) = (LayerMask::NONE, LayerMask::NONE);
    for layer in Layer::ALL {
        let found;
        (input, found) = one_of(&[b'.', b'-', layer.letter()][..]).parse(input)?;
        if found != '.' {
            fitted = fitted.with(layer);
        }
        if found != '.' && found != '-' {
            allowed = allowed.with(layer);
        }
    }
    Ok((input, (fitted, allowed)))
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn status(wild: bool) -> impl Strategy<Value = StatusLine> {
        let upto = move |tame: u16, most: u16| 0..=if wild { most } else { tame };
        let target = if wild { i16::MAX } else { 9999 };
        let place = (upto(999, u16::MAX), upto(999, u16::MAX)).prop_map(move |(driven, count)| {
            if wild || driven <= count {
                ListPlace { driven, count }
            } else {
                ListPlace {
                    driven: count,
                    count: driven,
                }
            }
        });
        (
            (
                upto(98, 254),
                upto(999, u16::MAX),
                prop::option::of((-target..=target, -target..=target)),
            ),
            (
                place,
                any::<u32>(),
                upto(99, 255),
                prop::option::of(any::<u8>()),
                prop::option::of(any::<u8>()),
            ),
            (any::<u8>(), any::<u8>(), upto(999, u16::MAX), upto(99, 255)),
        )
            .prop_map(
                move |(
                    (robot_id, battery_dv, target_in),
                    (list, digest, max_count, photo_left, photo_right),
                    (fitted, allowed, boots, odometer_resets),
                )| {
                    StatusLine {
                        robot_id: if wild { robot_id } else { robot_id + 1 } as u8,
                        battery_dv,
                        target_in,
                        list,
                        digest,
                        max_count: max_count as u8,
                        photo_left,
                        photo_right,
                        fitted: LayerMask::from_bits(fitted),
                        allowed: LayerMask::from_bits(if wild {
                            allowed
                        } else {
                            allowed & fitted
                        }),
                        boots,
                        odometer_resets: odometer_resets as u8,
                    }
                },
            )
    }

    fn blank() -> StatusLine {
        StatusLine {
            robot_id: 7,
            battery_dv: 124,
            target_in: None,
            list: ListPlace::default(),
            digest: 0,
            max_count: 12,
            photo_left: None,
            photo_right: None,
            fitted: LayerMask::ALL,
            allowed: LayerMask::ALL,
            boots: 4,
            odometer_resets: 0,
        }
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(line in status(false)) {
            prop_assert_eq!(read_back(Body::Status(line)), Body::Status(line));
        }

        #[test]
        fn any_value_makes_a_readable_line(line in status(true)) {
            read_back(Body::Status(line));
        }

        #[test]
        fn readable_lines_have_one_form(line in status(false), edits in edits()) {
            has_one_form(Body::Status(line), &edits);
        }
    }

    #[test]
    fn values_beyond_their_field_saturate_and_counters_wrap() {
        let line = StatusLine {
            robot_id: 0,
            battery_dv: 1000,
            target_in: Some((i16::MIN, i16::MAX)),
            list: ListPlace {
                driven: 7,
                count: 5,
            },
            max_count: 100,
            fitted: LayerMask::from_bits(0b11),
            allowed: LayerMask::from_bits(0b110),
            boots: 1003,
            odometer_resets: 101,
            ..blank()
        };
        let expected = StatusLine {
            robot_id: 1,
            battery_dv: 999,
            target_in: Some((-9999, 9999)),
            list: ListPlace {
                driven: 5,
                count: 5,
            },
            max_count: 99,
            fitted: LayerMask::from_bits(0b11),
            allowed: LayerMask::from_bits(0b10),
            boots: 3,
            odometer_resets: 1,
            ..blank()
        };
        assert_eq!(read_back(Body::Status(line)), Body::Status(expected));
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let bad: &[(usize, &[u8], u8)] = &[
            (5, b"00", 5),
            (5, b" 7", 5),
            (8, b"12,4", 8),
            (8, b"1x.4", 8),
            (8, b"12.x", 8),
            (13, b"----0", 13),
            (13, b"-0000", 13),
            (13, b"+0000", 19),
            (19, b"+0000", 19),
            (25, b"001/000", 25),
            (25, b"000-000", 25),
            (25, b"000/00x", 25),
            (33, b"$`````", 33),
            (33, b"~`````", 33),
            (35, b" ", 33),
            (40, b"-1", 40),
            (43, b"256", 43),
            (47, b"999", 47),
            (47, b"--0", 47),
            (51, b"b", 51),
            (52, b"U", 52),
            (58, b"d", 58),
            (60, b"00x", 60),
            (64, b"--", 64),
            (66, b"x", 66),
            (69, b"x", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::Status(blank()), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
