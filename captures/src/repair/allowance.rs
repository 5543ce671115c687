//! Limits the work that false lengths in a hostile file can cause.

use crate::record::RECORD_BYTES_MAX;

/// Number of bytes that may be examined per byte passed: a record is read, checked and, after damage, searched for.
const EARNED: u64 = 4;

/// Number of unpacked bytes that count as one byte examined.
const UNPACKED: u64 = 16;

/// Number of bytes that may still be examined. A byte may belong to any number of false records; the allowance keeps
/// the time linear in the length of the file.
pub(super) struct Allowance(u64);

impl Allowance {
    pub(super) const fn new() -> Self {
        Self(2 * RECORD_BYTES_MAX as u64)
    }

    /// Increases the allowance for bytes of the file that have been passed.
    pub(super) const fn pass(&mut self, bytes: usize) {
        self.0 = self.0.saturating_add(EARNED * bytes as u64);
    }

    /// Uses the allowance for examining `bytes`; returns whether it suffices.
    pub(super) const fn takes(&mut self, bytes: usize) -> bool {
        self.takes_bytes(bytes as u64)
    }

    /// Uses the allowance for unpacking a chunk; returns whether it suffices.
    pub(super) const fn takes_unpacked(&mut self, bytes: u64) -> bool {
        self.takes_bytes(bytes / UNPACKED)
    }

    const fn takes_bytes(&mut self, bytes: u64) -> bool {
        let is_allowed = bytes <= self.0;
        if is_allowed {
            self.0 -= bytes;
        }
        is_allowed
    }
}
