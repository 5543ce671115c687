//! Printable text in a field of its own, filled up with spaces.

use super::FieldError;
use super::columns::{Columns, Fields, bad};

/// Up to `N` printable characters, read without the spaces behind them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Printable<const N: usize>([u8; N]);

impl<const N: usize> Printable<N> {
    /// What is longer than `N` bytes is cut, what is not printable ASCII becomes `?`.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut bytes = [b' '; N];
        for (to, from) in bytes.iter_mut().zip(text.bytes()) {
            *to = if matches!(from, b' '..=b'~') {
                from
            } else {
                b'?'
            };
        }
        Self(bytes)
    }

    /// The text without the spaces that fill the field.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.0.trim_ascii_end()).unwrap_or_default()
    }

    pub(super) fn write(&self, columns: &mut Columns, column: usize) {
        columns.bytes(column, &self.0);
    }

    /// Blames the character that is not printable: each is a field of its own.
    pub(super) fn read(c: &Fields, column: usize) -> Result<Self, FieldError> {
        let bytes: [u8; N] = c.at(column)?;
        match bytes.iter().position(|b| !matches!(b, b' '..=b'~')) {
            Some(i) => Err(bad(column + i)),
            None => Ok(Self(bytes)),
        }
    }
}
