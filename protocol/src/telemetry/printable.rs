//! Printable text, padded with spaces.

use super::columns::Columns;
use super::fields::{Parsed, byte, each};
use nom::Parser;
use nom::combinator::verify;

/// Up to `N` printable characters, padded with spaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Printable<const N: usize>([u8; N]);

impl<const N: usize> Printable<N> {
    /// Makes a text from `text`, cut after `N` bytes, with `?` for each byte that is not printable ASCII.
    #[must_use]
    pub fn new(text: &str) -> Self {
        Self::from_bytes(text.as_bytes())
    }

    /// Likewise, from bytes in place of a string.
    #[must_use]
    pub fn from_bytes(text: &[u8]) -> Self {
        let mut bytes = [b' '; N];
        for (to, &from) in bytes.iter_mut().zip(text) {
            *to = if matches!(from, b' '..=b'~') {
                from
            } else {
                b'?'
            };
        }
        Self(bytes)
    }

    /// The text without its padding.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.0.trim_ascii_end()).unwrap_or_default()
    }

    pub(super) fn write(&self, columns: &mut Columns, column: usize) {
        columns.bytes(column, &self.0);
    }

    /// Parses `N` printable characters; an error names the wrong column.
    pub(super) fn parse(input: &[u8]) -> Parsed<'_, Self> {
        let printable = verify(byte, |byte| matches!(byte, b' '..=b'~'));
        each(printable).map(Self).parse(input)
    }
}
