//! Line P: a parameter with its limits and unit; the ground needs no table of parameters.
//!
//! ```text
//! 1-3  5-9   11-28              30-35  37-42  44-49  51-56  58-68        70-74 75-78
//! P48  01/26 top-speed          +00008 +00012 +00002 +00012 in/s         BH5*' ^*"+
//! seq  place name               value  kept   least  most   unit         ack   CRC
//! ```

use super::Printable;
use super::columns::Columns;
use super::fields::{Fields, Read, character, digits, signed};
use crate::parameter::{self, NAME_BYTES, PARAMETERS_MAX, UNIT_BYTES};
use nom::Parser;
use nom::combinator::verify;
use nom::sequence::separated_pair;

/// Line P.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterLine {
    /// Number of the parameter in the robot's table, from 1.
    pub place: u8,
    /// Number of parameters in the table, at most [`PARAMETERS_MAX`].
    pub count: u8,
    /// Name of the parameter.
    pub name: ParameterName,
    /// Current value.
    pub value: i32,
    /// Value after a reset.
    pub kept: i32,
    /// Minimum value that the robot accepts.
    pub least: i32,
    /// Maximum value that the robot accepts.
    pub most: i32,
    /// Unit of the values.
    pub unit: Printable<UNIT_BYTES>,
}

/// A parameter's name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ParameterName(pub(super) Printable<NAME_BYTES>);

impl ParameterName {
    /// Makes a name from `name`, cut to [`NAME_BYTES`], with a hyphen for each invalid byte; an empty name becomes one hyphen.
    #[must_use]
    pub fn new(name: &str) -> Self {
        let mut bytes = [b' '; NAME_BYTES];
        let given = if name.is_empty() { "-" } else { name };
        for (to, from) in bytes.iter_mut().zip(given.bytes()) {
            *to = if parameter::is_name_byte(from) {
                from
            } else {
                b'-'
            };
        }
        Self(Printable::from_bytes(&bytes))
    }

    /// The name.
    #[must_use]
    pub fn as_str(&self) -> &str {
        self.0.as_str()
    }

    pub(super) fn write(&self, columns: &mut Columns, column: usize) {
        self.0.write(columns, column);
    }
}

impl ParameterLine {
    pub(super) fn write(&self, columns: &mut Columns) {
        let place = self.place.clamp(1, PARAMETERS_MAX);
        columns.digits(5, 2, u32::from(place));
        columns.letter(7, b'/');
        columns.digits(8, 2, u32::from(self.count.max(place)));
        self.name.write(columns, 11);
        columns.signed(30, 6, self.value);
        columns.signed(37, 6, self.kept);
        columns.signed(44, 6, self.least);
        columns.signed(51, 6, self.most);
        self.unit.write(columns, 58);
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let place = separated_pair(digits::<2, u8>, character(b'/'), digits::<2, u8>);
        let (place, count) =
            line.field(verify(place, |&(place, count)| 0 < place && place <= count))?;
        let name = verify(Printable::parse, |name| parameter::is_name(name.as_str()));
        Ok(Self {
            place,
            count,
            name: line.field(name.map(ParameterName))?,
            value: line.field(signed(digits::<5, i32>))?,
            kept: line.field(signed(digits::<5, i32>))?,
            least: line.field(signed(digits::<5, i32>))?,
            most: line.field(signed(digits::<5, i32>))?,
            unit: line.fields(Printable::parse)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn parameter() -> impl Strategy<Value = ParameterLine> {
        let value = || -99_999..=99_999_i32;
        (
            (1..=99_u8, 0..99_u8),
            "[a-z0-9-]{1,18}",
            (value(), value(), value(), value()),
            "[ -~]{0,11}",
        )
            .prop_map(|((place, more), name, (value, kept, least, most), unit)| {
                ParameterLine {
                    place,
                    count: place.saturating_add(more).min(PARAMETERS_MAX),
                    name: ParameterName::new(&name),
                    value,
                    kept,
                    least,
                    most,
                    unit: Printable::new(&unit),
                }
            })
    }

    fn blank() -> ParameterLine {
        ParameterLine {
            place: 1,
            count: 26,
            name: ParameterName::new("top-speed"),
            value: 8,
            kept: 12,
            least: 2,
            most: 12,
            unit: Printable::new("in/s"),
        }
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(line in parameter()) {
            prop_assert_eq!(read_back(Body::Parameter(line)), Body::Parameter(line));
        }

        #[test]
        fn any_value_makes_a_readable_line(
            place: u8, count: u8, name in "\\PC*", value: i32, kept: i32, unit in "\\PC*",
        ) {
            let (name, unit) = (ParameterName::new(&name), Printable::new(&unit));
            read_back(Body::Parameter(ParameterLine {
                place, count, name, value, kept, unit, least: i32::MIN, most: i32::MAX,
            }));
        }

        #[test]
        fn readable_lines_have_one_form(line in parameter(), edits in edits()) {
            has_one_form(Body::Parameter(line), &edits);
        }
    }

    #[test]
    fn values_beyond_their_field_saturate() {
        let line = ParameterLine {
            place: 0,
            count: 0,
            name: ParameterName::new("Top speed of all the wheels"),
            value: 100_000,
            kept: i32::MIN,
            ..blank()
        };
        let expected = ParameterLine {
            place: 1,
            count: 1,
            name: ParameterName::new("-op-speed-of-all-t"),
            value: 99_999,
            kept: -99_999,
            ..blank()
        };
        assert_eq!(read_back(Body::Parameter(line)), Body::Parameter(expected));
        assert_eq!(ParameterName::new("").as_str(), "-");
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let bad: &[(usize, &[u8], u8)] = &[
            (4, b"x", 4),
            (5, b"00/26", 5),
            (5, b"27/26", 5),
            (5, b"01.26", 5),
            (5, b"01/x6", 5),
            (10, b"0", 10),
            (11, b" ", 11),
            (11, b"T", 11),
            (14, b" ", 11),
            (11, b"                  ", 11),
            (29, b"x", 29),
            (30, b"000008", 30),
            (30, b"-00000", 30),
            (37, b"------", 37),
            (44, b" +0002", 44),
            (51, b"+0001x", 51),
            (57, b"i", 57),
            (60, b"\x07", 60),
            (69, b"x", 69),
        ];
        for &(column, characters, column_blamed) in bad {
            let said = blamed(Body::Parameter(blank()), column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
