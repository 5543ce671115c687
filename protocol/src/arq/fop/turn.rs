//! When a half-duplex robot listens.

use super::US_PER_BYTE;

/// Byte times after which a robot that hears nothing in its turn to listen talks on.
pub(super) const PATIENCE_BYTES: u64 = 16;

/// Most bytes of one turn: the robot listens no longer.
const TURN_BYTES: u64 = 238;

/// The first byte has to leave within this: most of the robot's patience, the rest is the link's.
const BEGIN_WITHIN_US: u64 = PATIENCE_BYTES * 3 / 4 * US_PER_BYTE;

/// A robot that has been silent for so long listens, whether its line G arrived or not: it talks without a
/// pause otherwise.
pub(super) const SILENCE_US: u64 = 7 * US_PER_BYTE;

/// A link that leaves longer pauses within lines (modems, bridges, adapters that collect bytes) says nothing
/// by its silence.
const PROMPT_GAP_US: u64 = 5 * US_PER_BYTE;

/// A longer pause stands between lines.
const PAUSE_US: u64 = 12 * US_PER_BYTE;

/// Chunks of bytes that a link has to hand over in a row before it is trusted.
const PROMPT_CHUNKS: u8 = 4;

/// So much may be said again in one turn where every second frame gets lost: the rest of a turn costs less
/// than another one.
const REPEAT_BYTES: u64 = 60;

/// The robot listens: what may be said, and until when.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Turn {
    used_bytes: u64,
    /// The next frame has to begin before this.
    begin_by_us: u64,
}

impl Turn {
    pub(super) const fn begin(now_us: u64) -> Self {
        Self {
            used_bytes: 0,
            begin_by_us: now_us + BEGIN_WITHIN_US,
        }
    }

    /// Bytes that may still be said.
    pub(super) const fn room(self, now_us: u64) -> u64 {
        if now_us > self.begin_by_us {
            0
        } else {
            TURN_BYTES - self.used_bytes
        }
    }

    /// Whether anything has been said in it.
    pub(super) const fn is_used(self) -> bool {
        self.used_bytes > 0
    }

    /// Whether there is time to say something again.
    pub(super) const fn may_repeat(self) -> bool {
        self.used_bytes < REPEAT_BYTES
    }

    /// A frame of so many bytes is being sent; its last one leaves at `ends_us`.
    pub(super) fn take(&mut self, bytes: u64, ends_us: u64) {
        self.used_bytes = (self.used_bytes + bytes).min(TURN_BYTES);
        self.begin_by_us = ends_us + BEGIN_WITHIN_US;
    }
}

/// Whether the link hands bytes over as they come, judged by the pauses between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Promptness {
    latest_us: u64,
    chunks: u8,
    gap_us: u64,
}

impl Promptness {
    pub(super) fn handle_carrier(&mut self, now_us: u64) {
        let gap_us = now_us.saturating_sub(self.latest_us);
        self.latest_us = now_us;
        if gap_us > PAUSE_US {
            (self.chunks, self.gap_us) = (1, 0);
        } else {
            self.chunks = self.chunks.saturating_add(1);
            self.gap_us = self.gap_us.max(gap_us);
        }
    }

    /// Judged at the end of a line.
    pub(super) const fn is_prompt(self) -> bool {
        self.chunks >= PROMPT_CHUNKS && self.gap_us <= PROMPT_GAP_US
    }
}
