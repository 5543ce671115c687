//! The ground's own estimate of the robot's pose, and the commands that it suggests.
//!
//! Both follow from events alone. The operator accepts a suggestion, or [`automatic`](super::automatic) does. STOP, a mode,
//! driving by hand and any unfinished command have precedence; meanwhile nothing is suggested.

mod dock;
mod held;
mod rules;
mod unvisited;

use groundwave_mapping::{Compass, CorrectedPose, FloorMap, NoRoute, PlannedRoute};
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::{Layer, Mode};
use groundwave_protocol::telemetry::{Body, Line, Reading as Measured, StateLine};

use self::dock::Dock;
use self::held::Held;
use self::unvisited::Unvisited;
use super::ledger::Ledger;
use super::link::Link;
use super::motors::{Holder, Motors};
use super::reported_parameters::Parameters;
use super::robot::{Robot, STATE_STALE};
use crate::event::{Figure, Moment, SuggestionCode, SuggestionEvent, SuggestionStatus};
use crate::request::Request;

/// Time for which a robot must stand before its pose is set: a command takes effect seconds after the line from which it
/// follows, and a robot that turns meanwhile would get a wrong heading.
const STANDS: Moment = Moment::from_secs(2);

/// Time without suggestions after STOP, a mode, driving by hand and any unfinished command.
const QUIET: Moment = Moment::from_secs(10);

/// Time after which a suggestion expires.
const LIFE: Moment = Moment::from_mins(5);

/// Time between two suggestions of a kind; longer after one that expired, and for a scan.
const REST: Moment = Moment::from_secs(30);
const LONG_REST: Moment = Moment::from_mins(15);

/// X and Y of home and its dock, inches.
pub(super) const HOME_IN: (f64, f64) = (0.0, 0.0);

/// Lowest levels (SPEC.md section 1) of robots that accept a pose and a scan, and of robots with parameters.
const POSE_LEVEL: u8 = 4;
const PARAMETER_LEVEL: u8 = 5;

/// What the ground knows of the robot's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Statement {
    /// The heading may be wrong by a quarter turn.
    HeadingUnknown,
    /// The robot was lifted, so it may be anywhere.
    Lifted,
    /// The pose with its 95 % intervals.
    Pose(CorrectedPose),
}

/// Commands that the operator may accept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Suggestion {
    pub(crate) code: SuggestionCode,
    pub(crate) requests: Vec<Request>,
    /// True X and Y of the destination of a suggested route, inches.
    pub(crate) target_in: Option<(f64, f64)>,
    pub(crate) figures: Vec<Figure>,
}

impl Suggestion {
    /// A way to a true point (inches) over the floor that was seen; `None` if there is none, or the robot is there.
    fn way(
        code: SuggestionCode,
        target_in: (f64, f64),
        it: &Situation<'_>,
        compass: &Compass,
        figure: Figure,
    ) -> Option<Self> {
        let most = it.robot.list_capacity();
        let route = compass.route(target_in, most).ok()?;
        (!route.waypoints.is_empty()).then(|| Self {
            code,
            requests: vec![Request::Route(route.waypoints)],
            target_in: Some(target_in),
            figures: vec![figure],
        })
    }

    /// The waypoints of a suggested route.
    pub(crate) fn waypoints(&self) -> Option<&[Waypoint]> {
        self.requests.iter().find_map(|request| match request {
            Request::Route(waypoints) => Some(&waypoints[..]),
            _ => None,
        })
    }

    /// The event for a new status.
    pub(super) fn event(&self, status: SuggestionStatus) -> SuggestionEvent {
        SuggestionEvent {
            code: self.code,
            status,
            commands: self.requests.iter().map(Request::to_string).collect(),
            figures: self.figures.clone(),
        }
    }
}

/// Facts that suggestions follow from, apart from the ground's own.
pub(super) struct Situation<'a> {
    pub(super) now: Moment,
    pub(super) link: &'a Link,
    pub(super) robot: &'a Robot,
    pub(super) motors: &'a Motors,
    pub(super) ledger: &'a Ledger,
    pub(super) parameters: &'a Parameters,
    /// The alarm's limit of the battery, decivolts.
    pub(super) battery_low_dv: i32,
}

