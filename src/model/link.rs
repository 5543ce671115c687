//! The link to the robot: its state, its loss and the age of the newest line.

use std::collections::VecDeque;

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::Counters;
use groundwave_protocol::telemetry::LineType;

use super::age;
use super::robot::Reading;
use super::trace::{self, TRACED};
use crate::event::{LinkEvent, Moment, Reception};
use crate::statistics::Statistics;

/// Time over which rate and loss are measured.
const WINDOW: Moment = Moment::from_secs(20);

/// Time without a line and without damaged lines after which the shares of lost and damaged lines begin afresh.
const AFRESH_AFTER: Moment = Moment::from_secs(4);

/// Time without a line after which the robot is silent.
pub(crate) const SILENT_AFTER: Moment = Moment::from_secs(2);

/// Share of lines lost or damaged above which the link is weak.
const WEAK_SHARE: f64 = 0.05;

/// The state of the connection.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) enum Connection {
    /// The link is not open yet.
    #[default]
    Opening,
    /// The link is open.
    Open,
    /// The link is lost; the station keeps trying.
    Lost { reason: String, since: Moment },
    /// The link has ended and is not opened again.
    Ended,
}

/// Health of the link, in one word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Health {
    /// No line has arrived yet.
    Waiting,
    /// Lines arrive, and few are lost.
    Good,
    /// Lines arrive, but many are lost.
    Weak,
    /// The link is open, but no line arrives.
    Silent,
    /// The link is lost; the station keeps trying.
    Lost,
    /// The link has ended and is not opened again.
    Ended,
}

/// Shares of the lines that the robot sent, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shares {
    pub(crate) lost: f64,
    pub(crate) damaged: f64,
    /// Whether more lines may be lost, any number of them: lines are missing or the robot booted, and no time shows a silence.
    pub(crate) is_open: bool,
}

impl Shares {
    /// Share of lines lost or damaged.
    pub(crate) fn unusable(self) -> f64 {
        self.lost + self.damaged
    }

