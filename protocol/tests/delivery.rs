//! Both ends of command delivery against each other over a wire that loses bits, in virtual time.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use groundwave_protocol::arq::{Action, Config, Farm, Fop, FopEvent, Loss, Task};
use groundwave_protocol::command::{Key, Message, Open, Order};
use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::letters::{
    Arm, Bump, Cliff, Drive, Infrared, LayerMask, Link, Mode, Power,
};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::telemetry::{
    AckLine, Body, CountersLine, FirmwareVersion, LayerStates, Line, Outcome, StateLine,
};
use groundwave_protocol::{Waypoint, digest::digest};

const US_PER_BYTE: u64 = 1_000_000 / 240;
const ROBOT_ID: u8 = 7;

/// A small generator, so that a seed means the same everywhere.
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn chance(&mut self, probability: f64) -> bool {
        ((self.next() >> 11) as f64 / (1_u64 << 53) as f64) < probability
    }

    /// Flips each data bit with this probability.
    fn spoil(&mut self, byte: u8, bit_error_rate: f64) -> u8 {
        (0..8).fold(byte, |byte, bit| {
            if self.chance(bit_error_rate) {
                byte ^ 1 << bit
            } else {
                byte
            }
        })
    }
}

/// The robot's end: a receiver, a FARM and a transmitter that never rests.
struct Robot {
    farm: Farm,
    receiver: Receiver,
    mode: Mode,
    executed: Vec<Order>,
    lists: Vec<u32>,
    line: Vec<u8>,
    sent: usize,
    sequence: u8,
    lines_with_ack: u32,
}

impl Robot {
    fn new(boots: u16) -> Self {
        Self {
            farm: Farm::new(ROBOT_ID, boots),
            receiver: Receiver::default(),
            mode: Mode::Prowl,
            executed: Vec::new(),
            lists: Vec::new(),
            line: Vec::new(),
            sent: 0,
            sequence: 0,
            lines_with_ack: 0,
        }
    }

    fn handle_byte(&mut self, byte: u8) {
        self.lines_with_ack = 4;
        let Some(message) = self.receiver.handle_byte(byte, ROBOT_ID, self.farm.key()) else {
            return;
        };
        match self.farm.handle(&message) {
            Action::Stop => self.mode = Mode::Stop,
            Action::Execute(order) => {
                self.executed.push(order);
                let outcome = match order {
                    Order::Mode(Mode::Forage) | Order::Scan => Outcome::NotFitted,
                    Order::Mode(mode) => {
                        self.mode = mode;
                        Outcome::Done
                    }
                    _ => Outcome::Done,
                };
                self.farm.conclude(outcome);
            }
            Action::ListReplaced => self.lists.push(self.farm.lists().active_digest()),
            Action::Drive(_) | Action::Heard => {}
        }
    }

    /// The next byte on the wire; acknowledgements are filled in when their column is due.
    fn next_byte(&mut self) -> u8 {
        if self.sent == self.line.len() {
            self.compose();
        }
        let long = self.line.len() == 80;
        if self.sent == if long { 69 } else { 3 } {
            let ack = self.farm.ack();
            let sequence = self.sequence_of_line();
            let whole = if long {
                let line: [u8; 80] = self.line.clone().try_into().unwrap();
                Line {
                    ack,
                    ..Line::parse(&line).unwrap()
                }
                .encode()
                .to_vec()
            } else {
                AckLine { sequence, ack }.encode().to_vec()
            };
            self.line = whole;
        }
        self.sent += 1;
        self.line[self.sent - 1]
    }

    fn sequence_of_line(&self) -> u8 {
        (self.line[1] - b'0') * 10 + self.line[2] - b'0'
    }

    fn compose(&mut self) {
        let was_long = self.line.len() == 80;
        self.sent = 0;
        let sequence = self.sequence;
        self.sequence = (self.sequence + 1) % 100;
        if was_long && self.lines_with_ack > 0 {
            self.lines_with_ack -= 1;
            self.line = AckLine {
                sequence,
                ack: self.farm.ack(),
            }
            .encode()
            .to_vec();
            return;
        }
        let body = if sequence.is_multiple_of(6) {
            Body::Counters(counters())
        } else {
            Body::State(state(self.mode))
        };
        self.line = Line {
            sequence,
            body,
            ack: self.farm.ack(),
        }
        .encode()
        .to_vec();
    }
}

fn counters() -> CountersLine {
    CountersLine {
        robot_id: ROBOT_ID,
        uptime_s: 0,
        boots: 1,
        version: FirmwareVersion::default(),
        ticks_won: [0; 9],
        frames_heard: 0,
        frames_rejected: 0,
        ticks_late: 0,
        bumps: 0,
    }
}

