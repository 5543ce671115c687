//! A compass from the walls of a rectangular house: how far the odometer's heading is off, and the position from matches with
//! the walls seen before.

mod align;
mod directions;
mod dock;
mod drift;
mod landmarks;
mod lift;
mod lines;
mod matching;
mod panorama;
mod reckoning;
mod resets;
mod route;
mod seen;
mod statement;
mod submaps;
mod symmetric;
mod tracker;
mod walls;

use std::time::Duration;

use groundwave_protocol::status_codes::Drive;
use groundwave_protocol::telemetry::{Body, Line, ParameterLine, StateLine};

use crate::pose::Pose;
use crate::sensors::Readings;
use crate::sensors::sonar::{self, TRACK_IN};
use crate::trail::Trail;
pub use align::NoPlace;
pub(crate) use align::{align, thinned};
use directions::{Belief, Change};
use dock::Dock;
use drift::{Drift, Motion};
use landmarks::Home;
use lift::Lift;
use lines::{is_touching, position_in, pushed_deg, turn_deg};
pub(crate) use matching::Foot;
use panorama::Scan;
pub use reckoning::Ellipse;
use reckoning::Reckoning;
use resets::Resets;
pub use route::{NoRoute, PlannedRoute};
pub(crate) use seen::{Frame, Seen};
pub use statement::{CorrectedPose, Interval, Wheels};
use tracker::{Fix, Leg, Tracker};
use walls::{DIRECTIONS, Stretch};

/// Movement after which echoes are new.
const MOVED_IN: f64 = 1.5;
const TURNED_DEG: f64 = 3.0;

/// Variance of the heading error, square degrees: per inch, per degree turned, and per second of a contact.
const PER_IN: f64 = 0.002;
const PER_DEG: f64 = 0.001;
const PER_CONTACT_S: f64 = 2.0;

/// Time between two lines after which the path between them is unknown, and what a robot does meanwhile: mean and greatest
/// speed, and contacts a second.
const GAP: Duration = Duration::from_secs(3);
const MEAN_IN_S: f64 = 4.7;
const MOST_IN_S: f64 = 12.0;
const CONTACTS_S: f64 = 0.2;

/// Distance between two lines that no robot drives, inches.
const JUMP_IN: f64 = 60.0;

/// Differences up to which a new pose of the odometer is the stated one, in inches and degrees: it has whole ones.
const SAME_IN: f64 = 1.5;
const SAME_DEG: f64 = 1.5;

/// Diameter of the nominal wheels, inches.
const NOMINAL_WHEEL_IN: f64 = 5.0;

/// Deviation of the walls' direction in the odometer's frame from which the map begins, degrees.
const KNOWN_DEG: f64 = 6.0;

/// Factor on the deviation of the wheels' difference: slips at contacts have a side, too.
const ALIKE: f64 = 1.7;

/// The wheels that the robot has reported.
#[derive(Clone, Copy, Debug, Default)]
struct Gauge {
    left_in: Option<f64>,
    right_in: Option<f64>,
}

/// Estimates the true pose since the odometer's pose was last set, and how unequal the wheels are.
///
/// It takes the robot's lines in the order in which they were received. The position is reckoned until the direction of the
/// house is known, and from then on matched with a map that the compass builds itself. A pose set by others is taken as true. A pose that
/// is the stated one was taken from it, so its uncertainty stays. After the robot was lifted, its pose is unknown until it is set, or the
/// robot has found the dock on which it was before.
#[derive(Clone, Debug, Default)]
pub struct Compass {
    last: Option<(Duration, StateLine)>,
    /// Time of the first line A since the pose was set.
    since: Option<Duration>,
    resets: Resets,
    boots: Option<u16>,
    gauge: Gauge,
    /// Odometry since the stretch began, with the known errors of the wheels and of contacts taken off.
    pose: Pose,
    echoes_at: Option<Pose>,
    stretch: Stretch,
    /// What was seen since then; in the world before the direction of the house is known, then in the frame of the pose.
    trail: Trail,
    motion: Motion,
    /// Distance driven either way and contact since the stretch began, inches and seconds.
    driven_in: f64,
    contact_s: f64,
    drift: Drift,
    dock: Dock,
    lift: Lift,
    /// Whether the robot was lifted since its pose was known.
    is_lifted: bool,
    /// The scan under way, and the one that shows home.
    scan: Scan,
    home: Option<Home>,
    /// Position until the direction of the house is known, and where it began.
    reckoning: Reckoning,
    origin_in: (f64, f64),
    /// Position from then on.
    tracker: Option<Tracker>,
}

