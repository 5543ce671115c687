//! The position in the house's frame, whose +Y is along a wall: known headings, and matches with the map.

use std::collections::VecDeque;
use std::sync::Arc;

use super::directions::{self, Belief, Change};
use super::drift::Estimate;
use super::matching::Matrix;
use super::reckoning::{self, Ellipse};
use super::seen::{Frame, Seen};
use super::submaps::Submaps;
use super::walls::Stretch;
use crate::pose::{Pose, turned};
use crate::sensors::Readings;
use crate::trail::{Trail, View};

/// Stretches whose headings are still smoothed.
const LAG: usize = 2;

/// Deviation of a direction up to which a stretch is matched, degrees.
const MATCHED_DEG: f64 = 8.0;

/// Factor on the deviation of the direction of a movement, and what it has besides, degrees: a house can turn all of its
/// stretches to one side.
const ALIKE: f64 = 1.5;
const ALIKE_DEG: f64 = 1.0;

/// Share of a change of direction without a known cause that counts as its deviation.
const SLIP: f64 = 0.25;

/// Factor on the deviation of the house's direction.
const HOUSE: f64 = 0.7;

/// A movement and the walls seen on it.
#[derive(Clone, Debug)]
pub(super) struct Leg {
    pub(super) change: Change,
    /// Movement in the frame of the stretch.
    pub(super) pose: Pose,
    /// The odometer's heading at the end, degrees.
    pub(super) theta_deg: f64,
    pub(super) path_in: f64,
    pub(super) contact_s: f64,
    pub(super) stretch: Stretch,
    /// What was seen, in the frame of the stretch.
    pub(super) trail: Trail,
    /// Its place at the end, if that is known.
    pub(super) fix: Option<Fix>,
}

/// A known place in the house's frame, inches, and its variance on each axis, square inches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fix {
    pub(super) at_in: (f64, f64),
    pub(super) variance: f64,
    /// Whether the map around is right, so that the robot may be less certain of its place than it seemed.
    pub(super) trusts_map: bool,
}

impl Leg {
    /// Bearing of the house's +Y in the frame of the stretch, for a direction of the walls in the odometer's frame.
    fn house_rad(&self, direction_deg: f64) -> f64 {
        self.pose.theta_rad - (self.theta_deg - direction_deg).to_radians()
    }

    /// The movement in the house's frame.
    fn moved_in(&self, direction_deg: f64) -> (f64, f64) {
        turned(
            (self.pose.x_in, self.pose.y_in),
            self.house_rad(direction_deg),
        )
    }

    /// What was seen, in the house's frame from the position at the end.
    fn views(&self, direction_deg: f64) -> Arc<[View]> {
        let (x_in, y_in) = self.moved_in(direction_deg);
        let house_rad = self.house_rad(direction_deg);
        self.trail
            .mapped(|pose| pose.turned(house_rad).moved((-x_in, -y_in)))
    }

    /// Adds the movement to a position, with the directions before and after it.
    fn apply(&self, submaps: &mut Submaps, from: Estimate, to: Estimate) {
        let expected_deg = from.value + self.change.mean_deg;
        let slip_deg = SLIP * (to.value - expected_deg);
        let squares = from.deviation * from.deviation + to.deviation * to.deviation;
        let deviation_deg = libm::sqrt(squares / 2.0 + slip_deg * slip_deg + ALIKE_DEG * ALIKE_DEG);
        let middle_deg = f64::midpoint(expected_deg, to.value);
        submaps.advance(
            self.moved_in(middle_deg),
            ALIKE * deviation_deg.to_radians(),
            self.path_in,
            self.contact_s,
        );
        if let Some(fix) = self.fix {
            submaps.fix(fix.at_in, fix.variance, fix.trusts_map);
        }
    }
}

