//! Runs a station on a real link and a real clock.

mod alarms;
mod setup;

use std::collections::{BTreeSet, VecDeque};
use std::time::{Duration, Instant};

use tokio::sync::mpsc::Receiver;
use tokio::time::{Instant as TokioInstant, sleep_until};

use super::advice::advice;
use super::live::{self, Live};
use super::share_server::ShareServer;
use crate::event::{
    CommandId, Event, Failure, GROUND, Level, LinkEvent, Moment, Notice, NoticeCode, Reception,
};
use crate::io::alarm_hook::AlarmHook;
use crate::io::foxglove::Call;
use crate::io::link::{Link, LinkInput};
use crate::io::share::FromClient;
use crate::radio::{Radio, random_owner};
use crate::request::Request;
use crate::share::{Answers, Heard, ToStation, Welcome};
use crate::station::Station;
use crate::statistics::Statistics;

/// Maximum number of bytes handled before other inputs.
const BATCH_BYTES: u64 = 4096;

/// Minimum time between two notices about a device that accepts no bytes.
const NOT_TAKEN_REST: Duration = Duration::from_secs(10);

/// Minimum time between two steps that counts as a suspension of the process.
const SUSPENDED_AFTER: Duration = Duration::from_secs(5);

/// Takes every byte sent, for the recorder.
pub type SentSink = Box<dyn FnMut(Instant, &[u8])>;

/// Takes every event, for the recorder.
pub type EventSink = Box<dyn FnMut(Instant, &Event)>;

/// Notices about a link without intact lines.
struct Advising {
    baud: Option<u32>,
    /// Whether the last notice was a warning.
    has_complained: bool,
}

impl Advising {
    /// The notice about a change of reception; `None` for lines without an earlier warning.
    fn advise(&mut self, reception: Reception) -> Option<Event> {
        let complains = reception != Reception::Lines;
        let is_news = complains || self.has_complained;
        self.has_complained = complains;
        let (level, text) = advice(reception, self.baud);
        is_news.then(|| Event::Notice(Notice::new(NoticeCode::Radio, level, text)))
    }
}

/// Joins a [`Station`] to a [`Link`] and the clock.
pub struct Driver {
    station: Station,
    link: Link,
    /// Whether the station that shares this link (if there is one) sends commands.
    station_sends: bool,
    /// Whether that station runs the operator's command for alarms, so that this one does not.
    station_runs_hook: bool,
    /// Time at which that station began, ms since 1970, if it tells.
    station_began_ms: Option<u64>,
    inputs: Receiver<LinkInput>,
    name: String,
    radio: Radio,
    started: Instant,
    sent: SentSink,
    observer: Option<EventSink>,
    /// Number of bytes not accepted by the device at the last notice, and the time of the notice.
    reported_not_taken: (u64, Option<Moment>),
    /// Time at which the latest step began.
    stepped_at: Option<Moment>,
    share: Option<ShareServer>,
    live: Option<Live>,
    alarm_hook: Option<AlarmHook>,
    answers: Answers,
    /// Alarms that began while they were shelved: the hook did not get their begin, and does not get their end.
    withheld: BTreeSet<String>,
    advising: Option<Advising>,
    /// Events that are not the station's own.
    events: VecDeque<Event>,
}

impl Driver {
    /// A station on an open link. Over a receive-only radio, it never sends a byte.
    #[must_use]
    pub fn new(
        name: String,
        link: Link,
        inputs: Receiver<LinkInput>,
        radio: Radio,
        started: Instant,
        sent: SentSink,
    ) -> Self {
        let station_sends = sends(link.share());
        let station_runs_hook = link.share().is_some_and(|it| it.runs_alarm_hook);
        let can_send = radio.can_send() && link.can_send() && station_sends;
        let station_began_ms = link.share().and_then(|welcome| welcome.began_ms);
        let mut station = Station::new(radio.config(random_owner()), can_send);
        station.handle_shared(started.elapsed(), link.share().is_some());
        Self {
            station,
            link,
            station_sends,
            station_runs_hook,
            station_began_ms,
            inputs,
            name,
            radio,
            started,
            sent,
            observer: None,
            reported_not_taken: (0, None),
            stepped_at: None,
            share: None,
            live: None,
            alarm_hook: None,
            answers: Answers::default(),
            withheld: BTreeSet::new(),
            advising: None,
            events: VecDeque::new(),
        }
    }

