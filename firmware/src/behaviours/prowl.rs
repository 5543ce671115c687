//! Prowl, the lowest priority: straight ahead at top speed, or toward a target.

use crate::angle::{Angle, square_root};
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::odometry::Pose;
use crate::sensors::Senses;
use crate::units::cps;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;

/// Minimum approach speed: below it the wheels begin to stick.
const CREEP_CPS: i16 = cps(2);

/// Distance from which the robot slows down, inches: twice its stopping distance.
const SLOW_DOWN_IN: i32 = 24;

/// Heading error above which the robot turns on the spot instead of driving an arc: 60 degrees.
const AIM_ERROR: i32 = 0x1_0000 / 6;

/// Heading error per count a second of rotation: 30 degrees give 8.5 in/s, which settles in about half a second.
const ERROR_PER_CPS: i32 = 40;

/// Maximum rotation toward a target: 80 degrees per second.
const TURN_CPS: i32 = cps(14) as i32;

/// Request without a target in modes Prowl and Wander: straight ahead.
#[must_use]
pub fn freely(senses: &Senses) -> Request {
    if matches!(senses.mode, Mode::Prowl | Mode::Wander) && senses.target.is_none() {
        Request::raise(Motion {
            velocity_cps: senses.top_cps(),
            rotation_cps: 0,
        })
    } else {
        Request::QUIET
    }
}

/// Motion toward a target: turns by the heading error and slows down on approach.
#[must_use]
pub fn toward(senses: &Senses, target: Waypoint) -> Motion {
    let (x, y) = senses.pose.offset_to(target);
    let error = i32::from(Angle::toward(x, y).minus(senses.pose.heading));
    let distance_in = distance_in(&senses.pose, target).min(SLOW_DOWN_IN);
    let speed =
        (i32::from(senses.top_cps()) * distance_in / SLOW_DOWN_IN).max(i32::from(CREEP_CPS));
    let aimed = (AIM_ERROR - error.abs()).max(0);
    Motion {
        velocity_cps: (speed * aimed / AIM_ERROR) as i16,
        rotation_cps: (error / ERROR_PER_CPS).clamp(-TURN_CPS, TURN_CPS) as i16,
    }
}

/// Distance to a target in inches, rounded down; above 100 inches the distance along the longer axis.
#[must_use]
pub fn distance_in(pose: &Pose, target: Waypoint) -> i32 {
    const EXACT: i32 = 100 * 16;
    let (x, y) = pose.offset_to(target);
    let (x, y) = (x.abs(), y.abs());
    if x.max(y) > EXACT {
        x.max(y) / 16
    } else {
        square_root((x * x + y * y) as u32) as i32 / 16
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn toward(x_in: i16, y_in: i16) -> Motion {
        super::toward(&Senses::idle(), Waypoint { x_in, y_in })
    }

    #[test]
    fn free_prowling_needs_its_mode_and_no_target() {
        let mut senses = Senses::idle();
        let request = freely(&senses);
        assert_eq!(request, Request::raise(Motion::new(12, 0)));
        senses.mode = Mode::Reactive;
        assert_eq!(freely(&senses), Request::QUIET);
        senses.mode = Mode::Wander;
        assert_eq!(freely(&senses), request);
        senses.mode = Mode::Prowl;
        senses.target = Waypoint::new(0, 0);
        assert_eq!(freely(&senses), Request::QUIET);
    }

    #[test]
    fn approach_slows_down_to_a_creep() {
        let speeds = [1, 4, 6, 12, 23, 24, 1000].map(|y_in| toward(0, y_in).velocity_cps);
        assert_eq!(
            speeds,
            [cps(2), cps(2), cps(3), cps(6), 184, cps(12), cps(12)]
        );
    }

    #[test]
    fn rotation_takes_the_shorter_direction() {
        assert_eq!(toward(0, 50).rotation_cps, 0);
        assert!(toward(5, 50).rotation_cps > 0);
        assert!(toward(-5, 50).rotation_cps < 0);
        assert!(toward(50, -1).rotation_cps > toward(5, 50).rotation_cps);
    }

    #[test]
    fn large_heading_error_turns_on_the_spot() {
        assert_eq!(toward(50, 0).velocity_cps, 0);
        assert_eq!(toward(0, -50).velocity_cps, 0);
        assert!(toward(50, 100).velocity_cps < cps(12));
    }

    #[test]
    fn distances_are_whole_inches() {
        let pose = Pose::default();
        for (x_in, y_in, distance) in [(3, 4, 5), (0, 0, 0), (-6, 0, 6), (9999, -9999, 9999)] {
            assert_eq!(distance_in(&pose, Waypoint { x_in, y_in }), distance);
        }
    }
}
