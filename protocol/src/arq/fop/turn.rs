//! Determines when a half-duplex robot listens. Durations are those of 2400 baud at every rate.

use super::super::US_PER_BYTE;

/// Time after which a robot that receives nothing in its turn to listen sends again, byte times.
pub(super) const PATIENCE_BYTES: u64 = 16;

/// Maximum number of bytes in one turn.
const TURN_BYTES: u64 = 238;

/// Maximum wait before the first byte of a turn: three quarters of the robot's patience; the rest is for the link's latency.
const BEGIN_WITHIN_US: u64 = PATIENCE_BYTES * 3 / 4 * US_PER_BYTE;

/// Silence after which a half-duplex robot must be listening, even if its line G was lost, microseconds.
const SILENCE_US: u64 = 7 * US_PER_BYTE;

/// Maximum gap within lines on a link whose silence is meaningful. Modems, bridges and adapters that collect bytes
/// make longer gaps.
const PROMPT_GAP_US: u64 = 5 * US_PER_BYTE;

/// Maximum pause within a line, microseconds; a longer pause separates lines.
const PAUSE_US: u64 = 12 * US_PER_BYTE;

/// Number of consecutive chunks to receive before a link's silence is trusted.
const PROMPT_CHUNKS: u8 = 4;

/// Number of bytes used in a turn below which frames are repeated on a bad channel, because a further turn costs more than the
/// rest of this one.
const REPEAT_BYTES: u64 = 60;

/// A turn of the ground, while a half-duplex robot listens.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Turn {
    used_bytes: u64,
    /// Time before which the next frame must begin, microseconds.
    begin_by_us: u64,
}

impl Turn {
    pub(super) const fn begin(now_us: u64) -> Self {
        Self {
            used_bytes: 0,
            begin_by_us: now_us + BEGIN_WITHIN_US,
        }
    }

    /// Number of bytes that may still be sent.
    pub(super) const fn room(self, now_us: u64) -> u64 {
        if now_us > self.begin_by_us {
            0
        } else {
            TURN_BYTES - self.used_bytes
        }
    }

    /// Whether a frame has been sent in the turn.
    pub(super) const fn is_used(self) -> bool {
        self.used_bytes > 0
    }

    /// Whether there is time to repeat a frame.
    pub(super) const fn may_repeat(self) -> bool {
        self.used_bytes < REPEAT_BYTES
    }

    /// Takes a frame of `bytes` bytes, whose last byte leaves at `ends_us`.
    pub(super) fn take(&mut self, bytes: u64, ends_us: u64) {
        self.used_bytes = (self.used_bytes + bytes).min(TURN_BYTES);
        self.begin_by_us = ends_us + BEGIN_WITHIN_US;
    }
}

/// Timing of received bytes; recognizes a robot's silence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(super) struct Carrier {
    /// Time of the latest byte, until the silence after it has begun a turn.
    latest_us: Option<u64>,
    /// Number of chunks since the latest pause, and the longest gap between two of them.
    chunks: u8,
    gap_us: u64,
    /// Whether the link delivered the latest line without delay.
    is_prompt: bool,
}

impl Carrier {
    /// Takes the time at which bytes arrived.
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

    /// Judges at the end of a line whether the link delivers bytes without delay.
    pub(super) fn judge(&mut self) {
        self.is_prompt = self.chunks >= PROMPT_CHUNKS && self.gap_us <= PROMPT_GAP_US;
    }

    /// Time from which the robot must be listening, if no byte arrives before.
    pub(super) fn silent_at_us(self) -> Option<u64> {
        self.latest_us
            .filter(|_| self.is_prompt)
            .map(|latest_us| latest_us + SILENCE_US)
    }

    /// Time of the latest byte; returned only once, because a silence begins one turn.
    pub(super) fn take(&mut self) -> Option<u64> {
        self.latest_us.take()
    }
}
