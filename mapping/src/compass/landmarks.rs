//! Places that the robot knows again: its dock, and where it scanned.
//!
//! The scan where it began shows home. The place of a later one is known if it shows how far it is from home, or from another known place.

use std::sync::Arc;

use super::drift::{Estimate, Motion};
use super::panorama::{Features, Panorama, REACH_IN};
use super::reckoning::Reckoning;
use super::tracker::Fix;
use super::{Compass, dock};
use crate::pose::turned;
use crate::trail::Trail;

/// Least and greatest deviation of the place of a scan that is searched, inches, and variance of the place that is found from home's, square
/// inches, on each axis.
const SEARCHED_IN: (f64, f64) = (10.0, 30.0);
const FOUND: f64 = 9.0;

/// Deviation of the walls' direction that a scan has shown, degrees, and the likelihood of others.
const DIRECTION_DEG: f64 = 2.5;
const OTHER: f64 = 0.02;

/// Long semi-axis of the 95 % ellipse up to which a scan before the map is one of home, inches, and up to which one is worth an order: it
/// grows until the scan ends.
const AT_HOME_IN: f64 = 24.0;
const BEFORE_SCAN_IN: f64 = 12.0;

/// Multiple of the 95 % ellipse; a docked robot beyond it was misplaced.
const FAR: f64 = 1.5;

/// Distance from other scans at which one is worth keeping, inches; the most that are kept, and the number of the nearest ones with which a new
/// one is compared.
const APART_IN: f64 = 24.0;
const LANDMARKS_MAX: usize = 24;
const COMPARED: usize = 3;

/// The scan at home, before the map: where it ended in the world, its variance on each axis, square inches, and the error of the heading
/// there, degrees.
#[derive(Clone, Debug)]
pub(super) struct Home {
    panorama: Panorama,
    at_in: (f64, f64),
    variance: f64,
    error_deg: f64,
    landmarks: Vec<Arc<Landmark>>,
}

/// A scan whose place is known.
#[derive(Clone, Debug)]
struct Landmark {
    features: Features,
    /// Place from that of the scan at home, in the house's frame, inches, and its variance on each axis, square inches.
    from_home_in: (f64, f64),
    variance: f64,
}

impl Compass {
    /// Distance of a true point (X and Y, inches) from the nearest place where a scan has shown how it looks there, inches; `None` if a scan
    /// from that point would not show where it is.
    #[must_use]
    pub fn landmark_off_in(&self, (x_in, y_in): (f64, f64)) -> Option<f64> {
        let (home, tracker) = (self.home.as_ref()?, self.tracker.as_ref()?);
        let house_rad = self.drift.house(tracker.reference_deg).value.to_radians();
        let at_in = turned((x_in - home.at_in.0, y_in - home.at_in.1), house_rad);
        let places_in = home.landmarks.iter().map(|it| it.from_home_in);
        let places_in = places_in.chain([(0.0, 0.0)]);
        let least_in = places_in
            .map(|place_in| distance_in(at_in, place_in))
            .fold(f64::INFINITY, f64::min);
        (least_in < REACH_IN).then_some(least_in)
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
                    landmarks: Vec::new(),
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
        let here = panorama.direction_deg(of_error(error.value, error.deviation));
        let believed_in = (pose.x_in - home.at_in.0, pose.y_in - home.at_in.1);
        let believed_in = turned(believed_in, house_rad);
        let deviation_in = pose.ellipse.long_in.clamp(SEARCHED_IN.0, SEARCHED_IN.1);
        let found = home
            .nearest(believed_in, of_error(home.error_deg, house.deviation))
            .into_iter()
            .find_map(|landmark| {
                let from = landmark.from_home_in;
                let expected_in = (believed_in.0 - from.0, believed_in.1 - from.1);
                let ((x_in, y_in), turn_deg) =
                    panorama.displacement(&landmark.features, here, expected_in, deviation_in)?;
                let variance = landmark.variance + FOUND;
                Some(((from.0 + x_in, from.1 + y_in), variance, here + turn_deg))
            });
        let Some((from_home_in, variance, direction_deg)) = found else {
            return;
        };
        let (x_in, y_in) = turned(from_home_in, -house_rad);
        let at_in = (home.at_in.0 + x_in, home.at_in.1 + y_in);
        let fix = Fix {
            at_in: tracker.in_house(at_in, house),
            variance,
            trusts_map: true,
        };
        if let Some(home) = &mut self.home {
            home.keep(Landmark {
                features: panorama.features(direction_deg),
                from_home_in,
                variance,
            });
        }
        let of_wall = |wall_deg: f64| {
            let off = libm::remainder(wall_deg - direction_deg, 90.0) / DIRECTION_DEG;
            libm::exp(-off * off / 2.0) + OTHER
        };
        let likelihoods = std::array::from_fn(|deg| of_wall(deg as f64));
        self.end_leg(theta_deg, Some(&likelihoods), Some(fix));
        self.drift.update(self.motion, of_wall);
        self.drift.confirm();
        self.begin();
        self.pose.theta_rad = theta_deg.to_radians();
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

impl Home {
    /// The scans nearest to a place in the house's frame, counted from that of the scan at home; `direction` is that of the walls in the
    /// odometer's frame then.
    fn nearest(&self, at_in: (f64, f64), direction: Estimate) -> Vec<Arc<Landmark>> {
        let home = Landmark {
            features: self
                .panorama
                .features(self.panorama.direction_deg(direction)),
            from_home_in: (0.0, 0.0),
            variance: self.variance,
        };
        let off_in = |it: &Landmark| distance_in(at_in, it.from_home_in);
        let home = [Arc::new(home)].into_iter();
        let mut landmarks: Vec<_> = home.chain(self.landmarks.iter().cloned()).collect();
        landmarks.sort_by(|one, other| off_in(one).total_cmp(&off_in(other)));
        landmarks.truncate(COMPARED);
        landmarks
    }

    /// Keeps a landmark, unless there is one at its place.
    fn keep(&mut self, landmark: Landmark) {
        let at_in = landmark.from_home_in;
        let is_apart = |place_in| distance_in(at_in, place_in) > APART_IN;
        let is_new =
            is_apart((0.0, 0.0)) && self.landmarks.iter().all(|it| is_apart(it.from_home_in));
        if is_new && self.landmarks.len() < LANDMARKS_MAX {
            self.landmarks.push(Arc::new(landmark));
        }
    }
}

fn distance_in(one: (f64, f64), other: (f64, f64)) -> f64 {
    libm::hypot(one.0 - other.0, one.1 - other.1)
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