impl Compass {
    /// Takes a line that arrived at a time.
    pub fn handle_line(&mut self, now: Duration, line: &Line) {
        match &line.body {
            Body::State(state) => self.take_state(now, state),
            Body::Status(status) => {
                let has_restarted = self.boots.is_some_and(|boots| boots != status.boots);
                self.boots = Some(status.boots);
                if has_restarted {
                    *self = Self {
                        resets: Resets::from_count(status.odometer_resets),
                        boots: self.boots,
                        ..Self::default()
                    };
                } else {
                    self.resets.take_count(status.odometer_resets);
                }
            }
            Body::Parameter(parameter) => self.take_parameter(parameter),
            _ => {}
        }
    }

    /// Time of the first line A since the pose was set, or since the first of all: the world's frame began. `None` before one.
    #[must_use]
    pub const fn since(&self) -> Option<Duration> {
        self.since
    }

    /// Whether the next leg is mapped in the right direction: the heading relative to the house is known as well as for the beginning of
    /// a map. How the house stands in the world turns the whole map.
    #[must_use]
    pub fn maps_well(&self) -> bool {
        let Some(tracker) = &self.tracker else {
            return false;
        };
        let before = self.drift.walls(tracker.reference_deg).deviation;
        let unknown_deg = self.drift.per_in().deviation * self.motion.path_in;
        let since = libm::sqrt(self.motion.variance + unknown_deg * unknown_deg);
        libm::hypot(before, since) < KNOWN_DEG && self.heading_error_deg().is_some()
    }

    /// Whether the directions of enough walls are known for a map.
    pub(crate) const fn knows_walls(&self) -> bool {
        self.tracker.is_some()
    }

    /// Whether the robot was lifted, so that it may be anywhere.
    #[must_use]
    pub const fn is_lifted(&self) -> bool {
        self.is_lifted
    }

    /// True heading minus the odometer's, degrees; `None` if it may be wrong by a quarter turn, and after the robot was lifted.
    #[must_use]
    pub fn heading_error_deg(&self) -> Option<Interval> {
        let (error, is_lost) = self.drift.heading(self.motion);
        (!is_lost && !self.is_lifted).then_some(Interval::of(error))
    }

    /// The true pose; `None` before a line, if the heading may be wrong by a quarter turn, and after the robot was lifted.
    #[must_use]
    pub fn pose(&self) -> Option<CorrectedPose> {
        let (_, last) = self.last.as_ref()?;
        let error = self.heading_error_deg()?;
        let ((x_in, y_in), ellipse) = self.tracker.as_ref().map_or_else(
            || {
                let at = (self.reckoning.x_in, self.reckoning.y_in);
                (at, self.reckoning.ellipse())
            },
            |tracker| {
                let house = self.drift.house(tracker.reference_deg);
                tracker.position(&self.leg(f64::from(last.theta_deg), None), house)
            },
        );
        Some(CorrectedPose {
            x_in,
            y_in,
            theta_deg: Interval {
                value: (f64::from(last.theta_deg) + error.value).rem_euclid(360.0),
                half: error.half,
            },
            ellipse,
        })
    }

    /// Growth of the heading error by unequal wheels, degrees per inch driven.
    #[must_use]
    pub fn growth_deg_per_in(&self) -> Interval {
        let growth = Interval::of(self.drift.per_in());
        Interval {
            half: ALIKE * growth.half,
            ..growth
        }
    }

    /// The wheels for which the odometer's heading would not drift; `None` before the robot has reported the present ones.
    #[must_use]
    pub fn wheels(&self) -> Option<Wheels> {
        let (left_in, right_in) = (self.gauge.left_in?, self.gauge.right_in?);
        let larger = self.wheel_difference().value / 2.0;
        Some(Wheels {
            left_in: left_in * (1.0 + larger),
            right_in: right_in * (1.0 - larger),
        })
    }

    /// How much larger the left wheel is than the parameters say, as a share of the right one.
    #[must_use]
    pub fn wheel_difference(&self) -> Interval {
        let growth = self.growth_deg_per_in();
        let share = |per_in_deg: f64| per_in_deg.to_radians() * TRACK_IN;
        Interval {
            value: share(growth.value),
            half: share(growth.half),
        }
    }

    fn take_parameter(&mut self, parameter: &ParameterLine) {
        let value_in = f64::from(parameter.value) / 1000.0;
        let (known, sign) = match parameter.name.as_str() {
            "wheel-left" => (&mut self.gauge.left_in, -1.0),
            "wheel-right" => (&mut self.gauge.right_in, 1.0),
            _ => return,
        };
        let change = match known.replace(value_in) {
            Some(before) if before > 0.0 => {
                Some(sign * (value_in / before - 1.0) / TRACK_IN * 1.0_f64.to_degrees())
            }
            // The present wheels may differ from those with which the robot drove until now.
            _ => ((value_in - NOMINAL_WHEEL_IN).abs() < 1e-6).then_some(0.0),
        };
        if change != Some(0.0) {
            if let Some((_, last)) = self.last {
                self.end_stretch(f64::from(last.theta_deg), None);
            }
            self.drift.regauge(change);
        }
    }

