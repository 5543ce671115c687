//! Damaged lines by kind and type.

use crate::LINE_BYTES;
use crate::telemetry::{ACK_LINE_BYTES, AckLine, LineType};

/// Reason why a line is damaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DamageKind {
    /// The checksum is wrong.
    Checksum,
    /// The length is not that of a line.
    Shape,
    /// The checksum is valid but a field is unreadable, as in another version of the protocol.
    Field,
}

/// Number of rows of [`Damaged`] in addition to the long line types: short lines, and lines of unrecognizable type.
const OTHER_ROWS: usize = 2;

/// Number of types distinguished.
const ROWS: usize = LineType::ALL.len() + OTHER_ROWS;

/// Counts of damaged lines (received but not intact), by type and kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Damaged {
    kinds: [u32; 3],
    types: [u32; ROWS],
}

impl Damaged {
    /// Counts the damaged line at the end of `seen`.
    pub(super) fn count(&mut self, kind: DamageKind, seen: &[u8]) {
        for count in [&mut self.kinds[kind as usize], &mut self.types[row(seen)]] {
            *count = count.saturating_add(1);
        }
    }

    /// Number of damaged lines of a kind.
    #[must_use]
    pub const fn of_kind(&self, kind: DamageKind) -> u64 {
        self.kinds[kind as usize] as u64
    }

    /// Number of damaged lines of each type: the letter of a long line, `K` for short lines, `?` if unrecognizable.
    pub fn by_type(&self) -> impl Iterator<Item = (char, u64)> {
        let long = LineType::ALL.iter().map(|it| it.letter());
        let letters = long.chain([AckLine::LETTERS[0], b'?']).map(char::from);
        letters.zip(self.types.map(u64::from))
    }

    /// Number of all damaged lines.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.kinds.iter().map(|count| u64::from(*count)).sum()
    }
}

/// The row of the line at the end of `seen`, recognized by the letter and digits with which a line begins.
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
