//! Facts about the robot, the link and the recording, derived from events alone.

mod lines;

use std::sync::Arc;

use groundwave_captures::own_lines::DescribedFields;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::life::Life;
use groundwave_protocol::status_codes::{Link as Letter, Mode};

use super::alarms::{AlarmChange, Alarms, Attended, Inputs};
use super::chart::Chart;
use super::config::{Advise, Config};
use super::fields::Fields;
use super::ground::{Ground, Situation, Suggestion};
use super::ledger::Ledger;
use super::link::{Connection, Link};
use super::log::{Log, Subject};
use super::motors::Motors;
use super::panel::Panel;
use super::plots::Plots;
use super::reported_parameters::Parameters;
use super::robot::{Robot, STATE_STALE};
use super::tally::Counted;
use super::{age, failsafe, words};
use crate::event::{
    AlarmAnswer, AlarmEvent, AlarmStatus, Answer, CommandId, CommandStatus, Event, Level,
    LinkEvent, Moment, Recording, SuggestionEvent, SuggestionStatus,
};
use crate::playback::Tally;
use crate::request::{Request, Tuning};

/// All state that follows from events.
#[derive(Clone, Debug)]
pub struct Facts {
    /// Settings of the session.
    pub(crate) config: Arc<Config>,
    pub(crate) link: Link,
    pub(crate) robot: Robot,
    pub(crate) motors: Motors,
    pub(crate) chart: Chart,
    pub(crate) ground: Ground,
    pub(crate) ledger: Ledger,
    pub(crate) log: Log,
    pub(crate) alarms: Alarms,
    /// Alarms that the latest event raised or ended.
    pub(crate) alarm_changes: Vec<AlarmChange>,
    pub(crate) plots: Plots,
    /// Values of the robot's own lines.
    pub(crate) fields: Fields,
    pub(crate) parameters: Parameters,
    described: DescribedFields,
    pub(crate) recording: Recording,
    life: Life,
    counted: Counted,
    /// Whether the current event brought an alarm or a song.
    calls: bool,
}

/// Effect of an event on the facts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Change {
    /// Whether the screen shows the change.
    pub is_shown: bool,
    /// Whether the bell rings for the change.
    pub calls: bool,
}

impl Facts {
    /// Facts before the first event.
    #[must_use]
    pub fn new(config: Arc<Config>) -> Self {
        Self {
            alarms: Alarms::new(&config.limits, &config.alarms),
            config,
            link: Link::default(),
            robot: Robot::default(),
            motors: Motors::default(),
            chart: Chart::default(),
            ground: Ground::default(),
            ledger: Ledger::default(),
            log: Log::default(),
            alarm_changes: Vec::new(),
            plots: Plots::default(),
            fields: Fields::default(),
            parameters: Parameters::default(),
            described: DescribedFields::default(),
            recording: Recording::default(),
            life: Life::default(),
            counted: Counted::default(),
            calls: false,
        }
    }

    /// Ends the estimate of the pose, which takes nine tenths of the time of a line. Facts that lack earlier lines would only have a wrong one.
    pub(crate) fn end_estimate(&mut self) {
        self.ground.end();
    }

    /// Whether an event can change facts apart from the passing of time.
    #[must_use]
    pub const fn takes(event: &Event) -> bool {
        !matches!(
            event,
            Event::Key(_)
                | Event::Paste(_)
                | Event::Pointer { .. }
                | Event::Resize { .. }
                | Event::Files { .. }
                | Event::RouteLoaded { .. }
                | Event::ParametersLoaded { .. }
                | Event::Saved { .. }
                | Event::Runs(_)
                | Event::Overlaid(_)
                | Event::Mark(_)
                | Event::Tick
        )
    }

