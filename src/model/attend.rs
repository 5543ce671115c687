//! The operator's answers to alarms: acknowledge or shelve, one or all, by key or command.

use std::time::Duration;

use groundwave_captures::when::span;

use super::alarms::{Shown, code};
use super::keys::Action;
use super::news::Passing;
use super::{Facts, Panel, Ui, age};
use crate::event::{AlarmAnswer, AlarmEvent, AlarmStatus, Answer, Effect, Moment, SHELF_MAX};
use crate::suggest;

/// Time by which an alarm may begin here after it was acknowledged in another program: this one may have joined the link later.
pub const JOINED_LATER: Duration = Duration::from_mins(1);

/// Times for which the key shelves an alarm, at successive presses.
const SHELF_TIMES: [Duration; 3] = [
    Duration::from_mins(10),
    Duration::from_hours(1),
    Duration::from_hours(8),
];

impl Ui {
    /// Whether the arrows choose an alarm.
    pub(super) fn chooses_alarms(&self) -> bool {
        self.panel == Panel::Alarms && self.map.cursor.is_none()
    }

    /// Chooses an alarm in its panel; returns whether it did.
    pub(super) fn act_on_alarms(&mut self, facts: &Facts, action: Action) -> bool {
        let Action::MoveCursor { north, .. } = action else {
            return false;
        };
        let listed: Vec<usize> = self.listed(facts).iter().map(|shown| shown.index).collect();
        let last = listed.len().saturating_sub(1);
        let chosen = self.chosen_alarm(facts);
        let at = listed.iter().position(|&index| Some(index) == chosen);
        let at = at.map_or(0, |at| at.saturating_add_signed((-north).into()));
        self.alarm = listed.get(at.min(last)).copied();
        true
    }

    /// The chosen alarm, while the arrows choose one: before a choice the first raised one.
    pub(crate) fn chosen_alarm(&self, facts: &Facts) -> Option<usize> {
        let chosen = self.alarm.or_else(|| self.first_raised(facts));
        chosen.filter(|_| self.chooses_alarms())
    }

