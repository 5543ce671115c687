//! Hands bytes to the operating system no faster than the wire sends them.

use crate::BYTES_PER_S;
use crate::command::Frame;

/// Most bytes queued in the operating system: a STOP has to wait for them.
const QUEUED_BYTES_MAX: u64 = 16;

const US_PER_BYTE: u64 = 1_000_000 / BYTES_PER_S as u64;

/// A frame on its way out, and the instant at which the wire will be free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Pacer {
    frame: Frame,
    handed_out: usize,
    free_at_us: u64,
}

impl Pacer {
    pub(super) fn is_idle(&self) -> bool {
        self.handed_out >= self.frame.as_bytes().len()
    }

    /// Begins a frame; returns when its last byte will have been sent.
    pub(super) fn begin(&mut self, now_us: u64, frame: Frame) -> u64 {
        self.frame = frame;
        self.handed_out = 0;
        self.free_at_us = self.free_at_us.max(now_us);
        self.free_at_us + frame.as_bytes().len() as u64 * US_PER_BYTE
    }

    /// Drops the rest of the frame. The line feed that begins the next frame aborts it at the robot.
    pub(super) fn abort(&mut self) {
        self.handed_out = self.frame.as_bytes().len();
    }

    /// The bytes to hand over now.
    pub(super) fn poll(&mut self, now_us: u64) -> Option<&[u8]> {
        let rest = self.frame.as_bytes().get(self.handed_out..)?;
        let queued = self.free_at_us.saturating_sub(now_us).div_ceil(US_PER_BYTE);
        let room = QUEUED_BYTES_MAX.saturating_sub(queued) as usize;
        // Half the allowance at a time keeps the number of writes low.
        if rest.is_empty() || room < rest.len().min(QUEUED_BYTES_MAX as usize / 2) {
            return None;
        }
        let chunk = rest.get(..room.min(rest.len()))?;
        self.handed_out += chunk.len();
        self.free_at_us = self.free_at_us.max(now_us) + chunk.len() as u64 * US_PER_BYTE;
        Some(chunk)
    }

    /// When to call [`Pacer::poll`] again; `None` when no bytes wait.
    pub(super) fn poll_timeout(&self) -> Option<u64> {
        let rest = self.frame.as_bytes().len().saturating_sub(self.handed_out) as u64;
        let wanted = rest.min(QUEUED_BYTES_MAX / 2);
        (rest > 0).then(|| {
            self.free_at_us
                .saturating_sub((QUEUED_BYTES_MAX - wanted) * US_PER_BYTE)
        })
    }
}
