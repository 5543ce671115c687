//! Plausible distances between two reports of the robot.

use groundwave_protocol::telemetry::SEQUENCE_MODULUS;

/// Speed above which the odometer was reset instead, inches per second.
const SPEED_MAX_IN_S: f64 = 24.0;

/// Long lines per second at 2400 baud.
const LINES_PER_S: f64 = 3.0;

/// Long lines from one sequence number to another.
pub(super) const fn slots_between(before: u8, after: u8) -> u8 {
    (after + SEQUENCE_MODULUS - before) % SEQUENCE_MODULUS
}

/// Transmission time of a number of long lines, seconds; it also counts for raw text, which has no pauses.
pub(super) fn seconds_of(slots: u8) -> f64 {
    f64::from(slots) / LINES_PER_S
}

/// Whether a robot can drive `step_in` inches in `passed_s` seconds.
pub(super) fn can_be_driven(step_in: f64, passed_s: f64) -> bool {
    step_in <= passed_s * SPEED_MAX_IN_S
}
