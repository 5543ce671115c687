//! Layer 4: stereo sonar. Turns toward the side with the longer range.
//!
//! At a corner of a narrow passage the longest view is often the way back, so the robot looks to both sides before it turns
//! round.

use super::behaviour::Behaviour;
use crate::angle::Angle;
use crate::arbiter::Request;
use crate::board::{COUNTS_PER_IN, Sides};
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

/// Turn after which the robot has looked to a side: 96 degrees, so that a sonar has faced a way at a right angle.
const LOOK_TURN: i16 = 0x4400;

/// Path, ahead and backward, after which the robot has left a corner, in counts of both wheels: 32 inches.
const LEAVE_COUNTS: i16 = 32 * COUNTS_PER_IN as i16 * 2;

/// The search for the way on in a confined space.
#[derive(Clone, Debug, Default)]
struct Search {
    /// Heading at the start: the way on is not behind it.
    ahead: Angle,
    /// Heading relative to that, positive to the right.
    turned: i16,
    /// Sides to which the robot has looked.
    looked: Sides,
    /// Path since the start, ahead and backward, counts of both wheels.
    path_counts: i16,
}

impl Search {
    /// A search that starts at the robot's heading.
    fn from(senses: &Senses) -> Self {
        Self {
            ahead: senses.pose.heading,
            ..Self::default()
        }
    }

    /// Takes the motion of the past tick. A new search starts where the robot has left the corner.
    fn advance(&mut self, senses: &Senses) {
        self.path_counts = self
            .path_counts
            .saturating_add(senses.path_counts.saturating_abs());
        if self.path_counts > LEAVE_COUNTS {
            *self = Self::from(senses);
        }
        let faced_back = self.faces_back();
        self.turned = senses.pose.heading.minus(self.ahead);
        // Between two looks the robot may turn past its own back, with a contact.
        if self.faces_back() != faced_back {
            let is_left = self.turned < 0;
            self.looked.left |= is_left;
            self.looked.right |= !is_left;
        }
    }

    /// Whether the robot has looked to one side alone, so that the way on may be at the other.
    const fn is_half_done(&self) -> bool {
        self.looked.left != self.looked.right
    }

    /// Whether the robot faces the way by which it came.
    fn faces_back(&self) -> bool {
        self.turned.unsigned_abs() > LOOK_TURN.unsigned_abs()
    }
}

/// State of the sonar layer.
#[derive(Clone, Debug, Default)]
pub struct Sonar {
    /// The search, in a confined space.
    search: Option<Search>,
}

impl Sonar {
    /// Drops the search, because the odometer has been set.
    pub fn forget_heading(&mut self) {
        self.search = None;
    }
}

impl Behaviour for Sonar {
    fn decide(&mut self, senses: &Senses) -> Request {
        if senses.is_confined {
            let search = self.search.get_or_insert_with(|| Search::from(senses));
            search.advance(senses);
        } else {
            self.search = None;
        }
        let half_done = self.search.as_ref().filter(|search| search.is_half_done());
        let faces_back = half_done.is_some_and(Search::faces_back);
        // Between near walls the missing echoes of both sides are smooth walls met obliquely.
        let is_deaf = senses.is_confined && senses.sonar == Ranges::default();
        let unheard_in = if is_deaf { 0 } else { FAR_IN };
        let view = |range_in: Option<u16>| i32::from(range_in.unwrap_or(unheard_in).min(FAR_IN));
        let (left_in, right_in) = (view(senses.sonar.left_in), view(senses.sonar.right_in));
        let (shorter_in, longer_in) = (left_in.min(right_in), left_in.max(right_in));
        if shorter_in >= i32::from(senses.horizon_in) && !faces_back {
            return Request::QUIET;
        }
        let mut close_in = i32::from(senses.parameters.get(Parameter::SonarClose));
        if senses.is_confined && half_done.is_none() {
            close_in /= CONFINED;
        }
        let is_close = longer_in < close_in || faces_back;
        // Sonar ranges scatter by some percent.
        let deadzone_pct = i32::from(senses.parameters.get(Parameter::SonarDeadzone));
        let differs = (longer_in - shorter_in) * 100 > deadzone_pct * (longer_in + shorter_in);
        if !is_close && !differs {
            return Request::QUIET;
        }
        let sharp =
            (SHARPNESS_CPS_IN / shorter_in.max(1)).clamp(TURN_LEAST_CPS, TURN_MOST_CPS) as i16;
        let rotation_cps = match half_done.filter(|_| is_close) {
            None if !differs => senses.in_turning_direction(sharp),
            search if search.map_or(right_in > left_in, |search| search.looked.left) => sharp,
            _ => -sharp,
        };
        let velocity_cps = if is_close { 0 } else { senses.top_cps() };
        Request::raise(Motion {
            velocity_cps,
            rotation_cps,
        })
    }