    /// Takes a new pose of the odometer.
    fn reset(&mut self, now: Duration, state: &StateLine) {
        let (x_in, y_in) = position_in(state);
        let is_stated = self.pose().is_some_and(|pose| {
            libm::hypot(pose.x_in - x_in, pose.y_in - y_in) <= SAME_IN
                && turn_deg(pose.theta_deg.value, f64::from(state.theta_deg)).abs() <= SAME_DEG
        });
        match self.last {
            Some((_, last)) if is_stated => {
                let turn_deg = turn_deg(f64::from(last.theta_deg), f64::from(state.theta_deg));
                self.scan = Scan::default();
                self.drift.turn(turn_deg);
                if let Some(tracker) = &mut self.tracker {
                    tracker.turn(turn_deg);
                }
                self.last = Some((now, *state));
            }
            _ => self.restart(),
        }
    }

    fn restart(&mut self) {
        self.drift.restart();
        self.last = None;
        (self.lift, self.is_lifted) = (Lift::default(), false);
        self.scan = Scan::default();
        self.home = None;
        self.begin();
    }

    fn begin(&mut self) {
        self.pose = Pose::default();
        self.echoes_at = None;
        self.stretch = Stretch::default();
        if self.tracker.is_some() {
            self.trail = Trail::default();
        }
        self.motion = Motion::default();
        (self.driven_in, self.contact_s) = (0.0, 0.0);
    }

    fn take_state(&mut self, now: Duration, state: &StateLine) {
        if self.resets.take_flag(state.drive == Drive::OdometerReset) {
            self.reset(now, state);
        }
        let Some((then, last)) = self.last.replace((now, *state)) else {
            self.pose.theta_rad = f64::from(state.theta_deg).to_radians();
            self.origin_in = position_in(state);
            self.since = Some(now);
            self.reckoning = Reckoning::at(self.origin_in);
            self.dock = Dock::of_first(state);
            self.tracker = None;
            self.trail = Trail::default();
            self.see(state);
            return;
        };
        let elapsed = now.saturating_sub(then);
        let turn_deg = turn_deg(f64::from(last.theta_deg), f64::from(state.theta_deg));
        let (from, to) = (position_in(&last), position_in(state));
        let (x_in, y_in) = (to.0 - from.0, to.1 - from.1);
        let chord_in = libm::hypot(x_in, y_in);
        let mut seconds = elapsed.as_secs_f64();
        if chord_in > JUMP_IN.max(MOST_IN_S * seconds * 1.5) {
            // No new pose was reported, so the line before was late: a radio can keep it over an outage.
            seconds = chord_in / MEAN_IN_S;
        }
        let middle = (f64::from(last.theta_deg) + turn_deg / 2.0).to_radians();
        let (sin, cos) = libm::sincos(middle);
        let (ahead_in, right_in) = (x_in * sin + y_in * cos, x_in * cos - y_in * sin);
        let growth = self.drift.per_in();
        let (mut path_in, mut contact_s) = (ahead_in, 0.0);
        if seconds > GAP.as_secs_f64() {
            path_in = chord_in.max(MEAN_IN_S * seconds);
            let unknown_deg = libm::hypot(growth.value, growth.deviation) * path_in / 2.0;
            self.motion.variance += unknown_deg * unknown_deg;
            contact_s = CONTACTS_S * seconds;
            self.stretch = Stretch::default();
        }
        if is_touching(state) {
            contact_s += seconds.min(2.0);
        }
        self.motion.path_in += path_in;
        self.motion.turn_deg += turn_deg;
        let pushed_deg = pushed_deg(&last, state);
        self.motion.pushed_deg += pushed_deg;
        self.motion.variance +=
            PER_IN * path_in.abs() + PER_DEG * turn_deg.abs() + PER_CONTACT_S * contact_s;
        if let Some(tracker) = &mut self.tracker {
            tracker.catch_up();
        }
        self.driven_in += path_in.abs();
        self.contact_s += contact_s;
        if self.tracker.is_none() {
            let (error, _) = self.drift.heading(self.motion);
            self.reckoning
                .advance((x_in, y_in), error, path_in.abs(), contact_s);
        }
        self.stretch.drive(path_in.abs());

        let turn_rad = (turn_deg + growth.value * path_in + pushed_deg).to_radians();
        let between = Pose {
            theta_rad: self.pose.theta_rad + turn_rad / 2.0,
            ..self.pose
        };
        let (x_in, y_in) = between.point(right_in, ahead_in);
        self.pose = Pose {
            x_in,
            y_in,
            theta_rad: self.pose.theta_rad + turn_rad,
        };
        self.take_echoes(&last, state);
        if self.stretch.is_complete() {
            self.measure(f64::from(state.theta_deg));
        }
        if let Some(panorama) = self.scan.take(state, turn_deg) {
            self.take_panorama(panorama, f64::from(state.theta_deg));
        }
        self.is_lifted |= self.lift.take(state);
        if self.dock.take(state) {
            self.dock_at_home(f64::from(state.theta_deg));
        }
    }