/// The estimate, the present suggestion, and the times until which none is made.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ground {
    /// Whether there is never an estimate.
    is_ended: bool,
    compass: Compass,
    /// The estimate after the newest line A; `None` before one.
    pub(crate) statement: Option<Statement>,
    /// Since when the robot stands.
    stands_since: Option<Moment>,
    dock: Dock,
    held: Held,
    unvisited: Unvisited,
    /// The present suggestion, and when it expires.
    suggestion: Option<(Suggestion, Moment)>,
    /// Changes of the suggestion by the latest event.
    changes: Vec<SuggestionEvent>,
    quiet_until: Moment,
    rests: [Moment; SuggestionCode::COUNT],
}

impl Ground {
    /// Forgets the estimate and makes no other one.
    pub(super) fn end(&mut self) {
        *self = Self {
            is_ended: true,
            ..Self::default()
        };
    }

    /// Takes a line.
    pub(super) fn take_line(&mut self, now: Moment, line: &Line) {
        if self.is_ended {
            return;
        }
        self.estimate(now, line);
        if let Body::State(state) = &line.body {
            self.stands_since = stands(state).then(|| self.stands_since.unwrap_or(now));
        }
    }

    /// Takes a repaired line A, for the estimate alone. It can withhold a suggestion of a pose, which an estimate after the robot's newest
    /// intact line must not be compared with, and can allow none.
    pub(super) fn take_repaired(&mut self, now: Moment, line: &Line) {
        if self.is_ended {
            return;
        }
        self.estimate(now, line);
        if matches!(&line.body, Body::State(state) if !stands(state)) {
            self.stands_since = None;
        }
    }

    fn estimate(&mut self, now: Moment, line: &Line) {
        self.compass.handle_line(now, line);
        if matches!(line.body, Body::State(_)) {
            self.statement = Some(match self.compass.pose() {
                Some(pose) => Statement::Pose(pose),
                None if self.compass.is_lifted() => Statement::Lifted,
                None => Statement::HeadingUnknown,
            });
        }
    }

