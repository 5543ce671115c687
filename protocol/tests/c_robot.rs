//! Delivery to a robot with the C library (`protocol/c`), over a wire that flips bits, in virtual time.
//!
//! The robot is a process in lockstep with the test: each exchange takes a byte time.
#![cfg(unix)]

use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use crate::world::{DONE, Rng, STOPPED, US_PER_BYTE, Uart, failed, replaced, route};
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{CommandStatus, Config, Failure, Fop, FopEvent, Shortfall, Task};
use groundwave_protocol::command::Order;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::parameter;
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line, Outcome};

/// Time that a half-duplex robot waits for an answer, in byte times; 0 means full duplex.
const HALF_DUPLEX: u8 = 16;

/// The robot's program in C.
struct Robot {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
}

/// State of the robot, as its program reports it.
#[derive(Debug, PartialEq)]
struct State {
    mode: Option<Mode>,
    orders: u32,
    drives: u32,
    active_count: usize,
    active_digest: u32,
    reached: usize,
}

impl Robot {
    fn start(level: u8) -> Self {
        Self::at_rate(level, 240)
    }

    fn at_rate(level: u8, bytes_per_s: u32) -> Self {
        let mut process = Command::new(compiled(level, bytes_per_s))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the robot starts");
        Self {
            questions: process.stdin.take().expect("standard input is a pipe"),
            answers: BufReader::new(process.stdout.take().expect("standard output is a pipe")),
            process,
        }
    }

    fn ask(&mut self, question: &[u8]) {
        self.questions
            .write_all(question)
            .expect("the robot's program runs");
    }

    fn boot(&mut self, boots: u8, patience_bytes: u8) {
        self.ask(&[b'B', boots, patience_bytes]);
    }

    /// Advances by a byte time, with or without a byte from the ground; returns the byte that the robot sends.
    fn exchange(&mut self, heard: Option<u8>) -> Option<u8> {
        match heard {
            Some(byte) => self.ask(&[b'+', byte, b'-', b'\n']),
            None => self.ask(b"-\n"),
        }
        let mut answer = [0; 2];
        self.answers
            .read_exact(&mut answer)
            .expect("the robot's program runs");
        (answer[0] == b'+').then_some(answer[1])
    }

    fn state(&mut self) -> State {
        self.ask(b"?\n");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |n: usize| words[n].parse().expect("a number");
        State {
            mode: Mode::from_letter(words[0].as_bytes()[0]),
            orders: number(1),
            drives: number(2),
            active_count: number(3) as usize,
            active_digest: number(4),
            reached: number(5) as usize,
        }
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

fn library() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("c")
}

/// Compiles the robot at a level, under the name of the test's thread, because tests run at the same time.
fn compiled(level: u8, bytes_per_s: u32) -> PathBuf {
    let test = std::thread::current()
        .name()
        .unwrap_or("main")
        .replace("::", "-");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}-{level}"));
    let rate = format!("-DGW_RATE={bytes_per_s}");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let status = Command::new(&compiler)
        .args(["-std=c99", "-O1", &format!("-DGW_LEVEL={level}"), &rate])
        .arg(library().join("test/lockstep.c"))
        .arg(library().join("src/groundwave.c"))
        .args(["-lm", "-o"])
        .arg(&program)
        .status()
        .unwrap_or_else(|error| panic!("cannot start {compiler}: {error}"));
    assert!(status.success(), "{compiler} ended with {status}");
    program
}

/// Both ends and the wire between them.
struct World {
    robot: Robot,
    fop: Fop,
    decoder: Decoder,
    uplink: VecDeque<u8>,
    up: Uart,
    down: Uart,
    now_us: u64,
    rng: Rng,
    bit_error_rate: f64,
    events: Vec<FopEvent>,
    lines: Vec<Line>,
    /// Whether the station hears no line I.
    skips_abilities: bool,
}

