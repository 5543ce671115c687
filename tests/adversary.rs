//! Two operators, the robot's real program, and an adversary on the link between them, in virtual time. From a seed, the
//! adversary flips bits; drops, repeats, reorders and delays frames and lines; silences and resets links; sends
//! recorded frames again; restarts stations and reboots the robot. The operators issue any command at any time.
//!
//! The adversary keeps the limit of `protocol/SPEC.md` on the delay of lines.

use std::collections::{HashMap, HashSet};
use std::mem;
use std::ops::AddAssign;
use std::time::Duration;

use groundwave::event::{CommandId, CommandStatus, Event, Failure, LinkEvent, NoticeCode};
use groundwave::request::{Amount, Request, Tuning};
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use groundwave_protocol::command::{Message, Order};
use groundwave_protocol::digest::digest;
use groundwave_protocol::parameter::key;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::telemetry::{Ack, Outcome};
use groundwave_protocol::{Waypoint, crc};
use sr04_firmware::drive::Motion;
use sr04_sim::{Simulation, SimulationConfig, TICK_MS, World};

use crate::common::{Rng, on_all_cores, owner, seeds};

#[path = "adversary/hostile_link.rs"]
mod hostile_link;
#[path = "../src/request/testing.rs"]
mod testing;

use hostile_link::{DELAY_MS, Direction, JITTER_MS, Weather};

const SEEDS: u64 = 20;

/// Duration of a trial, milliseconds.
const TRIAL_MS: u64 = 60_000;

const ROBOT_ID: u8 = 1;

/// Time without progress after which a task or a STOP fails, and the time between two calls of the station.
const GIVE_UP: Duration = Duration::from_millis(15_001);

/// A command that has not ended.
#[derive(Debug)]
struct Pending {
    id: CommandId,
    request: Request,
    /// Number of executions and STOPs of the robot before the command was given.
    executions_before: usize,
    stops_before: usize,
    /// Time at which the client abandons the command.
    give_up_at: Option<Duration>,
}

/// An operator with a station, and both directions of the link.
struct Operator {
    station: Station,
    /// Number of the station's process among those of the trial.
    process: u64,
    up: Direction,
    down: Direction,
    /// Time at which the link opens again, milliseconds; `None` while it is open.
    back_ms: Option<u64>,
    pending: Vec<Pending>,
    /// Times of the latest progress of a command and of the latest STOP given.
    progress_at: Duration,
    stop_at: Duration,
}

impl Operator {
    fn new(seed: u64, process: u64) -> Self {
        Self {
            // Processes of a trial differ in their owners.
            station: Station::new(Config::new(owner(seed + process)), true),
            process,
            up: Direction::default(),
            down: Direction::default(),
            back_ms: None,
            pending: Vec::new(),
            progress_at: Duration::ZERO,
            stop_at: Duration::ZERO,
        }
    }

    /// Time without progress within which the oldest command must end.
    fn limit(request: &Request) -> Duration {
        match request {
            // The robot refuses the digest of a list up to three times.
            Request::Route(_) => 4 * GIVE_UP,
            // Up to twelve questions, each of them an order and 2.5 s.
            Request::Parameter(_) => 13 * (GIVE_UP + Duration::from_millis(2500)),
            _ => GIVE_UP,
        }
    }

    fn check_timeouts(&self, now: Duration, context: &str) {
        let is_stop = |pending: &&Pending| pending.request == Request::Stop;
        if let Some(oldest) = self.pending.iter().find(|pending| !is_stop(pending)) {
            let ends_at = self.progress_at + Self::limit(&oldest.request);
            assert!(now <= ends_at, "has not ended: {oldest:?}; {context}");
        }
        let has_stop = self.pending.iter().any(|pending| is_stop(&pending));
        assert!(
            !has_stop || now <= self.stop_at + GIVE_UP,
            "STOP has not ended; {context}"
        );
    }
}

/// A frame sent by a station: the station's process, and the time at which the frame was last sent.
#[derive(Clone, Copy)]
struct Sent {
    process: u64,
    at_ms: u64,
}

/// A command executed or refused by the robot.
#[derive(Debug)]
struct Execution {
    process: u64,
    order: Order,
    outcome: Outcome,
    /// Whether this execution has confirmed or refused a command.
    is_claimed: bool,
}

/// Totals, which show that events occurred in the trials.
#[derive(Debug, Default)]
struct Totals {
    commands: usize,
    confirmed: usize,
    stops: usize,
    routes: usize,
    refused_replays: usize,
}

