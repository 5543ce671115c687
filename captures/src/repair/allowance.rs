//! Limits the work on lengths that a hostile file claims.

use crate::record::RECORD_BYTES_MAX;

/// Bytes that each byte passed allows to look at: a record is read, checked and, after damage, searched for.
const EARNED: u64 = 4;

/// Unpacked bytes that count as one byte looked at.
const UNPACKED: u64 = 16;

/// Bytes that may still be looked at. A byte of a file can lie in any number of false records; with an allowance, time is linear
/// in the file all the same.
pub(super) struct Allowance(u64);

impl Allowance {
    pub(super) const fn new() -> Self {
        Self(2 * RECORD_BYTES_MAX as u64)
    }

    /// Allows more: bytes of the file are left behind.
    pub(super) const fn pass(&mut self, bytes: usize) {
        self.0 = self.0.saturating_add(EARNED * bytes as u64);
    }

    /// Whether so many bytes may be looked at, which uses them up.
    pub(super) const fn takes(&mut self, bytes: usize) -> bool {
        self.takes_bytes(bytes as u64)
    }

    /// Whether a chunk of so many unpacked bytes may be unpacked.
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