fn state(mode: Mode) -> StateLine {
    StateLine {
        x_tenths_in: 0,
        y_tenths_in: 0,
        theta_deg: 0,
        velocity_in_s: 0,
        rotation_in_s: 0,
        wheel_left_in_s: 0,
        wheel_right_in_s: 0,
        sonar_left_in: None,
        sonar_right_in: None,
        photo_left_pct: None,
        photo_right_pct: None,
        bump: Bump::None,
        infrared: Infrared::None,
        cliff: Cliff::NotFitted,
        arm: Arm::NotFitted,
        drive: Drive::Ok,
        power: Power::Ok,
        link: Link::Ok,
        mode,
        layers: LayerStates::OFF,
    }
}

/// Both ends and the wire between them, a byte time a step.
struct World {
    robot: Robot,
    fop: Fop,
    decoder: Decoder,
    uplink: std::collections::VecDeque<u8>,
    now_us: u64,
    dice: Dice,
    bit_error_rate: f64,
    deaf: bool,
    events: Vec<FopEvent>,
}

impl World {
    fn new(seed: u64, bit_error_rate: f64) -> Self {
        Self {
            robot: Robot::new(1),
            fop: Fop::new(Config::new(0x2A5)),
            decoder: Decoder::default(),
            uplink: std::collections::VecDeque::new(),
            now_us: 0,
            dice: Dice(seed),
            bit_error_rate,
            deaf: false,
            events: Vec::new(),
        }
    }

    fn step(&mut self) {
        self.now_us += US_PER_BYTE;
        if let Some(byte) = self.uplink.pop_front() {
            let byte = self.dice.spoil(byte, self.bit_error_rate);
            if !self.deaf {
                self.robot.handle_byte(byte);
            }
        }
        let byte = self.robot.next_byte();
        let byte = self.dice.spoil(byte, self.bit_error_rate);
        if let (_, Some(received)) = self.decoder.handle_bytes(&[byte]) {
            self.fop.handle_received(self.now_us, &received);
        }
        self.fop.handle_timeout(self.now_us);
        while let Some(chunk) = self.fop.poll_transmit(self.now_us) {
            let chunk = chunk.to_vec();
            self.uplink.extend(chunk);
            assert!(
                self.uplink.len() <= 17,
                "STOP must never wait behind more than this"
            );
        }
        while let Some(event) = self.fop.poll_event() {
            self.check(event);
            self.events.push(event);
        }
    }

    /// Whatever is claimed must be true at the robot at that moment.
    fn check(&self, event: FopEvent) {
        if let FopEvent::Concluded {
            outcome: Outcome::Done,
            digest: Some(digest),
        } = event
        {
            assert_eq!(self.robot.farm.lists().active_digest(), digest);
        }
    }

    fn run_until(&mut self, limit_s: u64, done: impl Fn(&FopEvent) -> bool) -> FopEvent {
        let limit_us = self.now_us + limit_s * 1_000_000;
        while self.now_us < limit_us {
            let seen = self.events.len();
            self.step();
            if let Some(event) = self.events[seen..].iter().find(|event| done(event)) {
                return *event;
            }
        }
        panic!(
            "nothing of the kind within {limit_s} s; events: {:?}",
            self.events
        );
    }

    fn finish(&mut self) -> FopEvent {
        self.run_until(600, |event| {
            matches!(event, FopEvent::Concluded { .. } | FopEvent::Failed(_))
        })
    }

    fn deliver(&mut self, task: Task<'_>) -> FopEvent {
        assert!(self.fop.start(self.now_us, task));
        self.finish()
    }
}

fn route(seed: u64, count: usize) -> Vec<Waypoint> {
    let mut dice = Dice(seed);
    let mut part = || (dice.next() % 19_999) as i16 - 9999;
    (0..count)
        .map(|_| Waypoint {
            x_in: part(),
            y_in: part(),
        })
        .collect()
}

const DONE: FopEvent = FopEvent::Concluded {
    outcome: Outcome::Done,
    digest: None,
};

#[test]
fn a_command_is_executed_once_and_proven() {
    for seed in 0..200 {
        for bit_error_rate in [0.0, 1e-3, 3e-3] {
            let mut world = World::new(seed, bit_error_rate);
            let order = Order::Mode(Mode::Reactive);
            assert_eq!(
                world.deliver(Task::Order(order)),
                DONE,
                "seed {seed}, ber {bit_error_rate}"
            );
            let layers = Order::Layers(LayerMask::from_bits(0x9A));
            assert_eq!(
                world.deliver(Task::Order(layers)),
                DONE,
                "seed {seed}, ber {bit_error_rate}"
            );
            assert_eq!(
                world.robot.executed,
                [order, layers],
                "seed {seed}, ber {bit_error_rate}"
            );
        }
    }
}

