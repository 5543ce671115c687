//! What the screen says: everything known about the robot, the link and the operator's wishes.
//!
//! [`Model::update`] is the only way it changes: facts in, wishes out. It has no clock and does no
//! I/O; its size does not grow with the length of a session.

pub(crate) mod age;
pub(crate) mod chart;
pub(crate) mod draft;
pub(crate) mod drive;
pub(crate) mod editor;
pub(crate) mod failsafe;
mod history;
mod input;
pub(crate) mod keys;
pub(crate) mod ledger;
mod life;
pub(crate) mod link;
pub(crate) mod log;
pub(crate) mod motors;
pub(crate) mod news;
pub(crate) mod robot;
mod trail;
mod travel;
pub(crate) mod why;
pub(crate) mod words;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use groundwave_protocol::letters::Power;
use groundwave_protocol::telemetry::{Body, Line, StateLine};

use crate::event::{CommandId, CommandStep, Effect, Event, Level, LinkEvent, Moment, Recording};
use crate::request::Request;
use crate::travel::Playback;
use chart::Chart;
use drive::Stick;
use editor::Editor;
use keys::Context;
use ledger::Ledger;
use life::Life;
use link::{Connection, Link};
use log::{Log, Subject};
use motors::Motors;
use robot::Robot;
use travel::Counted;

/// How the dashboard is to look, fixed for a session.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Config {
    /// Colours.
    pub colors: Colors,
    /// Nothing but ASCII on the screen.
    pub ascii: bool,
    /// How to see the raw line from another terminal, told above the keys; `None` where there is no way.
    pub raw_copy: Option<String>,
    /// Never ring the bell.
    pub silent: bool,
}

/// Colours of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// For a dark background.
    #[default]
    Dark,
    /// For a light background.
    Light,
    /// None: `NO_COLOR`.
    Mono,
}

/// A panel that shares its place with others where the screen is small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Panel {
    #[default]
    Sensors,
    Commands,
    Log,
    Link,
}

impl Panel {
    /// In the order of the Tab key.
    pub(crate) const ALL: [Self; 4] = [Self::Sensors, Self::Commands, Self::Log, Self::Link];
}

/// What lies over the panels and takes the keyboard.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Overlay {
    #[default]
    None,
    Help,
    Question(Question),
    Text(TextEntry),
    Drive(Stick),
    /// Which kind of moment to jump to.
    Jump {
        forward: bool,
    },
}

/// A question that is answered with yes or no.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Question {
    pub(crate) text: String,
    then: Then,
}

/// What a yes leads to.
#[derive(Clone, Debug, PartialEq)]
enum Then {
    Send(Vec<Request>),
    Drive,
    /// Write the draft over the file of this name.
    SaveRoute(String),
}

/// A line being typed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct TextEntry {
    pub(crate) purpose: Purpose,
    pub(crate) text: String,
    /// Why the text as it was submitted does not do.
    pub(crate) error: Option<String>,
}

/// What a typed line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    Command,
    RouteFile,
    /// A place in time.
    Moment,
    SaveRoute,
}

/// The state of the dashboard.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) config: Config,
    pub(crate) link: Link,
    pub(crate) robot: Robot,
    pub(crate) motors: Motors,
    pub(crate) chart: Chart,
    pub(crate) ledger: Ledger,
    pub(crate) log: Log,
    pub(crate) recording: Recording,
    pub(crate) panel: Panel,
    /// Pages turned over in the chosen panel; the view goes round.
    pub(crate) page: i32,
    /// The chosen panel has the place of all of them.
    pub(crate) enlarged: bool,
    /// Pages turned over in the help.
    pub(crate) help_page: i32,
    pub(crate) overlay: Overlay,
    /// The route editor, while it is open.
    pub(crate) editor: Option<Editor>,
    size: (u16, u16),
    life: Life,
    /// What there was to jump to so far.
    counted: Counted,
    /// Where the screen stands in time, unless it shows now.
    pub(crate) playback: Option<Playback>,
    /// Told to the operator while the screen shows another moment, until the next key.
    pub(crate) aside: Option<String>,
    /// The robot sings or calls, and the bell has not rung for it.
    calls: bool,
    revision: u64,
}

