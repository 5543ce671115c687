//! Damaged lines by kind and type.

use crate::LINE_BYTES;
use crate::telemetry::{ACK_LINE_BYTES, AckLine, LineType};

/// Why a line is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamageKind {
    /// Its checksum is wrong.
    Checksum,
    /// It does not have the length of a line.
    Shape,
    /// Its checksum is right and a field is unreadable: another version of the protocol.
    Field,
}

/// Rows of [`Damaged`] besides the types of long lines: short lines, and lines of an unrecognizable type.
const OTHER_ROWS: usize = 2;

/// Number of types distinguished.
const ROWS: usize = LineType::ALL.len() + OTHER_ROWS;

/// Damaged lines: received and not intact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Damaged {
    kinds: [u32; 3],
    types: [u32; ROWS],
}

impl Damaged {
    /// Counts a damaged line. `seen` ends with it.
    pub(super) fn count(&mut self, kind: DamageKind, seen: &[u8]) {
        for count in [&mut self.kinds[kind as usize], &mut self.types[row(seen)]] {
            *count = count.saturating_add(1);
        }
    }

    /// Damaged lines of a kind.
    #[must_use]
    pub const fn of_kind(&self, kind: DamageKind) -> u64 {
        self.kinds[kind as usize] as u64
    }

    /// Damaged lines of each type: the letter of a long line, `K` for short lines, `?` where it is unrecognizable.
    pub fn by_type(&self) -> impl Iterator<Item = (char, u64)> {
        let long = LineType::ALL.iter().map(|it| it.letter());
        let letters = long.chain([AckLine::LETTERS[0], b'?']).map(char::from);
        letters.zip(self.types.map(u64::from))
    }

    /// All damaged lines.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.kinds.iter().map(|count| u64::from(*count)).sum()
    }
}

/// The row of the line at the end of `seen`: its letter and the digits of its sequence are where a line begins.
fn row(seen: &[u8]) -> usize {
    let begins = |bytes: usize| {
        let start = seen.get(seen.len().checked_sub(bytes)?..)?;
        let [letter, tens, units, ..] = *start else {
            return None;
        };
        (tens.is_ascii_digit() && units.is_ascii_digit()).then_some(letter)
    };
    let place = |letter| LineType::ALL.iter().position(|it| it.letter() == letter);
    if let Some(row) = begins(LINE_BYTES).and_then(place) {
        return row;
    }
    let is_short = begins(ACK_LINE_BYTES).is_some_and(AckLine::begins_with);
    LineType::ALL.len() + usize::from(!is_short)
}
