//! The ground's own estimate of the robot's pose, and the commands that it suggests.
//!
//! Both follow from events alone. The operator accepts a suggestion, or [`automatic`](super::automatic) does. STOP, a mode,
//! driving by hand and any unfinished command have precedence; meanwhile nothing is suggested.

use groundwave_mapping::{Compass, CorrectedPose, Destination, FloorMap, NoRoute, PlannedRoute};
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::{Layer, Mode};
use groundwave_protocol::telemetry::{Body, Line, ParameterName, Reading as Measured, StateLine};

use super::chart::Pose;
use super::ledger::Ledger;
use super::link::Link;
use super::motors::{Holder, Motors};
use super::reported_parameters::Parameters;
use super::robot::{Robot, STATE_STALE};
use crate::event::{Figure, Moment, SuggestionCode, SuggestionEvent, SuggestionStatus};
use crate::request::{Amount, Request, Tuning};

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

/// Multiple of a 95 % interval from which a value is clearly outside.
const CLEARLY: f64 = 1.5;

/// Minimum errors worth a command: degrees, inches, and difference of the wheels as a share of their diameter.
const HEADING_LEAST_DEG: f64 = 5.0;
const POSITION_LEAST_IN: f64 = 6.0;
const WHEELS_LEAST: f64 = 0.002;

/// Lowest levels (SPEC.md section 1) of robots that accept a pose and a scan, and of robots with parameters.
const POSE_LEVEL: u8 = 4;
const PARAMETER_LEVEL: u8 = 5;

/// What the ground knows of the robot's pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Statement {
    /// The heading may be wrong by a quarter turn.
    HeadingUnknown,
    /// The pose with its 95 % intervals.
    Pose(CorrectedPose),
}

/// Commands that the operator may accept.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Suggestion {
    pub(crate) code: SuggestionCode,
    pub(crate) requests: Vec<Request>,
    pub(crate) figures: Vec<Figure>,
}