    /// The shares as text: `loss 6.0 %`, and `damaged 2.0 %` if there are damaged lines.
    pub(crate) fn words(self) -> Vec<String> {
        let at_least = if self.is_open { "at least " } else { "" };
        let loss = format!("loss {at_least}{:.1} %", self.lost * 100.0);
        let damaged = format!("damaged {:.1} %", self.damaged * 100.0);
        [Some(loss), (self.damaged > 0.0).then_some(damaged)]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// The link to the robot.
#[derive(Clone, Debug, Default)]
pub(crate) struct Link {
    pub(crate) name: String,
    pub(crate) can_send: bool,
    pub(crate) connection: Connection,
    /// Time at which the session ended.
    frozen_at: Option<Moment>,
    newest_line_at: Option<Moment>,
    /// Number of damaged lines when the newest line arrived.
    damaged_before: u64,
    /// Whether the newest line ended an outage.
    ends_outage: bool,
    /// Time at which the link was opened last, or this station went on after a suspension.
    opened_at: Option<Moment>,
    newest_raw: Option<[u8; LINE_BYTES]>,
    /// The newest line of each traced kind.
    traced: [Option<Reading<[u8; LINE_BYTES]>>; TRACED.len()],
    /// The kind of received bytes, and the time at which it began.
    reception: Option<(Reception, Moment)>,
    counters: Counters,
    statistics: Option<Statistics>,
    /// Lines of the robot's own in each second of the window, newest last.
    own: VecDeque<(Moment, u32)>,
    /// The decoder's totals during the window, at most one per second.
    totals: VecDeque<(Moment, Counters)>,
}

impl Link {
    pub(super) fn take_event(&mut self, now: Moment, event: &LinkEvent) {
        self.frozen_at = None;
        self.reception = None;
        match event {
            LinkEvent::Opened { name, can_send } => {
                self.name.clone_from(name);
                self.can_send = *can_send;
                self.connection = Connection::Open;
                self.opened_at = Some(now);
            }
            LinkEvent::Lost { reason } => {
                let since = match self.connection {
                    Connection::Lost { since, .. } => since,
                    _ => now,
                };
                self.connection = Connection::Lost {
                    reason: reason.clone(),
                    since,
                };
            }
            LinkEvent::Ended => {
                self.connection = Connection::Ended;
                self.frozen_at = Some(now);
            }
        }
    }

    /// Takes the end of a suspension of this station: its silence is not the robot's.
    pub(super) fn resume(&mut self, now: Moment) {
        self.opened_at = self.opened_at.map(|_| now);
    }

    /// Whether the link is lost because the station that shares it closed the connection.
    pub(crate) fn is_closed_by_station(&self) -> bool {
        matches!(&self.connection, Connection::Lost { reason, .. } if reason == LinkEvent::STATION_CLOSED)
    }

    pub(super) fn take_reception(&mut self, reception: Reception, since: Moment) {
        self.reception = Some((reception, since));
    }

    /// The kind of bytes received instead of lines, and the duration; `None` while lines arrive or the kind is unknown.
    pub(crate) fn instead_of_lines(&self, now: Moment) -> Option<(Reception, Moment)> {
        let (reception, since) = self.reception?;
        let age = self.clock(now).saturating_sub(since);
        (reception != Reception::Lines).then_some((reception, age))
    }

    pub(super) fn take_line(&mut self, now: Moment, raw: &[u8; LINE_BYTES]) {
        let damaged = damaged(&self.counters);
        // A line that was cut by the outage is no sign of a weak radio.
        self.ends_outage = damaged <= self.damaged_before + 1
            && self.newest_age(now).is_some_and(|age| age >= AFRESH_AFTER);
        self.damaged_before = damaged;
        self.newest_line_at = Some(now);
        self.newest_raw = Some(*raw);
        if let Some(place) = LineType::from_letter(raw[0]).and_then(trace::place) {
            self.traced[place] = Some(Reading {
                value: *raw,
                at: now,
            });
        }
    }

    /// Takes a line of the robot's own.
    pub(super) fn take_own_line(&mut self, now: Moment) {
        self.newest_line_at = Some(now);
        match self.own.back_mut() {
            Some((at, lines)) if now.saturating_sub(*at) < Moment::from_secs(1) => *lines += 1,
            _ => self.own.push_back((now, 1)),
        }
        while self
            .own
            .front()
            .is_some_and(|(at, _)| now.saturating_sub(*at) > WINDOW)
        {
            self.own.pop_front();
        }
    }

    /// Whether lines of the robot's own arrive, but no Groundwave line.
    pub(crate) fn has_only_own_lines(&self) -> bool {
        self.newest_raw.is_none() && self.newest_line_at.is_some()
    }

    /// Lines of the robot's own per second over the window.
    fn own_per_s(&self, now: Moment) -> f64 {
        let now = self.clock(now);
        let window = || {
            let is_in = |(at, _): &&(Moment, u32)| now.saturating_sub(*at) <= WINDOW;
            self.own.iter().filter(is_in)
        };
        let Some((since, _)) = window().next() else {
            return 0.0;
        };
        let until = match self.newest_age(now) {
            Some(age) if age < SILENT_AFTER => self.newest_line_at.unwrap_or(now),
            _ => now,
        };
        // The first line begins the measured time, so it is not counted.
        let lines: u32 = window().map(|(_, lines)| lines).sum();
        f64::from(lines - 1) / until.saturating_sub(*since).as_secs_f64().max(1.0)
    }

    /// Whether the link is receive-only; `false` before it is open.
    pub(crate) fn is_receive_only(&self) -> bool {
        !self.can_send && self.connection != Connection::Opening
    }

    /// Number of bytes received.
    pub(crate) const fn bytes(&self) -> u64 {
        self.counters.bytes
    }

    pub(super) fn take_counters(&mut self, now: Moment, counters: &Counters) {
        if std::mem::take(&mut self.ends_outage) {
            // The lines lost in the outage say nothing about the radio now.
            self.totals.clear();
        }
        self.counters = *counters;
        if let Some(statistics) = &mut self.statistics {
            statistics.count(counters);
        }
        let due = self
            .totals
            .back()
            .is_none_or(|(at, _)| now.saturating_sub(*at) >= Moment::from_secs(1));
        if due {
            self.totals.push_back((now, *counters));
        }
        while self
            .totals
            .front()
            .is_some_and(|(at, _)| now.saturating_sub(*at) > WINDOW)
        {
            self.totals.pop_front();
        }
    }

    pub(super) const fn take_statistics(&mut self, statistics: &Statistics) {
        self.statistics = Some(*statistics);
    }

    /// Link statistics, at most a second old.
    pub(crate) const fn statistics(&self) -> Option<&Statistics> {
        self.statistics.as_ref()
    }

    /// The decoder's totals.
    pub(crate) const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// The newest line.
    pub(crate) const fn newest_raw(&self) -> Option<&[u8; LINE_BYTES]> {
        self.newest_raw.as_ref()
    }

    /// The newest line of a type, if it is traced.
    pub(crate) fn newest_of(&self, line_type: LineType) -> Option<Reading<[u8; LINE_BYTES]>> {
        self.traced[trace::place(line_type)?]
    }

    /// `now`, or the end of the session.
    pub(crate) fn clock(&self, now: Moment) -> Moment {
        self.frozen_at.map_or(now, |at| at.min(now))
    }

    /// Whether the session has ended.
    pub(crate) const fn is_frozen(&self) -> bool {
        self.frozen_at.is_some()
    }

    /// Time at which the newest line arrived.
    pub(crate) const fn newest_line_at(&self) -> Option<Moment> {
        self.newest_line_at
    }

    /// Age of the newest line.
    pub(crate) fn newest_age(&self, now: Moment) -> Option<Moment> {
        let at = self.newest_line_at?;
        Some(self.clock(now).saturating_sub(at))
    }

    /// Time without a line on the open link; `None` before the first line or while the link is not open.
    pub(crate) fn silence(&self, now: Moment) -> Option<Moment> {
        let age = self.newest_age(now)?;
        let open = self.opened_at.map(|at| self.clock(now).saturating_sub(at));
        (self.connection == Connection::Open).then(|| open.map_or(age, |open| age.min(open)))
    }

    /// 80-byte lines and lines of the robot's own a second over the window.
    pub(crate) fn lines_per_s(&self, now: Moment) -> f64 {
        let wire = self.rate(now, |counters| counters.lines - counters.other_lines);
        wire + self.own_per_s(now)
    }

    /// Number of acknowledgement lines per second over the window.
    pub(crate) fn acks_per_s(&self, now: Moment) -> f64 {
        self.rate(now, |counters| {
            counters.ack_lines - counters.other_ack_lines
        })
    }

    fn rate(&self, now: Moment, count: impl Fn(&Counters) -> u64) -> f64 {
        let now = self.clock(now);
        let Some(&(at, ref then)) = self.window_start(now) else {
            return 0.0;
        };
        let lines = count(&self.counters).saturating_sub(count(then));
        let until = if self.newest_age(now).is_some_and(|age| age < SILENT_AFTER) {
            self.newest_line_at.unwrap_or(now)
        } else {
            now
        };
        lines as f64 / until.saturating_sub(at).as_secs_f64().max(1.0)
    }

    /// Shares of lines lost and damaged over the window, 0 to 1; `None` without lines. If the number of lost lines is an
    /// interval, its upper end counts; if it is open, the lines that are certain.
    pub(crate) fn shares(&self, now: Moment) -> Option<Shares> {
        // Lines of the robot's own are not damaged Groundwave lines.
        if self.has_only_own_lines() {
            return None;
        }
        let (_, then) = self.window_start(self.clock(now))?;
        let since =
            |count: fn(&Counters) -> u64| count(&self.counters).saturating_sub(count(then)) as f64;
        let lost = since(|counters| counters.lost().max);
        let damaged = since(|counters| counters.damaged.total());
        let sent = since(Counters::intact) + lost + damaged;
        (sent > 0.0).then(|| Shares {
            lost: lost / sent,
            damaged: damaged / sent,
            is_open: self.counters.unsettled.is_open
                || self.counters.hidden.since(then.hidden).is_open
                || self.counters.hidden.is_open && self.counters.restarts > then.restarts,
        })
    }

    /// Damaged lines over the window.
    pub(crate) fn damaged(&self, now: Moment) -> u64 {
        let then = self.window_start(self.clock(now));
        let then = then.map_or(0, |(_, then)| damaged(then));
        damaged(&self.counters).saturating_sub(then)
    }

    fn window_start(&self, now: Moment) -> Option<&(Moment, Counters)> {
        self.totals
            .iter()
            .find(|(at, _)| now.saturating_sub(*at) <= WINDOW)
    }

    /// Health of the link, in one word.
    pub(crate) fn health(&self, now: Moment) -> Health {
        match &self.connection {
            Connection::Lost { .. } => return Health::Lost,
            Connection::Ended => return Health::Ended,
            Connection::Opening | Connection::Open => {}
        }
        match self.newest_age(now) {
            None => Health::Waiting,
            Some(age) if age >= SILENT_AFTER => Health::Silent,
            Some(_)
                if self
                    .shares(now)
                    .is_some_and(|it| it.unusable() > WEAK_SHARE) =>
            {
                Health::Weak
            }
            Some(_) => Health::Good,
        }
    }

    /// Time at which an age on the screen changes.
    pub(super) fn next_tick(&self, now: Moment) -> Option<Moment> {
        if self.is_frozen() {
            return None;
        }
        let lost = match self.connection {
            Connection::Lost { since, .. } => Some(since),
            _ => None,
        };
        let heard_at = self.newest_line_at;
        let silent_since = self
            .opened_at
            .filter(|at| heard_at.is_some_and(|it| it < *at));
        let instead = self
            .instead_of_lines(now)
            .map(|(_, age)| now.saturating_sub(age));
        [self.newest_line_at, silent_since, lost, instead]
            .into_iter()
            .flatten()
            .map(|since| age::next_change(since, now))
            .min()
    }
}
/// Number of damaged lines.
const fn damaged(counters: &Counters) -> u64 {
    counters.crc_rejected + counters.shape_rejected + counters.field_rejected
}
