//! The drive to a destination by planned routes: where it is, and what it may need next.

use groundwave_mapping::NoRoute;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::{Layer, LayerState, Mode};

use super::super::Facts;
use super::super::ground::{HOME_IN, Statement};
use super::super::ledger::ActiveList;
use super::super::robot::Robot;
use crate::event::{CommandId, Moment};

/// Distance from a destination that counts as arrived, inches.
pub(super) const ARRIVED_IN: f64 = 12.0;

/// Distance from the route under way in which a new one is the same, inches.
const SAME_IN: f64 = 6.0;

/// Time of driving after which the robot has clearly begun a new list.
const BEGUN: Moment = Moment::from_secs(3);

/// Scans near the destination, at most; the distance from it at which they begin, that from the latest one, that from home up to which
/// they show where it is, and the long semi-axis of the 95 % ellipse from which one is worth it, inches.
const LOOKS_MAX: u8 = 5;
const LOOK_IN: f64 = 42.0;
const APART_IN: f64 = 12.0;
const HOME_SEEN_IN: f64 = 90.0;
const UNCERTAIN_IN: f64 = 20.0;

/// Places for more of them where those on the way were in vain, inches from the destination; the time left from which the robot is sent to one,
/// and that after which it is given up.
const ASIDE_IN: [Point; 4] = [(30.0, 0.0), (-30.0, 0.0), (0.0, 30.0), (0.0, -30.0)];
const ASIDE: Moment = Moment::from_mins(3);
const ASIDE_LIMIT: Moment = Moment::from_mins(1);

/// Time after which a route is planned again.
const AGAIN: Moment = Moment::from_secs(20);

/// Time after the order of a scan in which it begins, and that in which it ends: outages delay both.
const LOOK_BEGINS: Moment = Moment::from_secs(5);
const LOOK_ENDS: Moment = Moment::from_secs(40);

/// A point, inches.
type Point = (f64, f64);

/// A destination whose planned route was sent.
#[derive(Clone, Debug)]
pub(super) struct PlannedDrive {
    /// The destination as the operator typed it.
    pub(super) to: String,
    pub(super) target_in: (f64, f64),
    /// The command that sent the first route.
    pub(super) id: CommandId,
    planned_at: Moment,
    pub(super) until: Moment,
    /// Whether the station has chosen the destination, for a robot that prowls.
    pub(super) is_detour: bool,
    /// Reason why the latest plan failed.
    pub(super) refusal: Option<NoRoute>,
    /// The end of the list that the latest one replaced while the robot was driving it, until the robot has clearly begun the latest one;
    /// and since when it drives that.
    replaced_end: Option<Waypoint>,
    drives_since: Option<Moment>,
    /// Number of scans near the destination, and when and where the latest was ordered.
    looks: u8,
    looked_at: Option<(Moment, Point)>,
    /// Number of places aside that were tried, and whether the robot is on its way to one.
    asides: usize,
    is_aside: bool,
}

