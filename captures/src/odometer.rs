//! What the robot's own reports say of the way between two of them.

use groundwave_protocol::telemetry::SEQUENCE_MODULUS;

/// Faster than this between two lines, the odometer was set and nothing driven.
const SPEED_MAX_IN_S: f64 = 24.0;

/// Long lines that 2400 baud carry.
const LINES_PER_S: f64 = 3.0;

/// Long lines from one number to another, both of which were heard.
pub(super) const fn slots_between(before: u8, after: u8) -> u8 {
    (after + SEQUENCE_MODULUS - before) % SEQUENCE_MODULUS
}

/// Seconds that so many long lines take. A raw capture knows nothing of a silence; the numbers do.
pub(super) fn seconds_of(slots: u8) -> f64 {
    f64::from(slots) / LINES_PER_S
}

/// Whether a robot can have driven so far in that time.
pub(super) fn can_be_driven(step_in: f64, passed_s: f64) -> bool {
    step_in <= passed_s * SPEED_MAX_IN_S
}