impl World {
    fn new(level: u8, patience_bytes: u8) -> Self {
        let mut robot = Robot::start(level);
        robot.boot(1, patience_bytes);
        Self {
            robot,
            fop: Fop::new(Config::new(0x2A5)),
            decoder: Decoder::default(),
            uplink: VecDeque::new(),
            up: Uart::default(),
            down: Uart::default(),
            now_us: 0,
            rng: Rng(0),
            bit_error_rate: 0.0,
            events: Vec::new(),
            lines: Vec::new(),
            skips_abilities: false,
        }
    }

    /// A world whose robot and station have just started, as after `new`, but in the same process.
    fn begin(&mut self, seed: u64, bit_error_rate: f64, patience_bytes: u8) {
        self.robot.boot(1, patience_bytes);
        self.fop = Fop::new(Config::new(0x2A5));
        self.decoder = Decoder::default();
        self.uplink.clear();
        self.rng = Rng(seed);
        self.bit_error_rate = bit_error_rate;
        self.events.clear();
        self.lines.clear();
    }

    fn step(&mut self) {
        self.now_us += US_PER_BYTE;
        let sent = self.uplink.pop_front();
        let heard = self.up.pass(sent, &mut self.rng, self.bit_error_rate);
        let sent = self.robot.exchange(heard);
        if let Some(byte) = self.down.pass(sent, &mut self.rng, self.bit_error_rate) {
            self.fop.handle_carrier(self.now_us);
            let received = self.decoder.lines(&[byte]).next().filter(|received| {
                let is_abilities = matches!(received, Received::Line(line, _) if matches!(line.body, Body::Abilities(_)));
                !(is_abilities && self.skips_abilities)
            });
            if let Some(received) = received {
                if let Received::Line(line, _) = &received {
                    self.lines.push(*line);
                }
                self.fop.handle_received(self.now_us, &received);
            }
        }
        self.fop.handle_timeout(self.now_us);
        while let Some(chunk) = self.fop.poll_transmit(self.now_us) {
            self.uplink.extend(chunk);
        }
        while let Some(event) = self.fop.poll_event() {
            self.check(event);
            self.events.push(event);
        }
    }

    /// Checks that an event is true at the robot at that moment.
    fn check(&mut self, event: FopEvent) {
        if let FopEvent::Task(CommandStatus::Confirmed {
            digest: Some(digest),
        }) = event
        {
            assert_eq!(self.robot.state().active_digest, digest);
        }
        if event == STOPPED {
            assert_eq!(self.robot.state().mode, Some(Mode::Stop));
        }
    }

    fn run(&mut self, seconds: u64) {
        let end_us = self.now_us + seconds * 1_000_000;
        while self.now_us < end_us {
            self.step();
        }
    }

    fn run_until(&mut self, done: impl Fn(&FopEvent) -> bool) -> FopEvent {
        let limit_us = self.now_us + 300_000_000;
        while self.now_us < limit_us {
            let seen = self.events.len();
            self.step();
            if let Some(event) = self.events[seen..].iter().find(|event| done(event)) {
                return *event;
            }
        }
        panic!(
            "nothing of the kind within 300 s; events: {:?}",
            self.events
        );
    }

    fn finish(&mut self) -> FopEvent {
        self.run_until(|event| matches!(event, FopEvent::Task(status) if status.is_end()))
    }

    fn deliver(&mut self, task: Task<'_>) -> FopEvent {
        assert!(self.fop.start(self.now_us, task));
        self.finish()
    }

    fn stop(&mut self) -> FopEvent {
        self.fop.stop(self.now_us);
        self.run_until(|event| matches!(event, FopEvent::Stop(status) if status.is_end()))
    }

    /// The latest body that `pick` accepts.
    fn latest<T>(&self, pick: impl Fn(&Body) -> Option<T>) -> Option<T> {
        self.lines.iter().rev().find_map(|line| pick(&line.body))
    }
}