    /// Takes an event; returns its effect.
    pub fn update(&mut self, now: Moment, event: &Event) -> Change {
        let mut is_shown = true;
        match event {
            Event::Line { line, raw } => {
                self.link.take_line(now, raw);
                self.alarms.take_line(|| Received::Line(**line, *raw));
                self.take_line(now, line);
            }
            Event::Repaired(line) => {
                self.ground.take_repaired(now, line);
                is_shown = false;
            }
            Event::Own(line) => {
                self.alarms.take_own_line(line);
                self.take_own_line(now, line);
            }
            Event::Ack(line) => {
                self.chart.take_sequence(now, line.sequence);
                self.counted.take_ack(line.ack);
                is_shown = self.life.take_boot(line.ack.boot);
                if is_shown {
                    self.take_restart(now);
                }
            }
            Event::Counters(counters) => {
                self.link.take_counters(now, counters);
                // The line that changed the totals is drawn anyway; damaged lines can wait for the next line
                // unless there has been no line yet.
                is_shown = counters.lines == 0;
            }
            // The change is drawn with the next line.
            Event::Statistics(statistics) => {
                self.link.take_statistics(statistics);
                self.plots.take_statistics(now, statistics, &self.link);
                is_shown = false;
            }
            Event::Link(link) => self.take_link(now, link),
            Event::Command { id, status } => self.take_command_status(now, *id, status),
            Event::Reception { reception, since } => self.link.take_reception(*reception, *since),
            Event::Asked { id, request, by } => self.take_asked(now, *id, request, by.as_deref()),
            Event::Recording(recording) => is_shown = self.take_recording(now, recording),
            Event::Outage(outage) => {
                self.plots.take_outage(outage);
                is_shown = outage.end.is_some();
                if is_shown {
                    let text = outage.to_string();
                    self.log.add(now, Level::Info, Subject::Station, text);
                }
            }
            Event::Suspended(duration) => {
                self.link.resume(now);
                let text = format!("suspended for {:.1} s", duration.as_secs_f64());
                self.log.add(now, Level::Warning, Subject::Station, text);
            }
            Event::Alarm(alarm) => is_shown = self.take_alarm(now, alarm),
            Event::Suggestion(suggestion) => is_shown = self.take_suggestion(now, suggestion),
            Event::Truth(truth) => self.chart.take_truth(truth.clone()),
            Event::Notice(notice) => {
                let text = notice.text.as_str();
                self.log.add(now, notice.level, Subject::Station, text);
            }
            _ => is_shown = false,
        }
        is_shown |= self.watch_alarms(now);
        self.ground.forget_changes();
        if matches!(
            event,
            Event::Line { .. } | Event::Asked { .. } | Event::Link(_) | Event::Statistics(_)
        ) {
            is_shown |= self.watch_ground(now);
        }
        Change {
            is_shown,
            calls: std::mem::take(&mut self.calls),
        }
    }

    /// Describes what the robot does when the operator leaves, and the commands that it did not confirm; `None` if no line was
    /// received.
    #[must_use]
    pub fn last_words(&self, now: Moment) -> Option<String> {
        let state = self.robot.state?;
        let mode = words::mode(state.value.mode);
        let age = state.age(now);
        let does = if age >= STATE_STALE {
            format!(
                "the robot was in mode {mode} when last heard, {} ago",
                age::words(age)
            )
        } else if state.value.mode == Mode::Stop {
            "the robot is stopped".to_owned()
        } else {
            format!("the robot is still in mode {mode}")
        };
        let failsafe = failsafe::standing(&self.robot, &self.ledger);
        let failsafe = failsafe.filter(|(link, _)| *link != Letter::Ok);
        let failsafe = failsafe.map(|(_, says)| format!("; failsafe: {says}"));
        let open: Vec<String> = self.ledger.open().map(Request::to_string).collect();
        let open = (!open.is_empty()).then(|| format!("; not confirmed: {}", open.join(", ")));
        Some(does + &failsafe.unwrap_or_default() + &open.unwrap_or_default())
    }

