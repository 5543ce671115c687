//! Line T: a line of text from the robot's program, its `printf`.
//!
//! ```text
//! 1-3  5-68                                       70-74 75-78
//! T49  I'm finished with the co-ordinate list     !5:HS ^*"+
//! ```

use super::FieldError;
use super::columns::{Columns, Fields, bad};

/// Characters a line of text holds.
pub const TEXT_BYTES: usize = 64;

/// Line T.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextLine([u8; TEXT_BYTES]);

impl TextLine {
    /// A line of text; what is longer than 64 bytes is cut, what is not printable ASCII becomes `?`.
    #[must_use]
    pub fn new(text: &str) -> Self {
        let mut bytes = [b' '; TEXT_BYTES];
        for (to, from) in bytes.iter_mut().zip(text.bytes()) {
            *to = if matches!(from, b' '..=b'~') {
                from
            } else {
                b'?'
            };
        }
        Self(bytes)
    }

    /// The text without the spaces that fill the line.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(self.0.trim_ascii_end()).unwrap_or_default()
    }

    pub(super) fn write(&self, columns: &mut Columns) {
        columns.bytes(5, &self.0);
    }

    pub(super) fn read(c: &Fields) -> Result<Self, FieldError> {
        c.spaces(&[4, 69])?;
        let bytes: [u8; TEXT_BYTES] = c.at(5)?;
        match bytes.iter().position(|b| !matches!(b, b' '..=b'~')) {
            Some(i) => Err(bad(5 + i)),
            None => Ok(Self(bytes)),
        }
    }
}