#[test]
fn commands_are_executed_once_and_confirmed_at_every_level_and_duplex() {
    for (level, patience_bytes) in [(2, 0), (3, 0), (4, 0), (5, 0), (5, HALF_DUPLEX)] {
        let mut world = World::new(level, patience_bytes);
        for seed in 0..12 {
            for bit_error_rate in [0.0, 1e-3, 2e-3] {
                let context = format!(
                    "level {level}, patience {patience_bytes}, seed {seed}, bit error rate {bit_error_rate}"
                );
                world.begin(seed, bit_error_rate, patience_bytes);
                let user = Task::Order(Order::Mode(Mode::User));
                assert_eq!(world.deliver(user), DONE, "{context}");
                let prowl = Task::Order(Order::Mode(Mode::Prowl));
                assert_eq!(world.deliver(prowl), DONE, "{context}");
                let state = world.robot.state();
                assert_eq!(
                    (state.mode, state.orders),
                    (Some(Mode::Prowl), 2),
                    "{context}"
                );
                assert_eq!(world.stop(), STOPPED, "{context}");
            }
        }
    }
}

#[test]
fn lists_arrive_whole_or_not_at_all_and_are_driven_to_the_end() {
    for patience_bytes in [0, HALF_DUPLEX] {
        let mut world = World::new(5, patience_bytes);
        for seed in 0..8 {
            for (count, bit_error_rate) in [(1, 0.0), (8, 1e-3), (40, 1e-3), (40, 2e-3)] {
                let context = format!(
                    "patience {patience_bytes}, seed {seed}, {count} waypoints, bit error rate {bit_error_rate}"
                );
                world.begin(seed, bit_error_rate, patience_bytes);
                let list = route(seed, count);
                let digest = digest(list.iter());
                assert_eq!(
                    world.deliver(Task::List(&list)),
                    replaced(digest),
                    "{context}"
                );
                assert_eq!(world.robot.state().active_count, count, "{context}");
            }
        }
        world.begin(1, 0.0, patience_bytes);
        let square = [(0, 20), (20, 20), (20, 0), (0, 0)];
        let square = square.map(|(x_in, y_in)| Waypoint { x_in, y_in });
        world.deliver(Task::List(&square));
        world.run(60);
        let driven = world.latest(|body| match body {
            Body::Status(status) => Some((status.list.driven, status.list.count)),
            _ => None,
        });
        assert_eq!(driven, Some((4, 4)));
    }
}

#[test]
fn a_list_beyond_the_capacity_is_refused_and_the_old_one_stays() {
    let mut world = World::new(3, 0);
    let old = route(1, 40);
    world.deliver(Task::List(&old));
    let long = route(2, 41);
    let beyond = Failure::BeyondCapacity(Shortfall { has: 40, needs: 41 });
    // The line I after the session's opening has reported the robot's capacity: nothing is sent.
    world.uplink.clear();
    assert_eq!(world.deliver(Task::List(&long)), failed(beyond));
    assert!(world.uplink.is_empty());
    // A station that has received no line I sends the list, and the robot refuses it.
    world.fop = Fop::new(Config::new(0x111));
    let end = world.deliver(Task::List(&long));
    assert_eq!(end, failed(beyond));
    assert_eq!(world.robot.state().active_digest, digest(old.iter()));
}

#[test]
fn a_robot_that_restarts_during_a_transfer_executes_nothing_of_it() {
    let mut world = World::new(5, 0);
    let list = route(3, 40);
    assert!(world.fop.start(0, Task::List(&list)));
    world.run_until(|event| matches!(event, FopEvent::Task(CommandStatus::Progress { .. })));
    world.robot.boot(2, 0);
    assert_eq!(world.finish(), failed(Failure::RobotRestarted));
    assert_eq!(world.robot.state().active_count, 0);
    assert_eq!(
        world.deliver(Task::List(&list)),
        replaced(digest(list.iter()))
    );
}