    fn rest(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn decide(left_in: u16, right_in: u16) -> Request {
        Sonar::default().decide(&Senses {
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
            Sonar::default().decide(&Senses {
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
        assert_eq!(Sonar::default().decide(&senses).motion.velocity_cps, 0);
        senses.sonar.right_in = Some(170);
        assert_eq!(Sonar::default().decide(&senses), Request::QUIET);
        senses.sonar.right_in = Some(180);
        assert!(Sonar::default().decide(&senses).flag);
    }

    #[test]
    fn missing_echo_is_a_long_range() {
        let mut senses = Senses::idle();
        assert_eq!(Sonar::default().decide(&senses), Request::QUIET);
        senses.sonar.left_in = Some(50);
        assert!(Sonar::default().decide(&senses).motion.rotation_cps > 0);
    }

    #[test]
    fn two_missing_echoes_are_walls_in_a_confined_space() {
        let mut senses = Senses {
            is_confined: true,
            ..Senses::idle()
        };
        assert_eq!(Sonar::default().decide(&senses).motion.velocity_cps, 0);
        senses.sonar.left_in = Some(50);
        assert!(Sonar::default().decide(&senses).motion.rotation_cps > 0);
    }

    #[test]
    fn obstacle_beyond_the_horizon_is_ignored() {
        let mut senses = Senses::idle();
        senses.sonar.left_in = Some(50);
        senses.horizon_in = 50;
        assert_eq!(Sonar::default().decide(&senses), Request::QUIET);
        senses.horizon_in = 51;
        assert!(Sonar::default().decide(&senses).flag);
    }

    /// Headings to which the layer turns a robot on the spot, in a confined space with the same view on both sides.
    fn headings_deg(view_in: impl Fn(u16) -> u16) -> Vec<u16> {
        let mut sonar = Sonar::default();
        let mut heading_deg = 0;
        let mut headings_deg = Vec::new();
        for _ in 0..800 {
            headings_deg.push(heading_deg);
            let view_in = view_in(heading_deg);
            let senses = facing(heading_deg, view_in);
            let request = sonar.decide(&senses);
            if !request.flag || request.motion.velocity_cps != 0 {
                break;
            }
            heading_deg = (heading_deg
                + if request.motion.rotation_cps > 0 {
                    1
                } else {
                    359
                })
                % 360;
        }
        headings_deg
    }

    fn facing(heading_deg: u16, view_in: u16) -> Senses<'static> {
        let mut odometer = crate::odometry::Odometer::default();
        odometer.set(
            groundwave_protocol::Waypoint { x_in: 0, y_in: 0 },
            Angle::from_degrees(heading_deg),
        );
        Senses {
            pose: odometer.pose(),
            sonar: Ranges {
                left_in: Some(view_in),
                right_in: Some(view_in),
            },
            is_confined: true,
            ..Senses::idle()
        }
    }

    #[test]
    fn corner_is_searched_to_both_sides_before_the_way_back() {
        // The way on is to the left, and idle senses turn to the right first.
        let left = headings_deg(|heading_deg| match heading_deg {
            265..=275 => 90,
            160..=200 => 150,
            _ => 9,
        });
        assert_eq!(
            left.iter().filter(|&&deg| (90..=180).contains(&deg)).max(),
            Some(&96),
            "{left:?}"
        );
        assert_eq!(left.last(), Some(&275));
        // A dead end: to the right, to the left, and back.
        let dead_end = headings_deg(|heading_deg| {
            if (160..=200).contains(&heading_deg) {
                150
            } else {
                9
            }
        });
        assert!(
            dead_end.contains(&96) && dead_end.contains(&264),
            "{dead_end:?}"
        );
        assert!(
            (160..=200).contains(dead_end.last().expect("a heading")),
            "{dead_end:?}"
        );
    }

    #[test]
    fn robot_that_faces_back_turns_to_the_side_it_has_not_looked_to() {
        let mut sonar = Sonar::default();
        sonar.decide(&facing(0, 9));
        // A contact has turned it to the left by half a turn.
        let request = sonar.decide(&facing(200, 150));
        assert_eq!(request.motion.velocity_cps, 0);
        assert!(request.motion.rotation_cps > 0);
        // 32 inches further it has left the corner.
        let mut senses = facing(200, 150);
        senses.path_counts = LEAVE_COUNTS + 1;
        assert_eq!(sonar.decide(&senses), Request::QUIET);
        assert_eq!(sonar.decide(&facing(200, 150)), Request::QUIET);
    }

    #[test]
    fn turn_past_the_back_is_a_look_to_one_side() {
        let mut sonar = Sonar::default();
        for heading_deg in [0, 60, 120, 200] {
            sonar.decide(&facing(heading_deg, 9));
        }
        let looked = sonar.search.as_ref().expect("a search").looked;
        assert_eq!((looked.left, looked.right), (false, true));
        // On to the left side, by the way of the back.
        sonar.decide(&facing(270, 9));
        let looked = sonar.search.as_ref().expect("a search").looked;
        assert_eq!((looked.left, looked.right), (true, true));
    }

    #[test]
    fn backing_off_does_not_lengthen_a_search() {
        let mut sonar = Sonar::default();
        let mut senses = facing(0, 9);
        sonar.decide(&senses);
        senses.path_counts = -LEAVE_COUNTS / 2;
        sonar.decide(&senses);
        senses.path_counts = LEAVE_COUNTS / 2 + 2;
        sonar.decide(&senses);
        assert_eq!(sonar.search.as_ref().expect("a search").path_counts, 0);
    }

    #[test]
    fn search_ends_on_open_floor() {
        let mut sonar = Sonar::default();
        sonar.decide(&facing(0, 9));
        let open = Senses {
            is_confined: false,
            ..facing(200, 150)
        };
        assert_eq!(sonar.decide(&open), Request::QUIET);
        assert_eq!(sonar.decide(&facing(200, 150)), Request::QUIET);
    }

    #[test]
    fn search_starts_again_when_the_odometer_is_set() {
        let mut sonar = Sonar::default();
        sonar.decide(&facing(0, 9));
        sonar.forget_heading();
        assert_eq!(sonar.decide(&facing(200, 150)), Request::QUIET);
    }
}