    /// Every alarm in the order of its panel: raised alarms first.
    pub(crate) fn listed<'a>(&self, facts: &'a Facts) -> Vec<Shown<'a>> {
        let mut listed: Vec<_> = facts.alarms.all(&self.attended).collect();
        listed.sort_by_key(|shown| shown.raised.is_none());
        listed
    }

    /// Index of the alarm that a key acts on: the chosen one in the panel of alarms, else the one under the status line, else the first
    /// raised one.
    fn concerned(&self, facts: &Facts) -> Option<usize> {
        if self.chooses_alarms() {
            return self.chosen_alarm(facts);
        }
        let calling = facts.alarms.calling(&self.attended);
        match calling.first() {
            Some((rule, _)) => facts.alarms.find(&rule.code),
            None => self.first_raised(facts),
        }
    }

    fn first_raised(&self, facts: &Facts) -> Option<usize> {
        let first = self.listed(facts).into_iter().next();
        let first = first.filter(|shown| shown.raised.is_some());
        first.map(|shown| shown.index)
    }

    pub(super) fn acknowledge_all(&mut self, facts: &Facts, now: Moment) -> Vec<Effect> {
        let calling = facts
            .alarms
            .all(&self.attended)
            .filter(|shown| shown.raised.is_some_and(|raised| !raised.is_acknowledged));
        let calling: Vec<usize> = calling.map(|shown| shown.index).collect();
        if calling.is_empty() {
            self.warn("no alarm to acknowledge");
        }
        self.acknowledge(facts, now, &calling)
    }

    pub(super) fn acknowledge_one(&mut self, facts: &Facts, now: Moment) -> Vec<Effect> {
        let concerned = self.concerned(facts).filter(|&index| {
            let mut all = facts.alarms.all(&self.attended);
            let raised = all.nth(index).and_then(|shown| shown.raised);
            raised.is_some_and(|raised| !raised.is_acknowledged)
        });
        if concerned.is_none() {
            self.warn("no alarm to acknowledge");
        }
        self.acknowledge(facts, now, concerned.as_slice())
    }

    fn acknowledge(&mut self, facts: &Facts, now: Moment, indices: &[usize]) -> Vec<Effect> {
        // An acknowledged alarm that is over is not shown any more.
        let answers = self.reports(facts, indices, AlarmStatus::Acknowledged);
        for &index in indices {
            self.attended.acknowledge(now, &facts.alarms, index);
        }
        answers.into_iter().map(Effect::AnswerAlarm).collect()
    }

    /// Takes another operator's answer to an alarm of this program.
    pub(super) fn take_answer(&mut self, facts: &Facts, now: Moment, answer: &AlarmAnswer) {
        let Some(index) = facts.alarms.find(&answer.alarm) else {
            return;
        };
        match answer.answer {
            Answer::Acknowledged => {
                let shown = facts.alarms.all(&self.attended).nth(index);
                let is_raised = shown.is_some_and(|shown| shown.raised.is_some());
                let until = if is_raised { now } else { now + JOINED_LATER };
                self.attended.acknowledge(until, &facts.alarms, index);
            }
            Answer::Shelved(_) | Answer::Unshelved => {
                let until = answer.answer.shelved_for().map(|time| now + time);
                self.attended.shelve(&facts.alarms, index, until);
            }
        }
    }

    /// Shelves an alarm, for a longer time at each press; the last press unshelves it.
    pub(super) fn shelve_one(&mut self, facts: &Facts, now: Moment) -> Vec<Effect> {
        let is_calling = !facts.alarms.calling(&self.attended).is_empty();
        let shelved = self
            .last_shelved
            .filter(|_| !self.chooses_alarms() && !is_calling);
        let Some(index) = shelved.or_else(|| self.concerned(facts)) else {
            self.warn("no alarm to shelve");
            return Vec::new();
        };
        let left = facts.alarms.all(&self.attended).nth(index);
        let left = left.and_then(|shown| shown.shelved_until);
        let left = left.map_or(Duration::ZERO, |until| until.saturating_sub(now));
        let time = SHELF_TIMES.into_iter().find(|time| left < *time);
        self.shelve(facts, now, index, time)
    }

    /// Shelves an alarm for a time, or unshelves it.
    fn shelve(
        &mut self,
        facts: &Facts,
        now: Moment,
        index: usize,
        time: Option<Duration>,
    ) -> Vec<Effect> {
        let Some(rule) = facts.alarms.rules().get(index) else {
            return Vec::new();
        };
        self.last_shelved = time.map(|_| index);
        self.attended
            .shelve(&facts.alarms, index, time.map(|time| now + time));
        let words = match time {
            Some(time) => format!("{} shelved for {}", rule.name, age::words(time)),
            None => format!("{} is no longer shelved", rule.name),
        };
        self.pass_on(now, Passing::Words(words));
        let status = match time {
            Some(_) => AlarmStatus::Shelved,
            None => AlarmStatus::Unshelved,
        };
        let answer = facts.alarms.answered(&self.attended, index, status);
        let event = answer.map(|answer| AlarmEvent {
            shelved_for: time,
            ..answer
        });
        event.map(Effect::AnswerAlarm).into_iter().collect()
    }

    /// The events that report a new status of alarms.
    fn reports(&self, facts: &Facts, indices: &[usize], status: AlarmStatus) -> Vec<AlarmEvent> {
        let indices = indices.iter();
        indices
            .filter_map(|&index| facts.alarms.answered(&self.attended, index, status))
            .collect()
    }

    /// Whether every alarm raised by the latest event is shelved or acknowledged.
    pub(super) fn is_attended_alone(&self, facts: &Facts) -> bool {
        let mut begun = facts.alarm_changes.iter().filter(|change| change.is_active);
        let is_attended = |code: &str| {
            let mut all = facts.alarms.all(&self.attended);
            all.find(|shown| shown.rule.code == code)
                .is_some_and(|shown| {
                    let is_acknowledged = shown.raised.is_some_and(|raised| raised.is_acknowledged);
                    shown.shelved_until.is_some() || is_acknowledged
                })
        };
        facts.alarm_changes.iter().any(|change| change.is_active)
            && begun.all(|change| is_attended(&change.rule.code))
    }

    /// Carries out `acknowledge [NAME]`, `shelve NAME [TIME]` and `unshelve NAME`; `None` for other commands.
    pub(super) fn attend(
        &mut self,
        facts: &Facts,
        now: Moment,
        words: &[&str],
    ) -> Option<Result<Vec<Effect>, String>> {
        let (verb, rest) = words.split_first()?;
        let find = |words: &[&str]| {
            let name = code(&words.join(" "));
            facts.alarms.find(&name).ok_or_else(|| {
                let codes = facts.alarms.rules().iter().map(|rule| &*rule.code);
                let all = codes.clone().collect::<Vec<_>>().join(", ");
                let question = suggest::question_or(&name, codes, format!("there are {all}"));
                format!("no alarm is named `{}`{question}", words.join(" "))
            })
        };
        Some(match (*verb, rest) {
            ("acknowledge", [] | ["all"]) => Ok(self.acknowledge_all(facts, now)),
            ("acknowledge", name) => find(name).and_then(|index| {
                let shown = facts.alarms.all(&self.attended).nth(index);
                match shown {
                    Some(shown) if shown.raised.is_none() => {
                        Err(format!("{} is not on", shown.rule.name))
                    }
                    Some(shown) if shown.raised.is_some_and(|it| it.is_acknowledged) => {
                        Err(format!("{} is acknowledged already", shown.rule.name))
                    }
                    _ => Ok(self.acknowledge(facts, now, &[index])),
                }
            }),
            ("unshelve" | "shelve", []) => Err(format!(
                "`{verb}` needs the name of an alarm: {verb} battery_low"
            )),
            ("unshelve", name) => find(name).map(|index| self.shelve(facts, now, index, None)),
            ("shelve", name) => {
                let (time, name) = match name.split_last() {
                    Some((last, name)) if !name.is_empty() && span(last).is_some() => {
                        (span(last).unwrap_or(SHELF_TIMES[0]), name)
                    }
                    _ => (SHELF_TIMES[0], name),
                };
                if time.is_zero() || time > SHELF_MAX {
                    Err("an alarm is shelved for at most 24h".to_owned())
                } else {
                    find(name).map(|index| self.shelve(facts, now, index, Some(time)))
                }
            }
            _ => return None,
        })
    }
}