    /// Plans a route to a true point (inches) for a robot whose list holds `most` waypoints.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(super) fn route(
        &self,
        target_in: (f64, f64),
        most: usize,
    ) -> Result<PlannedRoute, NoRoute> {
        self.compass.route(target_in, most)
    }

    /// The floor that was seen; `None` while what is seen cannot be placed well.
    pub(crate) fn floor_map(&self) -> Option<FloorMap> {
        self.compass
            .maps_well()
            .then(|| self.compass.floor_map())
            .flatten()
    }

    /// Whether a scan now would show how home looks.
    pub(super) fn may_see_home(&self) -> bool {
        self.compass.may_see_home()
    }

    /// Whether a scan near home would show where it is.
    pub(super) const fn knows_home(&self) -> bool {
        self.compass.knows_home()
    }

    /// Since when the estimate's frame is the same: the robot's pose was set, or it was restarted.
    pub(crate) const fn since(&self) -> Option<Moment> {
        self.compass.since()
    }

    /// Takes a restart of the robot: its frame begins at its place.
    pub(super) fn take_restart(&mut self) {
        self.compass = Compass::default();
        self.statement = None;
        self.stands_since = None;
        self.dock = Dock::default();
        self.held = Held::default();
        self.unvisited = Unvisited::default();
    }

    /// Takes a command of an operator.
    pub(super) fn take_asked(&mut self, now: Moment, request: &Request) {
        if request.mode().is_some() {
            self.quiet_until = now + QUIET;
        }
    }

    /// Takes the operator's acceptance.
    pub(super) fn take_accepted(&mut self, now: Moment) {
        if let Some((suggestion, _)) = self.suggestion.take() {
            match suggestion.code {
                SuggestionCode::DockNow => self.dock.take_accepted(),
                SuggestionCode::Unvisited => self.unvisited.take_accepted(suggestion.target_in),
                _ => {}
            }
            self.rest(now, suggestion.code, SuggestionStatus::Accepted);
        }
    }

    /// Forgets the changes by the event before.
    pub(super) fn forget_changes(&mut self) {
        self.changes.clear();
    }

    /// Changes of the suggestion by the latest event.
    pub(super) fn changes(&self) -> &[SuggestionEvent] {
        &self.changes
    }

    /// The suggestion that the operator may accept now.
    pub(crate) fn offered(&self, now: Moment, robot: &Robot) -> Option<&Suggestion> {
        let (suggestion, until) = self.suggestion.as_ref()?;
        (is_heard(robot, now) && now < *until).then_some(suggestion)
    }

    /// Offers a suggestion to tests.
    #[cfg(test)]
    pub(crate) fn offer(&mut self, suggestion: Suggestion, until: Moment) {
        self.suggestion = Some((suggestion, until));
    }

    /// Begins, ends and expires suggestions.
    pub(super) fn watch(&mut self, it: &Situation<'_>) {
        if is_driven_by_hand(it.robot, it.motors) || it.ledger.is_busy() {
            self.quiet_until = it.now + QUIET;
        }
        // Lost lines neither begin nor end a suggestion; it is not offered meanwhile.
        if !is_heard(it.robot, it.now) && !it.link.is_frozen() {
            return;
        }
        // They plan routes, which a replay and a receive-only link cannot send.
        if it.link.can_send {
            let pose = match self.statement {
                Some(Statement::Pose(pose)) => Some(pose),
                _ => None,
            };
            self.dock.watch(it, pose, &self.compass);
            self.held.watch(it, pose, &self.compass);
            self.unvisited.watch(it, &self.compass);
        }
        let wanted = self.wanted(it);
        if let Some((suggestion, until)) = self.suggestion.take() {
            let same = wanted.as_ref().filter(|new| new.code == suggestion.code);
            let status = match same {
                _ if it.now >= until => SuggestionStatus::Expired,
                Some(new) => {
                    // A route begins where the robot is.
                    let is_route = new.waypoints().is_some();
                    let kept = if is_route { new.clone() } else { suggestion };
                    self.suggestion = Some((kept, until));
                    return;
                }
                None => SuggestionStatus::Ended,
            };
            self.rest(it.now, suggestion.code, status);
            self.changes.push(suggestion.event(status));
        }
        if let Some(suggestion) = wanted.filter(|new| it.now >= self.rests[new.code as usize]) {
            self.changes.push(suggestion.event(SuggestionStatus::Begun));
            self.suggestion = Some((suggestion, it.now + LIFE));
        }
    }

    fn rest(&mut self, now: Moment, code: SuggestionCode, status: SuggestionStatus) {
        let rest = match (code, status) {
            (SuggestionCode::HeadingUnknown, SuggestionStatus::Accepted)
            | (_, SuggestionStatus::Expired) => LONG_REST,
            _ => REST,
        };
        self.rests[code as usize] = now + rest;
    }

    /// The suggestion that the present facts call for.
    fn wanted(&self, it: &Situation<'_>) -> Option<Suggestion> {
        let state = it.robot.state?;
        let is_barred = !it.link.can_send || it.link.is_frozen() || it.now < self.quiet_until;
        let level = it
            .robot
            .abilities
            .map_or(PARAMETER_LEVEL, |robot| robot.level);
        if is_barred || level < POSE_LEVEL || !it.robot.measures(Measured::Sonars) {
            return None;
        }
        match self.statement? {
            Statement::HeadingUnknown => rules::scan(it.robot),
            // A look around does not show where it was put down.
            Statement::Lifted => None,
            Statement::Pose(pose) => {
                let has_stood = self
                    .stands_since
                    .is_some_and(|since| it.now.saturating_sub(since) >= STANDS);
                let set_pose = || rules::set_pose(&state.value, &pose);
                let set_wheels = || rules::set_wheels(&self.compass, it.parameters);
                has_stood
                    .then(set_pose)
                    .flatten()
                    .or_else(|| self.dock.suggestion().cloned())
                    .or_else(|| self.held.suggestion().cloned())
                    .or_else(|| (level >= PARAMETER_LEVEL).then(set_wheels).flatten())
                    .or_else(|| self.unvisited.suggestion().cloned())
            }
        }
    }
}

/// Whether the robot drives a route.
fn is_on_route(it: &Situation<'_>) -> bool {
    let drives = it.robot.mode() == Some(Mode::Prowl);
    drives && it.ledger.active().is_some_and(|route| !route.is_driven())
}

/// Whether an operator drives the robot by hand.
pub(super) fn is_driven_by_hand(robot: &Robot, motors: &Motors) -> bool {
    let holder = motors.holder().map(|holder| holder.value);
    robot.mode() == Some(Mode::User) || holder == Some(Holder::Layer(Layer::User))
}

/// Whether the robot's newest line A is fresh.
fn is_heard(robot: &Robot, now: Moment) -> bool {
    robot
        .state
        .is_some_and(|state| state.age(now) < STATE_STALE)
}

/// Whether the robot stands and is not ordered to move.
const fn stands(state: &StateLine) -> bool {
    state.velocity_in_s == 0
        && state.rotation_in_s == 0
        && state.wheel_left_in_s == 0
        && state.wheel_right_in_s == 0
}