#[test]
fn a_station_that_restarts_takes_over() {
    for seed in 0..10 {
        let mut world = World::new(4, 0);
        world.begin(seed, 1e-3, 0);
        assert!(world.fop.start(0, Task::List(&route(seed, 40))));
        world.run_until(|event| matches!(event, FopEvent::Task(CommandStatus::Progress { .. })));
        world.fop = Fop::new(Config::new(0x111));
        let list = route(seed + 100, 17);
        let mut event = world.deliver(Task::List(&list));
        if event == failed(Failure::TimedOut) {
            // While a list is staged only lines B, C and I name the robot: all of 15 s may be damaged.
            event = world.deliver(Task::List(&list));
        }
        assert_eq!(event, replaced(digest(list.iter())), "seed {seed}");
    }
}

#[test]
fn hand_drive_ends_within_a_second_of_the_latest_frame() {
    for patience_bytes in [0, HALF_DUPLEX] {
        let mut world = World::new(5, patience_bytes);
        world.deliver(Task::Order(Order::Mode(Mode::User)));
        world
            .fop
            .drive(world.now_us, 8, 0, world.now_us + 1_500_000);
        world.run(1);
        let speed = |body: &Body| match body {
            Body::State(state) => Some(state.velocity_in_s),
            _ => None,
        };
        assert_eq!(world.latest(speed), Some(8));
        assert!(world.robot.state().drives > 2);
        // The station vanishes with its last frames.
        world.fop = Fop::new(Config::new(0x2A5));
        world.uplink.clear();
        world.run(2);
        assert_eq!(world.latest(speed), Some(0));
    }
}

#[test]
fn a_failsafe_acts_after_its_silence_and_ends_by_a_command() {
    let mut world = World::new(4, 0);
    let failsafe = groundwave_protocol::failsafe::Failsafe {
        silence_s: 10,
        mode: Mode::GoHome,
    };
    assert_eq!(
        world.deliver(Task::Order(Order::Failsafe(Some(failsafe)))),
        DONE
    );
    // Keepalives hold it off.
    world.run(15);
    assert_eq!(world.robot.state().mode, Some(Mode::Prowl));
    world.fop = Fop::new(Config::new(0x111));
    world.run(9);
    assert_eq!(world.robot.state().mode, Some(Mode::Prowl));
    world.run(2);
    assert_eq!(world.robot.state().mode, Some(Mode::GoHome));
    assert_eq!(world.deliver(Task::Order(Order::Mode(Mode::Prowl))), DONE);
    assert_eq!(world.robot.state().mode, Some(Mode::Prowl));
}

#[test]
fn a_parameter_is_set_within_its_limits_and_reported() {
    let mut world = World::new(5, 0);
    let key = parameter::key("top-speed");
    let set = |value| Task::Order(Order::SetParameter { key, value });
    assert_eq!(world.deliver(set(8)), DONE);
    world.run(3);
    let value = |body: &Body| match body {
        Body::Parameter(line) if line.name.as_str() == "top-speed" => Some(line.value),
        _ => None,
    };
    assert_eq!(world.latest(value), Some(8));
    let refused = |outcome| FopEvent::Task(CommandStatus::Refused(outcome));
    assert_eq!(world.deliver(set(13)), refused(Outcome::BadValue));
    world.lines.clear();
    world.run(3);
    assert_eq!(world.latest(value), Some(8));
    let unknown = Order::ReadParameter { key: 1 };
    assert_eq!(
        world.deliver(Task::Order(unknown)),
        refused(Outcome::Unknown)
    );
}

