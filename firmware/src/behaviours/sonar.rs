//! Layer 4: stereo sonar. Turns toward the side with the longer range.

use super::behaviour::Behaviour;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::{Ranges, Senses};
use crate::units::cps;

/// Maximum range considered, inches: a doorway 8 ft away must differ from the wall, the end of a hall need not.
const FAR_IN: u16 = 180;

/// Rotation times the shorter range, so that near obstacles cause sharper turns: 8 in/s at 30 in. A sharper turn would
/// pass an opening before the next echo.
const SHARPNESS_CPS_IN: i32 = cps(8) as i32 * 30;

/// Divisor of the close range in a confined space, where the robot drives on into a corner to see around it.
const CONFINED: i32 = 3;

/// Minimum rotation.
const TURN_LEAST_CPS: i32 = cps(3) as i32;

/// Maximum rotation: 92 degrees per second.
const TURN_MOST_CPS: i32 = cps(16) as i32;

/// The layer has no state: its request follows from the latest echoes.
#[derive(Clone, Debug, Default)]
pub struct Sonar;

impl Behaviour for Sonar {
    fn decide(&mut self, senses: &Senses) -> Request {
        // Between near walls the missing echoes of both sides are smooth walls met obliquely.
        let is_deaf = senses.is_confined && senses.sonar == Ranges::default();
        let unheard_in = if is_deaf { 0 } else { FAR_IN };
        let view = |range_in: Option<u16>| i32::from(range_in.unwrap_or(unheard_in).min(FAR_IN));
        let (left_in, right_in) = (view(senses.sonar.left_in), view(senses.sonar.right_in));
        let (shorter_in, longer_in) = (left_in.min(right_in), left_in.max(right_in));
        if shorter_in >= i32::from(senses.horizon_in) {
            return Request::QUIET;
        }
        let mut close_in = i32::from(senses.parameters.get(Parameter::SonarClose));
        if senses.is_confined {
            close_in /= CONFINED;
        }
        let is_close = longer_in < close_in;
        // Sonar ranges scatter by some percent.
        let deadzone_pct = i32::from(senses.parameters.get(Parameter::SonarDeadzone));
        let differs = (longer_in - shorter_in) * 100 > deadzone_pct * (longer_in + shorter_in);
        if !is_close && !differs {
            return Request::QUIET;
        }
        let sharp =
            (SHARPNESS_CPS_IN / shorter_in.max(1)).clamp(TURN_LEAST_CPS, TURN_MOST_CPS) as i16;
        let rotation_cps = if !differs {
            senses.in_turning_direction(sharp)
        } else if right_in > left_in {
            sharp
        } else {
            -sharp
        };
        let velocity_cps = if is_close { 0 } else { senses.top_cps() };
        Request::raise(Motion {
            velocity_cps,
            rotation_cps,
        })
    }

    fn rest(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decide(left_in: u16, right_in: u16) -> Request {
        Sonar.decide(&Senses {
            sonar: Ranges {
                left_in: Some(left_in),
                right_in: Some(right_in),
            },
            ..Senses::idle()
        })
    }

    #[test]
    fn difference_above_the_deadzone_turns_to_the_longer_range() {
        assert!(decide(60, 100).motion.rotation_cps > 0);
        assert!(decide(100, 60).motion.rotation_cps < 0);
        assert_eq!(decide(60, 100).motion.velocity_cps, cps(12));
    }

    #[test]
    fn deadzone_is_a_share_of_the_sum() {
        // 15 % of 200 is 30: a difference of 30 is within, of 32 is not.
        assert_eq!(decide(85, 115), Request::QUIET);
        assert!(decide(84, 116).flag);
    }

    #[test]
    fn rotation_grows_as_the_obstacle_comes_nearer() {
        let rotations = [120, 60, 31].map(|near_in| decide(near_in, 180).motion.rotation_cps);
        assert!(
            rotations.is_sorted() && rotations[0] < rotations[2],
            "{rotations:?}"
        );
    }

    #[test]
    fn close_obstacles_on_both_sides_stop_the_drive() {
        let request = decide(29, 20);
        assert!(request.flag && request.motion.rotation_cps < 0);
        assert_eq!(request.motion.velocity_cps, 0);
        // Equal on both sides: the robot must still turn.
        assert_eq!(decide(29, 29).motion.velocity_cps, 0);
        assert_ne!(decide(29, 29).motion.rotation_cps, 0);
        assert_eq!(decide(31, 31), Request::QUIET);
    }

    #[test]
    fn obstacles_are_close_only_at_a_third_of_the_range_in_a_confined_space() {
        let decide = |range_in| {
            Sonar.decide(&Senses {
                sonar: Ranges {
                    left_in: Some(range_in),
                    right_in: Some(range_in),
                },
                is_confined: true,
                ..Senses::idle()
            })
        };
        assert_eq!(decide(10), Request::QUIET);
        assert_eq!(decide(9).motion.velocity_cps, 0);
    }

    #[test]
    fn parameters_set_the_close_range_and_the_deadzone() {
        let mut parameters = crate::parameters::Parameters::DEFAULT;
        assert!(parameters.set(Parameter::SonarClose, 60));
        assert!(parameters.set(Parameter::SonarDeadzone, 50));
        let mut senses = Senses {
            parameters: &parameters,
            ..Senses::idle()
        };
        senses.sonar.left_in = Some(59);
        senses.sonar.right_in = Some(59);
        assert_eq!(Sonar.decide(&senses).motion.velocity_cps, 0);
        senses.sonar.right_in = Some(170);
        assert_eq!(Sonar.decide(&senses), Request::QUIET);
        senses.sonar.right_in = Some(180);
        assert!(Sonar.decide(&senses).flag);
    }

    #[test]
    fn missing_echo_is_a_long_range() {
        let mut senses = Senses::idle();
        assert_eq!(Sonar.decide(&senses), Request::QUIET);
        senses.sonar.left_in = Some(50);
        assert!(Sonar.decide(&senses).motion.rotation_cps > 0);
    }

    #[test]
    fn two_missing_echoes_are_walls_in_a_confined_space() {
        let mut senses = Senses {
            is_confined: true,
            ..Senses::idle()
        };
        assert_eq!(Sonar.decide(&senses).motion.velocity_cps, 0);
        senses.sonar.left_in = Some(50);
        assert!(Sonar.decide(&senses).motion.rotation_cps > 0);
    }

    #[test]
    fn obstacle_beyond_the_horizon_is_ignored() {
        let mut senses = Senses::idle();
        senses.sonar.left_in = Some(50);
        senses.horizon_in = 50;
        assert_eq!(Sonar.decide(&senses), Request::QUIET);
        senses.horizon_in = 51;
        assert!(Sonar.decide(&senses).flag);
    }
}