/// Tracks the position in the house.
#[derive(Clone, Debug)]
pub(super) struct Tracker {
    /// Position in the world of the house's origin.
    origin_in: (f64, f64),
    /// Direction of the house's frame in the world when it began, degrees: others are counted from it.
    pub(super) reference_deg: f64,
    legs: VecDeque<Leg>,
    /// Belief in directions before the legs.
    belief: Belief,
    /// The same after the first leg, from it alone.
    belief_after: Belief,
    /// Directions before the legs and after each.
    directions: Vec<Estimate>,
    /// Position before the legs; and after those that are matched, and their number.
    settled: Arc<Submaps>,
    newest: Arc<Submaps>,
    matched: usize,
}

impl Tracker {
    /// Begins at a position in the world, with the direction of the walls in the odometer's frame and of the house in the
    /// world, and what was seen before, in the world.
    pub(super) fn new(
        origin_in: (f64, f64),
        position_in: (f64, f64),
        variance: f64,
        direction: Estimate,
        house_deg: f64,
        trail: &Trail,
    ) -> Self {
        let house_rad = house_deg.to_radians();
        let from_origin = (position_in.0 - origin_in.0, position_in.1 - origin_in.1);
        let mut submaps = Submaps::at(turned(from_origin, house_rad), variance);
        submaps.add_first_views(trail.mapped(|pose| {
            let from_origin = pose.moved((-origin_in.0, -origin_in.1));
            from_origin.turned(house_rad)
        }));
        let submaps = Arc::new(submaps);
        Self {
            origin_in,
            reference_deg: house_deg,
            legs: VecDeque::new(),
            belief: directions::belief(direction),
            belief_after: directions::belief(direction),
            directions: vec![direction],
            settled: Arc::clone(&submaps),
            newest: submaps,
            matched: 0,
        }
    }

    /// Takes a finished leg.
    pub(super) fn take(&mut self, leg: Leg) {
        self.settle();
        self.legs.push_back(leg);
        let changes: Vec<&Change> = self.legs.iter().map(|leg| &leg.change).collect();
        let (beliefs, first) = directions::smooth(&self.belief, &changes);
        let mut near_deg = self.directions[0].value;
        self.directions.clear();
        for (at, belief) in beliefs.iter().enumerate() {
            if at > 0 {
                near_deg += changes[at - 1].mean_deg;
            }
            let estimate = directions::estimate(belief, near_deg);
            near_deg = estimate.value;
            self.directions.push(estimate);
        }
        self.belief_after = first;
        self.newest = Arc::clone(&self.settled);
        self.matched = 0;
    }

    /// Matches the next leg; one for each line, so that no line takes long.
    pub(super) fn catch_up(&mut self) {
        if self.legs.len() > LAG {
            self.settle();
            self.newest = Arc::clone(&self.settled);
        } else if let Some(leg) = self.legs.get(self.matched) {
            let (from, to) = (
                self.directions[self.matched],
                self.directions[self.matched + 1],
            );
            drive(Arc::make_mut(&mut self.newest), leg, from, to);
            self.matched += 1;
        }
    }

    /// Takes the oldest leg for good if its headings are smoothed.
    fn settle(&mut self) {
        if self.legs.len() > LAG
            && let Some(leg) = self.legs.pop_front()
        {
            let (from, to) = (self.directions.remove(0), self.directions[0]);
            // The map is not copied if nothing else holds it.
            self.newest = Arc::new(self.settled.robot());
            drive(Arc::make_mut(&mut self.settled), &leg, from, to);
            self.belief = self.belief_after;
        }
    }

    /// Takes a turn of the odometer's heading by whole degrees without a turn of the robot.
    pub(super) fn turn(&mut self, turn_deg: f64) {
        self.belief = directions::turned(&self.belief, turn_deg);
        self.belief_after = directions::turned(&self.belief_after, turn_deg);
        for direction in &mut self.directions {
            direction.value += turn_deg;
        }
        for leg in &mut self.legs {
            leg.theta_deg += turn_deg;
            if let Some(likelihood) = &mut leg.change.likelihood {
                *likelihood = directions::turned(likelihood, turn_deg);
            }
        }
    }

