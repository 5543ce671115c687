//! The drive to a destination by planned routes: where it is, and what it may need next.

use groundwave_mapping::NoRoute;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;

use super::super::Facts;
use super::super::ground::Statement;
use super::super::ledger::ActiveList;
use super::super::robot::Robot;
use crate::event::{CommandId, Moment};

/// Distance from a destination that counts as arrived, inches.
pub(super) const ARRIVED_IN: f64 = 12.0;

/// Distance from the route under way in which a new one is the same, inches.
const SAME_IN: f64 = 6.0;

/// Scans near the destination, at most, and the distance from it at which they begin, inches.
const LOOKS_MAX: u8 = 5;
const LOOK_IN: f64 = 42.0;

/// Places for more of them where those on the way were in vain, inches from the destination.
const ASIDE_IN: [Point; 4] = [(30.0, 0.0), (-30.0, 0.0), (0.0, 30.0), (0.0, -30.0)];

/// A point, inches.
pub(super) type Point = (f64, f64);

/// A destination whose planned route was sent.
#[derive(Clone, Debug)]
pub(super) struct PlannedDrive {
    /// The destination as the operator typed it.
    pub(super) to: String,
    pub(super) target_in: Point,
    /// The command that sent the first route.
    pub(super) id: CommandId,
    pub(super) planned_at: Moment,
    pub(super) until: Moment,
    /// Whether the station has chosen the destination, for a robot that prowls.
    pub(super) is_detour: bool,
    /// Reason why the latest plan failed.
    pub(super) refusal: Option<NoRoute>,
    /// The end of the list that the latest one replaced while the robot was driving it.
    pub(super) replaced_end: Option<Waypoint>,
    /// Number of scans near the destination.
    looks: u8,
    /// Number of places aside that were tried.
    asides: usize,
}

impl PlannedDrive {
    pub(super) const fn new(
        to: String,
        target_in: Point,
        is_detour: bool,
        id: CommandId,
        now: Moment,
        until: Moment,
    ) -> Self {
        Self {
            to,
            target_in,
            id,
            planned_at: now,
            until,
            is_detour,
            refusal: None,
            replaced_end: None,
            looks: 0,
            asides: 0,
        }
    }

    /// Whether the robot has stopped at the end of its list, or at that of the one before while the new one was on its way.
    pub(super) fn is_at_end(&self, active: &ActiveList, robot: &Robot) -> bool {
        let stands_at = |end: Waypoint| {
            believed_in(robot).is_some_and(|here| distance_in(here, point(end)) < ARRIVED_IN)
        };
        robot.mode() == Some(Mode::Stop)
            && (active.is_driven() || self.replaced_end.is_some_and(stands_at))
    }

    /// Whether the robot is believed at the destination; how well that is known, inches.
    pub(super) fn arrived_within_in(&self, facts: &Facts) -> Option<f64> {
        let Some(Statement::Pose(pose)) = facts.ground.statement else {
            return None;
        };
        let off_in = distance_in((pose.x_in, pose.y_in), self.target_in);
        (off_in < ARRIVED_IN).then_some(pose.ellipse.long_in)
    }

    /// Whether a scan from a place may show that the destination is not quite there.
    pub(super) fn may_look(&self, here: Point) -> bool {
        self.looks < LOOKS_MAX && distance_in(here, self.target_in) < LOOK_IN
    }

    /// Takes the order of such a scan.
    pub(super) const fn look(&mut self) {
        self.looks += 1;
    }

    /// The route to the next place aside of the destination.
    pub(super) fn route_aside(&mut self, facts: &Facts) -> Option<Vec<Waypoint>> {
        let most = facts.robot.list_capacity();
        while let Some(aside_in) = ASIDE_IN.get(self.asides) {
            self.asides += 1;
            let (x_in, y_in) = self.target_in;
            let place_in = (x_in + aside_in.0, y_in + aside_in.1);
            if let Ok(route) = facts.ground.route(place_in, most)
                && !route.waypoints.is_empty()
                && route.short_in < ARRIVED_IN
            {
                return Some(route.waypoints);
            }
        }
        None
    }
}

/// Whether a route leads where the robot drives already.
pub(super) fn is_under_way(route: &[Waypoint], active: &ActiveList, robot: &Robot) -> bool {
    let (Some(here), Some(place)) = (believed_in(robot), active.driven) else {
        return false;
    };
    let left = active.waypoints.get(usize::from(place.driven)..);
    let path = |waypoints: &[Waypoint]| -> Vec<Point> {
        let points = waypoints.iter().copied().map(point);
        [here].into_iter().chain(points).collect()
    };
    let (new, old) = (path(route), path(left.unwrap_or_default()));
    let is_beside = |path: &[Point], other: &[Point]| {
        path.iter().all(|at| {
            let mut legs = other.windows(2);
            legs.any(|leg| off_leg_in(*at, leg[0], leg[1]) < SAME_IN)
        })
    };
    let ends_in = distance_in(new[new.len() - 1], old[old.len() - 1]);
    ends_in < SAME_IN && is_beside(&new, &old) && is_beside(&old, &new)
}

/// Where the robot believes to be.
fn believed_in(robot: &Robot) -> Option<Point> {
    let state = robot.state?.value;
    let tenths = |value: i32| f64::from(value) / 10.0;
    Some((tenths(state.x_tenths_in), tenths(state.y_tenths_in)))
}

fn point(waypoint: Waypoint) -> Point {
    (f64::from(waypoint.x_in), f64::from(waypoint.y_in))
}

pub(super) fn distance_in(one: Point, other: Point) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

/// Distance of a point from a straight leg.
fn off_leg_in(at: Point, from: Point, to: Point) -> f64 {
    let (leg, offset) = (
        (to.0 - from.0, to.1 - from.1),
        (at.0 - from.0, at.1 - from.1),
    );
    let squared = leg.0 * leg.0 + leg.1 * leg.1;
    let share = (offset.0 * leg.0 + offset.1 * leg.1) / squared.max(f64::MIN_POSITIVE);
    let share = share.clamp(0.0, 1.0);
    distance_in(offset, (share * leg.0, share * leg.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_from_a_leg_is_that_from_its_nearest_point() {
        let leg = ((10.0, 10.0), (10.0, 30.0));
        for (at, off_in) in [
            ((13.0, 20.0), 3.0),
            ((6.0, 7.0), 5.0),
            ((10.0, 34.0), 4.0),
            ((10.0, 15.0), 0.0),
        ] {
            assert!(
                (off_leg_in(at, leg.0, leg.1) - off_in).abs() < 1e-9,
                "{at:?}"
            );
        }
        assert!((off_leg_in((3.0, 4.0), (0.0, 0.0), (0.0, 0.0)) - 5.0).abs() < 1e-9);
    }
}
