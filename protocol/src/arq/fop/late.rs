//! Lines that a radio delayed or repeated.

use super::Fop;
use crate::decoder::Received;
use crate::telemetry::SEQUENCE_MODULUS;

/// Maximum delay of a line, microseconds; after such a silence, every line counts as new.
const LATE_MAX_US: u64 = 5_000_000;

/// Maximum number of lines that the robot may have sent since the newest line received.
const AHEAD_MAX: u8 = SEQUENCE_MODULUS / 2;

impl Fop {
    /// Whether a newer line has been received. Otherwise a late line could end the open session or restore an old one.
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