    /// Adds the legs that are not matched yet and an unfinished one to a position; `each` gets every leg with the position and
    /// the direction after it.
    fn reckon(
        &self,
        robot: &mut Submaps,
        leg: &Leg,
        mut each: impl FnMut(&mut Submaps, &Leg, f64),
    ) {
        let pairs = self.directions.windows(2);
        for (leg, pair) in self.legs.iter().zip(pairs).skip(self.matched) {
            leg.apply(robot, pair[0], pair[1]);
            each(robot, leg, pair[1].value);
        }
        let from = self.directions[self.directions.len() - 1];
        let to = Estimate {
            value: from.value + leg.change.mean_deg,
            deviation: libm::hypot(from.deviation, libm::sqrt(leg.change.variance)),
        };
        leg.apply(robot, from, to);
        each(robot, leg, to.value);
    }

    /// All that was seen, in the house's frame, oldest first, and the position in it after an unfinished leg.
    pub(super) fn seen(&self, leg: &Leg) -> (Vec<(Pose, Readings)>, (f64, f64)) {
        let submaps = self.with_views(leg);
        (submaps.views().collect(), submaps.position_in())
    }

    /// The same with the walls.
    pub(super) fn all(&self, leg: &Leg, house: Estimate) -> Seen {
        let submaps = self.with_views(leg);
        Seen {
            views: submaps.views().collect(),
            feet: submaps.feet().collect(),
            frame: self.frame(house),
        }
    }

    fn with_views(&self, leg: &Leg) -> Submaps {
        let mut submaps = Submaps::clone(&self.newest);
        self.reckon(&mut submaps, leg, |submaps, leg, direction_deg| {
            submaps.add_views(leg.views(direction_deg));
        });
        submaps
    }

    /// Place of the house in the world.
    fn frame(&self, house: Estimate) -> Frame {
        Frame {
            origin_in: self.origin_in,
            house_rad: house.value.to_radians(),
        }
    }

    /// A point of the world in the house's frame.
    pub(super) fn in_house(&self, (x_in, y_in): (f64, f64), house: Estimate) -> (f64, f64) {
        let from_origin = (x_in - self.origin_in.0, y_in - self.origin_in.1);
        turned(from_origin, house.value.to_radians())
    }

    /// A point of the house's frame in the world.
    pub(super) fn in_world(&self, (x_in, y_in): (f64, f64), house: Estimate) -> (f64, f64) {
        let pose = self.frame(house).in_world(Pose {
            x_in,
            y_in,
            ..Pose::default()
        });
        (pose.x_in, pose.y_in)
    }

    /// Position in the world after an unfinished leg, and where the true one is. The direction of the house turns both
    /// around the origin.
    pub(super) fn position(&self, leg: &Leg, house: Estimate) -> ((f64, f64), Ellipse) {
        let mut robot = self.newest.robot();
        self.reckon(&mut robot, leg, |_, _, _| {});
        let (sin, cos) = libm::sincos(house.value.to_radians());
        let (x_in, y_in) = turned(robot.position_in(), -house.value.to_radians());
        let deviation_rad = HOUSE * house.deviation.to_radians();
        let lever = [y_in * deviation_rad, -x_in * deviation_rad];
        let axes: Matrix = [[cos, sin], [-sin, cos]];
        let p = robot.covariance();
        let covariance = [0, 1].map(|row: usize| {
            [0, 1].map(|column: usize| {
                let turned: f64 = (0..4)
                    .map(|at| axes[row][at / 2] * p[at / 2][at % 2] * axes[column][at % 2])
                    .sum();
                turned + lever[row] * lever[column]
            })
        });
        (
            (self.origin_in.0 + x_in, self.origin_in.1 + y_in),
            reckoning::ellipse(covariance),
        )
    }
}

/// Adds a leg to a position and matches its walls.
fn drive(submaps: &mut Submaps, leg: &Leg, from: Estimate, to: Estimate) {
    leg.apply(submaps, from, to);
    if leg.change.likelihood.is_some() && to.deviation <= MATCHED_DEG {
        let (x_in, y_in) = leg.moved_in(to.value);
        let feet = leg.stretch.feet(leg.house_rad(to.value));
        let feet = feet.into_iter().map(|foot| foot.moved((-x_in, -y_in)));
        submaps.take(feet.collect());
    }
    submaps.add_views(leg.views(to.value));
}