#[test]
fn a_list_arrives_whole_or_not_at_all() {
    for seed in 0..60 {
        for (count, bit_error_rate) in [
            (1, 0.0),
            (40, 0.0),
            (300, 1e-4),
            (40, 1e-3),
            (7, 3e-3),
            (100, 3e-3),
        ] {
            let mut world = World::new(seed, bit_error_rate);
            let list = route(seed, count);
            let event = world.deliver(Task::List(&list));
            let digest = Some(digest(list.iter()));
            let context = format!("seed {seed}, {count} waypoints, ber {bit_error_rate}");
            assert_eq!(
                event,
                FopEvent::Concluded {
                    outcome: Outcome::Done,
                    digest
                },
                "{context}"
            );
            assert_eq!(world.robot.farm.lists().active(), list, "{context}");
            assert_eq!(world.robot.lists.len(), 1, "{context}");
        }
    }
}

#[test]
fn an_empty_list_clears() {
    let mut world = World::new(1, 0.0);
    world.deliver(Task::List(&route(1, 5)));
    let event = world.deliver(Task::List(&[]));
    let digest = Some(digest([].iter()));
    assert_eq!(
        event,
        FopEvent::Concluded {
            outcome: Outcome::Done,
            digest
        }
    );
    assert_eq!(world.robot.farm.lists().active(), []);
}

#[test]
fn a_refusal_says_why_and_the_next_command_goes_through() {
    let mut world = World::new(1, 0.0);
    let refused = FopEvent::Concluded {
        outcome: Outcome::NotFitted,
        digest: None,
    };
    assert_eq!(world.deliver(Task::Order(Order::Scan)), refused);
    assert_eq!(world.deliver(Task::Order(Order::Mode(Mode::Prowl))), DONE);
}

#[test]
fn stop_interrupts_a_transfer_and_nothing_sent_before_it_runs_after_it() {
    for seed in 0..100 {
        let mut world = World::new(seed, if seed % 2 == 0 { 0.0 } else { 1e-3 });
        let list = route(seed, 100);
        assert!(world.fop.start(0, Task::List(&list)));
        for _ in 0..200 + seed * 3 {
            world.step();
        }
        let pressed_us = world.now_us;
        world.fop.stop(pressed_us);
        while world.robot.mode != Mode::Stop {
            world.step();
        }
        let heard_s = (world.now_us - pressed_us) as f64 / 1e6;
        assert!(seed % 2 == 1 || heard_s < 0.15, "seed {seed}: {heard_s} s");
        world.run_until(60, |event| *event == FopEvent::StopProven);
        assert!(
            world.events.contains(&FopEvent::Failed(Loss::Stopped)),
            "seed {seed}"
        );
        assert_eq!(world.robot.lists, [], "seed {seed}");
        assert_eq!(
            world.deliver(Task::Order(Order::Mode(Mode::Prowl))),
            DONE,
            "seed {seed}"
        );
        assert_eq!(world.robot.mode, Mode::Prowl, "seed {seed}");
    }
}

#[test]
fn a_restart_of_the_robot_is_noticed_and_the_old_list_claim_withdrawn() {
    let mut world = World::new(3, 0.0);
    let list = route(3, 100);
    assert!(world.fop.start(0, Task::List(&list)));
    for _ in 0..400 {
        world.step();
    }
    world.robot = Robot::new(2);
    assert_eq!(world.finish(), FopEvent::Failed(Loss::RobotRestarted));
    assert_eq!(
        world.deliver(Task::Order(Order::Mode(Mode::Reactive))),
        DONE
    );
}

#[test]
fn a_second_station_takes_over_and_the_first_admits_it() {
    let mut world = World::new(4, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
    let ack = world.robot.farm.ack();
    let open = Open {
        boot: ack.boot,
        replaces: ack.session,
        owner: 0x111,
    };
    for &byte in Message::Open(open).encode(Key::robot(ROBOT_ID)).as_bytes() {
        world.robot.handle_byte(byte);
    }
    world.run_until(5, |event| *event == FopEvent::Session(Err(Loss::TakenOver)));
}

#[test]
fn a_robot_that_hears_nothing_fails_the_task_and_the_late_command_never_runs() {
    let mut world = World::new(5, 0.0);
    world.deliver(Task::Order(Order::Mode(Mode::Reactive)));
    world.deaf = true;
    let lost = Order::Layers(LayerMask::NONE);
    assert_eq!(
        world.deliver(Task::Order(lost)),
        FopEvent::Failed(Loss::TimedOut)
    );
    world.deaf = false;
    assert_eq!(world.deliver(Task::Order(Order::Mode(Mode::Prowl))), DONE);
    assert!(!world.robot.executed.contains(&lost));
}

#[test]
fn nothing_is_sent_before_the_first_task() {
    let mut world = World::new(6, 0.0);
    for _ in 0..240 * 60 {
        world.step();
        assert!(world.uplink.is_empty());
    }
    assert_eq!(world.events, []);
}
