//! The operators' answers to alarms that apply now, for programs that join the link later.

use std::collections::BTreeMap;

use super::OPERATOR;
use crate::event::{AlarmAnswer, AlarmEvent, AlarmStatus, Answer, Moment};

/// The answers to the station's alarms, by their codes. Each comes with the name of the program that gave it.
#[derive(Debug, Default)]
pub(super) struct Answers {
    /// Alarms that are known until they end.
    acknowledged: BTreeMap<String, String>,
    /// Alarms that are put off until a time.
    shelved: BTreeMap<String, (String, Moment)>,
}

impl Answers {
    /// Takes a new status of an alarm.
    pub(super) fn take(&mut self, now: Moment, alarm: &AlarmEvent) {
        let code = &alarm.code;
        let by = alarm.by.as_deref().unwrap_or(OPERATOR).to_owned();
        match alarm.status {
            AlarmStatus::Begun | AlarmStatus::Ended => {
                self.acknowledged.remove(code);
            }
            AlarmStatus::Acknowledged => {
                self.acknowledged.insert(code.clone(), by);
            }
            AlarmStatus::Shelved => {
                let until = now + alarm.shelved_for.unwrap_or_default();
                self.shelved.insert(code.clone(), (by, until));
            }
            AlarmStatus::Unshelved => {
                self.shelved.remove(code);
            }
        }
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
        let shelved = self.shelved.iter().map(|(code, (by, until))| {
            let seconds = until.saturating_sub(now).as_secs().max(1);
            (code, Answer::Shelved(seconds), by)
        });
        let acknowledged = self.acknowledged.iter();
        acknowledged
            .map(|(code, by)| (code, Answer::Acknowledged, by))
            .chain(shelved)
            .map(|(code, answer, by)| AlarmAnswer {
                alarm: code.clone(),
                answer,
                by: by.clone(),
            })
            .collect()
    }
}