    /// Time since the station started.
    #[must_use]
    pub fn now(&self) -> Moment {
        self.started.elapsed()
    }

    /// Whether commands can be sent.
    #[must_use]
    pub fn can_send(&self) -> bool {
        self.radio.can_send() && self.link.can_send() && self.station_sends
    }

    /// The station.
    #[must_use]
    pub const fn station(&self) -> &Station {
        &self.station
    }

    /// Waits for an input or the next deadline, then handles it. Cancel-safe.
    pub async fn step(&mut self) {
        self.detect_suspension();
        let server = self.share.as_ref();
        let server = server.and_then(|server| server.broker.poll_timeout());
        let live = self.live.as_ref().and_then(Live::poll_timeout);
        let shelved = self.answers.next_expiry();
        let deadline = [self.station.poll_timeout(), server, live, shelved]
            .into_iter()
            .flatten()
            .min()
            .map(|moment| self.started + moment);
        tokio::select! {
            input = self.inputs.recv() => {
                // After `None`, the reader thread has reported its end.
                let Some(mut input) = input else { std::future::pending().await };
                let before = self.heard().bytes;
                loop {
                    self.handle_input(input);
                    if self.heard().bytes - before >= BATCH_BYTES {
                        break;
                    }
                    match self.inputs.try_recv() {
                        Ok(next) => input = next,
                        Err(_) => break,
                    }
                }
            }
            input = next_client(self.share.as_mut()) => self.handle_client(input),
            call = next_call(self.live.as_mut()) => self.handle_call(call),
            problem = next_problem(self.alarm_hook.as_mut()) => self.tell_hook(problem),
            () = sleep_to(deadline) => {}
        }
        // A silence during a suspension is not the robot's.
        self.detect_suspension();
        let now = self.now();
        self.link.hand_over_at_once(self.station.takes_turns());
        self.station.handle_timeout(now);
        for unshelved in self.answers.expired(now) {
            self.tell(Event::Alarm(unshelved));
        }
        let heard = self.heard();
        if let Some(server) = &mut self.share {
            server.broker.handle_timeout(now, heard);
        }
        self.serve_share();
        if let Some(live) = &mut self.live {
            live.handle_timeout(now);
        }
        self.serve_live();
        self.flush();
        self.tell_not_taken();
        // Timers and signals of the runtime also get their turn during a flood of inputs.
        tokio::task::yield_now().await;
    }

    /// Takes the end of the session, whose last events follow.
    pub fn end(&mut self) {
        // What was read until now is in the recording, so it counts.
        self.inputs.close();
        while let Ok(input) = self.inputs.try_recv() {
            self.handle_input(input);
        }
        self.station.handle_end(self.now());
    }

    /// Detects a suspension of the process: callers step at least every few seconds, so a longer time is one.
    pub fn detect_suspension(&mut self) {
        let now = self.now();
        if let Some(stepped_at) = self.stepped_at.replace(now)
            && now >= stepped_at + SUSPENDED_AFTER
        {
            self.station
                .handle_suspension(now, now.saturating_sub(stepped_at));
        }
    }

    fn handle_client(&mut self, input: FromClient) {
        let (now, heard) = (self.now(), self.heard());
        let server = self.share.as_mut();
        let Some(asked) = server.and_then(|server| server.handle(now, input, &self.answers)) else {
            return;
        };
        let by = Some(asked.by.clone());
        let id = self.start(now, asked.ask.request.clone(), by);
        if let Some(server) = &mut self.share {
            server.broker.handle_started(now, id, &asked, heard);
        }
    }

    fn handle_call(&mut self, call: Call) {
        let now = self.now();
        if let Some(live) = &mut self.live {
            live.handle_call(now, call);
        }
    }

    /// Carries out the requests of live tools.
    fn serve_live(&mut self) {
        while let Some(wanted) = self.live.as_mut().and_then(Live::poll) {
            match wanted {
                live::Wanted::Start { call, request, by } => {
                    let id = self.start(self.now(), request, Some(by));
                    if let Some(live) = &mut self.live {
                        live.handle_started(call, id);
                    }
                }
                live::Wanted::GiveUp(id) => {
                    let why = Failure::TimedOut;
                    self.station.handle_give_up(self.now(), id, why);
                }
            }
        }
    }

