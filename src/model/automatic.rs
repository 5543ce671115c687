//! Commands that the station sends by itself with `--advise=auto`: suggested poses, the way to the dock and out of a place,
//! planned routes again while the robot drives them, and scans where it begins and near the end of a planned route.
//!
//! The operator outranks it. After driving by hand, STOP and a mode it is silent for a minute, and after a command that was stopped,
//! taken over or cancelled. These commands, STOP, another route, a new pose and a mode in which the robot does not drive the route end the
//! drive to a destination. Nothing is sent while another command
//! is unfinished or a STOP is not confirmed, and no route while the robot's position is not known.

mod planned_drive;

use groundwave_captures::words::counted;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Failure;
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::Reading;

use super::config::Advise;
use super::ground::{Suggestion, is_driven_by_hand};
use super::ledger::ActiveList;
use super::{Facts, Ui};
use crate::event::{
    CommandId, CommandStatus, Effect, Event, GROUND, Level, Moment, SuggestionCode,
    SuggestionStatus,
};
use crate::request::Request;
use planned_drive::{ARRIVED_IN, PlannedDrive, is_under_way};

/// Time without commands after an operator has acted.
const SILENT: Moment = Moment::from_mins(1);

/// Time after which a destination is given up.
const LIMIT: Moment = Moment::from_mins(20);

/// The same for one that only the station has chosen.
const DETOUR_LIMIT: Moment = Moment::from_mins(5);

/// A planned draft.
#[derive(Clone, Debug)]
struct Planned {
    /// The destination as the operator typed it.
    to: String,
    target_in: (f64, f64),
    waypoints: Vec<Waypoint>,
    /// Whether the station has chosen the destination, for a robot that prowls; it goes on prowling from there.
    is_detour: bool,
}

/// The present destination, and the time until which nothing is sent.
#[derive(Clone, Debug, Default)]
pub(super) struct Automatic {
    silent_until: Moment,
    planned: Option<Planned>,
    drive: Option<PlannedDrive>,
    /// Whether the robot stands at the end of a route of the station, and no operator has stopped it.
    has_arrived: bool,
    /// The beginning of the estimate's frame in which home was scanned.
    scanned: Option<Moment>,
}

impl Automatic {
    /// Takes a draft that was planned to a true point, inches.
    pub(super) fn take_planned(
        &mut self,
        to: &str,
        target_in: (f64, f64),
        waypoints: Vec<Waypoint>,
    ) {
        self.planned = Some(Planned {
            to: to.to_owned(),
            target_in,
            waypoints,
            is_detour: false,
        });
    }

    /// Takes a suggestion that is being sent; `is_detour` if the station sends it to a robot that prowls.
    pub(super) fn take_suggested(&mut self, suggestion: &Suggestion, is_detour: bool) {
        if let (Some(waypoints), Some(target_in)) = (suggestion.waypoints(), suggestion.target_in) {
            self.planned = Some(Planned {
                to: match suggestion.code {
                    SuggestionCode::DockNow => "home".to_owned(),
                    _ => format!("{:.0} {:.0}", target_in.0, target_in.1),
                },
                target_in,
                waypoints: waypoints.to_vec(),
                is_detour,
            });
        }
    }

    fn is_planned(&self, waypoints: &[Waypoint]) -> bool {
        let planned = self.planned.as_ref();
        planned.is_some_and(|it| it.waypoints == waypoints)
    }

    /// Takes a route that is being sent: if it was planned or suggested, a drive begins. Any other one ends it.
    fn take_route(&mut self, now: Moment, id: CommandId, waypoints: &[Waypoint]) {
        let planned = self.planned.take_if(|it| it.waypoints == waypoints);
        self.drive = planned.map(|it| {
            let until = now + if it.is_detour { DETOUR_LIMIT } else { LIMIT };
            PlannedDrive::new(it.to, it.target_in, it.is_detour, id, now, until)
        });
    }

    /// Takes driving by hand.
    pub(super) fn take_drive(&mut self, now: Moment) {
        self.has_arrived = false;
        self.silent_until = now + SILENT;
    }

    /// Takes a command of an operator.
    fn take_asked(&mut self, now: Moment, id: CommandId, request: &Request) {
        if request.mode().is_some() {
            self.silent_until = now + SILENT;
        }
        self.has_arrived = false;
        match request {
            Request::Route(waypoints) => self.take_route(now, id, waypoints),
            Request::Mode(Mode::Prowl | Mode::User) => {}
            Request::Stop | Request::Mode(_) | Request::Pose { .. } => self.drive = None,
            _ => {}
        }
    }
}

