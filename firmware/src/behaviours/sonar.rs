//! Layer 4: stereo sonar ranging. Toward the side with the longer view.

use super::Behaviour;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::parameters::Parameter;
use crate::sensors::Senses;
use crate::units::cps;

/// Farther than this is all the same: a doorway 8 ft away must stand out, the end of a hall not.
const FAR_IN: u16 = 180;

/// Rotation times the shorter view, so that what is near is turned from sharply: 8 in/s at 30 in, and no
/// sharper, or it swings past an opening by the time of the next echo.
const SHARPNESS_CPS_IN: i32 = cps(8) as i32 * 30;

/// The gentlest turn that is one.
const TURN_LEAST_CPS: i32 = cps(3) as i32;

/// The sharpest: 92 degrees a second.
const TURN_MOST_CPS: i32 = cps(16) as i32;

/// It has no state: what it does follows from the latest echoes.
#[derive(Clone, Debug, Default)]
pub struct Sonar;

impl Behaviour for Sonar {
    fn decide(&mut self, senses: &Senses) -> Request {
        let view = |range_in: Option<u16>| i32::from(range_in.unwrap_or(FAR_IN).min(FAR_IN));
        let (left_in, right_in) = (view(senses.sonar.left_in), view(senses.sonar.right_in));
        let (shorter_in, longer_in) = (left_in.min(right_in), left_in.max(right_in));
        if shorter_in >= i32::from(senses.horizon_in) {
            return Request::QUIET;
        }
        let close_in = i32::from(senses.parameters.get(Parameter::SonarClose));
        let is_close = longer_in < close_in;
        // Sonars scatter by some per cent.
        let deadzone_pct = i32::from(senses.parameters.get(Parameter::SonarDeadzone));
        let differs = (longer_in - shorter_in) * 100 > deadzone_pct * (longer_in + shorter_in);
        if !is_close && !differs {
            return Request::QUIET;
        }
        let sharp =
            (SHARPNESS_CPS_IN / shorter_in.max(1)).clamp(TURN_LEAST_CPS, TURN_MOST_CPS) as i16;
        let rotation_cps = if !differs {
            senses.the_way_it_turns(sharp)
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
    use crate::sensors::Ranges;

    fn decide(left_in: u16, right_in: u16) -> Request {
        Sonar.decide(&Senses {
            sonar: Ranges {
                left_in: Some(left_in),
                right_in: Some(right_in),
            },
            ..Senses::nothing()
        })
    }

    #[test]
    fn it_turns_to_the_longer_side_when_they_differ_by_more_than_the_deadzone() {
        assert!(decide(60, 100).motion.rotation_cps > 0);
        assert!(decide(100, 60).motion.rotation_cps < 0);
        assert_eq!(decide(60, 100).motion.velocity_cps, cps(12));
    }

    #[test]
    fn the_deadzone_is_a_share_of_the_sum() {
        // 15 % of 200 is 30: a difference of 30 is within, of 32 is not.
        assert_eq!(decide(85, 115), Request::QUIET);
        assert!(decide(84, 116).flag);
    }

    #[test]
    fn it_turns_the_sharper_the_nearer() {
        let rotations = [120, 60, 31].map(|near_in| decide(near_in, 180).motion.rotation_cps);
        assert!(
            rotations.is_sorted() && rotations[0] < rotations[2],
            "{rotations:?}"
        );
    }

    #[test]
    fn both_close_means_no_further_ahead() {
        let request = decide(29, 20);
        assert!(request.flag && request.motion.rotation_cps < 0);
        assert_eq!(request.motion.velocity_cps, 0);
        // Equal on both sides: it must turn somewhere.
        assert_eq!(decide(29, 29).motion.velocity_cps, 0);
        assert_ne!(decide(29, 29).motion.rotation_cps, 0);
        assert_eq!(decide(31, 31), Request::QUIET);
    }

    #[test]
    fn the_operator_tunes_what_is_close_and_what_differs() {
        let mut parameters = crate::parameters::Parameters::DEFAULT;
        assert!(parameters.set(Parameter::SonarClose, 60));
        assert!(parameters.set(Parameter::SonarDeadzone, 50));
        let mut senses = Senses {
            parameters: &parameters,
            ..Senses::nothing()
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
    fn no_echo_is_a_long_view() {
        let mut senses = Senses::nothing();
        assert_eq!(Sonar.decide(&senses), Request::QUIET);
        senses.sonar.left_in = Some(50);
        assert!(Sonar.decide(&senses).motion.rotation_cps > 0);
    }

    #[test]
    fn what_lies_beyond_the_horizon_does_not_matter() {
        let mut senses = Senses::nothing();
        senses.sonar.left_in = Some(50);
        senses.horizon_in = 50;
        assert_eq!(Sonar.decide(&senses), Request::QUIET);
        senses.horizon_in = 51;
        assert!(Sonar.decide(&senses).flag);
    }
}
