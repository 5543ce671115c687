//! The ground station, sans-IO: turns bytes into events and commands into bytes.
//!
//! `handle_*` takes input, `poll_*` returns output. After each `handle_*`, call all `poll_*` until they return `None`.

mod delivery;
mod own_uplink;
pub mod plan;
mod reception;
mod reports;
mod requests;
mod shared;
mod tuner;

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use groundwave_lines::{Content, OwnCommand, Recognizer, runs};
use groundwave_protocol::arq::{Config, Duplex, Fop};
use groundwave_protocol::decoder::{Arrival, Counters, Decoder, Received};
use groundwave_protocol::telemetry::Body;

use crate::diagnosis::Examiner;
use crate::event::{CommandId, CommandStatus, Event, Failure, LinkEvent, Moment};
use crate::outages::Outages;
use crate::request::Request;
use crate::statistics::{BITS_PER_BYTE, LinkMeter, OtherRobot, Statistics};
use own_uplink::OwnUplink;
use reception::Listener;
use shared::Shared;
use tuner::Tuner;

#[derive(Clone, Debug)]
struct Waiting {
    id: CommandId,
    request: Request,
}

/// The ground station.
#[derive(Clone, Debug)]
pub struct Station {
    decoder: Decoder,
    /// Whether the times of bytes were not measured.
    has_estimated_times: bool,
    /// Reads lines in the robot's own form.
    own: Recognizer,
    /// Number of lines of the robot's own so far.
    own_lines: u64,
    /// Lines of its own with values, and all lines.
    own_values: u64,
    all_lines: u64,
    /// Command strings, for a robot that takes them and no frames.
    own_uplink: Option<OwnUplink>,
    listener: Listener,
    fop: Fop,
    /// Connection to another station that sends the commands; `None` on a radio.
    shared: Option<Shared>,
    sending: Sending,
    /// Whether an operator watches.
    is_attended: bool,
    waiting: VecDeque<Waiting>,
    current: Option<CommandId>,
    /// Least number of frames that were sent for the current command.
    frames: u32,
    /// The current command, if it is about parameters.
    tuner: Option<Tuner>,
    /// A list of parameters that waits for other commands, and the part of it that was received.
    paused_list: Option<(CommandId, Tuner)>,
    /// STOPs that the robot has not confirmed yet, oldest first; each with the number of STOP frames sent since.
    stops: Vec<(CommandId, u16)>,
    /// Whether this station has sent STOP in this session.
    stopped: bool,
    next_id: u32,
    reported_counters: Counters,
    /// What was reported of other robots on the channel.
    reported_other: OtherRobot,
    outages: Outages,
    /// Time at which the session ended.
    ended_at: Option<Moment>,
    examiner: Examiner,
    /// Rate of the port, bit/s; `None` if it is unknown, as behind a network.
    baud: Option<u32>,
    meter: LinkMeter,
    reported_statistics: Option<(Moment, Statistics)>,
    events: VecDeque<Event>,
}

/// Whether frames can be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sending {
    /// The link is receive-only or has ended.
    Never,
    /// The link is lost: frames wait until it is open again.
    Later,
    Now,
}

impl Sending {
    const fn on(can_send: bool) -> Self {
        if can_send { Self::Now } else { Self::Never }
    }
}

impl Station {
    /// A station before its first input. `can_send` is needed from the start, because a STOP pressed before the
    /// link's first event must be sent.
    #[must_use]
    pub fn new(config: Config, can_send: bool) -> Self {
        Self {
            decoder: Decoder::default(),
            has_estimated_times: false,
            own: Recognizer::default(),
            own_lines: 0,
            own_values: 0,
            all_lines: 0,
            own_uplink: None,
            listener: Listener::default(),
            fop: Fop::new(config),
            shared: None,
            sending: Sending::on(can_send),
            is_attended: false,
            waiting: VecDeque::new(),
            current: None,
            frames: 0,
            tuner: None,
            paused_list: None,
            stops: Vec::new(),
            stopped: false,
            next_id: 1,
            reported_counters: Counters::default(),
            reported_other: OtherRobot::default(),
            outages: Outages::default(),
            ended_at: None,
            examiner: Examiner::default(),
            baud: None,
            meter: LinkMeter::default(),
            reported_statistics: None,
            events: VecDeque::new(),
        }
    }

    /// Sets the port's baud rate, for the pace of frames and the airtime. Without one, both follow the robot's line I; until then the
    /// rate is 2400.
    pub fn set_baud(&mut self, baud: u32) {
        self.baud = Some(baud);
        self.meter.set_baud(baud);
        self.fop.set_rate(baud / BITS_PER_BYTE);
    }

    /// Sets that an operator watches. An unconfirmed STOP is sent until [`Station::handle_cancel`] gives it up. Other commands do not
    /// wait for a lost link: another program may have stopped the robot before it opens again.
    pub const fn set_attended(&mut self) {
        self.is_attended = true;
    }

