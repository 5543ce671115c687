//! The operators' answers to alarms that apply now: until their time is over, and for programs that join the link later.

use std::collections::BTreeMap;

use super::OPERATOR;
use crate::event::{AlarmAnswer, AlarmEvent, AlarmStatus, Answer, Moment};

/// The answers to the station's alarms, by their codes.
#[derive(Debug, Default)]
pub struct Answers {
    /// Alarms that are known until they end, and the programs that acknowledged them.
    acknowledged: BTreeMap<String, String>,
    /// Alarms that are put off until a time.
    shelved: BTreeMap<String, (AlarmEvent, Moment)>,
}

/// Name of the program that gave an answer.
fn by(answer: &AlarmEvent) -> String {
    answer.by.as_deref().unwrap_or(OPERATOR).to_owned()
}

impl Answers {
    /// Takes a new status of an alarm.
    pub fn take(&mut self, now: Moment, alarm: &AlarmEvent) {
        let code = &alarm.code;
        match alarm.status {
            AlarmStatus::Begun | AlarmStatus::Ended => {
                self.acknowledged.remove(code);
                if let Some((shelved, _)) = self.shelved.get_mut(code) {
                    let is_on = alarm.status == AlarmStatus::Begun;
                    shelved.began_at = alarm.began_at.filter(|_| is_on);
                    (shelved.value, shelved.limit) = (alarm.value.filter(|_| is_on), alarm.limit);
                }
            }
            AlarmStatus::Acknowledged => {
                self.acknowledged.insert(code.clone(), by(alarm));
            }
            AlarmStatus::Shelved => {
                let until = now + alarm.shelved_for.unwrap_or_default();
                self.shelved.insert(code.clone(), (alarm.clone(), until));
            }
            AlarmStatus::Unshelved => {
                self.shelved.remove(code);
            }
        }
    }

    /// Whether an alarm is put off now.
    #[must_use]
    pub fn has_shelved(&self, code: &str) -> bool {
        self.shelved.contains_key(code)
    }

    /// Time at which the next alarm is put off no more.
    #[must_use]
    pub fn next_expiry(&self) -> Option<Moment> {
        self.shelved.values().map(|(_, until)| *until).min()
    }

    /// The events of alarms that are put off no more because their time is over, once each.
    pub fn expired(&mut self, now: Moment) -> Vec<AlarmEvent> {
        let expired = self.shelved.extract_if(.., |_, (_, until)| *until <= now);
        let unshelved = expired.map(|(_, (shelved, _))| AlarmEvent {
            status: AlarmStatus::Unshelved,
            shelved_for: None,
            by: None,
            ..shelved
        });
        unshelved.collect()
    }

    /// Whether an answer says what applies already, to the second.
    pub(super) fn has(&self, now: Moment, code: &str, answer: Answer) -> bool {
        let until = self.shelved.get(code).map(|(_, until)| *until);
        match answer {
            Answer::Acknowledged => self.acknowledged.contains_key(code),
            Answer::Shelved(seconds) => {
                let meant = now + Moment::from_secs(seconds);
                until.is_some_and(|until| until.abs_diff(meant) < Moment::from_secs(1))
            }
            Answer::Unshelved => false,
        }
    }

    /// Every answer that applies.
    pub(super) fn all(&self, now: Moment) -> Vec<AlarmAnswer> {
        let shelved = self.shelved.iter().map(|(code, (shelved, until))| {
            let seconds = until.saturating_sub(now).as_secs().max(1);
            (code, Answer::Shelved(seconds), by(shelved))
        });
        let acknowledged = self.acknowledged.iter();
        acknowledged
            .map(|(code, by)| (code, Answer::Acknowledged, by.clone()))
            .chain(shelved)
            .map(|(code, answer, by)| AlarmAnswer {
                alarm: code.clone(),
                answer,
                by,
            })
            .collect()
    }
}
