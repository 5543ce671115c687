//! Estimated place of a silent robot: dead reckoning from its last wheel speeds, with the
//! uncertainty.

use groundwave_protocol::telemetry::StateLine;

use super::chart::{Pose, ROBOT_RADIUS_IN};
use super::robot::{Reading, STATE_STALE};
use crate::event::Moment;

/// Distance between the wheels, inches.
const TRACK_IN: f64 = 10.0;

/// Growth of the uncertainty, in/s.
const DRIFT_IN_S: f64 = 1.0;

/// Uncertainty as a share of the reckoned distance.
const STRAYING: f64 = 0.5;

/// Maximum time of dead reckoning.
const RECKONED_MAX: Moment = Moment::from_mins(1);

/// The estimated place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ghost {
    pub(crate) pose: Pose,
    /// Uncertainty, inches.
    pub(crate) radius_in: f64,
}

/// The estimated place of the robot after its last line; `None` while lines arrive.
pub(crate) fn ghost(last: &Reading<StateLine>, now: Moment) -> Option<Ghost> {
    let age = last.age(now);
    if age < STATE_STALE {
        return None;
    }
    let s = age.min(RECKONED_MAX).as_secs_f64();
    let state = &last.value;
    let left = f64::from(state.wheel_left_in_s);
    let right = f64::from(state.wheel_right_in_s);
    let speed_in_s = f64::midpoint(left, right);
    let turned = (left - right) / TRACK_IN * s;
    let from = Pose::of(state);
    // The chord of the driven arc.
    let distance_in = speed_in_s * s;
    let chord_in = if turned.abs() < 1e-6 {
        distance_in
    } else {
        distance_in * (turned / 2.0).sin() / (turned / 2.0)
    };
    let (x_in, y_in) = from.ahead((turned / 2.0).to_degrees(), chord_in);
    Some(Ghost {
        pose: Pose {
            x_in,
            y_in,
            theta_deg: (from.theta_deg + turned.to_degrees()).rem_euclid(360.0),
        },
        radius_in: ROBOT_RADIUS_IN + DRIFT_IN_S * s + STRAYING * distance_in.abs(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::testing::state;

    fn after(left: i8, right: i8, s: u64) -> Option<Ghost> {
        let value = StateLine {
            wheel_left_in_s: left,
            wheel_right_in_s: right,
            ..state()
        };
        let at = Moment::from_secs(7);
        ghost(&Reading { value, at }, at + Moment::from_secs(s))
    }

    #[test]
    fn it_drives_on_as_it_did_and_grows() {
        assert_eq!(after(10, 10, 1), None, "it is heard");
        let ten = after(10, 10, 10).unwrap();
        assert!((ten.pose.y_in - 100.0).abs() < 1e-6 && ten.pose.x_in.abs() < 1e-6);
        let mut radius_in = 0.0;
        for s in 2..=60 {
            let grown = after(10, 10, s).unwrap().radius_in;
            assert!(grown > radius_in);
            radius_in = grown;
        }
        assert_eq!(
            after(10, 10, 60),
            after(10, 10, 86_400),
            "a day is no worse"
        );
        assert!(after(0, 0, 10).unwrap().radius_in < ten.radius_in);
    }

    #[test]
    fn it_turns_on_as_it_did() {
        // To the right around a point 20 in from its middle, by 10 in/s between wheels 10 in apart.
        let arc = after(25, 15, 2).unwrap();
        let radius_in = 20.0;
        let turned = 2.0 * 10.0 / TRACK_IN;
        assert!((arc.pose.x_in - radius_in * (1.0 - f64::cos(turned))).abs() < 1e-6);
        assert!((arc.pose.y_in - radius_in * f64::sin(turned)).abs() < 1e-6);
        assert!((arc.pose.theta_deg - turned.to_degrees()).abs() < 1e-6);
    }
}
