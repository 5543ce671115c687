//! The floor that was seen, and routes over it.

use std::fmt;

use groundwave_protocol::Waypoint;
use groundwave_protocol::telemetry::StateLine;

use super::Compass;
use super::seen::Seen;
use super::tracker::Leg;
use crate::floor::Floor;
use crate::floor_map::FloorMap;
use crate::plan::{Blocked, Point, Terrain};
use crate::pose::turned;
use crate::unvisited;

/// Long semi-axis of the position's 95 % ellipse from which no route is planned, inches: a room.
const UNCERTAIN_IN: f64 = 300.0;

/// A route for a robot that trusts its odometer.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRoute {
    /// The waypoints as the robot will believe them.
    pub waypoints: Vec<Waypoint>,
    /// Length, inches.
    pub length_in: f64,
    /// Length over floor that was never seen, inches.
    pub unknown_in: f64,
    /// Distance of its end from the destination, inches: more than 0 if an obstacle is there or the list is full.
    pub short_in: f64,
}

/// Reason why there is no route.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoRoute {
    /// No line A was received.
    NoPose,
    /// The heading may be wrong by a quarter turn.
    HeadingUnknown,
    /// The robot was lifted, so it may be anywhere.
    Lifted,
    /// The directions of too few walls were seen.
    WallsUnknown,
    /// The 95 % ellipse of the position is as large as a room.
    TooUncertain,
    /// The destination is beyond the floor that was seen, or that is too large for a map.
    TooFar,
    /// The destination is blocked.
    DestinationBlocked,
    /// Obstacles are all around the robot or the destination.
    Blocked,
}

impl fmt::Display for NoRoute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unknown = match self {
            Self::NoPose => "no position was received",
            Self::HeadingUnknown => "its heading may be wrong by a quarter turn",
            Self::Lifted => "it was lifted, so set its pose",
            Self::WallsUnknown => "it has not passed enough walls yet",
            Self::TooUncertain => "its position is known to no better than 300 in",
            Self::TooFar => {
                return f.write_str("the destination is beyond the floor that was seen");
            }
            Self::DestinationBlocked => {
                return f.write_str("obstacles or drops are all over the destination");
            }
            Self::Blocked => {
                return f.write_str("no route is known: obstacles or drops are on all sides");
            }
        };
        write!(f, "the ground does not know where the robot is: {unknown}")
    }
}

impl std::error::Error for NoRoute {}

impl Compass {
    /// Plans a route from the true pose to a true point (X and Y, inches; the origin is home) over the floor that was seen, with no more
    /// than `most` waypoints.
    ///
    /// The waypoints are turned and shifted by the error of the odometer, and by its expected growth on the route: a robot that
    /// drives them by its odometer arrives there.
    ///
    /// # Errors
    /// If the true pose is not known, or the floor is blocked.
    pub fn route(&self, target_in: (f64, f64), most: usize) -> Result<PlannedRoute, NoRoute> {
        let (_, last) = self.last.as_ref().ok_or(NoRoute::NoPose)?;
        if self.is_lifted {
            return Err(NoRoute::Lifted);
        }
        let error_deg = self
            .heading_error_deg()
            .ok_or(NoRoute::HeadingUnknown)?
            .value;
        let tracker = self.tracker.as_ref().ok_or(NoRoute::WallsUnknown)?;
        if self
            .pose()
            .is_some_and(|pose| pose.ellipse.long_in > UNCERTAIN_IN)
        {
            return Err(NoRoute::TooUncertain);
        }
        let house = self.drift.house(tracker.reference_deg);
        let (views, start) = tracker.seen(&self.unfinished_leg(last));

        let here = tracker.in_world(start, house);
        let target = tracker.in_house(target_in, house);
        let floor = Floor::new(&views);
        let terrain = Terrain::new(&floor, start, target).ok_or(NoRoute::TooFar)?;
        let mut points = terrain
            .route(start, target)
            .map_err(|blocked| match blocked {
                Blocked::Target => NoRoute::DestinationBlocked,
                Blocked::Between => NoRoute::Blocked,
            })?;
        points.truncate(most);
        let end = points.last().copied().unwrap_or(start);
        let world = points.iter().map(|point| tracker.in_world(*point, house));
        let waypoints = self.believed(super::position_in(last), here, error_deg, world);
        Ok(PlannedRoute {
            waypoints,
            length_in: length_in(start, &points),
            unknown_in: terrain.unknown_in(start, &points),
            short_in: libm::hypot(end.0 - target.0, end.1 - target.1),
        })
    }

    /// The floor that was seen since the pose was set, in the world's frame: the odometer's at that time. `None` before the directions of
    /// enough walls are known.
    ///
    /// If the heading is not known any more ([`Self::heading_error_deg`]), what was seen since then may be misplaced.
    #[must_use]
    pub fn floor_map(&self) -> Option<FloorMap> {
        self.seen()?.floor_map()
    }

