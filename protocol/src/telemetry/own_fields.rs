//! Lines F and V: a robot's own fields, each described by a line F, and their values.
//!
//! ```text
//! 1-3  5-7   9-26               28       30-40                             70-74 75-78
//! F03  1/2   motor-current      2        A                                 BH5*' ^*"+
//! seq  place name               decimals unit                              ack   CRC
//!
//! 1-3  5-10   12-17  19-24  ..  61-66
//! V04  +00125 ------ ------ ..  ------
//! seq  value of field 1, 2, 3, .. 9
//! ```

use super::columns::Columns;
use super::fields::{Fields, Read, character, digits, optional, signed, spaces};
use super::{FIELDS_MAX, ParameterName, Printable};
use crate::parameter::{self, UNIT_BYTES, VALUE_MAX};
use nom::Parser;
use nom::combinator::verify;
use nom::sequence::separated_pair;

/// Maximum number of digits after the decimal point of a field's values.
pub const DECIMALS_MAX: u8 = 5;

const VALUES: usize = FIELDS_MAX as usize;

/// Internal value for a missing value (hyphens on the wire).
const NO_VALUE: i32 = i32::MIN;

/// Line F.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldLine {
    /// Number of the field in line V, from 1.
    pub place: u8,
    /// Total number of fields, up to [`FIELDS_MAX`].
    pub count: u8,
    /// Name of the field.
    pub name: ParameterName,
    /// Number of digits after the decimal point of its values, up to [`DECIMALS_MAX`].
    pub decimals: u8,
    /// Unit of the field.
    pub unit: Printable<UNIT_BYTES>,
}

impl FieldLine {
    pub(super) fn write(&self, columns: &mut Columns) {
        let place = self.place.clamp(1, FIELDS_MAX);
        columns.digits(5, 1, u32::from(place));
        columns.letter(6, b'/');
        columns.digits(7, 1, u32::from(self.count.clamp(place, FIELDS_MAX)));
        self.name.write(columns, 9);
        columns.digits(28, 1, u32::from(self.decimals.min(DECIMALS_MAX)));
        self.unit.write(columns, 30);
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let place = separated_pair(digits::<1, u8>, character(b'/'), digits::<1, u8>);
        let (place, count) =
            line.field(verify(place, |&(place, count)| 0 < place && place <= count))?;
        let name = verify(Printable::parse, |name| parameter::is_name(name.as_str()));
        let decimals = verify(digits::<1, u8>, |&decimals| decimals <= DECIMALS_MAX);
        let field = Self {
            place,
            count,
            name: line.field(name.map(ParameterName))?,
            decimals: line.field(decimals)?,
            unit: line.fields(Printable::parse)?,
        };
        line.next(spaces::<28>)?;
        Ok(field)
    }
}

/// Line V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ValuesLine([i32; VALUES]);

impl ValuesLine {
    /// A line with these values. Values beyond the ninth are left out, and large values saturate.
    #[must_use]
    pub fn new(values: impl IntoIterator<Item = Option<i32>>) -> Self {
        let mut line = Self([NO_VALUE; VALUES]);
        for (to, value) in line.0.iter_mut().zip(values) {
            *to = value.map_or(NO_VALUE, |value| value.clamp(-VALUE_MAX, VALUE_MAX));
        }
        line
    }

    /// The value of each field, in units of its last decimal place.
    pub fn values(&self) -> impl Iterator<Item = Option<i32>> + '_ {
        self.0
            .iter()
            .map(|&value| (value != NO_VALUE).then_some(value))
    }

    pub(super) fn write(&self, columns: &mut Columns) {
        for (column, value) in (5..).step_by(7).zip(self.values()) {
            match value {
                Some(value) => columns.signed(column, 6, value),
                None => columns.optional(column, 6, None),
            }
        }
    }

    pub(super) fn read(line: &mut Fields) -> Read<Self> {
        let mut values = Self([NO_VALUE; VALUES]);
        for to in &mut values.0 {
            let value = line.field(optional(b"------", signed(digits::<5, i32>)))?;
            *to = value.unwrap_or(NO_VALUE);
        }
        line.next(spaces::<2>)?;
        Ok(values)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Body;
    use super::super::testing::{blamed, edits, has_one_form, read_back};
    use super::*;
    use proptest::prelude::*;

    fn field() -> impl Strategy<Value = FieldLine> {
        let place = (1..=FIELDS_MAX, 0..FIELDS_MAX);
        (place, "[a-z0-9-]{1,18}", 0..=DECIMALS_MAX, "[ -~]{0,11}").prop_map(
            |((place, more), name, decimals, unit)| FieldLine {
                place,
                count: place.saturating_add(more).min(FIELDS_MAX),
                name: ParameterName::new(&name),
                decimals,
                unit: Printable::new(&unit),
            },
        )
    }

    fn values() -> impl Strategy<Value = ValuesLine> {
        let value = prop::option::of(-VALUE_MAX..=VALUE_MAX);
        prop::collection::vec(value, 0..=VALUES).prop_map(ValuesLine::new)
    }

    fn current() -> FieldLine {
        FieldLine {
            place: 1,
            count: 2,
            name: ParameterName::new("motor-current"),
            decimals: 2,
            unit: Printable::new("A"),
        }
    }

    proptest! {
        #[test]
        fn values_in_range_survive_a_round_trip(field in field(), values in values()) {
            prop_assert_eq!(read_back(Body::Field(field)), Body::Field(field));
            prop_assert_eq!(read_back(Body::Values(values)), Body::Values(values));
        }

        #[test]
        fn any_value_makes_a_readable_line(
            (place, count, decimals) in any::<(u8, u8, u8)>(), name in "\\PC*", unit in "\\PC*",
            values: [Option<i32>; 12],
        ) {
            let (name, unit) = (ParameterName::new(&name), Printable::new(&unit));
            read_back(Body::Field(FieldLine { place, count, name, decimals, unit }));
            read_back(Body::Values(ValuesLine::new(values)));
        }

        #[test]
        fn readable_lines_have_one_form(field in field(), values in values(), edits in edits()) {
            has_one_form(Body::Field(field), &edits);
            has_one_form(Body::Values(values), &edits);
        }
    }

    #[test]
    fn bad_fields_are_blamed_by_their_first_column() {
        let field = Body::Field(current());
        let values = Body::Values(ValuesLine::new([Some(125), None]));
        let bad: &[(Body, usize, &[u8], u8)] = &[
            (field, 5, b"0/2", 5),
            (field, 5, b"3/2", 5),
            (field, 6, b".", 5),
            (field, 9, b"M", 9),
            (field, 9, b" ", 9),
            (field, 27, b"x", 27),
            (field, 28, b"6", 28),
            (field, 28, b" ", 28),
            (field, 33, b"\x07", 33),
            (field, 41, b"x", 41),
            (values, 5, b"-00000", 5),
            (values, 5, b" 00125", 5),
            (values, 11, b"-", 11),
            (values, 12, b"-----0", 12),
            (values, 61, b"      ", 61),
            (values, 67, b"0", 67),
        ];
        for &(body, column, characters, column_blamed) in bad {
            let said = blamed(body, column, characters);
            let shown = characters.escape_ascii();
            assert_eq!(said, Some(column_blamed), "{shown} at {column}");
        }
    }
}