    /// Sets that the times of bytes were not measured: the count of lost lines does not use them, and airtime is unknown.
    pub const fn set_estimated_times(&mut self) {
        self.has_estimated_times = true;
    }

    /// Sets how lines in the robot's own form are read. Until then, the form is recognized automatically.
    pub fn set_own_lines(&mut self, own: Recognizer) {
        self.own = own;
    }

    /// Sets the robot's command strings. If there are any, the robot gets no frames.
    pub fn set_own_commands(&mut self, commands: BTreeMap<String, OwnCommand>) {
        self.own_uplink = (!commands.is_empty()).then(|| OwnUplink::new(commands));
    }

    fn settle_own(&mut self, now: Moment) {
        while let Some((id, status)) = self.own_uplink.as_mut().and_then(OwnUplink::poll_status) {
            self.report(now, id, status);
        }
    }

    /// Takes a change of the connection.
    pub fn handle_link(&mut self, now: Moment, event: LinkEvent) {
        self.listener
            .open(matches!(event, LinkEvent::Opened { .. }));
        if let Some(uplink) = &mut self.own_uplink {
            uplink.set_lost(!matches!(event, LinkEvent::Opened { .. }));
        }
        self.meter.interrupt();
        match &event {
            LinkEvent::Opened { can_send, .. } => {
                self.sending = Sending::on(*can_send);
                self.own.reopen();
            }
            LinkEvent::Lost { .. } => {
                self.decoder.interrupt();
                self.examiner.skip();
                self.own.interrupt();
                self.outages.handle_unplugged(now);
                if self.sending == Sending::Now {
                    self.sending = Sending::Later;
                }
                if self.is_attended {
                    self.cancel_waiting(now, Failure::NotSent);
                }
            }
            LinkEvent::Ended => {
                self.sending = Sending::Never;
                self.handle_end(now);
            }
        }
        if !matches!(event, LinkEvent::Opened { .. }) {
            self.report_last_statistics(now);
        }
        self.events.push_back(Event::Link(event));
        self.report_outages();
    }

    /// Takes the end of the session: reports the outages that have not been reported, and the lines that may be lost in one that lasts.
    pub fn handle_end(&mut self, now: Moment) {
        if self.ended_at.is_none() {
            self.ended_at = Some(now);
            let undecided: Vec<Received> = self.decoder.undecided_lines().collect();
            for received in undecided {
                let counters = self.decoder.counters();
                self.outages.handle_line(now, &received, counters);
                self.handle_received(now, &received);
            }
            self.outages.finish(now, &self.totals(now));
            self.report_outages();
        }
    }

    /// Takes a connection to another station than before: its robot may be another one, so nothing is known of the lines between.
    pub fn handle_other_station(&mut self) {
        self.decoder.forget_robot();
        self.examiner = Examiner::default();
    }

    /// Takes the end of a suspension of this station.
    pub fn handle_suspension(&mut self, now: Moment, duration: Moment) {
        self.outages.handle_suspension(now.saturating_sub(duration));
        self.listener.resume(now);
        self.events.push_back(Event::Suspended(duration));
    }

    /// Whether the link is half duplex. The station then sends only while the robot is silent, so received bytes must
    /// be passed on without delay.
    #[must_use]
    pub fn takes_turns(&self) -> bool {
        self.fop.duplex() == Duplex::Half
    }

    /// Takes bytes from the radio. The events do not depend on how the bytes are split.
    pub fn handle_bytes(&mut self, now: Moment, bytes: &[u8]) {
        self.fop.handle_carrier(micros(now));
        for run in runs(bytes) {
            self.handle_run(now, run);
        }
    }

    /// Takes a line or a part of a line, and the empty lines after it.
    fn handle_run(&mut self, now: Moment, run: &[u8]) {
        self.meter.take_received(now, run.len());
        if !self.has_estimated_times {
            self.decoder.set_time(milliseconds(now));
        }
        let before = *self.decoder.counters();
        let mut bytes = run;
        let mut last = None;
        self.decoder.hold_robot(self.fop.holds_robot());
        while let Some(arrival) = self.decoder.next_arrival(&mut bytes) {
            let received = match arrival {
                Arrival::Line(received) => received,
                Arrival::Repaired(line) => {
                    self.events.push_back(Event::Repaired(Box::new(line)));
                    continue;
                }
            };
            let counters = self.decoder.counters();
            self.meter.take_line(counters);
            self.outages.handle_line(now, &received, counters);
            last = Some((received, counters.noise_bytes));
            self.handle_received(now, &received);
        }
        // A line of another robot is a line, too.
        let mut has_line = self.decoder.counters().received() != before.received();
        self.all_lines += u64::from(run.ends_with(b"\n"));
        self.report_outages();
        self.report_other_robot();
        let has_left_out = self.own.left_out() > 0;
        let own = self.own.take(run, has_line);
        if !has_left_out && self.own.left_out() > 0 {
            self.report_fields_left_out();
        }
        if let Some(line) = own {
            let is_intact = line.content != Content::Damaged;
            has_line |= is_intact;
            self.own_lines += u64::from(is_intact);
            let has_values = matches!(&line.content, Content::Values(values) if !values.is_empty());
            self.own_values += u64::from(has_values);
            self.decoder.disown(run.len(), before.damaged);
            self.examiner.skip();
            if let Some(uplink) = &mut self.own_uplink {
                uplink.handle_line(&line.text);
                self.settle_own(now);
            }
            self.events.push_back(Event::Own(line));
        } else {
            self.examiner.take(run, last, &before, &self.decoder);
            self.report_mistakes();
        }
        let heard = self.listener.take(now, run, has_line);
        self.report_reception(heard);
        if run.last() != Some(&b'\n') {
            return;
        }
        let counters = *self.decoder.counters();
        let ended = |c: &Counters| {
            (
                c.crc_rejected,
                c.shape_rejected,
                c.field_rejected,
                c.received(),
            )
        };
        if ended(&counters) != ended(&self.reported_counters) {
            self.reported_counters = counters;
            // A flood of short lines makes only one event.
            match self.events.back_mut() {
                Some(Event::Counters(last)) => *last = counters,
                _ => self.events.push_back(Event::Counters(counters)),
            }
        }
        self.report_statistics(now);
    }

