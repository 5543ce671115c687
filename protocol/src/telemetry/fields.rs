//! Parsers for the fields of a line, by the forms of SPEC.md section 3.

use super::FieldError;
use crate::sixbit;
use nom::combinator::{map_opt, verify};
use nom::error::{ErrorKind, ParseError};
use nom::multi::fill;
use nom::{IResult, Parser, branch::alt};

/// The result of a parser: the rest of the line, and the value read.
pub(super) type Parsed<'a, T> = IResult<&'a [u8], T, BadField>;

/// An unreadable field.
#[derive(Clone, Copy, Debug)]
pub(super) struct BadField {
    /// Number of bytes in the line from the field's first column on.
    left: usize,
}

impl BadField {
    /// The error for the column with which `input` begins.
    pub(super) fn at(input: &[u8]) -> nom::Err<Self> {
        nom::Err::Error(Self { left: input.len() })
    }
}

impl ParseError<&[u8]> for BadField {
    fn from_error_kind(input: &[u8], _: ErrorKind) -> Self {
        Self { left: input.len() }
    }

    fn append(_: &[u8], _: ErrorKind, inner: Self) -> Self {
        inner
    }
}

/// A value read from a line, or the unreadable field.
pub(super) type Read<T> = Result<T, nom::Err<BadField>>;

/// The fields of a line, read one after another.
pub(super) struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// Reads a line with `read`, which need not read the whole line.
    pub(super) fn of<T>(
        line: &'a [u8],
        read: impl FnOnce(&mut Self) -> Read<T>,
    ) -> Result<T, FieldError> {
        read(&mut Self(line)).map_err(|error| {
            let left = match error {
                nom::Err::Error(bad) | nom::Err::Failure(bad) => bad.left,
                nom::Err::Incomplete(_) => line.len(),
            };
            FieldError {
                column: (line.len() - left + 1) as u8,
            }
        })
    }

    /// The bytes not read yet.
    pub(super) fn rest(&self) -> &'a [u8] {
        self.0
    }

    /// Reads with a parser.
    pub(super) fn next<T>(
        &mut self,
        mut parser: impl Parser<&'a [u8], Output = T, Error = BadField>,
    ) -> Read<T> {
        let value;
        (self.0, value) = parser.parse(self.0)?;
        Ok(value)
    }

    /// Reads a space and a field. An error names the field's first column.
    pub(super) fn field<T>(
        &mut self,
        mut parser: impl Parser<&'a [u8], Output = T, Error = BadField>,
    ) -> Read<T> {
        self.fields(|input| parser.parse(input).map_err(|_| BadField::at(input)))
    }

    /// Reads a space and several fields without spaces between them.
    pub(super) fn fields<T>(
        &mut self,
        parser: impl Parser<&'a [u8], Output = T, Error = BadField>,
    ) -> Read<T> {
        self.next(character(b' '))?;
        self.next(parser)
    }
}

/// Parses `N` fields of one kind.
pub(super) fn each<'a, const N: usize, T: Copy + Default>(
    mut field: impl Parser<&'a [u8], Output = T, Error = BadField>,
) -> impl Parser<&'a [u8], Output = [T; N], Error = BadField> {
    move |input| {
        let mut fields = [T::default(); N];
        let (rest, ()) = fill(|input| field.parse(input), &mut fields).parse(input)?;
        Ok((rest, fields))
    }
}

/// Parses `N` bytes.
pub(super) fn bytes<const N: usize>(input: &[u8]) -> Parsed<'_, [u8; N]> {
    match input.split_first_chunk() {
        Some((bytes, rest)) => Ok((rest, *bytes)),
        None => Err(BadField::at(input)),
    }
}

/// Parses any byte.
pub(super) fn byte(input: &[u8]) -> Parsed<'_, u8> {
    bytes::<1>.map(|[byte]| byte).parse(input)
}

/// Parses a given character.
pub(super) fn character<'a>(expected: u8) -> impl Parser<&'a [u8], Output = (), Error = BadField> {
    map_opt(byte, move |byte| (byte == expected).then_some(()))
}

/// Parses `N` spaces; an error names the wrong column.
pub(super) fn spaces<const N: usize>(input: &[u8]) -> Parsed<'_, ()> {
    fill(character(b' '), &mut [(); N]).parse(input)
}

/// Parses `N` decimal digits.
pub(super) fn digits<const N: usize, T: TryFrom<u32>>(input: &[u8]) -> Parsed<'_, T> {
    map_opt(bytes::<N>, |digits| {
        let value = digits.iter().try_fold(0, |value, digit| match digit {
            b'0'..=b'9' => Some(value * 10 + u32::from(digit - b'0')),
            _ => None,
        })?;
        T::try_from(value).ok()
    })
    .parse(input)
}

/// Parses a sign and a magnitude; zero has a plus.
pub(super) fn signed<'a, T: Default + PartialEq + core::ops::Neg<Output = T>>(
    magnitude: impl Parser<&'a [u8], Output = T, Error = BadField>,
) -> impl Parser<&'a [u8], Output = T, Error = BadField> {
    map_opt((byte, magnitude), |(sign, magnitude)| match sign {
        b'+' => Some(magnitude),
        b'-' if magnitude != T::default() => Some(-magnitude),
        _ => None,
    })
}

/// Parses a value, or hyphens in the whole field for a missing value.
pub(super) fn optional<'a, const N: usize, T>(
    hyphens: &'static [u8; N],
    value: impl Parser<&'a [u8], Output = T, Error = BadField>,
) -> impl Parser<&'a [u8], Output = Option<T>, Error = BadField> {
    let none = map_opt(bytes::<N>, move |bytes| (bytes == *hyphens).then_some(None));
    alt((none, value.map(Some)))
}

/// Parses a number of `N` 6-bit characters.
pub(super) fn sixbits<const N: usize, T: TryFrom<u32>>(input: &[u8]) -> Parsed<'_, T> {
    map_opt(bytes::<N>, |characters| {
        T::try_from(sixbit::decode_from(&characters)?).ok()
    })
    .parse(input)
}

/// Parses a robot id, 01 to 99.
pub(super) fn robot_id(input: &[u8]) -> Parsed<'_, u8> {
    verify(digits::<2, u8>, |&id| id > 0).parse(input)
}

/// Parses a letter of a vocabulary.
pub(super) fn letter<'a, T>(
    from_letter: impl Fn(u8) -> Option<T>,
) -> impl Parser<&'a [u8], Output = T, Error = BadField> {
    map_opt(byte, from_letter)
}