    /// Carries out the requests of the share server.
    fn serve_share(&mut self) {
        while let Some(wanted) = self.share.as_mut().and_then(ShareServer::poll) {
            match wanted {
                ToStation::GiveUp(id, why) => self.station.handle_give_up(self.now(), id, why),
                ToStation::Drive {
                    velocity_in_s: 0,
                    rotation_in_s: 0,
                } => self.station.handle_drive_end(self.now()),
                ToStation::Drive {
                    velocity_in_s,
                    rotation_in_s,
                } => {
                    let now = self.now();
                    self.station.handle_drive(now, velocity_in_s, rotation_in_s);
                }
                ToStation::Answered(answered) => {
                    let alarm = &answered.alarm;
                    self.station.handle_answer(alarm, answered.answer);
                    self.events.push_back(Event::AlarmAnswer(answered));
                }
                ToStation::Warning(text) => self.events.push_back(Event::Notice(Notice::new(
                    NoticeCode::ShareClient,
                    Level::Warning,
                    format!("shared link: {text}"),
                ))),
            }
        }
    }

    /// Totals received from the robot.
    #[must_use]
    pub const fn heard(&self) -> Heard {
        let counters = self.station.counters();
        Heard {
            bytes: counters.bytes,
            lines: counters.received() + self.station.own_lines(),
        }
    }

    /// Statistics of the link.
    #[must_use]
    pub fn statistics(&self) -> Statistics {
        Statistics {
            not_taken_bytes: self.link.not_taken_bytes(),
            ..self.station.statistics(self.now())
        }
    }

    fn tell_not_taken(&mut self) {
        let now = self.now();
        let bytes = self.link.not_taken_bytes();
        let (reported, at) = self.reported_not_taken;
        if bytes > reported && at.is_none_or(|at| now.saturating_sub(at) >= NOT_TAKEN_REST) {
            self.reported_not_taken = (bytes, Some(now));
            self.events.push_back(Event::Notice(Notice::new(
                NoticeCode::NotTaken,
                Level::Warning,
                format!("the device accepts no bytes: {bytes} not sent so far"),
            )));
        }
    }

    fn handle_input(&mut self, input: LinkInput) {
        match input {
            LinkInput::Opened {
                renamed,
                empty,
                share,
            } => {
                self.station_sends = sends(share.as_ref());
                self.station_runs_hook = share.as_ref().is_some_and(|it| it.runs_alarm_hook);
                self.tell_clients_of_hook();
                let began_ms = share.as_ref().and_then(|welcome| welcome.began_ms);
                let before_ms = std::mem::replace(&mut self.station_began_ms, began_ms);
                if before_ms.is_some() && before_ms != began_ms {
                    self.station.handle_other_station();
                }
                self.events.extend(share.iter().flat_map(welcomed));
                let name = renamed.unwrap_or_else(|| self.name.clone());
                let opened = LinkEvent::Opened {
                    name: via(share.as_ref(), name),
                    can_send: self.can_send(),
                };
                let now = self.now();
                self.station.handle_link(now, opened);
                self.station.handle_shared(now, share.is_some());
                if empty > 1 {
                    self.events.push_back(Event::Notice(Notice::new(
                        NoticeCode::EmptyConnections,
                        Level::Warning,
                        format!("{empty} connections before this one were closed without a byte"),
                    )));
                }
            }
            LinkInput::Bytes(at, bytes) => {
                let at = at.saturating_duration_since(self.started);
                if let Some(live) = &mut self.live {
                    live.handle_rx(at, &bytes);
                }
                self.station.handle_bytes(at, &bytes);
            }
            LinkInput::Said(line) => {
                let now = self.now();
                if let Some(server) = &mut self.share {
                    server.broker.pass_on(&line);
                    self.serve_share();
                }
                self.station.handle_shared_line(now, &line);
            }
            LinkInput::Lost(reason) => {
                let now = self.now();
                // Its end is the reason why commands end.
                self.station.handle_link(now, LinkEvent::Lost { reason });
                self.station.handle_shared_lost(now);
            }
            LinkInput::Ended => self.station.handle_link(self.now(), LinkEvent::Ended),
        }
    }

