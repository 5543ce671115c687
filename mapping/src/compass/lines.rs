//! Facts of lines A.

use groundwave_protocol::status_codes::{Bump, Drive};
use groundwave_protocol::telemetry::StateLine;

/// Difference of a wheel's speed from its command from which the wheel is held, in/s: more than a robot gains in 0.3 s.
const HELD_IN_S: i16 = 8;

/// Turn towards the side of a contact, degrees per in/s of speed ahead: the other side goes on while the wheels slip. Measured in
/// simulated houses (docs/decisions.md).
const PUSHED_DEG: f64 = 0.1;

/// Position of the odometer, inches.
pub(super) fn position_in(state: &StateLine) -> (f64, f64) {
    (
        f64::from(state.x_tenths_in) / 10.0,
        f64::from(state.y_tenths_in) / 10.0,
    )
}

/// The shortest turn from one heading to another, degrees, positive to the right.
pub(super) fn turn_deg(from: f64, to: f64) -> f64 {
    (to - from + 540.0).rem_euclid(360.0) - 180.0
}

/// Turn of the robot, which its odometer does not see, by a contact that began between two lines: degrees, positive to the right.
pub(super) fn pushed_deg(last: &StateLine, state: &StateLine) -> f64 {
    let side = match state.bump {
        Bump::Left if last.bump != Bump::Left => -1.0,
        Bump::Right if last.bump != Bump::Right => 1.0,
        _ => return 0.0,
    };
    let wheels_in_s = i16::from(last.wheel_left_in_s) + i16::from(last.wheel_right_in_s);
    side * PUSHED_DEG * f64::from(wheels_in_s.max(0)) / 2.0
}

/// Whether a wheel lags behind its command by more than it takes to speed up.
fn is_held(state: &StateLine) -> bool {
    let (velocity, rotation) = (
        i16::from(state.velocity_in_s),
        i16::from(state.rotation_in_s),
    );
    let lag = |commanded: i16, measured: i8| (commanded - i16::from(measured)).abs();
    let left = lag(velocity + rotation / 2, state.wheel_left_in_s);
    let right = lag(velocity - rotation / 2, state.wheel_right_in_s);
    left.max(right) > HELD_IN_S
}

/// Whether an obstacle touches the robot or holds a wheel.
pub(super) fn is_touching(state: &StateLine) -> bool {
    !matches!(state.bump, Bump::None | Bump::NotFitted)
        || state.drive == Drive::Stalled
        || is_held(state)
}
