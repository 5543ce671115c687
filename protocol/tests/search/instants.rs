//! Hashing that sees instants as they look from now, so that the same situation at another hour is the
//! same state.

use std::hash::Hasher;

/// When every search begins, microseconds. Smaller values are durations or instants that mean "never".
pub const EPOCH_US: u64 = 1 << 50;

/// Snapshots and lines that arrive now were latched and composed after whatever is older than this.
const LATEST_US: u64 = 450_000;

/// Hands everything on, instants relative to `now_us`. Instants farther back than [`LATEST_US`] are alike:
/// nothing but a timer tells them apart, and the search lets every timer run out in every state.
pub struct Relative<'a, H> {
    pub inner: &'a mut H,
    pub now_us: u64,
}

impl<H: Hasher> Hasher for Relative<'_, H> {
    fn write_u64(&mut self, value: u64) {
        let seen = if value < EPOCH_US {
            value
        } else {
            let ahead = value as i64 - self.now_us as i64;
            ahead.max(-(LATEST_US as i64)) as u64 ^ 1 << 63
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

    fn write_u32(&mut self, value: u32) {
        self.inner.write_u32(value);
    }

    fn write_usize(&mut self, value: usize) {
        self.inner.write_usize(value);
    }

    fn finish(&self) -> u64 {
        self.inner.finish()
    }
}
