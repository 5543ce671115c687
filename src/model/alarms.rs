//! Alarms: raised when a rule has matched for long enough, kept until the operator acknowledges them.

mod attended;
mod rules;
mod settings;

use std::sync::Arc;

use groundwave_captures::messages::Telemetry;
use groundwave_lines::OwnLine;
use groundwave_protocol::decoder::Received;

use super::age;
use crate::event::{AlarmEvent, AlarmStatus, Moment};
pub(crate) use attended::Attended;
#[cfg(test)]
pub(crate) use rules::DISK_IS_SILENT;
pub(super) use rules::Inputs;
pub use rules::Limits;
pub(crate) use rules::{LINK_LOST, PRESSED_S, ROBOT_SILENT, Rule, Source, rules};
use rules::{Look, Sight};
use settings::FieldLimit;
pub(crate) use settings::code;
pub use settings::{AlarmSetting, Operand, Severity};

/// A raised alarm that is active or not acknowledged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Raised {
    /// Time at which the cause began.
    pub(crate) at: Moment,
    /// Time at which the cause ended; `None` while the alarm is active.
    pub(crate) over_at: Option<Moment>,
    pub(crate) is_acknowledged: bool,
    /// Worst value since the alarm was raised.
    pub(crate) worst: Option<f64>,
    /// Latest value while the alarm is active.
    pub(crate) latest: Option<f64>,
    /// Number of times the alarm was raised since the last acknowledgement.
    pub(crate) times: u32,
}

/// A rule and its current state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shown<'a> {
    /// Index in the table.
    pub(crate) index: usize,
    pub(crate) rule: &'a Rule,
    /// Whether the state of the cause is known.
    pub(crate) is_known: bool,
    /// The latest figure.
    pub(crate) value: Option<f64>,
    /// The rule's alarm, unless it is acknowledged and over.
    pub(crate) raised: Option<Raised>,
    /// Time until which the alarm is shelved.
    pub(crate) shelved_until: Option<Moment>,
}

/// The latest time for which one rule was raised.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Episode {
    /// Time at which the cause began.
    began_at: Moment,
    raised_at: Moment,
    over_at: Option<Moment>,
    worst: Option<f64>,
    latest: Option<f64>,
    /// Number of times the rule has been raised.
    times: u32,
}

/// An alarm that was raised or ended.
#[derive(Clone, Debug)]
pub(crate) struct AlarmChange {
    pub(crate) rule: Rule,
    /// Whether the alarm was raised; `false` if it ended.
    pub(crate) is_active: bool,
    /// Time at which the cause began.
    pub(crate) began_at: Moment,
    /// Latest value, in the rule's unit.
    pub(crate) value: Option<f64>,
}

impl AlarmChange {
    /// The event that reports the change.
    pub(super) fn event(&self) -> AlarmEvent {
        AlarmEvent {
            began_at: Some(self.began_at),
            value: self.value,
            limit: self.value.map(|_| self.rule.bounds.raise),
            ..self.rule.event(if self.is_active {
                AlarmStatus::Begun
            } else {
                AlarmStatus::Ended
            })
        }
    }
}

/// The state of one rule.
#[derive(Clone, Debug, Default, PartialEq)]
struct Standing {
    /// The latest value of the field.
    reading: Option<Operand>,
    /// Time since which the limit is exceeded, while that is too short to raise the alarm.
    pending_since: Option<Moment>,
    episode: Option<Episode>,
    /// The latest figure.
    value: Option<f64>,
}

/// All alarms.
#[derive(Clone, Debug)]
pub(crate) struct Alarms {
    rules: Arc<[Rule]>,
    standings: Vec<Standing>,
    has_fields: bool,
}

impl Alarms {
    pub(super) fn new(limits: &Limits, settings: &[AlarmSetting]) -> Self {
        let rules = rules(limits, settings);
        Self {
            standings: vec![Standing::default(); rules.len()],
            has_fields: rules.iter().any(|rule| matches!(rule.look, Look::Field(_))),
            rules,
        }
    }

    /// Takes the fields of a line of Groundwave's protocol.
    pub(super) fn take_line(&mut self, received: impl FnOnce() -> Received) {
        if !self.has_fields {
            return;
        }
        let telemetry = Telemetry::from(&received());
        self.take_fields(|limit| limit.in_line(&telemetry));
    }

    /// Takes the values of a line of the robot's own.
    pub(super) fn take_own_line(&mut self, line: &OwnLine) {
        self.take_fields(|limit| limit.in_own_line(line));
    }

    fn take_fields(&mut self, value: impl Fn(&FieldLimit) -> Option<Operand>) {
        for (rule, standing) in self.rules.iter().zip(&mut self.standings) {
            if let Look::Field(limit) = &rule.look
                && let Some(value) = value(limit)
            {
                standing.reading = Some(value);
            }
        }
    }

    /// Checks every rule; returns the alarms that were raised or ended now.
    pub(super) fn watch(&mut self, inputs: &Inputs<'_>) -> Vec<AlarmChange> {
        let mut changes = Vec::new();
        for (rule, standing) in self.rules.iter().zip(&mut self.standings) {
            let was_up = standing.is_up();
            standing.look(rule, inputs);
            let Some(episode) = standing.episode else {
                continue;
            };
            if was_up != standing.is_up() {
                changes.push(AlarmChange {
                    rule: rule.clone(),
                    is_active: !was_up,
                    began_at: episode.began_at,
                    value: standing.value.filter(|_| rule.is_measured()),
                });
            }
        }
        changes
    }

