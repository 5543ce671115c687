//! Places that the robot knows again: its dock, and what it saw of home in a scan.

use super::drift::{Estimate, Motion};
use super::panorama::Panorama;
use super::reckoning::Reckoning;
use super::tracker::Fix;
use super::{Compass, dock};
use crate::pose::turned;
use crate::trail::Trail;

/// Least and greatest deviation of the place of a scan that is searched, inches, and variance of the place that is found from home's, square
/// inches, on each axis.
const SEARCHED_IN: (f64, f64) = (10.0, 30.0);
const FOUND: f64 = 9.0;

/// Long semi-axis of the 95 % ellipse up to which a scan before the map is one of home, inches, and up to which one is worth an order: it
/// grows until the scan ends.
const AT_HOME_IN: f64 = 24.0;
const BEFORE_SCAN_IN: f64 = 12.0;

/// Multiple of the 95 % ellipse; a docked robot beyond it was misplaced.
const FAR: f64 = 1.5;

/// The scan at home, before the map: where it ended in the world, its variance on each axis, square inches, and the error of the heading
/// there, degrees.
#[derive(Clone, Debug)]
pub(super) struct Home {
    panorama: Panorama,
    at_in: (f64, f64),
    variance: f64,
    error_deg: f64,
}

impl Compass {
    /// Whether a scan has shown how home looks, so that another one nearby shows where home is.
    #[must_use]
    pub const fn knows_home(&self) -> bool {
        self.home.is_some()
    }

    /// Whether a scan now would be one of home.
    #[must_use]
    pub fn may_see_home(&self) -> bool {
        self.last.is_some()
            && self.tracker.is_none()
            && self.home.is_none()
            && !self.is_lifted
            && self.reckoning.ellipse().long_in <= BEFORE_SCAN_IN
    }

    /// Takes a scan that has ended: at home, or where the robot may see what it saw there.
    pub(super) fn take_panorama(&mut self, panorama: Panorama, theta_deg: f64) {
        let (error, _) = self.drift.heading(self.motion);
        let Some(tracker) = &self.tracker else {
            if !self.is_lifted
                && self.home.is_none()
                && self.reckoning.ellipse().long_in <= AT_HOME_IN
            {
                self.home = Some(Home {
                    panorama,
                    at_in: (self.reckoning.x_in, self.reckoning.y_in),
                    variance: self.reckoning.variance(),
                    error_deg: error.value,
                });
            }
            return;
        };
        let (Some(home), Some(pose)) = (&self.home, self.pose()) else {
            return;
        };
        let house = self.drift.house(tracker.reference_deg);
        let house_rad = house.value.to_radians();
        let of_error = |error_deg: f64, deviation: f64| Estimate {
            value: house.value - error_deg,
            deviation,
        };
        let at_home = home
            .panorama
            .direction_deg(of_error(home.error_deg, house.deviation));
        let here = panorama.direction_deg(of_error(error.value, error.deviation));
        let from_home = (pose.x_in - home.at_in.0, pose.y_in - home.at_in.1);
        let found = panorama.displacement(
            &home.panorama.features(at_home),
            here,
            turned(from_home, house_rad),
            pose.ellipse.long_in.clamp(SEARCHED_IN.0, SEARCHED_IN.1),
        );
        let Some(found) = found else {
            return;
        };
        let (x_in, y_in) = turned(found, -house_rad);
        let at_in = (home.at_in.0 + x_in, home.at_in.1 + y_in);
        let fix = Fix {
            at_in: tracker.in_house(at_in, house),
            variance: FOUND + home.variance,
            trusts_map: true,
        };
        self.end_stretch(theta_deg, Some(fix));
    }

    /// Takes the robot's place on its dock: it is at home, and its heading is known again if it has been there before.
    pub(super) fn dock_at_home(&mut self, theta_deg: f64) {
        if self.is_lifted {
            self.begin_at_dock(theta_deg);
            return;
        }
        let Some(tracker) = &self.tracker else {
            return;
        };
        let (error, is_lost) = self.drift.heading(self.motion);
        let heading_deg = theta_deg + error.value;
        let Some(quarters) = self.dock.quarters(heading_deg, error.deviation, is_lost) else {
            return;
        };
        let house = self.drift.house(tracker.reference_deg);
        let dock_in = tracker.in_house((0.0, 0.0), house);
        self.drift.find(quarters);
        let is_far = self
            .pose()
            .is_none_or(|pose| pose.ellipse.multiple((pose.x_in, pose.y_in)) > FAR);
        let fix = Fix {
            at_in: dock_in,
            variance: dock::VARIANCE,
            trusts_map: false,
        };
        self.end_stretch(theta_deg, Some(fix));
        if quarters != 0 || is_far {
            // What was seen is misplaced.
            self.tracker = None;
            self.reckoning = Reckoning::near((0.0, 0.0), dock::VARIANCE);
            self.begin_map();
        }
    }

    /// Begins again on the dock, if its heading is known.
    fn begin_at_dock(&mut self, theta_deg: f64) {
        let Some(heading_deg) = self.dock.heading_deg() else {
            return;
        };
        self.drift.restart();
        self.drift.turn(theta_deg - heading_deg);
        self.drift.pass(Motion {
            variance: dock::HEADING,
            ..Motion::default()
        });
        self.is_lifted = false;
        self.tracker = None;
        self.trail = Trail::default();
        self.reckoning = Reckoning::near((0.0, 0.0), dock::VARIANCE);
        self.begin();
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use groundwave_protocol::status_codes::{Cliff, Mode, Power};
    use groundwave_protocol::telemetry::{Ack, Body, Line, StateLine};

    use super::*;

    /// A robot that was lifted knows its pose again on the dock from which it came, whatever its odometer says.
    #[test]
    fn lifted_robot_is_found_on_its_dock() {
        let docked = StateLine {
            power: Power::Charging,
            mode: Mode::Forage,
            cliff: Cliff::None,
            ..StateLine::BLANK
        };
        let lifted = StateLine {
            cliff: Cliff::Several,
            y_tenths_in: 600,
            ..StateLine::BLANK
        };
        let docked_again = StateLine {
            y_tenths_in: 900,
            theta_deg: 130,
            ..docked
        };
        let mut compass = Compass::default();
        let mut at = Duration::ZERO;
        let mut hear = |compass: &mut Compass, state: StateLine| {
            for _ in 0..6 {
                at += Duration::from_millis(350);
                let line = Line {
                    sequence: 0,
                    body: Body::State(state),
                    ack: Ack::default(),
                };
                compass.handle_line(at, &line);
            }
        };
        hear(&mut compass, docked);
        hear(&mut compass, lifted);
        assert!(compass.is_lifted() && compass.pose().is_none());
        hear(&mut compass, docked_again);
        let pose = compass.pose().expect("a pose");
        assert!(libm::hypot(pose.x_in, pose.y_in) < 1.0, "{pose:?}");
        let off_deg = libm::remainder(pose.theta_deg.value, 360.0);
        assert!(
            off_deg.abs() < 1.0 && pose.theta_deg.half > 10.0,
            "{pose:?}"
        );
    }
}