impl Ui {
    /// Whether the station sends commands by itself, and whether it is silent now; `None` if it does not.
    pub(crate) fn is_automatic(&self, now: Moment) -> Option<bool> {
        (self.config.advise == Advise::Auto).then_some(now < self.automatic.silent_until)
    }

    /// Takes an event; returns the commands that the station sends by itself.
    pub(super) fn automate(&mut self, now: Moment, event: &Event, facts: &Facts) -> Vec<Effect> {
        match event {
            _ if self.config.advise != Advise::Auto => {}
            Event::Asked { id, request, by } if by.as_deref() != Some(GROUND) => {
                self.automatic.take_asked(now, *id, request);
            }
            // A route that is planned again goes on with its drive; a suggested one begins a drive.
            Event::Asked {
                id,
                request: Request::Route(waypoints),
                ..
            } if self.automatic.is_planned(waypoints) => {
                self.automatic.take_route(now, *id, waypoints);
            }
            // An operator, perhaps another station's, has ended what was being sent.
            Event::Command {
                id,
                status:
                    CommandStatus::Failed(Failure::Stopped | Failure::TakenOver | Failure::Cancelled),
            } => {
                self.automatic.drive.take_if(|drive| drive.id <= *id);
                self.automatic.has_arrived = false;
                self.automatic.silent_until = now + SILENT;
            }
            Event::Command {
                id,
                status: CommandStatus::Refused(_) | CommandStatus::Failed(_),
            } => {
                self.automatic.drive.take_if(|drive| drive.id == *id);
            }
            Event::Line { .. } => {
                self.automatic.has_arrived &= facts.robot.mode() == Some(Mode::Stop);
                if is_driven_by_hand(&facts.robot, &facts.motors) {
                    self.automatic.take_drive(now);
                }
                let is_barred = now < self.automatic.silent_until
                    || facts.ledger.is_busy()
                    || facts.ledger.unconfirmed_stop().is_some()
                    || !facts.link.can_send
                    || facts.link.is_frozen();
                if !is_barred {
                    return match self.automatic.drive.take() {
                        Some(drive) => self.drive_on(now, facts, drive),
                        None if self.is_home_unseen(facts) => {
                            self.automatic.scanned = facts.ground.since();
                            unasked([Request::Scan])
                        }
                        None => self.accept_unasked(now, facts),
                    };
                }
            }
            _ => {}
        }
        Vec::new()
    }

    /// Whether a robot that prowls may show how home looks, which it has not yet.
    fn is_home_unseen(&self, facts: &Facts) -> bool {
        // The list may be another station's.
        let is_driven = facts.robot.status.is_some_and(|status| {
            let list = status.value.list;
            list.driven >= list.count
        });
        facts.robot.mode() == Some(Mode::Prowl)
            && is_driven
            && facts.ledger.active().is_none_or(ActiveList::is_driven)
            && facts.robot.measures(Reading::Sonars)
            && facts.ground.may_see_home()
            && self.automatic.scanned != facts.ground.since()
            && facts.robot.turns_on_request()
    }

    /// Goes on with a drive: scans, plans its route again, and ends it.
    fn drive_on(&mut self, now: Moment, facts: &Facts, mut drive: PlannedDrive) -> Vec<Effect> {
        let to = drive.to.clone();
        if facts.robot.mode() == Some(Mode::Forage) {
            // It drives to its dock by itself.
            return Vec::new();
        }
        // Without a list, the robot has restarted.
        let Some(active) = facts.ledger.active() else {
            self.automatic.has_arrived = false;
            self.note(Level::Warning, format!("plan {to}: given up"));
            return Vec::new();
        };
        let drives = !active.is_driven() && facts.robot.mode() == Some(Mode::Prowl);
        if drives {
            drive.take_driving(now);
        }
        if drive.is_looking(now, facts) {
            self.automatic.drive = Some(drive);
            return Vec::new();
        }
        let is_at_end = drive.is_at_end(active, &facts.robot);
        self.automatic.has_arrived = is_at_end && !drive.is_detour;
        if now >= drive.until {
            self.note(Level::Warning, format!("plan {to}: given up"));
            if drive.is_detour && drives {
                return unasked([Request::Route(Vec::new())]);
            }
            return unasked(onward(&drive, active, is_at_end));
        }
        let place_in = drive.place_to_look_in(facts);
        if drives && let Some(here) = place_in.filter(|here| drive.is_elsewhere(*here)) {
            self.note(Level::Info, format!("plan {to}: looks around"));
            drive.look(now, here);
            self.automatic.drive = Some(drive);
            // It goes on along its route afterwards.
            return unasked([Request::Scan]);
        }
        if !is_at_end && (!drives || !drive.is_due(now)) {
            self.automatic.drive = Some(drive);
            return Vec::new();
        }
        drive.take_plan(now);
        let within_in = drive.arrived_within_in(facts).filter(|_| is_at_end);
        if let Some(within_in) = within_in {
            if place_in.is_some()
                && let Some(route) = drive.route_aside(now, facts)
            {
                self.note(Level::Info, format!("plan {to}: looks from aside"));
                self.automatic.drive = Some(drive);
                return unasked([Request::Route(route), Request::Mode(Mode::Prowl)]);
            }
            let within = format!("arrived, within {within_in:.0} in");
            self.note(Level::Info, format!("plan {to}: {within}"));
            return unasked(onward(&drive, active, is_at_end));
        }
        self.plan_again(facts, drive, active, is_at_end)
    }

