//! What the robot's lines change.

use groundwave_lines::{Content, OwnLine};
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{Body, Line, StateLine};

use super::Facts;
use crate::event::{Level, Moment};
use crate::model::log::Subject;
use crate::model::motors::Holder;
use crate::model::{failsafe, why, words};

impl Facts {
    /// Takes a line of Groundwave's form.
    pub(super) fn take_line(&mut self, now: Moment, line: &Line) {
        if self.life.take_line(line) {
            self.take_restart(now);
        }
        let before = self.robot.state.map(|state| state.value);
        self.robot.take(now, line);
        self.counted.tally.lines += 1;
        self.counted.take_ack(line.ack);
        self.chart.take_sequence(now, line.sequence);
        self.ground.take_line(now, line);
        match &line.body {
            Body::State(state) => self.take_state(now, before.as_ref(), state),
            Body::Status(status) => {
                self.ledger.take_status(status);
                if self.robot.battery().is_some() {
                    self.plots.take_status(now, status);
                }
            }
            Body::Counters(counters) => self.motors.take_counters(now, counters),
            Body::Text(text) => {
                self.log
                    .add(now, Level::Info, Subject::Robot, text.as_str());
            }
            Body::Parameter(parameter) => {
                self.parameters.take(*parameter);
                let text = words::parameter(parameter);
                self.log.add(now, Level::Info, Subject::Robot, text);
            }
            Body::Song(song) => {
                self.calls = true;
                self.log
                    .add(now, Level::Info, Subject::Robot, words::song(song));
            }
            Body::Abilities(_) => {}
            Body::Field(_) | Body::Values(_) => {
                if let Some(values) = self.described.take(&line.body) {
                    self.fields.take(now, &values);
                    self.plots.begin(now);
                }
            }
        }
    }

    /// Takes a line of the robot's own.
    pub(super) fn take_own_line(&mut self, now: Moment, line: &OwnLine) {
        let found = self.fields.take(now, line);
        match line.content {
            Content::Damaged => return,
            Content::Text => {
                self.log
                    .add(now, Level::Info, Subject::Robot, line.text.as_str());
            }
            Content::Values(_) => self.plots.begin(now),
        }
        self.link.take_own_line(now);
        self.counted.tally.lines += 1;
        if let Some(pose) = found.pose {
            self.chart.take_pose(now, pose);
            self.follow();
        }
        if found.is_bumped {
            let place = self
                .chart
                .pose()
                .map(|pose| self.chart.take_bump(pose, 0.0));
            let text = match place {
                Some((x_in, y_in)) => format!("bumper hit at ({x_in:.0}, {y_in:.0})"),
                None => "bumper hit".to_owned(),
            };
            self.log.add(now, Level::Warning, Subject::Bump, text);
            self.take_contact();
        }
        if let Some(mode) = found.mode {
            let text = format!("the robot reports mode {mode}");
            self.log.add(now, Level::Info, Subject::Behaviour, text);
            self.counted.tally.behaviours += 1;
        }
        if let Some(text) = found.text {
            self.log.add(now, Level::Info, Subject::Robot, text);
        }
    }

    const fn take_contact(&mut self) {
        self.counted.tally.bumps += 1;
        self.robot.contacts = self.robot.contacts.saturating_add(1);
    }

    /// Takes a restart of the robot: its list is lost, and its frame begins at its place.
    pub(super) fn take_restart(&mut self, now: Moment) {
        self.ledger.take_restart();
        self.robot.take_restart();
        self.motors.start_afresh();
        self.parameters.take_restart();
        self.chart.start_afresh();
        self.ground.take_restart();
        self.log
            .add(now, Level::Alarm, Subject::Robot, "the robot restarted");
    }

    fn take_state(&mut self, now: Moment, before: Option<&StateLine>, state: &StateLine) {
        if let Some((x_in, y_in)) = self.chart.take_state(now, state) {
            let text = format!("{} hit at ({x_in:.0}, {y_in:.0})", why::bump(state.bump));
            self.log.add(now, Level::Warning, Subject::Bump, text);
            self.take_contact();
        }
        self.follow();
        if before.is_some_and(|before| before.mode != state.mode) {
            let text = format!("the robot reports mode {}", words::mode(state.mode));
            self.log.add(now, Level::Info, Subject::Behaviour, text);
            self.counted.tally.behaviours += 1;
        }
        let linked = before.map(|before| before.link);
        if let Some((level, text)) = failsafe::news(linked, state.link, &self.robot, &self.ledger) {
            let subject = match level {
                Level::Alarm => Subject::Robot,
                Level::Info | Level::Warning => Subject::Behaviour,
            };
            self.log.add(now, level, subject, text);
        }
        self.plots.take_state(now, state, &self.link);
        let held = self.motors.holder().map(|held| held.value);
        if self
            .motors
            .take_state(now, state, self.robot.is_unguarded())
        {
            self.note_holder(now, held, state);
        }
    }

    /// Shows the holder in the mode that the robot confirmed, before its next line A.
    pub(super) fn take_confirmed_mode(&mut self, now: Moment, mode: Mode) {
        self.robot.take_confirmed_mode(mode);
        let held = self.motors.holder().map(|held| held.value);
        if let Some(state) = self.robot.state_in_mode()
            && self
                .motors
                .take_holder(now, &state.value, self.robot.is_unguarded())
        {
            self.note_holder(now, held, &state.value);
        }
    }

    /// Counts and logs a change of the holder.
    fn note_holder(&mut self, now: Moment, held: Option<Holder>, state: &StateLine) {
        let (robot, Some(holder)) = (&self.robot, self.motors.holder()) else {
            return;
        };
        let holder = holder.value;
        if held.is_some_and(|held| !(held.is_routine() && holder.is_routine())) {
            self.counted.tally.behaviours += 1;
        }
        self.log.add_holder(now, holder.is_routine(), || {
            let why = why::why(holder, state, robot, now);
            format!("{}: {why}", words::holder(holder).to_uppercase())
        });
    }

    /// Keeps the robot, the rest of its route and its target in the picture.
    pub(super) fn follow(&mut self) {
        let active = self.ledger.active().filter(|active| !active.is_driven());
        let route = active.map_or(&[][..], |active| &active.waypoints);
        let pending = self.ledger.pending_route().unwrap_or_default();
        let waypoints = route.iter().chain(pending);
        let waypoints = waypoints.map(|at| (f64::from(at.x_in), f64::from(at.y_in)));
        let target = self.robot.status.and_then(|status| status.value.target_in);
        let target = target.map(|(x_in, y_in)| (f64::from(x_in), f64::from(y_in)));
        self.chart.follow(waypoints.chain(target));
    }
}