impl AddAssign for Totals {
    fn add_assign(&mut self, other: Self) {
        self.commands += other.commands;
        self.confirmed += other.confirmed;
        self.stops += other.stops;
        self.routes += other.routes;
        self.refused_replays += other.refused_replays;
    }
}

struct Trial {
    seed: u64,
    rng: Rng,
    simulation: Simulation,
    operators: [Operator; 2],
    processes: u64,
    /// Whether the adversary has stopped.
    is_over: bool,
    /// Frames sent by the stations without their line feeds.
    sent: HashMap<Vec<u8>, Sent>,
    recorded: Vec<Vec<u8>>,
    samples: Vec<Request>,
    routes: Vec<Vec<Waypoint>>,
    route: Vec<Waypoint>,
    /// Finds STOPs among the bytes that reach the robot.
    receiver: Receiver,
    /// Bytes that have reached the robot since the latest line feed.
    reached: Vec<u8>,
    /// Time at which the robot's session, or the time without a session, began.
    session_ms: u64,
    /// Commands executed in this session.
    taken: HashSet<Vec<u8>>,
    executions: Vec<Execution>,
    /// The stations' processes whose STOPs the robot took.
    stops: Vec<u64>,
    totals: Totals,
}

impl Trial {
    fn new(seed: u64) -> Self {
        let world = World::built_in("open-room").unwrap();
        let config = SimulationConfig {
            robot_id: ROBOT_ID,
            ..SimulationConfig::new(world, seed)
        };
        Self {
            seed,
            rng: Rng(seed),
            simulation: Simulation::new(&config),
            operators: [0, 1].map(|process| Operator::new(seed, process)),
            processes: 2,
            is_over: false,
            sent: HashMap::new(),
            recorded: Vec::new(),
            samples: testing::samples(),
            routes: vec![vec![]],
            route: vec![],
            receiver: Receiver::default(),
            reached: Vec::new(),
            session_ms: 0,
            taken: HashSet::new(),
            executions: Vec::new(),
            stops: Vec::new(),
            totals: Totals::default(),
        }
    }

    fn now_ms(&self) -> u64 {
        self.simulation.now_ms()
    }

    fn now(&self) -> Duration {
        Duration::from_millis(self.now_ms())
    }

    fn context(&self) -> String {
        format!("seed {}, at {:.3} s", self.seed, self.now().as_secs_f64())
    }

    fn run(mut self) -> Totals {
        let mut act_ms = 0;
        while self.now_ms() < TRIAL_MS {
            self.step();
            if self.now_ms() >= act_ms {
                act_ms = self.now_ms() + self.rng.below(2500);
                self.act();
            }
        }
        self.finish();
        self.totals
    }

    /// Checks that all commands end, and that new ones arrive after the adversary has stopped.
    fn finish(&mut self) {
        self.is_over = true;
        for operator in &mut self.operators {
            operator.up.weather = Weather::default();
            operator.down.weather = Weather::default();
        }
        let quiet_ms = self.now_ms() + DELAY_MS + JITTER_MS;
        while self.now_ms() < quiet_ms || self.operators.iter().any(|o| !o.pending.is_empty()) {
            self.step();
        }
        for n in 0..self.operators.len() {
            let confirmed = self.totals.confirmed;
            self.order(n, Request::Mode(Mode::Reactive));
            while !self.operators[n].pending.is_empty() {
                self.step();
            }
            let is_confirmed = self.totals.confirmed > confirmed;
            assert!(is_confirmed, "not confirmed: {}", self.context());
        }
    }

    /// Advances by a millisecond.
    fn step(&mut self) {
        self.simulation.step();
        let now_ms = self.now_ms();
        while let Some(byte) = self.simulation.poll_downlink() {
            for operator in &mut self.operators {
                operator.down.take(now_ms, byte, &mut self.rng);
            }
        }
        for n in 0..self.operators.len() {
            self.change_weather(n);
            self.serve(n);
            for frame in self.operators[n].up.arrived(now_ms) {
                self.deliver(&frame);
            }
        }
        if now_ms.is_multiple_of(TICK_MS) {
            self.look_at_route();
        }
    }

    fn change_weather(&mut self, n: usize) {
        let now_ms = self.now_ms();
        let Operator { up, down, .. } = &mut self.operators[n];
        for direction in [up, down] {
            if !self.is_over && now_ms >= direction.weather.until_ms {
                direction.weather = Weather::draw(now_ms, &mut self.rng);
            }
        }
    }