    /// Plans the route of a drive again; where it has ended, the robot goes on.
    fn plan_again(
        &mut self,
        facts: &Facts,
        mut drive: PlannedDrive,
        active: &ActiveList,
        is_at_end: bool,
    ) -> Vec<Effect> {
        let to = drive.to.clone();
        let onward = onward(&drive, active, is_at_end);
        let most = facts.robot.list_capacity();
        let (level, text, requests) = match facts.ground.route(drive.target_in, most) {
            Ok(route)
                if is_at_end && (route.waypoints.is_empty() || route.length_in < ARRIVED_IN) =>
            {
                let text = format!("plan {to}: ended {:.0} in short", route.short_in);
                (Level::Warning, text, unasked(onward))
            }
            Ok(route)
                if !is_at_end
                    && (route.waypoints.is_empty()
                        || is_under_way(&route.waypoints, active, &facts.robot)) =>
            {
                drive.refusal = None;
                self.automatic.drive = Some(drive);
                return Vec::new();
            }
            Ok(route) => {
                let count = counted(route.waypoints.len() as u64, "waypoint");
                let text = format!("plan {to}: planned again, {count}");
                drive.refusal = None;
                drive.take_sent((!is_at_end).then_some(active));
                self.automatic.drive = Some(drive);
                let route = Request::Route(route.waypoints);
                let prowl = is_at_end.then_some(Request::Mode(Mode::Prowl));
                (Level::Info, text, unasked([route].into_iter().chain(prowl)))
            }
            Err(reason) => {
                let is_known = drive.refusal.replace(reason) == Some(reason);
                let text = format!("plan {to}: no route planned: {reason}");
                if !is_at_end {
                    self.automatic.drive = Some(drive);
                }
                if is_known {
                    return unasked(onward);
                }
                (Level::Warning, text, unasked(onward))
            }
        };
        self.note(level, text);
        requests
    }

    /// Accepts a suggested pose, the way to the dock unless an operator has stopped the robot, and the way out for one that prowls.
    fn accept_unasked(&mut self, now: Moment, facts: &Facts) -> Vec<Effect> {
        let mode = facts.robot.mode();
        let is_meant = |it: &&Suggestion| match it.code {
            SuggestionCode::PoseOff => true,
            SuggestionCode::DockNow => mode != Some(Mode::Stop) || self.automatic.has_arrived,
            SuggestionCode::Held => mode == Some(Mode::Prowl),
            _ => false,
        };
        let Some(suggestion) = facts.suggestion(now).filter(is_meant) else {
            return Vec::new();
        };
        let is_detour = suggestion.code == SuggestionCode::Held;
        self.automatic.take_suggested(suggestion, is_detour);
        let accepted = suggestion.event(SuggestionStatus::Accepted);
        [Effect::Suggestion(accepted)]
            .into_iter()
            .chain(unasked(suggestion.requests.iter().cloned()))
            .collect()
    }
}

/// A robot that prowled before the station sent it away prowls on at the end, without what is left of a list.
fn onward(drive: &PlannedDrive, active: &ActiveList, is_at_end: bool) -> Vec<Request> {
    if !drive.is_detour || !is_at_end {
        return Vec::new();
    }
    let clear = (!active.is_driven()).then(|| Request::Route(Vec::new()));
    let prowl = Request::Mode(Mode::Prowl);
    clear.into_iter().chain([prowl]).collect()
}

fn unasked(requests: impl IntoIterator<Item = Request>) -> Vec<Effect> {
    requests.into_iter().map(Effect::SendUnasked).collect()
}