impl PlannedDrive {
    pub(super) const fn new(
        to: String,
        target_in: (f64, f64),
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
            drives_since: None,
            looks: 0,
            looked_at: None,
            asides: 0,
            is_aside: false,
        }
    }

    /// Whether the robot has stopped at the end of its list, or of the list before while the new one was on its way.
    pub(super) fn is_at_end(&self, active: &ActiveList, robot: &Robot) -> bool {
        let stands_at = |end: Waypoint| {
            believed_in(robot).is_some_and(|here| distance_in(here, point(end)) < ARRIVED_IN)
        };
        robot.mode() == Some(Mode::Stop)
            && (active.is_driven() || self.replaced_end.is_some_and(stands_at))
    }

    /// Whether the route under way is to be planned again.
    pub(super) fn is_due(&self, now: Moment) -> bool {
        let after = if self.is_aside { ASIDE_LIMIT } else { AGAIN };
        now >= self.planned_at + after
    }

    /// Takes a new plan.
    pub(super) const fn take_plan(&mut self, now: Moment) {
        self.planned_at = now;
        self.is_aside = false;
    }

    /// Takes a list that is sent; `replaced` is the one that the robot is driving until it arrives.
    pub(super) fn take_sent(&mut self, replaced: Option<&ActiveList>) {
        self.replaced_end = replaced.and_then(|list| list.waypoints.last().copied());
        self.drives_since = None;
    }

    /// Takes a moment at which the robot drives the latest list.
    pub(super) fn take_driving(&mut self, now: Moment) {
        if now >= *self.drives_since.get_or_insert(now) + BEGUN {
            // A stop at the end of the list before would have another reason now.
            self.replaced_end = None;
        }
    }

    /// Whether the robot is believed at the destination; how well that is known, inches.
    pub(super) fn arrived_within_in(&self, facts: &Facts) -> Option<f64> {
        let Some(Statement::Pose(pose)) = facts.ground.statement else {
            return None;
        };
        let off_in = distance_in((pose.x_in, pose.y_in), self.target_in);
        (off_in < ARRIVED_IN).then_some(pose.ellipse.long_in)
    }

    /// Whether the robot may still be in a scan.
    pub(super) fn is_looking(&self, now: Moment, facts: &Facts) -> bool {
        let turns = facts
            .robot
            .state
            .is_some_and(|state| state.value.layers.get(Layer::Rotation) == LayerState::Holds);
        self.looked_at
            .is_some_and(|(at, _)| now < at + LOOK_BEGINS || turns && now < at + LOOK_ENDS)
    }

    /// The place where a scan may show that the destination is not quite there.
    pub(super) fn place_to_look_in(&self, facts: &Facts) -> Option<Point> {
        let Some(Statement::Pose(pose)) = facts.ground.statement else {
            return None;
        };
        let here = (pose.x_in, pose.y_in);
        let is_useful = self.looks < LOOKS_MAX
            && pose.ellipse.long_in > UNCERTAIN_IN
            && distance_in(here, self.target_in) < LOOK_IN
            && distance_in(here, HOME_IN) < HOME_SEEN_IN
            && facts.ground.knows_home()
            && facts.robot.turns_on_request();
        is_useful.then_some(here)
    }

    /// Whether the robot is away from its latest scan, which would look the same.
    pub(super) fn is_elsewhere(&self, here: Point) -> bool {
        self.looked_at
            .is_none_or(|(_, there)| distance_in(here, there) > APART_IN)
    }

    /// Takes the order of a scan.
    pub(super) const fn look(&mut self, now: Moment, here: Point) {
        self.looks += 1;
        self.looked_at = Some((now, here));
    }

    /// The route to the next place aside of the destination, if there is time for it.
    pub(super) fn route_aside(&mut self, now: Moment, facts: &Facts) -> Option<Vec<Waypoint>> {
        if self.is_detour || now + ASIDE > self.until {
            return None;
        }
        let most = facts.robot.list_capacity();
        while let Some(aside_in) = ASIDE_IN.get(self.asides) {
            self.asides += 1;
            let (x_in, y_in) = self.target_in;
            let place_in = (x_in + aside_in.0, y_in + aside_in.1);
            if let Ok(route) = facts.ground.route(place_in, most)
                && !route.waypoints.is_empty()
                && route.short_in < ARRIVED_IN
            {
                self.is_aside = true;
                self.take_sent(None);
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

/// Where the robot believes it is.
fn believed_in(robot: &Robot) -> Option<Point> {
    let state = robot.state?.value;
    let tenths = |value: i32| f64::from(value) / 10.0;
    Some((tenths(state.x_tenths_in), tenths(state.y_tenths_in)))
}

fn point(waypoint: Waypoint) -> Point {
    (f64::from(waypoint.x_in), f64::from(waypoint.y_in))
}

fn distance_in(one: Point, other: Point) -> f64 {
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
