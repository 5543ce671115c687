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
const SILENCE_US: u64 = 7 * US_PER_BYTE;

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

/// What is on the air, and what the link makes of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Carrier {
    /// The latest byte, until the silence after it has been taken for a turn.
    latest_us: Option<u64>,
    /// Since the latest pause: chunks of bytes, and the longest gap between two of them.
    chunks: u8,
    gap_us: u64,
    /// The latest line was handed over as it came.
    is_prompt: bool,
}

impl Carrier {
    /// Bytes came in.
    pub(super) fn hear(&mut self, now_us: u64) {
        let gap_us = self
            .latest_us
            .map_or(u64::MAX, |latest_us| now_us.saturating_sub(latest_us));
        self.latest_us = Some(now_us);
        if gap_us > PAUSE_US {
            (self.chunks, self.gap_us) = (1, 0);
        } else {
            self.chunks = self.chunks.saturating_add(1);
            self.gap_us = self.gap_us.max(gap_us);
        }
    }

    /// A line has ended: whether a silence tells something is known from how it came.
    pub(super) fn judge(&mut self) {
        self.is_prompt = self.chunks >= PROMPT_CHUNKS && self.gap_us <= PROMPT_GAP_US;
    }

    /// When it will have been silent for so long that the robot must be listening.
    pub(super) fn silent_at_us(self) -> Option<u64> {
        self.latest_us
            .filter(|_| self.is_prompt)
            .map(|latest_us| latest_us + SILENCE_US)
    }

    /// Takes the silence since the latest byte for a turn; the same one is not taken twice.
    pub(super) fn take(&mut self) -> Option<u64> {
        self.latest_us.take()
    }
}
