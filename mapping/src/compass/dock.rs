//! The dock as a landmark: by convention it is at the origin of the odometer's frame (`docking` in the robot's program), so a robot
//! that has found it is there.

use groundwave_protocol::status_codes::{Mode, Power};
use groundwave_protocol::telemetry::StateLine;

use super::lines::{position_in, turn_deg};

/// Variance of a docked robot's position on each axis, square inches: the dock is as wide as the robot, and its front is some
/// inches from the origin.
pub(super) const VARIANCE: f64 = 64.0;

/// Variance of a docked robot's heading around the dock's, square degrees: it comes at an angle of up to 20 degrees.
pub(super) const HEADING: f64 = 112.5;

/// Lines A on the dock after which the robot is there: contacts bounce, and the robot stands.
const LINES: u8 = 3;

/// Deviation of the estimated heading up to which it is the dock's, degrees.
const KNOWN_DEG: f64 = 15.0;

/// Distance from the origin within which a robot that begins on a dock is at home, inches.
const AT_HOME_IN: f64 = 12.0;

/// The dock's contacts, and the robot's heading on it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Dock {
    lines: u8,
    /// True heading on the dock at the first time.
    heading_deg: Option<f64>,
}

impl Dock {
    /// The dock in a frame whose first line is given: a robot that begins on its dock shows its heading there.
    pub(super) fn of_first(state: &StateLine) -> Self {
        let (x_in, y_in) = position_in(state);
        let is_at_home = libm::hypot(x_in, y_in) < AT_HOME_IN;
        Self {
            lines: 0,
            heading_deg: (is_docked(state) && is_at_home).then(|| f64::from(state.theta_deg)),
        }
    }

    /// Takes a line; returns whether the robot has found its dock with it. A robot that is charged elsewhere does not forage.
    pub(super) fn take(&mut self, state: &StateLine) -> bool {
        let stands = state.wheel_left_in_s == 0 && state.wheel_right_in_s == 0;
        self.lines = if is_docked(state) && state.mode == Mode::Forage && stands {
            self.lines.saturating_add(1)
        } else {
            0
        };
        self.lines == LINES
    }

    /// True heading on the dock, degrees, once it is known.
    pub(super) const fn heading_deg(&self) -> Option<f64> {
        self.heading_deg
    }

    /// Quarter turns by which an estimated heading is off; `None` if that is not known. The first heading that is known well is the dock's.
    pub(super) fn quarters(
        &mut self,
        heading_deg: f64,
        deviation_deg: f64,
        is_lost: bool,
    ) -> Option<i32> {
        if let Some(dock_deg) = self.heading_deg {
            return Some(libm::round(turn_deg(heading_deg, dock_deg) / 90.0) as i32);
        }
        if is_lost {
            return None;
        }
        self.heading_deg = (deviation_deg < KNOWN_DEG).then_some(heading_deg);
        Some(0)
    }
}

const fn is_docked(state: &StateLine) -> bool {
    matches!(state.power, Power::Docked | Power::Charging)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn docked() -> StateLine {
        StateLine {
            power: Power::Charging,
            mode: Mode::Forage,
            ..StateLine::BLANK
        }
    }

    #[test]
    fn a_robot_has_docked_once_it_stands_on_the_dock_that_it_looked_for() {
        let charged_by_hand = StateLine {
            mode: Mode::Stop,
            ..docked()
        };
        let pushing = StateLine {
            wheel_left_in_s: 2,
            ..docked()
        };
        for (what, line, docks) in [
            ("it stands", docked(), 1),
            ("by hand", charged_by_hand, 0),
            ("it pushes", pushing, 0),
            ("without power", StateLine::BLANK, 0),
        ] {
            let mut dock = Dock::default();
            let count = (0..20).filter(|_| dock.take(&line)).count();
            assert_eq!(count, docks, "{what}");
        }
        let mut dock = Dock::default();
        for _ in 0..10 {
            assert!(!(0..LINES - 1).any(|_| dock.take(&docked())), "a contact");
            dock.take(&StateLine::BLANK);
        }
    }

    /// Headings on the dock: what the estimate says, its deviation, whether it may have lost a quarter turn, and the result.
    #[test]
    fn the_dock_shows_how_many_quarter_turns_were_lost() {
        let mut dock = Dock::default();
        for (heading_deg, deviation_deg, is_lost, quarters) in [
            (100.0, 5.0, true, None),
            (100.0, 30.0, false, Some(0)),
            (170.0, 5.0, false, Some(0)),
            (-160.0, 5.0, true, Some(0)),
            (85.0, 20.0, true, Some(1)),
            (265.0, 5.0, false, Some(-1)),
            (-5.0, 5.0, true, Some(2)),
        ] {
            let found = dock.quarters(heading_deg, deviation_deg, is_lost);
            let found = found.map(|count| count.rem_euclid(4));
            assert_eq!(
                found,
                quarters.map(|count: i32| count.rem_euclid(4)),
                "{heading_deg}"
            );
        }
    }

    #[test]
    fn a_robot_that_begins_on_its_dock_shows_its_heading_there() {
        let begun = StateLine {
            theta_deg: 180,
            ..docked()
        };
        assert_eq!(Dock::of_first(&begun).quarters(90.0, 40.0, true), Some(1));
        let far = StateLine {
            x_tenths_in: 400,
            ..begun
        };
        assert_eq!(Dock::of_first(&far).quarters(90.0, 40.0, true), None);
    }
}
