//! Alarms and the operator's answers to them: as events, to the hook, and to the other programs on the link.

use std::time::SystemTime;

use super::Driver;
use crate::capture::name::utc;
use crate::event::{
    AlarmAnswer, AlarmEvent, AlarmStatus, Answer, Event, Level, Notice, NoticeCode,
};
use crate::share::OPERATOR;

impl Driver {
    /// Adds an event that is not the station's own; [`Self::poll_event`] returns it.
    pub fn tell(&mut self, event: Event) {
        if let Event::Alarm(alarm) = &event {
            self.answers.take(self.now(), alarm);
            self.call_hook(alarm);
        }
        self.events.push_back(event);
    }

    /// Passes an alarm's event to the hook, unless the alarm begins while it is shelved, or that alarm ends: the operator does not want to be called.
    fn call_hook(&mut self, alarm: &AlarmEvent) {
        let code = &alarm.code;
        let is_silent = match alarm.status {
            AlarmStatus::Begun => {
                self.answers.has_shelved(code) && self.withheld.insert(code.clone())
            }
            AlarmStatus::Ended => self.withheld.remove(code),
            AlarmStatus::Unshelved => {
                self.withheld.remove(code);
                false
            }
            AlarmStatus::Acknowledged | AlarmStatus::Shelved => false,
        };
        let hook = self.alarm_hook.as_ref();
        let Some(hook) = hook.filter(|_| !self.station_runs_hook && !is_silent) else {
            return;
        };
        let mut value = alarm.to_json();
        value["name"] = alarm.name.as_str().into();
        value["link"] = self.name.as_str().into();
        let now = SystemTime::now();
        value["time"] = utc(now).into();
        let ago = alarm.began_at.map(|at| self.now().saturating_sub(at));
        if let Some(begin) = ago.and_then(|ago| now.checked_sub(ago)) {
            value["begin"] = utc(begin).into();
        }
        if let Err(problem) = hook.pass(value.to_string()) {
            self.tell_hook(problem);
        }
    }

    /// Reports the operator's answer to an alarm, also to the other programs on this link.
    pub fn answer_alarm(&mut self, event: AlarmEvent) {
        if let Some(answer) = Answer::of(&event) {
            let answered = AlarmAnswer {
                alarm: event.code.clone(),
                answer,
                by: OPERATOR.to_owned(),
            };
            if let Some(server) = &mut self.share {
                server.broker.handle_answer(None, &answered);
                self.serve_share();
            }
            self.station.handle_answer(&event.code, answer);
        }
        self.tell(Event::Alarm(event));
        self.flush();
    }

    /// Tells clients that come from now on whether this station, or the one before it, runs the hook.
    pub(super) fn tell_clients_of_hook(&mut self) {
        if let Some(server) = &mut self.share {
            let runs = self.alarm_hook.is_some() || self.station_runs_hook;
            server.broker.set_runs_alarm_hook(runs);
        }
    }

    pub(super) fn tell_hook(&mut self, problem: String) {
        let notice = Notice::new(NoticeCode::AlarmHook, Level::Warning, problem);
        self.events.push_back(Event::Notice(notice));
    }
}