    /// One event of the adversary or of an operator.
    fn act(&mut self) {
        let n = self.rng.below(2) as usize;
        let now = self.now();
        match self.rng.below(24) {
            0..12 => {
                let request = self.some_request();
                self.order(n, request);
            }
            12 | 13 => self.order(n, Request::Stop),
            14 | 15 => {
                let (velocity, rotation) = (self.rng.below(13) as i8, self.rng.below(9) as i8 - 4);
                self.operators[n]
                    .station
                    .handle_drive(now, velocity, rotation);
            }
            16 => self.operators[n].station.handle_drive_end(now),
            17 => self.operators[n].station.handle_cancel(now),
            18..21 => self.replay(),
            21 => {
                let back_ms = self.now_ms() + self.rng.below(3000);
                let operator = &mut self.operators[n];
                operator.up.reset();
                operator.down.reset();
                operator.back_ms = Some(back_ms);
                let lost = LinkEvent::Lost {
                    reason: "reset".to_owned(),
                };
                operator.station.handle_link(now, lost);
            }
            22 => {
                let killed = &mut self.operators[n];
                *killed = Operator {
                    up: mem::take(&mut killed.up),
                    down: mem::take(&mut killed.down),
                    ..Operator::new(self.seed, self.processes)
                };
                self.processes += 1;
            }
            _ => {
                self.simulation.reboot();
                self.receiver = Receiver::default();
                self.reached.clear();
                self.route.clear();
                self.begin_session();
            }
        }
    }

    /// A command of any kind, with its own route or mode.
    fn some_request(&mut self) -> Request {
        let kind = self.rng.below(self.samples.len() as u64) as usize;
        match self.samples[kind].clone() {
            Request::Route(sample) => {
                let mut part = || self.rng.below(19_999) as i16 - 9999;
                let point = |_| Waypoint {
                    x_in: part(),
                    y_in: part(),
                };
                let route: Vec<Waypoint> = sample.iter().map(point).collect();
                let count = (self.rng.below(4) as usize * 13).max(1);
                Request::Route(route[..sample.len().min(count)].to_vec())
            }
            Request::Mode(_) => {
                Request::Mode(Mode::ALL[self.rng.below(Mode::ALL.len() as u64) as usize])
            }
            request => request,
        }
    }

    fn order(&mut self, n: usize, request: Request) {
        if let Request::Route(route) = &request {
            self.routes.push(route.clone());
        }
        self.totals.commands += 1;
        let now = self.now();
        let timeout_s = 3 + self.rng.below(40);
        let has_client = !self.is_over && self.rng.below(2) == 0 && request != Request::Stop;
        let operator = &mut self.operators[n];
        let is_stop = |request: &Request| *request == Request::Stop;
        if is_stop(&request) {
            operator.stop_at = now;
        } else if operator.pending.iter().all(|p| is_stop(&p.request)) {
            operator.progress_at = now;
        }
        let id = operator.station.handle_request(now, request.clone(), None);
        operator.pending.push(Pending {
            id,
            request,
            executions_before: self.executions.len(),
            stops_before: self.stops.len(),
            give_up_at: has_client.then(|| now + Duration::from_secs(timeout_s)),
        });
        self.take_events(n);
    }

    /// Sends some consecutive recorded frames again.
    fn replay(&mut self) {
        if self.recorded.is_empty() {
            return;
        }
        let from = self.rng.below(self.recorded.len() as u64) as usize;
        let count = 1 + self.rng.below(30) as usize;
        let recorded = self.recorded.split_off(from);
        for frame in recorded.iter().take(count) {
            let obeyed = self.executions.len() + self.stops.len();
            self.deliver(&[b"\n", &frame[..]].concat());
            self.totals.refused_replays +=
                usize::from(obeyed == self.executions.len() + self.stops.len());
        }
        self.recorded.extend(recorded);
    }

    /// Passes lines and the time to a station, and frames from it.
    fn serve(&mut self, n: usize) {
        let (now, now_ms) = (self.now(), self.now_ms());
        let operator = &mut self.operators[n];
        if operator.back_ms.is_some_and(|at_ms| at_ms <= now_ms) {
            operator.back_ms = None;
            operator.station.handle_link(
                now,
                LinkEvent::Opened {
                    name: "tcp:robot".to_owned(),
                    can_send: true,
                },
            );
        }
        let is_open = operator.back_ms.is_none();
        for line in operator.down.arrived(now_ms) {
            if is_open {
                operator.station.handle_bytes(now, &line);
            }
        }
        if operator.station.poll_timeout().is_some_and(|at| at <= now) {
            operator.station.handle_timeout(now);
        }
        self.transmit(n);
        self.take_events(n);
        self.give_up(n);
        self.operators[n].check_timeouts(now, &self.context());
    }

