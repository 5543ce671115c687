//! Passes bytes to the operating system no faster than the wire sends them.

use super::US_PER_BYTE;
use crate::command::Frame;

/// Maximum number of bytes queued in the operating system; a STOP must wait for them.
const QUEUED_BYTES_MAX: u64 = 16;

const US_PER_S: u64 = 1_000_000;

/// The frame being sent, and the time at which the wire will be free.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Pacer {
    frame: Frame,
    handed_out: usize,
    free_at_us: u64,
    us_per_byte: u64,
}

impl Default for Pacer {
    fn default() -> Self {
        Self {
            frame: Frame::default(),
            handed_out: 0,
            free_at_us: 0,
            us_per_byte: US_PER_BYTE,
        }
    }
}

impl Pacer {
    /// Time of a byte on the wire, microseconds.
    pub(super) const fn us_per_byte(&self) -> u64 {
        self.us_per_byte
    }

    pub(super) const fn set_rate(&mut self, bytes_per_s: u32) {
        self.us_per_byte = US_PER_S
            / if bytes_per_s == 0 {
                1
            } else {
                bytes_per_s as u64
            };
    }

    pub(super) fn is_idle(&self) -> bool {
        self.handed_out >= self.frame.as_bytes().len()
    }

    /// Begins a frame; returns the time at which its last byte will have been sent.
    pub(super) fn begin(&mut self, now_us: u64, frame: Frame) -> u64 {
        self.frame = frame;
        self.handed_out = 0;
        self.free_at_us = self.free_at_us.max(now_us);
        self.free_at_us + frame.as_bytes().len() as u64 * self.us_per_byte
    }

    /// Drops the rest of the frame. The line feed that begins the next frame aborts it at the robot.
    pub(super) fn abort(&mut self) {
        self.handed_out = self.frame.as_bytes().len();
    }

    /// The bytes to pass to the operating system now.
    pub(super) fn poll(&mut self, now_us: u64) -> Option<&[u8]> {
        let rest = self.frame.as_bytes().get(self.handed_out..)?;
        let queued = self
            .free_at_us
            .saturating_sub(now_us)
            .div_ceil(self.us_per_byte);
        let room = QUEUED_BYTES_MAX.saturating_sub(queued) as usize;
        // Passing half of the allowance at a time keeps the number of writes low.
        if rest.is_empty() || room < rest.len().min(QUEUED_BYTES_MAX as usize / 2) {
            return None;
        }
        let chunk = rest.get(..room.min(rest.len()))?;
        self.handed_out += chunk.len();
        self.free_at_us = self.free_at_us.max(now_us) + chunk.len() as u64 * self.us_per_byte;
        Some(chunk)
    }

    /// Time at which to call [`Pacer::poll`] again; `None` if no bytes wait.
    pub(super) fn poll_timeout(&self) -> Option<u64> {
        let rest = self.frame.as_bytes().len().saturating_sub(self.handed_out) as u64;
        let wanted = rest.min(QUEUED_BYTES_MAX / 2);
        (rest > 0).then(|| {
            self.free_at_us
                .saturating_sub((QUEUED_BYTES_MAX - wanted) * self.us_per_byte)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Key, Message};

    /// Time at which the last byte of a frame is passed to the operating system.
    fn handed_over_us(bytes_per_s: u32) -> u64 {
        let mut pacer = Pacer::default();
        pacer.set_rate(bytes_per_s);
        let frame = Message::Stop(Some(1)).encode(Key::EVERY_ROBOT);
        for _ in 0..20 {
            pacer.begin(0, frame);
            while !pacer.is_idle() {
                let due_us = pacer.poll_timeout().expect("bytes wait");
                assert!(pacer.poll(due_us).is_some());
            }
        }
        pacer.free_at_us
    }

    #[test]
    fn frames_take_the_time_of_the_rate() {
        let bytes = Message::Stop(Some(1)).encode(Key::EVERY_ROBOT);
        let bytes = 20 * bytes.as_bytes().len() as u64;
        for bytes_per_s in [30, 120, 240, 960, 11_520] {
            let expected_us = bytes * (1_000_000 / u64::from(bytes_per_s));
            assert_eq!(handed_over_us(bytes_per_s), expected_us, "{bytes_per_s}");
        }
    }
}
