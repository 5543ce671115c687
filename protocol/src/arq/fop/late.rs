//! Lines that a radio held back or repeated.

use super::Fop;
use crate::decoder::Received;
use crate::telemetry::SEQUENCE_MODULUS;

/// No link holds a line back for longer; after such a silence whatever comes is news.
const LATE_MAX_US: u64 = 5_000_000;

/// Lines that the robot may have sent since the newest one heard, at the very most.
const AHEAD_MAX: u8 = SEQUENCE_MODULUS / 2;

impl Fop {
    /// Whether a newer line than this one has been heard. What it says has passed: taken for news, it
    /// would end a session that is open, and lead back into one that is over.
    pub(super) fn is_late(&self, arrived_us: u64, received: &Received) -> bool {
        let Some(newest) = self.latest_ack else {
            return false;
        };
        if arrived_us >= self.heard_us + LATE_MAX_US {
            return false;
        }
        let lives_ahead = received.ack().boot.wrapping_sub(newest.boot) & 7;
        if lives_ahead != 0 {
            return lives_ahead > 4;
        }
        let ahead = (received.sequence() + SEQUENCE_MODULUS - self.latest_line) % SEQUENCE_MODULUS;
        ahead > AHEAD_MAX
    }
}