    /// Passes the frames of a station to the link, and records them.
    fn transmit(&mut self, n: usize) {
        let (now, now_ms) = (self.now(), self.now_ms());
        let operator = &mut self.operators[n];
        let is_open = operator.back_ms.is_none();
        while let Some(bytes) = operator.station.poll_transmit(now) {
            for byte in bytes.into_iter().filter(|_| is_open) {
                let frame = operator.up.take(now_ms, byte, &mut self.rng);
                let Some(frame) = frame else { continue };
                let sent = Sent {
                    process: operator.process,
                    at_ms: now_ms,
                };
                self.sent.insert(frame.trim_ascii().to_vec(), sent);
                self.recorded.push(frame);
            }
        }
    }

    /// Abandons commands whose clients no longer wait.
    fn give_up(&mut self, n: usize) {
        let now = self.now();
        let late = |pending: &Pending| pending.give_up_at.is_some_and(|at| at <= now);
        while let Some(pending) = self.operators[n].pending.iter().find(|p| late(p)) {
            let id = pending.id;
            self.operators[n]
                .station
                .handle_give_up(now, id, Failure::TimedOut);
            self.take_events(n);
            let has_ended = self.operators[n].pending.iter().all(|p| p.id != id);
            assert!(has_ended, "outlives its client: {}", self.context());
        }
    }

    /// Passes the bytes of a frame to the robot, and checks their effect.
    fn deliver(&mut self, frame: &[u8]) {
        for &byte in frame {
            let before = self.simulation.robot().ack();
            self.simulation.deliver_uplink(&[byte]);
            let stop = self.receiver.handle_byte(byte, ROBOT_ID, None);
            if matches!(stop, Some(Message::Stop(_))) {
                let sent = self.sent.get(&self.reached);
                self.stops.extend(sent.map(|sent| sent.process));
                let robot = self.simulation.robot();
                let is_obeyed = robot.mode() == Mode::Stop && robot.motion() == Motion::STILL;
                assert!(is_obeyed, "STOP is not obeyed: {}", self.context());
            }
            if byte == b'\n' {
                let reached = mem::take(&mut self.reached);
                self.check_effect(reached, before);
            } else {
                self.reached.push(byte);
            }
        }
    }

    /// Checks the change of the robot's acknowledgement after a frame. A station must have sent the frame in this session,
    /// unless it is a STOP.
    fn check_effect(&mut self, frame: Vec<u8>, before: Ack) {
        let after = self.simulation.robot().ack();
        if after == before {
            return;
        }
        let is_stop = frame.starts_with(b"X");
        let sent = self.sent.get(&frame).copied();
        let context = self.context();
        let sent = sent.unwrap_or_else(|| {
            panic!(
                "a frame that nobody sent: {}; {context}",
                frame.escape_ascii()
            )
        });
        assert!(
            is_stop || sent.at_ms >= self.session_ms,
            "a frame of an earlier session has an effect: {}; {context}",
            frame.escape_ascii()
        );
        if after.session != before.session {
            self.begin_session();
        } else if after.sequence != before.sequence && !is_stop {
            let content = &frame[..frame.len() - crc::CHARACTERS];
            let Some(Message::Command(command)) = Message::parse(content) else {
                panic!("no command: {}; {context}", frame.escape_ascii())
            };
            self.executions.push(Execution {
                process: sent.process,
                order: command.order,
                outcome: after.outcome,
                is_claimed: false,
            });
            assert!(self.taken.insert(frame), "executed twice: {context}");
        }
        self.look_at_route();
    }

    fn begin_session(&mut self) {
        self.session_ms = self.now_ms();
        self.taken.clear();
    }

    /// Checks that the robot's route is one of those commanded.
    fn look_at_route(&mut self) {
        let active = self.simulation.robot().lists().active();
        if active != self.route {
            assert!(
                self.routes.iter().any(|route| route == active),
                "a route that nobody ordered: {active:?}; {}",
                self.context()
            );
            self.route = active.to_vec();
        }
    }