    /// What was seen since the pose was set, in the house's frame. `None` before the directions of enough walls are known.
    pub(crate) fn seen(&self) -> Option<Seen> {
        let (_, last) = self.last.as_ref()?;
        let tracker = self.tracker.as_ref()?;
        let house = self.drift.house(tracker.reference_deg);
        Some(tracker.all(&self.unfinished_leg(last), house))
    }

    /// The largest piece of floor that was seen but where the robot has never been, away from true points (inches) that it has tried to
    /// reach: true X and Y of a place in it, inches, and its area, square feet. `None` if there is none, or the floor is not known
    /// ([`Self::floor_map`]).
    #[must_use]
    pub fn unvisited(
        &self,
        tried_in: impl IntoIterator<Item = (f64, f64)>,
    ) -> Option<((f64, f64), f64)> {
        let (_, last) = self.last.as_ref()?;
        let tracker = self.tracker.as_ref()?;
        let (views, _) = tracker.seen(&self.unfinished_leg(last));
        let house = self.drift.house(tracker.reference_deg);
        let tried = tried_in.into_iter();
        let tried: Vec<_> = tried.map(|it| tracker.in_house(it, house)).collect();
        let piece = unvisited::largest(&Floor::new(&views), &tried)?;
        Some((tracker.in_world(piece.middle, house), piece.area_sq_ft))
    }

    /// The leg up to a line, with what was seen on it.
    fn unfinished_leg(&self, last: &StateLine) -> Leg {
        Leg {
            trail: self.trail.clone(),
            ..self.leg(f64::from(last.theta_deg), None)
        }
    }

    /// The waypoints with which a robot that trusts its odometer drives along points of the world.
    fn believed(
        &self,
        mut at: Point,
        mut from: Point,
        mut error_deg: f64,
        points: impl Iterator<Item = Point>,
    ) -> Vec<Waypoint> {
        let growth_deg_per_in = self.drift.per_in().value;
        let mut waypoints = Vec::new();
        for to in points {
            let leg = (to.0 - from.0, to.1 - from.1);
            let grown_deg = growth_deg_per_in * libm::hypot(leg.0, leg.1);
            let (x_in, y_in) = turned(leg, (error_deg + grown_deg / 2.0).to_radians());
            at = (at.0 + x_in, at.1 + y_in);
            error_deg += grown_deg;
            from = to;
            let whole = |value: f64| libm::round(value) as i16;
            waypoints.extend(Waypoint::new(whole(at.0), whole(at.1)));
        }
        waypoints.dedup();
        waypoints
    }
}

/// Length of a route, inches.
fn length_in(start: Point, points: &[Point]) -> f64 {
    let mut from = start;
    let legs = points.iter().map(|to| {
        let leg_in = libm::hypot(to.0 - from.0, to.1 - from.1);
        from = *to;
        leg_in
    });
    legs.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A robot whose heading is off, and turns off further with each inch, drives the waypoints by its odometer.
        #[test]
        fn robot_that_trusts_its_odometer_arrives(
            error_deg in -180.0..180.0_f64, growth_deg_per_in in -0.03..0.03_f64,
            believed in (-200.0..200.0_f64, -200.0..200.0_f64), start in (-200.0..200.0_f64, -200.0..200.0_f64),
            points in proptest::collection::vec((-200.0..200.0_f64, -200.0..200.0_f64), 1..6),
        ) {
            let mut compass = Compass::default();
            compass.drift.regauge(Some(growth_deg_per_in));
            let waypoints = compass.believed(believed, start, error_deg, points.iter().copied());
            let (mut odometer, mut truth, mut error_deg) = (believed, start, error_deg);
            for waypoint in waypoints {
                let to = (f64::from(waypoint.x_in), f64::from(waypoint.y_in));
                let leg = (to.0 - odometer.0, to.1 - odometer.1);
                let steps = (libm::hypot(leg.0, leg.1) as u32).max(1);
                for _ in 0..steps {
                    let step = (leg.0 / f64::from(steps), leg.1 / f64::from(steps));
                    let moved = turned(step, -error_deg.to_radians());
                    truth = (truth.0 + moved.0, truth.1 + moved.1);
                    error_deg += growth_deg_per_in * libm::hypot(step.0, step.1);
                }
                odometer = to;
            }
            let end = points[points.len() - 1];
            let off_in = libm::hypot(truth.0 - end.0, truth.1 - end.1);
            // Waypoints are whole inches, and the curve of a leg is taken as a chord.
            let curve_in = 0.02 * length_in(start, &points) * (growth_deg_per_in / 0.03).abs();
            prop_assert!(off_in < 2.0 + curve_in, "{off_in}");
        }
    }

    #[test]
    fn unknown_position_is_refused_in_words() {
        let refusal = Compass::default().route((0.0, 0.0), 300).unwrap_err();
        assert_eq!(
            refusal.to_string(),
            "the ground does not know where the robot is: no position was received"
        );
    }
}
