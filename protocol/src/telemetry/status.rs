//! Line B: what the robot is set to do.
//!
//! ```text
//! 1-3  5-6 8-11  13-17 19-23 25-31   33-38  40-41 43-45 47-49 51-58    60-62 64-65  70-74 75-78
//! B47  07  12.4  +0120 -0036 003/040 "Q8.Z` 12    155   122   UB.IS..D 004   00     !5:HS ^*"+
//! seq  id  volts target X Y  list    digest max   photo L R   layers   boots odom.  ack   CRC
//!                                           count                            resets
//! ```

use super::FieldError;
use super::columns::{Columns, Fields, bad};
use crate::letters::{Layer, LayerMask};

/// Line B.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StatusLine {
    /// 1 to 99.
    pub robot_id: u8,
    /// Battery voltage in tenths of a volt, to 999.
    pub battery_dv: u16,
    /// The point being driven to, whole inches; `None` when there is none (0, 0 is home).
    pub target_in: Option<(i16, i16)>,
    /// Place in the active list.
    pub list: ListPlace,
    /// [`crate::digest::digest`] of the active list.
    pub digest: u32,
    /// The infrared layer's present `max_count`, 0 to 99.
    pub max_count: u8,
    /// Left photocell, 0 very bright to 255 dark; `None` when not fitted.
    pub photo_left: Option<u8>,
    /// Right photocell, 0 very bright to 255 dark; `None` when not fitted.
    pub photo_right: Option<u8>,
    /// Layers this firmware has.
    pub fitted: LayerMask,
    /// Layers the operator allows, among those fitted.
    pub allowed: LayerMask,
    /// Boot counter, modulo 1000.
    pub boots: u16,
    /// Odometer resets since boot, modulo 100.
    pub odometer_resets: u8,
}

/// How far the active list has been driven.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ListPlace {
    /// Waypoints reached.
    pub driven: u16,
    /// Waypoints in the list.
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

    pub(super) fn read(c: &Fields) -> Result<Self, FieldError> {
        c.spaces(&[4, 7, 12, 18, 24, 32, 39, 42, 46, 50, 59, 63, 66, 67, 68, 69])?;
        let robot_id = c.number::<2>(5)? as u8;
        if robot_id == 0 {
            return Err(bad(5));
        }
        let target_in = if c.at(13)? == *b"-----" {
            if c.at(19)? != *b"-----" {
                return Err(bad(19));
            }
            None
        } else {
            Some((
                c.signed_number::<4>(13)? as i16,
                c.signed_number::<4>(19)? as i16,
            ))
        };
        let (volts, tenths) = c.pair::<2, 1>(8, b'.')?;
        let (driven, count) = c.pair::<3, 3>(25, b'/')?;
        if driven > count {
            return Err(bad(25));
        }
        let (fitted, allowed) = read_layers(c)?;
        Ok(Self {
            robot_id,
            battery_dv: (volts * 10 + tenths) as u16,
            target_in,
            list: ListPlace {
                driven: driven as u16,
                count: count as u16,
            },
            digest: read_digest(c)?,
            max_count: c.number::<2>(40)? as u8,
            photo_left: read_byte(c, 43)?,
            photo_right: read_byte(c, 47)?,
            fitted,
            allowed,
            boots: c.number::<3>(60)? as u16,
            odometer_resets: c.number::<2>(64)? as u8,
        })
    }
}

/// Six characters hold 36 bits; a digest has 32.
fn read_digest(c: &Fields) -> Result<u32, FieldError> {
    if c.sixbit_number::<1>(33)? > 3 {
        return Err(bad(33));
    }
    c.sixbit_number::<6>(33)
}

fn read_byte(c: &Fields, column: usize) -> Result<Option<u8>, FieldError> {
    match c.maybe_number::<3>(column)? {
        Some(value) => u8::try_from(value).map(Some).map_err(|_| bad(column)),
        None => Ok(None),
    }
}

fn read_layers(c: &Fields) -> Result<(LayerMask, LayerMask), FieldError> {
    let letters: [u8; 8] = c.at(51)?;
    let (mut fitted, mut allowed) = (LayerMask::NONE, LayerMask::NONE);
    for (i, (letter, layer)) in letters.into_iter().zip(Layer::ALL).enumerate() {
        match letter {
            b'.' => {}
            b'-' => fitted = fitted.with(layer),
            _ if letter == layer.letter() => {
                fitted = fitted.with(layer);
                allowed = allowed.with(layer);
            }
            _ => return Err(bad(51 + i)),
        }
    }
    Ok((fitted, allowed))
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
        fn what_is_in_range_is_read_as_it_was_written(line in status(false)) {
            prop_assert_eq!(read_back(Body::Status(line)), Body::Status(line));
        }

        #[test]
        fn whatever_the_robot_holds_can_be_read(line in status(true)) {
            read_back(Body::Status(line));
        }

        #[test]
        fn every_reading_has_one_form(line in status(false), edits in edits()) {
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