impl Model {
    /// A dashboard that knows nothing yet.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            config,
            link: Link::default(),
            robot: Robot::default(),
            motors: Motors::default(),
            chart: Chart::default(),
            ledger: Ledger::default(),
            log: Log::default(),
            recording: Recording::default(),
            panel: Panel::default(),
            page: 0,
            enlarged: false,
            help_page: 0,
            overlay: Overlay::default(),
            editor: None,
            size: (0, 0),
            life: Life::default(),
            counted: Counted::default(),
            playback: None,
            aside: None,
            calls: false,
            revision: 0,
        }
    }

    /// Takes what happened; returns what the operator wants done about it.
    pub fn update(&mut self, now: Moment, event: Event) -> Vec<Effect> {
        let mut effects = self.expire(now);
        let changed = match event {
            Event::Line { line, raw } => {
                self.link.take_line(now, &raw);
                self.take_line(now, &line);
                true
            }
            Event::Ack(line) => {
                self.counted.take_ack(line.ack);
                let restarted = self.life.take_boot(line.ack.boot);
                if restarted {
                    self.take_restart(now);
                }
                restarted
            }
            Event::Counters(counters) => {
                self.link.take_counters(now, &counters);
                // The lines that changed the totals say so themselves; rejects can wait for a line, unless
                // there is none.
                counters.lines == 0
            }
            // Drawn with the next line: whoever looks for figures can wait for it.
            Event::Statistics(statistics) => {
                self.link.take_statistics(*statistics);
                false
            }
            Event::Link(link) => {
                self.take_link(now, &link);
                true
            }
            Event::Command { id, step } => {
                self.take_step(now, id, &step);
                true
            }
            Event::Reception { reception, since } => {
                self.link.take_reception(reception, since);
                true
            }
            Event::Asked { id, by } => {
                self.take_asker(now, id, &by);
                true
            }
            Event::Recording(recording) => self.take_recording(now, recording),
            Event::RouteLoaded { path, route } => {
                self.take_route(now, &path, route);
                true
            }
            Event::Playback(playback) => self.take_playback(playback),
            Event::RouteSaved { path, saved } => {
                self.take_saved(now, &path, &saved);
                true
            }
            Event::Truth(truth) => {
                self.chart.take_truth(truth);
                true
            }
            Event::Notice { level, text } => {
                self.log.add(now, level, Subject::Station, text);
                true
            }
            Event::Key(key) => {
                effects.extend(self.take_key(now, key));
                true
            }
            Event::Paste(text) => self.take_paste(&text),
            Event::Resize { width, height } => {
                let changed = self.size != (width, height);
                self.size = (width, height);
                changed
            }
            Event::Tick => false,
        };
        if std::mem::take(&mut self.calls) && !self.config.silent {
            effects.push(Effect::Ring);
        }
        if changed || !effects.is_empty() {
            self.revision += 1;
        }
        effects
    }

    /// Grows whenever an update changed what the screen shows: draw when it differs from the revision
    /// that was drawn last.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// When the screen changes although nothing happens, because ages do: every second while the newest
    /// line is young, later every ten, and when something is no longer news; `None` while time stands still, as
    /// after the end of a session.
    #[must_use]
    pub fn redraw_at(&self, now: Moment) -> Option<Moment> {
        let ages = self.link.next_tick(now);
        ages.into_iter().chain(self.news_until(now)).min()
    }

    /// When to send [`Event::Tick`] at the latest: a lease on the motors ends then.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        match &self.overlay {
            Overlay::Drive(stick) => stick.next_expiry(),
            _ => None,
        }
    }

    /// Where the keyboard goes.
    pub(crate) const fn context(&self) -> Context {
        match self.overlay {
            Overlay::None if self.editor.is_some() => Context::Route,
            Overlay::None => Context::Dashboard,
            Overlay::Help => Context::Help,
            Overlay::Question(_) => Context::Question,
            Overlay::Text(_) => Context::Text,
            Overlay::Drive(_) => Context::Drive,
            Overlay::Jump { .. } => Context::Jump,
        }
    }

    fn expire(&mut self, now: Moment) -> Vec<Effect> {
        match &mut self.overlay {
            Overlay::Drive(stick) => stick.expire(now).into_iter().collect(),
            _ => Vec::new(),
        }
    }

    fn take_line(&mut self, now: Moment, line: &Line) {
        let restarted = self.life.take_boot(line.ack.boot)
            | match &line.body {
                Body::Status(status) => self.life.take_status(status),
                Body::Counters(counters) => self.life.take_counters(counters),
                Body::State(_) | Body::Text(_) | Body::Parameter(_) | Body::Song(_) => false,
            };
        if restarted {
            self.take_restart(now);
        }
        let before = self.robot.state.map(|state| state.value);
        self.robot.take(now, line);
        self.counted.tally.lines += 1;
        self.counted.take_ack(line.ack);
        match &line.body {
            Body::State(state) => self.take_state(now, before.as_ref(), state),
            Body::Status(status) => self.ledger.take_status(status),
            Body::Counters(counters) => self.motors.take_counters(now, counters),
            Body::Text(text) => {
                self.log
                    .add(now, Level::Info, Subject::Robot, text.as_str());
            }
            Body::Parameter(parameter) => {
                let text = words::parameter(parameter);
                self.log.add(now, Level::Info, Subject::Robot, text);
            }
            Body::Song(song) => {
                self.calls = true;
                self.log
                    .add(now, Level::Info, Subject::Robot, words::song(song));
            }
        }
    }

    /// The robot booted: it has forgotten its list, and measures from where it stands.
    fn take_restart(&mut self, now: Moment) {
        self.ledger.take_restart();
        self.chart.start_afresh();
        self.log
            .add(now, Level::Alarm, Subject::Robot, "the robot restarted");
    }

    fn take_state(&mut self, now: Moment, before: Option<&StateLine>, state: &StateLine) {
        if let Some((x_in, y_in)) = self.chart.take_state(now, state) {
            let text = format!("{} hit at ({x_in:.0}, {y_in:.0})", why::bump(state.bump));
            self.log.add(now, Level::Warning, Subject::Bump, text);
            self.counted.tally.bumps += 1;
        }
        if before.is_some_and(|before| before.mode != state.mode) {
            let text = format!("the robot reports mode {}", words::mode(state.mode));
            self.log.add(now, Level::Info, Subject::Behaviour, text);
            self.counted.tally.behaviours += 1;
        }
        let linked = before.map(|before| before.link);
        if let Some((level, text)) = failsafe::news(linked, state.link, &self.robot) {
            let subject = match level {
                Level::Alarm => Subject::Robot,
                Level::Info | Level::Warning => Subject::Behaviour,
            };
            self.log.add(now, level, subject, text);
        }
        if let Some(text) = power_alarm(before.map(|before| before.power), state.power) {
            self.calls = true;
            self.log.add(now, Level::Alarm, Subject::Robot, text);
        }
        let held = self.motors.holder().map(|held| held.value);
        if self.motors.take_state(now, state) {
            let robot = &self.robot;
            let holder = motors::Holder::of(state);
            if held.is_some_and(|held| !(held.is_routine() && holder.is_routine())) {
                self.counted.tally.behaviours += 1;
            }
            self.log.add_holder(now, holder.is_routine(), || {
                let why = why::why(holder, state, robot, now);
                format!("{}: {why}", words::holder(holder).to_uppercase())
            });
        }
    }

    fn take_link(&mut self, now: Moment, event: &LinkEvent) {
        let again = matches!(
            self.link.connection,
            Connection::Lost { .. } | Connection::Ended
        );
        let (level, text) = match event {
            LinkEvent::Opened { name, .. } if again && *name != self.link.name => {
                (Level::Info, format!("back as {name}"))
            }
            LinkEvent::Opened { name, .. } if again => (Level::Info, format!("{name} is back")),
            LinkEvent::Opened { name, can_send } => {
                let only = if *can_send { "" } else { ", receive only" };
                (Level::Info, format!("listening to {name}{only}"))
            }
            LinkEvent::Lost { reason } => (Level::Alarm, format!("link lost: {reason}")),
            LinkEvent::Ended => (Level::Info, "the session is over".to_owned()),
        };
        self.log.add(now, level, Subject::Link, text);
        self.link.take_event(now, event);
    }

    fn take_step(&mut self, now: Moment, id: CommandId, step: &CommandStep) {
        self.counted.take_step(step);
        let Some(entry) = self.ledger.take_step(now, id, step) else {
            return;
        };
        if let (Request::Route(waypoints), CommandStep::Refused(_) | CommandStep::Failed(_)) =
            (&entry.request, step)
            && self.chart.draft.waypoints().is_empty()
        {
            // What did not arrive goes back to where it can be sent again.
            self.chart.take_draft(waypoints);
        }
        let asked = &entry.request;
        let (level, text) = match step {
            CommandStep::Queued(_)
            | CommandStep::Sent { .. }
            | CommandStep::Progress { .. }
            | CommandStep::Told(_) => return,
            CommandStep::Proven {
                digest: Some(digest),
            } => (
                Level::Info,
                format!("{asked}: the robot verified {digest:08X}"),
            ),
            CommandStep::Proven { digest: None } => {
                (Level::Info, format!("{asked}: the robot acknowledged"))
            }
            CommandStep::Refused(outcome) => {
                let why = self.robot.standing().why(asked, *outcome);
                let why = why.unwrap_or_else(|| words::outcome(*outcome).to_owned());
                (Level::Warning, format!("{asked}: refused, {why}"))
            }
            CommandStep::Failed(failure) => (Level::Warning, format!("{asked}: {failure}")),
        };
        self.log.add(now, level, Subject::Command, text);
    }

    fn take_asker(&mut self, now: Moment, id: CommandId, by: &str) {
        if let Some(entry) = self.ledger.take_asker(id, by) {
            let text = format!("{}: asked by {by}", entry.request);
            self.log.add(now, Level::Info, Subject::Command, text);
        }
    }

    fn take_recording(&mut self, now: Moment, recording: Recording) -> bool {
        if let Some(problem) = &recording.problem
            && self.recording.problem.as_ref() != Some(problem)
        {
            self.log
                .add(now, Level::Alarm, Subject::Station, problem.as_str());
        }
        let shown = |r: &Recording| (r.tee.clone(), r.mcap.clone(), r.problem.clone());
        let changed = shown(&recording) != shown(&self.recording);
        self.recording = recording;
        changed
    }
}

fn power_alarm(before: Option<Power>, now: Power) -> Option<&'static str> {
    if before == Some(now) {
        return None;
    }
    match now {
        Power::Low => Some("battery low"),
        Power::Critical => Some("battery critical"),
        Power::Ok | Power::Docked | Power::Charging => None,
    }
}