#[test]
fn orders_beyond_the_level_or_the_body_are_refused() {
    let layers = |bits| Order::Layers {
        which: LayerMask::ALL,
        allowed: LayerMask::from_bits(bits),
    };
    for (level, order, outcome) in [
        (2, Order::Scan, Outcome::Unknown),
        (2, Order::Mode(Mode::Forage), Outcome::NotFitted),
        (2, layers(0b10), Outcome::NotFitted),
        (3, Order::KeepParameters, Outcome::Unknown),
        (4, Order::KeepParameters, Outcome::Unknown),
        (4, Order::Scan, Outcome::NotFitted),
    ] {
        let mut world = World::new(level, 0);
        let refused = FopEvent::Task(CommandStatus::Refused(outcome));
        let beyond = failed(Failure::BeyondLevel(Shortfall {
            has: level.into(),
            needs: order.level().into(),
        }));
        let is_beyond = order.level() > level;
        // From level 4 on, lines K answer before line I; the refusal waits for it.
        let event = world.deliver(Task::Order(order));
        let wanted = if is_beyond { beyond } else { refused };
        assert_eq!(event, wanted, "level {level}, {order:?}");
        world.run(5);
        let sent = world.uplink.len();
        assert!(world.fop.start(world.now_us, Task::Order(order)));
        if is_beyond {
            world.fop.handle_timeout(world.now_us);
            assert_eq!(
                world.fop.poll_event(),
                Some(beyond),
                "level {level}, {order:?}"
            );
            assert_eq!(world.uplink.len(), sent);
        } else {
            assert_eq!(world.finish(), refused, "level {level}, {order:?}");
        }
        assert_eq!(world.deliver(Task::Order(layers(0b1001_0001))), DONE);
    }
}

/// A refused order waits for the robot's first line I; STOP and a robot that sends none end the wait.
#[test]
fn a_refusal_waits_for_the_first_line_of_abilities() {
    let refused = FopEvent::Task(CommandStatus::Refused(Outcome::Unknown));
    let wait_us = |world: &mut World| {
        let sent = world.now_us;
        assert!(world.fop.start(sent, Task::Order(Order::KeepParameters)));
        world.skips_abilities = true;
        world.run(2);
        assert!(world.fop.is_busy());
        assert!(!world.fop.start(sent, Task::Order(Order::Scan)));
        sent
    };

    let mut world = World::new(4, 0);
    let sent = wait_us(&mut world);
    assert_eq!(world.finish(), refused);
    assert!(world.now_us - sent < 10_000_000, "{}", world.now_us - sent);

    let mut world = World::new(4, 0);
    wait_us(&mut world);
    assert_eq!(world.stop(), STOPPED);
    assert!(world.events.contains(&refused), "{:?}", world.events);
}

/// Above 2400 baud the robot pauses, also between lines K.
#[test]
fn a_faster_robot_begins_at_most_twelve_lines_a_second() {
    const BYTES_PER_S: u32 = 11_520;
    for level in 2..=5 {
        let mut robot = Robot::at_rate(level, BYTES_PER_S);
        robot.boot(1, 0);
        let mut lines = 0;
        for n in 0..2 * BYTES_PER_S {
            let knock = (n % 1000 == 0).then_some(b'\n');
            lines += u32::from(robot.exchange(knock) == Some(b'\n'));
        }
        assert!((22..=24).contains(&lines), "level {level}: {lines} in 2 s");
    }
}

/// A station with a robot that cannot hear: nothing is sent, and every task fails at once.
#[test]
fn a_robot_that_cannot_hear_is_sent_nothing() {
    let line = Line {
        sequence: 0,
        body: Body::Text(groundwave_protocol::telemetry::TextLine::new("level 1")),
        ack: Ack {
            detail: Detail::CannotHear { robot_id: 7 },
            ..Ack::default()
        },
    };
    let mut fop = Fop::new(Config::new(0x2A5));
    let mut decoder = Decoder::default();
    for received in decoder.lines(&line.encode()) {
        fop.handle_received(1_000_000, &received);
    }
    let list = route(1, 3);
    for task in [Task::Order(Order::Scan), Task::List(&list)] {
        assert!(fop.start(2_000_000, task));
        assert_eq!(fop.poll_timeout(), Some(0));
        assert_eq!(fop.poll_transmit(2_000_000), None);
        fop.handle_timeout(2_000_000);
        assert_eq!(fop.poll_event(), Some(failed(Failure::CannotHear)));
    }
    fop.stop(2_000_000);
    fop.handle_timeout(2_000_000);
    let refused = FopEvent::Stop(CommandStatus::Failed(Failure::CannotHear));
    assert_eq!(fop.poll_event(), Some(refused));
    assert_eq!(fop.poll_transmit(2_000_000), None);
    assert_eq!(fop.poll_timeout(), None);
}
