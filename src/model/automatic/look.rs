//! Scans that show where the robot is, near places where it has scanned before.

use groundwave_protocol::status_codes::{Layer, LayerState};

use super::super::Facts;
use super::super::ground::Statement;
use super::planned_drive::{Point, distance_in};
use crate::event::Moment;

/// Long semi-axis of the 95 % ellipse from which a scan is worth it, inches.
const UNCERTAIN_IN: f64 = 20.0;

/// Distance from the latest scan at which another one looks different, inches.
const APART_IN: f64 = 12.0;

/// Time after the order of a scan in which it begins, and that in which it ends: outages delay both.
const BEGINS: Moment = Moment::from_secs(5);
const ENDS: Moment = Moment::from_secs(40);

/// Scans on the way: distance between two, distance from a known place that makes another one worth it, inches, and the time after which
/// one is made anywhere.
const STEP_IN: f64 = 25.0;
const NEW_IN: f64 = 45.0;
const LONG: Moment = Moment::from_mins(2);

/// When and where the latest scan was ordered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Look {
    latest: Option<(Moment, Point)>,
}

impl Look {
    /// Takes the order of a scan.
    pub(super) const fn take(&mut self, now: Moment, here: Point) {
        self.latest = Some((now, here));
    }

    /// Whether the robot may still be in it.
    pub(super) fn is_under_way(&self, now: Moment, facts: &Facts) -> bool {
        let turns = facts
            .robot
            .state
            .is_some_and(|state| state.value.layers.get(Layer::Rotation) == LayerState::Holds);
        self.latest
            .is_some_and(|(at, _)| now < at + BEGINS || turns && now < at + ENDS)
    }

    /// Whether the robot is away from it, so that another one looks different.
    pub(super) fn is_elsewhere(&self, here: Point) -> bool {
        self.is_apart(here, APART_IN)
    }

    /// Whether a scan here is due that no destination asks for.
    pub(super) fn is_due(&self, now: Moment, here: Point, facts: &Facts) -> bool {
        let is_new = || {
            let off_in = facts.ground.landmark_off_in(here);
            off_in.is_some_and(|off_in| off_in > NEW_IN)
        };
        let is_long_ago = self.latest.is_none_or(|(at, _)| now >= at + LONG);
        self.is_apart(here, STEP_IN) && (is_long_ago || is_new())
    }

    fn is_apart(&self, here: Point, least_in: f64) -> bool {
        self.latest
            .is_none_or(|(_, there)| distance_in(here, there) > least_in)
    }
}

/// The robot's place, if it is uncertain and a scan may show it.
pub(super) fn place_in(facts: &Facts) -> Option<Point> {
    let Some(Statement::Pose(pose)) = facts.ground.statement else {
        return None;
    };
    let here = (pose.x_in, pose.y_in);
    let is_useful = pose.ellipse.long_in > UNCERTAIN_IN
        && facts.robot.turns_on_request()
        && facts.ground.landmark_off_in(here).is_some();
    is_useful.then_some(here)
}