    /// Latest time for the next [`Event::Tick`]: when the next pending alarm is due.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let alarm = self.alarms.next_due();
        alarm.filter(|_| !self.link.is_frozen())
    }

    /// Number of landmarks so far.
    #[must_use]
    pub const fn tally(&self) -> Tally {
        Tally {
            alarms: self.log.alarms() + self.counted.tally.alarms,
            ..self.counted.tally
        }
    }

    /// Time at which the newest line arrived.
    #[must_use]
    pub const fn newest_line_at(&self) -> Option<Moment> {
        self.link.newest_line_at()
    }

    /// The settings of the session.
    #[must_use]
    pub const fn config(&self) -> &Arc<Config> {
        &self.config
    }

    /// Checks the alarms; returns whether the screen changes. Does nothing after the end of a session.
    fn watch_alarms(&mut self, now: Moment) -> bool {
        self.alarm_changes.clear();
        if self.link.is_frozen() {
            return false;
        }
        let inputs = Inputs {
            now,
            robot: &self.robot,
            link: &self.link,
            motors: &self.motors,
            recording: &self.recording,
        };
        self.alarm_changes = self.alarms.watch(&inputs);
        for AlarmChange { rule, value, .. } in
            self.alarm_changes.iter().filter(|change| change.is_active)
        {
            self.calls = true;
            // Alarms of the highest level are counted by the log.
            self.counted.tally.alarms += u64::from(rule.level != Level::Alarm);
            if let Some(text) = rule.log_text(*value, &self.config.keys) {
                self.log.add(now, rule.level, Subject::Alarm, text);
            }
        }
        !self.alarm_changes.is_empty()
    }

    /// Alarms that the latest event raised or ended.
    pub fn alarm_events(&self) -> impl Iterator<Item = AlarmEvent> {
        self.alarm_changes.iter().map(AlarmChange::event)
    }

    /// The event that reports another operator's answer to an alarm; `None` if this program has no such alarm, or one that is not on is
    /// acknowledged.
    #[must_use]
    pub fn answer_event(&self, answer: &AlarmAnswer) -> Option<AlarmEvent> {
        let index = self.alarms.find(&answer.alarm)?;
        let status = answer.answer.status();
        let event = self.alarms.answered(&Attended::default(), index, status)?;
        if answer.answer == Answer::Acknowledged && event.began_at.is_none() {
            return None;
        }
        Some(AlarmEvent {
            shelved_for: answer.answer.shelved_for(),
            by: Some(answer.by.clone()),
            ..event
        })
    }

    /// Checks the suggestions; returns whether the screen changes.
    pub(crate) fn watch_ground(&mut self, now: Moment) -> bool {
        if self.config.advise == Advise::Off {
            return false;
        }
        self.ground.watch(&Situation {
            now,
            link: &self.link,
            robot: &self.robot,
            motors: &self.motors,
            ledger: &self.ledger,
            parameters: &self.parameters,
            battery_low_dv: i32::from(self.config.limits.battery_low_dv),
        });
        !self.ground.changes().is_empty()
    }

    /// Changes of the suggestion by the latest event.
    #[must_use]
    pub fn suggestion_events(&self) -> &[SuggestionEvent] {
        self.ground.changes()
    }

    /// The suggestion that the operator may accept now.
    pub(crate) fn suggestion(&self, now: Moment) -> Option<&Suggestion> {
        self.ground.offered(now, &self.robot)
    }

    /// Logs a suggestion and its acceptance; returns whether it did.
    fn take_suggestion(&mut self, now: Moment, suggestion: &SuggestionEvent) -> bool {
        match suggestion.status {
            SuggestionStatus::Begun => {}
            SuggestionStatus::Accepted => self.ground.take_accepted(now),
            SuggestionStatus::Ended | SuggestionStatus::Expired => return false,
        }
        let text = suggestion.to_string();
        self.log.add(now, Level::Info, Subject::Station, text);
        true
    }

    /// Logs the operator's answer to an alarm; returns whether there was one.
    fn take_alarm(&mut self, now: Moment, alarm: &AlarmEvent) -> bool {
        let name = &alarm.name;
        let mut text = match (alarm.status, alarm.shelved_for) {
            (AlarmStatus::Begun | AlarmStatus::Ended, _) => return false,
            (AlarmStatus::Shelved, Some(time)) => {
                format!("{name}: shelved for {}", age::words(time))
            }
            (status, _) => format!("{name}: {}", status.code()),
        };
        if let Some(by) = &alarm.by {
            text = format!("{text} by {by}");
        }
        self.log.add(now, Level::Info, Subject::Alarm, text);
        true
    }

    /// Whether a panel has content for this robot, or may have.
    pub(crate) fn offers(&self, panel: Panel) -> bool {
        match panel {
            Panel::Sensors | Panel::Above | Panel::Plots => !self.link.has_only_own_lines(),
            Panel::Fields => self.fields.are_known(),
            Panel::Commands | Panel::Log | Panel::Link | Panel::Alarms => true,
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
            LinkEvent::Lost { reason } => {
                self.chart.interrupt();
                (Level::Alarm, format!("link lost: {reason}"))
            }
            LinkEvent::Ended => (Level::Info, "the session is over".to_owned()),
        };
        self.log.add(now, level, Subject::Link, text);
        self.link.take_event(now, event);
    }

    fn take_asked(&mut self, now: Moment, id: CommandId, request: &Request, by: Option<&str>) {
        self.counted.take_asked();
        if let Some(by) = by {
            let text = format!("{request}: asked by {by}");
            self.log.add(now, Level::Info, Subject::Link, text);
        }
        let by = by.map(str::to_owned);
        self.ground.take_asked(now, request);
        self.ledger.add(now, id, request.clone(), by);
        self.follow();
    }

    fn take_command_status(&mut self, now: Moment, id: CommandId, status: &CommandStatus) {
        self.counted.take_command_status(status);
        let Some(entry) = self.ledger.take_command_status(now, id, status) else {
            return;
        };
        let asked = &entry.request;
        if let (CommandStatus::Confirmed { .. }, Request::Parameter(Tuning::Save)) = (status, asked)
        {
            self.parameters.take_saved();
        }
        let mode = asked.mode();
        let (level, text) = match status {
            CommandStatus::Queued
            | CommandStatus::Sent { .. }
            | CommandStatus::Progress { .. }
            | CommandStatus::Reported(_) => return,
            CommandStatus::Confirmed {
                digest: Some(digest),
            } => (
                Level::Info,
                format!("{asked}: confirmed, digest {digest:08X}"),
            ),
            CommandStatus::Confirmed { digest: None } => {
                (Level::Info, format!("{asked}: confirmed"))
            }
            CommandStatus::Echoed => (Level::Info, format!("{asked}: echoed")),
            CommandStatus::Refused(outcome) => {
                let reason = self.robot.standing().why(asked, *outcome);
                let why = reason.as_deref().unwrap_or(words::outcome(*outcome));
                let text = format!("{asked}: refused, {why}");
                self.ledger.take_reason(id, reason);
                (Level::Warning, text)
            }
            CommandStatus::Failed(failure) => (Level::Warning, format!("{asked}: {failure}")),
        };
        self.log.add(now, level, Subject::Command, text);
        if let (CommandStatus::Confirmed { .. }, Some(mode)) = (status, mode) {
            self.take_confirmed_mode(now, mode);
        }
    }

    fn take_recording(&mut self, now: Moment, recording: &Recording) -> bool {
        if let Some(problem) = &recording.problem
            && self.recording.problem.as_ref() != Some(problem)
        {
            self.log
                .add(now, Level::Alarm, Subject::Station, problem.as_str());
        }
        let shown = |r: &Recording| (r.tee.clone(), r.mcap.clone(), r.problem.clone());
        let changed = shown(recording) != shown(&self.recording);
        self.recording.clone_from(recording);
        changed
    }
}
