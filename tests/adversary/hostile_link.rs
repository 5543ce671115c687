//! The adversary's treatment of a link.

use std::mem;

use crate::common::Rng;

/// Maximum delay of a frame or line, and maximum additional delay with which others overtake it, milliseconds. The link
/// may delay lines by less than five seconds.
pub const DELAY_MS: u64 = 4000;
pub const JITTER_MS: u64 = 900;

/// The adversary's treatment of one direction of a link.
#[derive(Clone, Copy, Default)]
pub struct Weather {
    pub until_ms: u64,
    delay_ms: u64,
    jitter_ms: u64,
    /// Percentages of frames or lines.
    dropped: u64,
    damaged: u64,
    doubled: u64,
    is_out: bool,
}

impl Weather {
    pub fn draw(now_ms: u64, rng: &mut Rng) -> Self {
        let calm = Self {
            until_ms: now_ms + rng.below(5000),
            ..Self::default()
        };
        let faults = Self {
            dropped: rng.below(30),
            damaged: rng.below(30),
            doubled: rng.below(30),
            ..calm
        };
        let delay_ms = rng.below(DELAY_MS);
        let jitter_ms = rng.below(JITTER_MS);
        match rng.below(9) {
            0 => faults,
            1 => Self { delay_ms, ..calm },
            2 => Self {
                delay_ms,
                jitter_ms,
                ..faults
            },
            3 => Self {
                jitter_ms,
                doubled: faults.doubled,
                ..calm
            },
            4 => Self {
                // Also longer than the timeouts.
                until_ms: calm.until_ms + rng.below(2) * rng.below(30_000),
                is_out: true,
                ..calm
            },
            _ => calm,
        }
    }
}

/// A frame or line in transit, from after a line feed to the next one.
struct Held {
    due_ms: u64,
    bytes: Vec<u8>,
}

/// One direction of a link.
#[derive(Default)]
pub struct Direction {
    pub weather: Weather,
    /// Bytes since the latest line feed.
    begun: Vec<u8>,
    held: Vec<Held>,
}

impl Direction {
    /// Takes a byte; returns the frame or line that it completes.
    pub fn take(&mut self, now_ms: u64, byte: u8, rng: &mut Rng) -> Option<Vec<u8>> {
        self.begun.push(byte);
        if byte != b'\n' {
            return None;
        }
        let bytes = mem::take(&mut self.begun);
        let weather = self.weather;
        let copies = 1 + u64::from(rng.below(100) < weather.doubled);
        for _ in 0..copies {
            if weather.is_out || rng.below(100) < weather.dropped {
                continue;
            }
            let mut bytes = bytes.clone();
            if rng.below(100) < weather.damaged {
                damage(&mut bytes, rng);
            }
            self.held.push(Held {
                due_ms: now_ms + weather.delay_ms + rng.below(weather.jitter_ms + 1),
                bytes,
            });
        }
        Some(bytes)
    }

    /// Removes the frames or lines that arrive now.
    pub fn arrived(&mut self, now_ms: u64) -> Vec<Vec<u8>> {
        let due = self.held.extract_if(.., |held| held.due_ms <= now_ms);
        due.map(|held| held.bytes).collect()
    }

    /// Discards the bytes in transit.
    pub fn reset(&mut self) {
        self.begun.clear();
        self.held.clear();
    }
}

/// Discards some bytes or flips up to three bits.
fn damage(bytes: &mut Vec<u8>, rng: &mut Rng) {
    if rng.below(2) == 0 {
        let from = rng.below(bytes.len() as u64) as usize;
        let count = 1 + rng.below(8) as usize;
        bytes.drain(from..bytes.len().min(from + count));
        return;
    }
    for _ in 0..=rng.below(3) {
        let bit = rng.below(bytes.len() as u64 * 8);
        bytes[bit as usize / 8] ^= 1 << (bit % 8);
    }
}