impl Suggestion {
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
    /// The present suggestion, and when it expires.
    suggestion: Option<(Suggestion, Moment)>,
    /// Changes of the suggestion by the latest event.
    changes: Vec<SuggestionEvent>,
    quiet_until: Moment,
    rests: [Moment; 3],
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
        self.compass.handle_line(now, line);
        if let Body::State(state) = &line.body {
            let pose = self.compass.pose();
            self.statement = Some(pose.map_or(Statement::HeadingUnknown, Statement::Pose));
            self.stands_since = stands(state).then(|| self.stands_since.unwrap_or(now));
        }
    }

    /// Plans a route for a robot whose list holds `most` waypoints.
    ///
    /// # Errors
    /// The reason why there is none.
    pub(super) fn route(&self, to: Destination, most: usize) -> Result<PlannedRoute, NoRoute> {
        self.compass.route(to, most)
    }

    /// The floor that was seen; `None` while what is seen cannot be placed well.
    pub(crate) fn floor_map(&self) -> Option<FloorMap> {
        self.compass
            .maps_well()
            .then(|| self.compass.floor_map())
            .flatten()
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

    /// Begins, ends and expires suggestions.
    pub(super) fn watch(&mut self, it: &Situation<'_>) {
        if is_driven_by_hand(it.robot, it.motors) || it.ledger.is_busy() {
            self.quiet_until = it.now + QUIET;
        }
        // Lost lines neither begin nor end a suggestion; it is not offered meanwhile.
        if !is_heard(it.robot, it.now) && !it.link.is_frozen() {
            return;
        }
        let wanted = self.wanted(it);
        if let Some((suggestion, until)) = self.suggestion.take() {
            let is_wanted = wanted
                .as_ref()
                .is_some_and(|new| new.code == suggestion.code);
            let status = if it.now >= until {
                SuggestionStatus::Expired
            } else if is_wanted {
                self.suggestion = Some((suggestion, until));
                return;
            } else {
                SuggestionStatus::Ended
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
            Statement::HeadingUnknown => scan(it.robot),
            Statement::Pose(pose) => {
                let has_stood = self
                    .stands_since
                    .is_some_and(|since| it.now.saturating_sub(since) >= STANDS);
                let suggestion = has_stood.then(|| set_pose(&state.value, &pose)).flatten();
                suggestion.or_else(|| {
                    (level >= PARAMETER_LEVEL)
                        .then(|| self.set_wheels(it.parameters))
                        .flatten()
                })
            }
        }
    }

    /// The wheels for which the heading would not drift, if they differ clearly from the robot's.
    fn set_wheels(&self, parameters: &Parameters) -> Option<Suggestion> {
        let wheels = self.compass.wheels()?;
        let difference = self.compass.wheel_difference();
        if difference.value.abs() < (CLEARLY * difference.half).max(WHEELS_LEAST) {
            return None;
        }
        let set = |name: &str, value_in: f64| {
            let known = parameters
                .heard()
                .iter()
                .find(|line| line.name.as_str() == name)?;
            let value = (value_in * 1000.0).round() as i32;
            let name = ParameterName::new(name);
            (known.least..=known.most)
                .contains(&value)
                .then_some(Request::Parameter(Tuning::Set(name, Amount::Counts(value))))
        };
        Some(Suggestion {
            code: SuggestionCode::WheelsDiffer,
            requests: vec![
                set("wheel-left", wheels.left_in)?,
                set("wheel-right", wheels.right_in)?,
            ],
            figures: vec![Figure {
                code: "wheels".to_owned(),
                value: 100.0 * difference.value,
                half: 100.0 * difference.half,
                unit: "%".to_owned(),
            }],
        })
    }
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

/// The estimated pose, if the robot's is clearly outside its intervals.
fn set_pose(state: &StateLine, pose: &CorrectedPose) -> Option<Suggestion> {
    if state.mode == Mode::Calibrate {
        return None;
    }
    let believed = Pose::of(state);
    let (x_in, y_in) = (believed.x_in - pose.x_in, believed.y_in - pose.y_in);
    let turned_deg = believed.theta_deg - pose.theta_deg.value;
    let turned_deg = ((turned_deg + 540.0).rem_euclid(360.0) - 180.0).abs();
    let moved_in = x_in.hypot(y_in);
    let is_turned = turned_deg >= HEADING_LEAST_DEG.max(CLEARLY * pose.theta_deg.half);
    let is_moved = moved_in >= POSITION_LEAST_IN && ellipses(pose, (x_in, y_in)) >= CLEARLY;
    if !is_turned && !is_moved {
        return None;
    }
    let figure = |code: &str, value, half, unit: &str| Figure {
        code: code.to_owned(),
        value,
        half,
        unit: unit.to_owned(),
    };
    Some(Suggestion {
        code: SuggestionCode::PoseOff,
        requests: vec![Request::Pose {
            position: Waypoint::new(pose.x_in.round() as i16, pose.y_in.round() as i16)?,
            theta_deg: pose.theta_deg.value.round().rem_euclid(360.0) as u16,
        }],
        figures: vec![
            figure("position", moved_in, pose.ellipse.long_in, "in"),
            figure("heading", turned_deg, pose.theta_deg.half, "deg"),
        ],
    })
}

/// Distance from the middle of the 95 % ellipse, as a multiple of the distance of its edge.
fn ellipses(pose: &CorrectedPose, (x_in, y_in): (f64, f64)) -> f64 {
    let (sin, cos) = pose.ellipse.bearing_deg.to_radians().sin_cos();
    let along = (x_in * sin + y_in * cos) / pose.ellipse.long_in.max(1.0);
    let across = (x_in * cos - y_in * sin) / pose.ellipse.short_in.max(1.0);
    along.hypot(across)
}

/// A scan, if the robot can scan in its mode.
fn scan(robot: &Robot) -> Option<Suggestion> {
    let turns = robot
        .allowed()
        .is_some_and(|allowed| allowed.contains(Layer::Rotation));
    let stays = matches!(
        robot.mode()?,
        Mode::Stop | Mode::User | Mode::Passive | Mode::Calibrate
    );
    (turns && !stays).then(|| Suggestion {
        code: SuggestionCode::HeadingUnknown,
        requests: vec![Request::Scan],
        figures: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use groundwave_mapping::{Ellipse, Interval};

    use super::*;

    #[test]
    fn pose_must_be_clearly_outside_its_intervals() {
        for (x_in, theta_deg, half_deg, suggested) in [
            // The ellipse is 8 in long along X.
            (0.0, 0.0, 4.0, None),
            (0.0, 5.9, 4.0, None),
            (0.0, 6.1, 4.0, Some("set-pose 0 0 6")),
            (0.0, 353.8, 4.0, Some("set-pose 0 0 354")),
            (0.0, 4.9, 1.0, None),
            (0.0, 359.6, 4.0, None),
            (-11.9, 0.0, 4.0, None),
            (-12.4, 0.0, 4.0, Some("set-pose -12 0 0")),
            (14.0, 359.8, 4.0, Some("set-pose 14 0 0")),
            // Beyond the waypoints that the protocol has.
            (20_000.0, 0.0, 4.0, None),
        ] {
            let pose = CorrectedPose {
                x_in,
                y_in: 0.0,
                theta_deg: Interval {
                    value: theta_deg,
                    half: half_deg,
                },
                ellipse: Ellipse {
                    long_in: 8.0,
                    short_in: 4.0,
                    bearing_deg: 90.0,
                },
            };
            let suggestion = set_pose(&StateLine::BLANK, &pose);
            let words = suggestion.map(|it| it.requests[0].to_string());
            let what = format!("x {x_in}, {theta_deg} within {half_deg}");
            assert_eq!(words.as_deref(), suggested, "{what}");
        }
    }

    #[test]
    fn reason_is_in_figures() {
        let pose = CorrectedPose {
            x_in: -12.4,
            y_in: 0.0,
            theta_deg: Interval {
                value: 353.0,
                half: 4.0,
            },
            ellipse: Ellipse {
                long_in: 8.0,
                short_in: 4.0,
                bearing_deg: 90.0,
            },
        };
        let suggestion = set_pose(&StateLine::BLANK, &pose).expect("a suggestion");
        assert_eq!(
            suggestion.event(SuggestionStatus::Begun).to_string(),
            "suggestion begun: set-pose -12 0 353 (position off by 12.4 +-8.0 in, heading off by 7.0 +-4.0 deg)"
        );
    }
}