    /// Takes bytes sent, from a recording.
    pub fn handle_sent(&mut self, now: Moment, bytes: &[u8]) {
        self.meter.take_sent(now, bytes);
    }

    /// Takes a gap in the bytes; no line spans it.
    pub fn handle_interruption(&mut self) {
        self.decoder.skip();
        self.examiner.skip();
        self.own.interrupt();
        self.meter.interrupt();
        self.outages.handle_missing();
    }

    fn handle_received(&mut self, now: Moment, received: &Received) {
        match received {
            Received::Line(line, raw) => self.events.push_back(Event::Line {
                line: Box::new(*line),
                raw: *raw,
            }),
            Received::Ack(line) => self.events.push_back(Event::Ack(*line)),
        }
        self.fop.handle_received(micros(now), received);
        self.settle(now);
        if let Received::Line(line, _) = received
            && let Body::Abilities(robot) = &line.body
        {
            let own_baud = robot.rate_bytes_per_s * BITS_PER_BYTE;
            self.meter
                .set_baud(self.baud.map_or(own_baud, |port| port.min(own_baud)));
        }
        if let Received::Line(line, _) = received
            && let Body::Parameter(parameter) = &line.body
            && let Some(tuner) = &mut self.tuner
        {
            let (is_meant, verdict) = tuner.take_line(now, parameter);
            if is_meant {
                self.report_current(now, CommandStatus::Reported(*parameter));
            }
            self.follow(now, verdict);
        }
    }

    /// Handles deadlines that have passed.
    pub fn handle_timeout(&mut self, now: Moment) {
        if let Some(uplink) = &mut self.own_uplink {
            uplink.handle_timeout(now);
            self.settle_own(now);
        }
        self.fop.handle_timeout(micros(now));
        self.settle(now);
        if let Some(tuner) = &mut self.tuner {
            let verdict = tuner.handle_timeout(now);
            self.follow(now, verdict);
        }
        let heard = self.listener.handle_timeout(now);
        self.report_reception(heard);
        self.outages.handle_timeout(now, self.decoder.counters());
        self.report_outages();
        self.report_statistics(now);
    }

    /// The next bytes for the radio.
    pub fn poll_transmit(&mut self, now: Moment) -> Option<Vec<u8>> {
        if self.sending != Sending::Now || self.shared.is_some() {
            return None;
        }
        let bytes = match &mut self.own_uplink {
            Some(uplink) => uplink.poll_transmit(),
            None => self.fop.poll_transmit(micros(now)).map(<[u8]>::to_vec),
        };
        if let Some(bytes) = &bytes {
            self.meter.take_sent(now, bytes);
        }
        self.drain_fop(now);
        bytes
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Latest time for the next call of [`Station::handle_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let fop = match self.sending {
            Sending::Now => self.fop.poll_timeout(),
            Sending::Later | Sending::Never => self.fop.poll_give_up(),
        };
        let fop = fop.map(Duration::from_micros);
        let tuner = self.tuner.as_ref().and_then(Tuner::poll_timeout);
        let outage = self.outages.poll_timeout();
        let own = self.own_uplink.as_ref().and_then(OwnUplink::poll_timeout);
        [own, fop, tuner, self.listener.poll_timeout(), outage]
            .into_iter()
            .flatten()
            .min()
    }

    /// The decoder's totals.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// Number of lines of the robot's own so far.
    #[must_use]
    pub const fn own_lines(&self) -> u64 {
        self.own_lines
    }

    /// Whether every command has ended.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let has_echoes = self.own_uplink.as_ref().is_none_or(OwnUplink::is_settled);
        has_echoes && self.waiting.is_empty() && self.current.is_none() && self.stops.is_empty()
    }
}

const fn milliseconds(moment: Moment) -> u64 {
    moment.as_millis() as u64
}

fn micros(moment: Moment) -> u64 {
    moment.as_micros() as u64
}