    fn take_events(&mut self, n: usize) {
        let now = self.now();
        while let Some(event) = self.operators[n].station.poll_event() {
            let operator = &mut self.operators[n];
            match event {
                Event::Notice(notice) if notice.code == NoticeCode::SessionOpened => {
                    operator.progress_at = now;
                }
                Event::Command { id, status } => match status {
                    CommandStatus::Progress { .. } | CommandStatus::Reported(_) => {
                        operator.progress_at = now;
                    }
                    status if status.is_end() => {
                        let at = operator.pending.iter().position(|p| p.id == id);
                        let at = at.unwrap_or_else(|| panic!("ended twice: {}", self.context()));
                        let ended = self.operators[n].pending.remove(at);
                        if ended.request != Request::Stop {
                            self.operators[n].progress_at = now;
                        }
                        self.check_claim(self.operators[n].process, &ended, status);
                    }
                    _ => {}
                },
                _ => {}
            }
        }
    }

    /// Checks that the robot executed or refused a command after it was given, once for each command.
    fn check_claim(&mut self, process: u64, ended: &Pending, status: CommandStatus) {
        let outcome = match status {
            CommandStatus::Confirmed { .. } => Outcome::Done,
            CommandStatus::Refused(outcome) => outcome,
            _ => return,
        };
        let context = self.context();
        let is_confirmed = outcome == Outcome::Done;
        self.totals.confirmed += usize::from(is_confirmed);
        if ended.request == Request::Stop {
            self.totals.stops += 1;
            // The other operator may have ended its own STOP already.
            let is_true = self.stops[ended.stops_before..].contains(&process);
            assert!(is_true, "confirmed without its STOP: {ended:?}; {context}");
            return;
        }
        let robot = self.simulation.robot();
        if matches!(ended.request, Request::Mode(mode) if !robot.is_fitted(mode)) {
            // The station refuses by the robot's line I, with or without an order.
            assert_eq!(outcome, Outcome::NotFitted, "{ended:?}; {context}");
            return;
        }
        let is_route = matches!(ended.request, Request::Route(_));
        self.totals.routes += usize::from(is_confirmed && is_route);
        let later = &mut self.executions[ended.executions_before..];
        let execution = later.iter_mut().find(|execution| {
            !execution.is_claimed
                && execution.process == process
                && execution.outcome == outcome
                && is_order_of(execution.order, &ended.request)
        });
        let Some(execution) = execution else {
            panic!("{status:?} and not executed: {ended:?}; {context}")
        };
        execution.is_claimed = true;
    }
}

/// Whether a robot that has executed this order has executed this request.
fn is_order_of(order: Order, request: &Request) -> bool {
    let layers = |which, allowed| order == Order::Layers { which, allowed };
    match request {
        Request::Stop | Request::Own(_) => false,
        Request::Mode(mode) => order == Order::Mode(*mode),
        Request::Enable(mask) => layers(*mask, *mask),
        Request::Disable(mask) => layers(*mask, LayerMask::NONE),
        Request::Only(mask) => layers(LayerMask::ALL, *mask),
        Request::Route(route) => matches!(order, Order::Activate { count, digest: of, .. }
            if usize::from(count) == route.len() && of == digest(route.iter())),
        Request::Pose {
            position,
            theta_deg,
        } => {
            let (position, theta_deg) = (*position, *theta_deg);
            order
                == Order::Pose {
                    position,
                    theta_deg,
                }
        }
        Request::Scan => order == Order::Scan,
        Request::Failsafe(failsafe) => order == Order::Failsafe(*failsafe),
        Request::Parameter(tuning) => match tuning {
            Tuning::List => matches!(order, Order::ReadParameters { .. }),
            Tuning::Get(name) => {
                order
                    == Order::ReadParameter {
                        key: key(name.as_str()),
                    }
            }
            Tuning::Set(name, Amount::Counts(value)) => {
                let (key, value) = (key(name.as_str()), *value);
                order == Order::SetParameter { key, value }
            }
            Tuning::Set(_, Amount::Decimal { .. }) => matches!(order, Order::SetParameter { .. }),
            Tuning::Save => order == Order::KeepParameters,
        },
    }
}

#[test]
fn no_claim_is_false_and_no_route_is_mixed_on_a_hostile_link() {
    let mut totals = Totals::default();
    for (_, of_trial) in on_all_cores(seeds(SEEDS), |seed| Trial::new(seed).run()) {
        totals += of_trial;
    }
    println!("{totals:?}");
    // Trials in which nothing succeeds would show nothing.
    assert!(totals.confirmed > totals.commands / 4, "{totals:?}");
    assert!(totals.stops > 0 && totals.routes > 0, "{totals:?}");
    assert!(totals.refused_replays > 0, "{totals:?}");
}
