//! What the station reports of the lines: other robots, mistakes, outages and statistics.

use groundwave_lines::FIELDS_MAX;
use groundwave_protocol::decoder::Counters;

use super::{Station, milliseconds};
use crate::diagnosis::kind;
use crate::event::{Event, Level, Moment, Notice, NoticeCode, Reception};
use crate::statistics::{OtherRobot, Statistics};

/// Minimum time between two reports of the statistics.
const STATISTICS_REST: Moment = Moment::from_secs(1);

impl Station {
    /// Reports the outages that have begun or ended.
    pub(super) fn report_outages(&mut self) {
        while let Some(outage) = self.outages.poll() {
            self.events.push_back(Event::Outage(outage));
        }
    }

    /// Reports each other robot on the channel once, and a change of the followed one.
    pub(super) fn report_other_robot(&mut self) {
        let other = OtherRobot::of(self.decoder.counters());
        let before = std::mem::replace(&mut self.reported_other, other);
        if other.followed_robot != before.followed_robot
            && let Some(text) = other.change()
        {
            self.notice(NoticeCode::RobotReplaced, Level::Warning, &text);
            return;
        }
        let is_new = |id: &u8| before.ids().all(|known| known != *id);
        for id in other.ids().filter(is_new) {
            let own = self.decoder.counters().robot;
            let followed = own.map(|own| format!(", robot {own} is followed"));
            let text = format!(
                "robot {id} also sends on this channel; its lines are kept apart{}",
                followed.unwrap_or_default()
            );
            self.notice(NoticeCode::OtherRobot, Level::Warning, &text);
        }
    }

    /// Reports mistakes in the robot's lines, each kind once.
    pub(super) fn report_mistakes(&mut self) {
        while let Some(finding) = self.examiner.news() {
            // Another robot has a separate notice.
            if finding.kind == kind::TWO_ROBOTS {
                continue;
            }
            let text = format!(
                "mistake of the robot: {}; `groundwave check` shows more",
                finding.clause()
            );
            self.notice(NoticeCode::RobotMistake, Level::Warning, &text);
        }
    }

    /// Reports the statistics with the latest airtimes, if statistics were reported before.
    pub(super) fn report_last_statistics(&mut self, now: Moment) {
        if let Some((at, latest)) = self.reported_statistics {
            let last = Statistics {
                airtime_down_pct: latest.airtime_down_pct,
                airtime_up_pct: latest.airtime_up_pct,
                ..self.statistics(now)
            };
            self.reported_statistics = Some((at, last));
            self.events.push_back(Event::Statistics(Box::new(last)));
        }
    }

    /// Reports the statistics if they have changed, at most once a second.
    pub(super) fn report_statistics(&mut self, now: Moment) {
        let is_early = self
            .reported_statistics
            .is_some_and(|(at, _)| now < at + STATISTICS_REST);
        if is_early {
            return;
        }
        let statistics = self.statistics(now);
        let latest = self.reported_statistics.map(|(_, latest)| latest);
        if latest == Some(statistics) {
            return;
        }
        self.reported_statistics = Some((now, statistics));
        self.events
            .push_back(Event::Statistics(Box::new(statistics)));
    }

    /// Reports a change of what is received.
    pub(super) fn report_reception(&mut self, heard: Option<(Reception, Moment)>) {
        self.events
            .extend(heard.map(|(reception, since)| Event::Reception { reception, since }));
    }

    /// The decoder's totals if the session ends now, or when it ended.
    #[must_use]
    pub fn totals(&self, now: Moment) -> Counters {
        let until = self.ended_at.unwrap_or(now);
        self.decoder.counters_until(milliseconds(until))
    }

    /// Statistics of the link; the caller adds `not_taken_bytes`. An outage leaves the loss open until it or the session ends.
    #[must_use]
    pub fn statistics(&self, now: Moment) -> Statistics {
        let totals = match self.ended_at {
            Some(_) => self.totals(now),
            None => *self.decoder.counters(),
        };
        let mut statistics = self.meter.statistics(now, &totals);
        if self.ended_at.is_none() && self.outages.is_lasting() {
            statistics.loss.leave_open();
        }
        if !self.has_estimated_times {
            return statistics;
        }
        Statistics {
            airtime_down_pct: None,
            airtime_up_pct: None,
            ..statistics
        }
    }

    pub(super) fn report_fields_left_out(&mut self) {
        let text = format!(
            "values are left out: there are more than {FIELDS_MAX} fields, or a name is too long"
        );
        self.notice(NoticeCode::FieldsLeftOut, Level::Warning, &text);
    }

    pub(super) fn notice(&mut self, code: NoticeCode, level: Level, text: &str) {
        self.events
            .push_back(Event::Notice(Notice::new(code, level, text)));
    }
}
