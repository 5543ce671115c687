//! Hashes times relative to now, so that the same situation at another time is the same state.

use std::hash::Hasher;

/// Instant at which every search begins, microseconds. Smaller values are durations, or instants that mean "never".
pub const EPOCH_US: u64 = 1 << 50;

/// Upper limits of the age of the acknowledgement of a line that arrives now, and of the line itself, microseconds.
const LATCHED_US: u64 = 90_000;
const COMPOSED_US: u64 = 450_000;

/// Hashes instants relative to `now_us`. Past ones differ only as far as a line that arrives now distinguishes them;
/// beyond that only timers do, and the search lets every timer run out in every state. It leaves out numbers of 32
/// bits, which count frames and bytes or follow from other fields, and the waypoints of a list, which its task names.
pub struct Relative<'a, H> {
    pub inner: &'a mut H,
    pub now_us: u64,
}

impl<H: Hasher> Hasher for Relative<'_, H> {
    fn write_u64(&mut self, value: u64) {
        let seen = if value < EPOCH_US {
            value
        } else {
            match self.now_us.saturating_sub(value) {
                0 => EPOCH_US + value - self.now_us.min(value),
                1..LATCHED_US => EPOCH_US - 1,
                LATCHED_US..COMPOSED_US => EPOCH_US - 2,
                _ => EPOCH_US - 3,
            }
        };
        self.inner.write_u64(seen);
    }

    fn write(&mut self, bytes: &[u8]) {
        self.inner.write(bytes);
    }

    fn write_u8(&mut self, value: u8) {
        self.inner.write_u8(value);
    }

    fn write_u16(&mut self, value: u16) {
        self.inner.write_u16(value);
    }

    fn write_u32(&mut self, _: u32) {}

    fn write_i16(&mut self, _: i16) {}

    fn write_usize(&mut self, value: usize) {
        self.inner.write_usize(value);
    }

    fn finish(&self) -> u64 {
        self.inner.finish()
    }
}

/// A hasher for long plain data.
#[derive(Default)]
pub struct Quick(u64);

impl Hasher for Quick {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(byte.into());
        }
    }

    fn write_u64(&mut self, value: u64) {
        self.0 = (self.0.rotate_left(5) ^ value).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    }

    fn write_u32(&mut self, value: u32) {
        self.write_u64(value.into());
    }

    fn write_u16(&mut self, value: u16) {
        self.write_u64(value.into());
    }

    fn finish(&self) -> u64 {
        self.0 ^ self.0 >> 32
    }
}
