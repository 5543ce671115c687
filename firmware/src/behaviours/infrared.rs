//! Layer 3: infrared collision avoidance. Turns away from detections.
//!
//! A prowling robot passes between two detections if sonar measures open floor ahead, because they are the sides of a gap.

use super::behaviour::Behaviour;
use crate::arbiter::Request;
use crate::board::Sides;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::cps;

/// Turning speed while driving on: 57 degrees per second, so that half a second clears the edge of a wall.
const TURN_CPS: i16 = cps(10);

/// Turning speed on the spot: the same, because both detectors reach 30 inches.
const SPIN_CPS: i16 = cps(10);

/// Turning speed where sonar measures open floor ahead: 5 degrees per second keep the robot off an oblique wall from 18
/// inches away, and hardly turn it from the mouth of a passage.
const GAP_CPS: i16 = 13;

/// Reach of the detectors, inches. With a shorter horizon a detection may be behind the target.
const REACH_IN: u16 = 30;

/// Duration of a turn after a detection on one side: rare detections turn the robot less.
const HOLD_TICKS: u8 = 2;

/// Duration of a stop after a detection on both sides; if these are rare, the slew limit carries the robot on in a passage.
const STOP_TICKS: u8 = 1;

/// The latest detection while it still turns the robot.
#[derive(Clone, Debug, Default)]
pub struct InfraredAvoidance {
    sides: Sides,
    hold_ticks: u8,
}

impl Behaviour for InfraredAvoidance {
    fn decide(&mut self, senses: &Senses) -> Request {
        if senses.infrared.any() && senses.horizon_in >= REACH_IN {
            self.sides = senses.infrared;
            self.hold_ticks = if self.sides.left && self.sides.right {
                STOP_TICKS
            } else {
                HOLD_TICKS
            };
        }
        if self.hold_ticks == 0 {
            return Request::QUIET;
        }
        self.hold_ticks -= 1;
        let is_gap = senses.target.is_none() && senses.sonar.open().any();
        let (sides, turn_cps) = if is_gap {
            (self.sides.or(senses.sonar.blocked()), GAP_CPS)
        } else {
            (self.sides, TURN_CPS)
        };
        let turn = |rotation_cps| Motion {
            velocity_cps: senses.top_cps() / 2,
            rotation_cps,
        };
        Request::raise(match (sides.left, sides.right) {
            (true, false) => turn(turn_cps),
            (false, true) => turn(-turn_cps),
            _ if is_gap => turn(0),
            _ => Motion {
                velocity_cps: 0,
                rotation_cps: senses.in_turning_direction(SPIN_CPS),
            },
        })
    }

    fn rest(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensors::Ranges;
    use groundwave_protocol::Waypoint;

    fn see(left: bool, right: bool) -> Senses<'static> {
        Senses {
            infrared: Sides { left, right },
            ..Senses::idle()
        }
    }

    fn motion(senses: &Senses) -> Motion {
        let request = InfraredAvoidance::default().decide(senses);
        assert!(request.flag);
        request.motion
    }

    #[test]
    fn detection_on_one_side_turns_away_at_half_speed() {
        let away_from_left = motion(&see(true, false));
        assert_eq!(away_from_left.velocity_cps, cps(6));
        assert!(away_from_left.rotation_cps > 0);
        let away_from_right = motion(&see(false, true));
        assert_eq!(away_from_right.velocity_cps, cps(6));
        assert_eq!(away_from_right.rotation_cps, -away_from_left.rotation_cps);
    }

    #[test]
    fn detection_on_both_sides_spins_in_the_turning_direction() {
        for (turning_cps, sign) in [(-1, -1), (0, 1), (1, 1)] {
            let motion = motion(&Senses {
                turning_cps,
                ..see(true, true)
            });
            assert_eq!(motion.velocity_cps, 0);
            assert_eq!(motion.rotation_cps.signum(), sign, "turning {turning_cps}");
        }
    }

    #[test]
    fn prowling_robot_drives_on_between_obstacles_where_sonar_sees_open_floor() {
        let see = |left, right, left_in, right_in| {
            motion(&Senses {
                sonar: Ranges { left_in, right_in },
                ..see(left, right)
            })
        };
        assert_eq!(see(true, true, Some(90), None), Motion::new(6, 0));
        assert_eq!(see(true, false, Some(90), Some(20)), Motion::new(6, 0));
        assert_eq!(see(true, false, Some(90), None).rotation_cps, GAP_CPS);
        assert_eq!(see(false, true, None, Some(90)).rotation_cps, -GAP_CPS);
        assert_eq!(see(true, false, Some(20), None), Motion::new(6, 10));
        let bound = Senses {
            target: Waypoint::new(0, 500),
            sonar: Ranges {
                left_in: Some(90),
                right_in: Some(90),
            },
            ..self::see(true, false)
        };
        assert_eq!(motion(&bound), Motion::new(6, 10));
    }

    #[test]
    fn detection_lasts_two_ticks_or_one_on_both_sides() {
        for (left, right, lasts) in [
            (true, false, true),
            (false, true, true),
            (true, true, false),
        ] {
            let mut layer = InfraredAvoidance::default();
            let flags = [see(left, right), see(false, false), see(false, false)]
                .map(|senses| layer.decide(&senses).flag);
            assert_eq!(flags, [true, lasts, false], "{left} {right}");
        }
    }

    #[test]
    fn detection_close_to_the_target_is_ignored() {
        for (horizon_in, flag) in [(30, true), (29, false)] {
            let senses = Senses {
                horizon_in,
                ..see(true, true)
            };
            assert_eq!(InfraredAvoidance::default().decide(&senses).flag, flag);
        }
    }

    #[test]
    fn no_detection_is_no_request() {
        let mut layer = InfraredAvoidance::default();
        assert_eq!(layer.decide(&see(false, false)), Request::QUIET);
    }
}
