//! Fields at fixed columns, counted from 1 as `cut` does.

use super::HEAD_BYTES;
use crate::{LINE_BYTES, sixbit};

/// The columns of a line being written.
pub(super) struct Columns([u8; LINE_BYTES]);

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

    /// Writes decimal digits with leading zeros; a larger value saturates at all nines.
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

    /// Writes a sign and digits, `width` characters in total; saturates.
    pub(super) fn signed(&mut self, column: usize, width: usize, value: i32) {
        self.letter(column, if value < 0 { b'-' } else { b'+' });
        self.digits(column + 1, width - 1, value.unsigned_abs());
    }

    /// Writes digits, or hyphens for a missing value.
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
