//! Fields at fixed columns, counted from 1 as `cut` does.

use super::{FieldError, HEAD_BYTES};
use crate::{LINE_BYTES, sixbit};

/// The columns of one line, being written.
pub(super) struct Columns([u8; LINE_BYTES]);

/// The columns of one line, being read.
pub(super) struct Fields<'a>(&'a [u8; LINE_BYTES]);

impl Columns {
    pub(super) const fn blank() -> Self {
        Self([b' '; LINE_BYTES])
    }

    pub(super) fn into_head(self) -> [u8; HEAD_BYTES] {
        let mut head = [0; HEAD_BYTES];
        head.copy_from_slice(&self.0[..HEAD_BYTES]);
        head
    }

    fn field(&mut self, column: usize, width: usize) -> &mut [u8] {
        self.0
            .get_mut(column - 1..column - 1 + width)
            .unwrap_or_default()
    }

    pub(super) fn letter(&mut self, column: usize, letter: u8) {
        self.bytes(column, &[letter]);
    }

    pub(super) fn bytes(&mut self, column: usize, bytes: &[u8]) {
        for (to, from) in self.field(column, bytes.len()).iter_mut().zip(bytes) {
            *to = *from;
        }
    }

    /// Decimal digits with leading zeros; a larger value saturates at all nines.
    pub(super) fn digits(&mut self, column: usize, width: usize, value: u32) {
        let mut limit = 1;
        for _ in 0..width {
            limit *= 10;
        }
        let mut rest = value.min(limit - 1);
        for digit in self.field(column, width).iter_mut().rev() {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
    }

    /// A sign and digits, `width` in all; saturates.
    pub(super) fn signed(&mut self, column: usize, width: usize, value: i32) {
        self.letter(column, if value < 0 { b'-' } else { b'+' });
        self.digits(column + 1, width - 1, value.unsigned_abs());
    }

    /// Digits, or as many hyphens for a value that is not there.
    pub(super) fn optional(&mut self, column: usize, width: usize, value: Option<u32>) {
        match value {
            Some(value) => self.digits(column, width, value),
            None => self.field(column, width).fill(b'-'),
        }
    }

    pub(super) fn sixbit(&mut self, column: usize, width: usize, value: u32) {
        sixbit::encode_into(value, self.field(column, width));
    }
}

impl<'a> Fields<'a> {
    pub(super) fn from_line(line: &'a [u8]) -> Option<Self> {
        Some(Self(line.try_into().ok()?))
    }

    /// The `N` bytes from a column on.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn at<const N: usize>(&self, column: usize) -> Result<[u8; N], FieldError> {
        self.0
            .get(column - 1..)
            .and_then(|rest| rest.first_chunk())
            .copied()
            .ok_or_else(|| bad(column))
    }

    /// Checks that the named columns are spaces.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn spaces(&self, columns: &[usize]) -> Result<(), FieldError> {
        for &column in columns {
            if self.at(column)? != *b" " {
                return Err(bad(column));
            }
        }
        Ok(())
    }

    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn number<const N: usize>(&self, column: usize) -> Result<u32, FieldError> {
        let digits: [u8; N] = self.at(column)?;
        decimal(&digits).ok_or_else(|| bad(column))
    }

    /// `N` digits, or `None` for `N` hyphens.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn maybe_number<const N: usize>(
        &self,
        column: usize,
    ) -> Result<Option<u32>, FieldError> {
        if self.at::<N>(column)? == [b'-'; N] {
            return Ok(None);
        }
        self.number::<N>(column).map(Some)
    }

    /// A sign and `N` digits; minus zero is nothing the robot sends. Blames the sign's column, where
    /// the field begins.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn signed_number<const N: usize>(&self, column: usize) -> Result<i32, FieldError> {
        let magnitude = self.number::<N>(column + 1).map_err(|_| bad(column))? as i32;
        self.with_sign(column, magnitude)
    }

    /// The magnitude with the sign before it; zero has only one form, with a plus.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn with_sign(&self, column: usize, magnitude: i32) -> Result<i32, FieldError> {
        match (self.at(column)?, magnitude) {
            ([b'+'], magnitude) => Ok(magnitude),
            ([b'-'], 1..) => Ok(-magnitude),
            _ => Err(bad(column)),
        }
    }

    /// Two numbers with a mark between them, each of its own width. Blames the field's first column.
    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "constant columns make every bounds check vanish"
    )]
    pub(super) fn pair<const N: usize, const M: usize>(
        &self,
        column: usize,
        mark: u8,
    ) -> Result<(u32, u32), FieldError> {
        if self.at(column + N)? != [mark] {
            return Err(bad(column));
        }
        let first = self.number::<N>(column)?;
        let second = self.number::<M>(column + N + 1).map_err(|_| bad(column))?;
        Ok((first, second))
    }

    pub(super) fn sixbit_number<const N: usize>(&self, column: usize) -> Result<u32, FieldError> {
        sixbit::decode_from(&self.at::<N>(column)?).ok_or_else(|| bad(column))
    }

    /// A letter of one of the vocabularies in [`crate::letters`].
    pub(super) fn state<T>(
        &self,
        column: usize,
        from_letter: fn(u8) -> Option<T>,
    ) -> Result<T, FieldError> {
        let [letter] = self.at(column)?;
        from_letter(letter).ok_or_else(|| bad(column))
    }
}

pub(super) const fn bad(column: usize) -> FieldError {
    FieldError {
        column: column as u8,
    }
}

#[inline(always)]
#[expect(
    clippy::inline_always,
    reason = "the length is a constant at every call"
)]
fn decimal(digits: &[u8]) -> Option<u32> {
    let mut value = 0;
    for &digit in digits {
        let digit = digit.wrapping_sub(b'0');
        if digit > 9 {
            return None;
        }
        value = value * 10 + u32::from(digit);
    }
    Some(value)
}