    /// The event that reports the operator's answer to an alarm, with begin and figures of its cause if it is shown.
    pub(super) fn answered(
        &self,
        seen: &Attended,
        index: usize,
        status: AlarmStatus,
    ) -> Option<AlarmEvent> {
        let shown = self.all(seen).nth(index)?;
        let is_shown = shown.raised.is_some() && shown.rule.is_measured();
        let value = shown.value.filter(|_| is_shown);
        Some(AlarmEvent {
            began_at: shown.raised.map(|raised| raised.at),
            value,
            limit: value.map(|_| shown.rule.bounds.raise),
            ..shown.rule.event(status)
        })
    }

    /// Time at which the next pending alarm is raised.
    pub(super) fn next_due(&self) -> Option<Moment> {
        let due = self.rules.iter().zip(&self.standings);
        let due = due.map(|(rule, standing)| {
            let since = standing.pending_since?;
            Some(since + rule.bounds.persists)
        });
        due.flatten().min()
    }

    /// Time at which the age of an unacknowledged alarm, or the remaining time of a shelved one, changes on the screen.
    pub(super) fn next_tick(&self, seen: &Attended, now: Moment) -> Option<Moment> {
        let calling = self.calling(seen);
        let ages = calling
            .iter()
            .map(|(_, raised)| age::next_change(raised.at, now));
        let shelved = seen.next_expiry().map(|_| now + Moment::from_secs(1));
        ages.chain(shelved).min()
    }

    /// Index of the alarm with a code.
    pub(super) fn find(&self, code: &str) -> Option<usize> {
        self.rules.iter().position(|rule| rule.code == code)
    }

    /// Every rule, the worst first.
    pub(crate) fn rules(&self) -> &[Rule] {
        &self.rules
    }

    /// Every rule and its current state, the worst first.
    pub(crate) fn all(&self, seen: &Attended) -> impl Iterator<Item = Shown<'_>> {
        let standings = (0..).zip(self.rules.iter().zip(&self.standings));
        standings.map(|(index, (rule, standing))| {
            let attention = seen.of(index);
            let raised = standing.episode.and_then(|episode| {
                let acknowledged_at = attention.acknowledged_at;
                let is_acknowledged = acknowledged_at.is_some_and(|at| episode.raised_at <= at);
                let is_shown = !is_acknowledged || episode.over_at.is_none();
                is_shown.then(|| Raised {
                    at: episode.began_at,
                    over_at: episode.over_at,
                    is_acknowledged,
                    worst: episode.worst,
                    latest: episode.latest,
                    times: episode.times.saturating_sub(attention.times).max(1),
                })
            });
            Shown {
                index,
                rule,
                is_known: standing.reading.is_some() || matches!(rule.look, Look::BuiltIn(_)),
                value: standing.value,
                raised,
                shelved_until: attention.shelved_until,
            }
        })
    }

    /// Unacknowledged alarms that are not shelved: active ones first, then those that are over; the worst first.
    pub(crate) fn calling(&self, seen: &Attended) -> Vec<(&Rule, Raised)> {
        let calling = self.all(seen).filter(|shown| shown.shelved_until.is_none());
        let mut calling: Vec<_> = calling
            .filter_map(|shown| Some((shown.rule, shown.raised?)))
            .filter(|(_, raised)| !raised.is_acknowledged)
            .collect();
        calling.sort_by_key(|(_, raised)| raised.over_at.is_some());
        calling
    }
}

impl Standing {
    fn is_up(&self) -> bool {
        self.episode
            .is_some_and(|episode| episode.over_at.is_none())
    }

    /// Checks a rule.
    fn look(&mut self, rule: &Rule, inputs: &Inputs<'_>) {
        let bounds = rule.bounds;
        let sight = match &rule.look {
            Look::BuiltIn(look) => look(inputs),
            Look::Field(limit) => limit.look(self.reading.as_ref()),
        };
        if let Sight::Is(value) = sight {
            self.value = Some(value);
        }
        let is_up = self.is_up();
        let (is_bad, persists) = match sight {
            Sight::Unknown => {
                self.pending_since = None;
                return;
            }
            Sight::No => (false, bounds.persists),
            Sight::Yes => (true, bounds.persists),
            Sight::Certain => (true, Moment::ZERO),
            // Hysteresis: a raised alarm lasts until the value is clear of the limit.
            Sight::Is(value) if is_up => (!bounds.is_clear(value), bounds.persists),
            Sight::Is(value) => (bounds.reaches(value), bounds.persists),
        };
        if !is_bad {
            self.pending_since = None;
            if let Some(episode) = self.episode.as_mut().filter(|_| is_up) {
                episode.over_at = Some(inputs.now);
            }
            return;
        }
        if is_up {
            self.note_worst(bounds.is_high_bad);
            return;
        }
        let since = *self.pending_since.get_or_insert(inputs.now);
        if inputs.now.saturating_sub(since) < persists {
            return;
        }
        self.pending_since = None;
        let began = match sight {
            // The value is the age of the cause.
            Sight::Is(s) if rule.is_age() => {
                inputs.now.saturating_sub(Moment::from_secs_f64(s.max(0.0)))
            }
            _ => since,
        };
        let times = self.episode.map_or(0, |episode| episode.times);
        self.episode = Some(Episode {
            began_at: began,
            raised_at: inputs.now,
            over_at: None,
            worst: self.value,
            latest: self.value,
            times: times.saturating_add(1),
        });
    }

    fn note_worst(&mut self, is_high_bad: bool) {
        if let (Some(episode), Some(value)) = (&mut self.episode, self.value) {
            episode.latest = Some(value);
            let worst = episode.worst.unwrap_or(value);
            episode.worst = Some(if is_high_bad {
                worst.max(value)
            } else {
                worst.min(value)
            });
        }
    }
}