    /// Ends the stretch without its walls; with the robot's place if it is known.
    fn end_stretch(&mut self, theta_deg: f64, fix: Option<Fix>) {
        self.end_leg(theta_deg, None, fix);
        self.drift.pass(self.motion);
        let theta_rad = self.pose.theta_rad;
        self.begin();
        self.pose.theta_rad = theta_rad;
    }

    /// Keeps what a line says of the floor around its pose.
    fn see(&mut self, state: &StateLine) {
        let pose = if self.tracker.is_some() {
            self.pose
        } else {
            let (error, _) = self.drift.heading(self.motion);
            Pose {
                x_in: self.reckoning.x_in,
                y_in: self.reckoning.y_in,
                theta_rad: (f64::from(state.theta_deg) + error.value).to_radians(),
            }
        };
        self.trail.push(pose, Readings::of(state));
    }

    fn take_echoes(&mut self, last: &StateLine, state: &StateLine) {
        let is_new = self.echoes_at.is_none_or(|last| {
            self.pose.distance_in(last) > MOVED_IN
                || (self.pose.theta_rad - last.theta_rad).abs() > TURNED_DEG.to_radians()
        });
        if is_new || last.bump != state.bump || last.cliff != state.cliff {
            self.see(state);
        }
        if !is_new {
            return;
        }
        self.echoes_at = Some(self.pose);
        let wheels_in_s = (state.wheel_left_in_s, state.wheel_right_in_s);
        let pinged_at = sonar::pinged_at(self.pose, wheels_in_s);
        for (side, range_in) in sonar::ranges(state) {
            self.stretch.add(sonar::eye(pinged_at, side), range_in);
        }
    }

    /// Compares the walls of the finished stretch with what was expected.
    fn measure(&mut self, theta_deg: f64) {
        let likelihood = self.stretch.likelihood(self.pose.theta_rad);
        let of_wall = |wall_deg: f64| {
            let at = (wall_deg - theta_deg).rem_euclid(DIRECTIONS as f64);
            let low = at as usize % DIRECTIONS;
            let share = at - libm::floor(at);
            likelihood[low] * (1.0 - share) + likelihood[(low + 1) % DIRECTIONS] * share
        };
        let likelihoods = std::array::from_fn(|deg| of_wall(deg as f64));
        self.end_leg(theta_deg, Some(&likelihoods), None);
        self.drift.update(self.motion, of_wall);
        self.begin();
        self.pose.theta_rad = theta_deg.to_radians();
        if self.tracker.is_none() {
            self.begin_map();
        }
    }

    /// Begins the map if the direction of the walls is known.
    fn begin_map(&mut self) {
        let reference_deg = self.drift.likeliest_house_deg();
        let house = self.drift.house(reference_deg);
        let direction = self.drift.walls(reference_deg);
        if direction.deviation < KNOWN_DEG {
            let at = (self.reckoning.x_in, self.reckoning.y_in);
            let variance = self.reckoning.variance();
            let house_deg = house.value;
            self.tracker = Some(Tracker::new(
                self.origin_in,
                at,
                variance,
                direction,
                house_deg,
                &std::mem::take(&mut self.trail),
            ));
        }
    }

    /// The leg since the stretch began, with the likelihoods of the walls' directions at its end.
    fn leg(&self, theta_deg: f64, likelihood: Option<&Belief>) -> Leg {
        let growth = self.drift.per_in();
        let unknown_deg = growth.deviation * self.motion.path_in;
        let stretch = likelihood.map(|_| self.stretch.clone());
        Leg {
            change: Change {
                mean_deg: -growth.value * self.motion.path_in - self.motion.pushed_deg,
                variance: self.motion.variance + unknown_deg * unknown_deg,
                likelihood: likelihood.copied(),
            },
            pose: self.pose,
            theta_deg,
            path_in: self.driven_in,
            contact_s: self.contact_s,
            stretch: stretch.unwrap_or_default(),
            trail: Trail::default(),
            fix: None,
        }
    }

    fn end_leg(&mut self, theta_deg: f64, likelihood: Option<&Belief>, fix: Option<Fix>) {
        if self.tracker.is_none() {
            return;
        }
        let mut leg = self.leg(theta_deg, likelihood);
        leg.trail = std::mem::take(&mut self.trail);
        leg.fix = fix;
        if let Some(tracker) = &mut self.tracker {
            tracker.take(leg);
        }
    }
}