    /// Queues a command; its statuses are returned as events.
    pub fn request(&mut self, request: Request) -> CommandId {
        let id = self.start(self.now(), request, None);
        self.flush();
        id
    }

    /// Queues a command that the operator has not given.
    pub fn request_unasked(&mut self, request: Request) {
        self.start(self.now(), request, Some(GROUND.to_owned()));
        self.flush();
    }

    fn start(&mut self, now: Moment, request: Request, by: Option<String>) -> CommandId {
        // Lines for another station are not repeated, so none may be dropped.
        if request == Request::Stop && !self.station.is_shared() {
            self.link.clear_queue();
        }
        self.station.handle_request(now, request, by)
    }

    /// Drives by hand for half a second.
    pub fn drive(&mut self, velocity_in_s: i8, rotation_in_s: i8) {
        self.station
            .handle_drive(self.now(), velocity_in_s, rotation_in_s);
        self.flush();
    }

    /// Ends hand drive; the robot stops.
    pub fn drive_end(&mut self) {
        self.station.handle_drive_end(self.now());
        self.flush();
    }

    /// Cancels the current command and the waiting ones.
    pub fn cancel(&mut self) {
        self.station.handle_cancel(self.now());
        self.flush();
    }

    /// The next event.
    pub fn poll_event(&mut self) -> Option<Event> {
        let mut event = self.station.poll_event();
        if let Some(Event::Statistics(statistics)) = &mut event {
            statistics.not_taken_bytes = self.link.not_taken_bytes();
        }
        if let (Some(Event::Reception { reception, .. }), Some(advising)) =
            (&event, &mut self.advising)
        {
            self.events.extend(advising.advise(*reception));
        }
        let heard = self.heard();
        if let (Some(event), Some(server)) = (&event, &mut self.share) {
            server.handle_event(event, heard);
            self.serve_share();
        }
        let event = event.or_else(|| self.events.pop_front())?;
        if let Some(observer) = &mut self.observer {
            observer(Instant::now(), &event);
        }
        let now = self.now();
        if let Some(live) = &mut self.live {
            live.handle_event(now, &event);
            self.serve_live();
            self.flush();
        }
        Some(event)
    }

    fn flush(&mut self) {
        let now = self.now();
        while let Some(line) = self.station.poll_shared_line() {
            self.link.send(&line.to_line());
        }
        while let Some(bytes) = self.station.poll_transmit(now) {
            // Bytes are sent before they are recorded: STOP must not wait for a slow disk.
            let at = Instant::now();
            self.link.send(&bytes);
            (self.sent)(at, &bytes);
            if let Some(live) = &mut self.live {
                live.handle_tx(now, &bytes);
            }
        }
    }
}

/// Whether the station that shares a link (if there is one) sends commands.
fn sends(share: Option<&Welcome>) -> bool {
    share.is_none_or(|welcome| welcome.can_send)
}

/// The name of a link; of a shared link, first the name that the station that shares it gives it.
fn via(share: Option<&Welcome>, name: String) -> String {
    match share {
        Some(welcome) => format!("{} via {name}", welcome.link),
        None => name,
    }
}

/// What another station's welcome says: the world of its simulated robot, and the answers to its alarms.
fn welcomed(share: &Welcome) -> impl Iterator<Item = Event> {
    let answers = share.answers.iter().cloned().map(Event::AlarmAnswer);
    let truth = share.truth.clone().map(Event::Truth);
    truth.into_iter().chain(answers)
}

async fn next_client(server: Option<&mut ShareServer>) -> FromClient {
    match server {
        Some(server) => server.next().await,
        None => std::future::pending().await,
    }
}

async fn next_problem(hook: Option<&mut AlarmHook>) -> String {
    match hook {
        Some(hook) => hook.next_problem().await,
        None => std::future::pending().await,
    }
}

async fn next_call(live: Option<&mut Live>) -> Call {
    match live {
        Some(live) => live.next().await,
        None => std::future::pending().await,
    }
}

async fn sleep_to(deadline: Option<Instant>) {
    match deadline {
        Some(deadline) => sleep_until(TokioInstant::from_std(deadline)).await,
        None => std::future::pending().await,
    }
}

#[cfg(all(test, unix))]
mod tests;
