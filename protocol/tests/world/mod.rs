//! Both ends of delivery and the wire between them, in virtual time, in steps of a byte time.
#![allow(clippy::unwrap_used, reason = "a test stops where something is wrong")]

use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Action, CommandStatus, Config, Failure, Farm, Fop, FopEvent, Task};
use groundwave_protocol::command::{Key, Message, Order};
use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{Link, Mode};
use groundwave_protocol::telemetry::{AckLine, Body, CountersLine, Line, Outcome, StateLine};

pub const US_PER_BYTE: u64 = 1_000_000 / 240;
pub const ROBOT_ID: u8 = 7;

/// A small generator of random numbers, the same on every platform.
pub struct Rng(pub u64);

impl Rng {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn chance(&mut self, probability: f64) -> bool {
        ((self.next() >> 11) as f64 / (1_u64 << 53) as f64) < probability
    }
}

/// The receiver of a UART behind a wire that flips bits, start and stop bits included.
#[derive(Default)]
pub struct Uart {
    /// Received data bits and their number; `None` while it waits for a start bit.
    data: Option<(u8, u8)>,
    /// Whether a stop bit was wrong, so that the wire must be idle before the next start bit.
    broken: bool,
}

impl Uart {
    /// Passes one byte time, with a byte or an idle wire; returns the byte that the receiver reads.
    pub fn pass(&mut self, sent: Option<u8>, rng: &mut Rng, bit_error_rate: f64) -> Option<u8> {
        let mut received = None;
        for n in 0..10 {
            let bit = match (sent, n) {
                (Some(_), 0) => false,
                (Some(byte), 1..=8) => byte >> (n - 1) & 1 == 1,
                _ => true,
            };
            received = self.sample(bit ^ rng.chance(bit_error_rate)).or(received);
        }
        received
    }

    fn sample(&mut self, bit: bool) -> Option<u8> {
        match self.data {
            None if bit => self.broken = false,
            None if self.broken => {}
            None => self.data = Some((0, 0)),
            Some((data, 8)) => {
                self.data = None;
                self.broken = !bit;
                return bit.then_some(data);
            }
            Some((data, count)) => self.data = Some((data >> 1 | u8::from(bit) << 7, count + 1)),
        }
        None
    }
}

/// The robot's end: receiver, FARM and a transmitter that sends without a pause.
pub struct Robot {
    pub farm: Farm,
    pub receiver: Receiver,
    pub mode: Mode,
    pub executed: Vec<Order>,
    pub lists: Vec<u32>,
    /// Number of drive frames executed.
    pub drives: u32,
    /// Failsafe fields of lines A and C.
    pub link: Link,
    pub failsafe: Option<Failsafe>,
    pub line: Vec<u8>,
    pub sent: usize,
    pub sequence: u8,
    pub lines_with_ack: u32,
    pub ks: u32,
    /// Number of intact messages to lose.
    pub deaf_to: fn(&Message) -> bool,
}

impl Robot {
    pub fn new(boots: u16) -> Self {
        Self {
            farm: Farm::new(ROBOT_ID, boots),
            receiver: Receiver::default(),
            mode: Mode::Prowl,
            executed: Vec::new(),
            lists: Vec::new(),
            drives: 0,
            link: Link::Ok,
            failsafe: None,
            line: Vec::new(),
            sent: 0,
            sequence: 0,
            lines_with_ack: 0,
            ks: 0,
            deaf_to: |_| false,
        }
    }

    pub fn handle_byte(&mut self, byte: u8) {
        self.lines_with_ack = 4;
        let Some(message) = self.receiver.handle_byte(byte, ROBOT_ID, self.farm.key()) else {
            return;
        };
        if (self.deaf_to)(&message) {
            return;
        }
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
            Action::Drive(drive) => {
                self.farm.take_drive(&drive);
                self.drives += 1;
            }
            Action::Heard => {}
        }
    }

    /// Receives a frame of another station.
    pub fn hear(&mut self, message: &Message, key: Key) {
        for &byte in message.encode(key).as_bytes() {
            self.handle_byte(byte);
        }
    }

    /// The next byte on the wire; the acknowledgement is read when its column is due.
    pub fn next_byte(&mut self) -> u8 {
        if self.sent == self.line.len() {
            self.compose();
        }
        let long = self.line.len() == 80;
        if self.sent == if long { 69 } else { 3 } {
            let sequence = self.sequence_of_line();
            let ack = self.farm.ack_in(sequence);
            let whole = if long {
                let line: [u8; 80] = self.line.clone().try_into().unwrap();
                Line {
                    ack,
                    ..Line::parse(&line).unwrap()
                }
                .encode()
                .to_vec()
            } else {
                AckLine {
                    sequence,
                    ack,
                    listens: false,
                }
                .encode()
                .to_vec()
            };
            self.line = whole;
        }
        self.sent += 1;
        self.line[self.sent - 1]
    }

    pub fn sequence_of_line(&self) -> u8 {
        (self.line[1] - b'0') * 10 + self.line[2] - b'0'
    }

    pub fn compose(&mut self) {
        let was_long = self.line.len() == 80;
        self.sent = 0;
        let sequence = self.sequence;
        self.sequence = (self.sequence + 1) % 100;
        if (was_long || self.ks > 0) && self.lines_with_ack > 0 {
            if was_long {
                self.ks = 3;
                self.lines_with_ack -= 1;
            }
            self.ks -= 1;
            self.line = AckLine {
                sequence,
                ack: self.farm.ack(),
                listens: false,
            }
            .encode()
            .to_vec();
            return;
        }
        let body = if sequence.is_multiple_of(6) {
            Body::Counters(CountersLine {
                failsafe: self.failsafe,
                ..counters()
            })
        } else {
            Body::State(StateLine {
                link: self.link,
                mode: self.mode,
                ..StateLine::BLANK
            })
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

pub fn counters() -> CountersLine {
    CountersLine {
        robot_id: ROBOT_ID,
        boots: 1,
        ..CountersLine::default()
    }
}

/// Both ends and the wire between them.
pub struct World {
    pub robot: Robot,
    pub fop: Fop,
    pub decoder: Decoder,
    /// Bytes that the station sent, for the test to take.
    pub sent: Vec<u8>,
    pub uplink: std::collections::VecDeque<u8>,
    pub up: Uart,
    pub down: Uart,
    /// Delay of each byte on the downlink.
    pub down_delay_us: u64,
    pub under_way: std::collections::VecDeque<(u64, u8)>,
    pub now_us: u64,
    pub rng: Rng,
    pub bit_error_rate: f64,
    pub deaf: bool,
    pub events: Vec<FopEvent>,
}

impl World {
    pub fn new(seed: u64, bit_error_rate: f64) -> Self {
        Self {
            robot: Robot::new(1),
            fop: Fop::new(Config::new(0x2A5)),
            decoder: Decoder::default(),
            sent: Vec::new(),
            uplink: std::collections::VecDeque::new(),
            up: Uart::default(),
            down: Uart::default(),
            down_delay_us: 0,
            under_way: std::collections::VecDeque::new(),
            now_us: 0,
            rng: Rng(seed),
            bit_error_rate,
            deaf: false,
            events: Vec::new(),
        }
    }

    pub fn step(&mut self) {
        self.now_us += US_PER_BYTE;
        let sent = self.uplink.pop_front();
        let heard = self.up.pass(sent, &mut self.rng, self.bit_error_rate);
        if let Some(byte) = heard.filter(|_| !self.deaf) {
            self.robot.handle_byte(byte);
        }
        let sent = self.robot.next_byte();
        let heard = self
            .down
            .pass(Some(sent), &mut self.rng, self.bit_error_rate);
        if let Some(byte) = heard {
            self.under_way
                .push_back((self.now_us + self.down_delay_us, byte));
        }
        if let Some((due_us, byte)) = self.under_way.front().copied()
            && due_us <= self.now_us
            && self.under_way.pop_front().is_some()
            && let Some(received) = self.decoder.lines(&[byte]).next()
        {
            self.fop.handle_received(self.now_us, &received);
        }
        self.fop.handle_timeout(self.now_us);
        while let Some(chunk) = self.fop.poll_transmit(self.now_us) {
            let chunk = chunk.to_vec();
            self.sent.extend(&chunk);
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

    /// Checks that an event is true at the robot at that moment.
    pub fn check(&self, event: FopEvent) {
        if let FopEvent::Task(CommandStatus::Confirmed {
            digest: Some(digest),
        }) = event
        {
            assert_eq!(self.robot.farm.lists().active_digest(), digest);
        }
        if event == STOPPED {
            assert_eq!(self.robot.mode, Mode::Stop);
        }
    }

    pub fn run_until(&mut self, limit_s: u64, done: impl Fn(&FopEvent) -> bool) -> FopEvent {
        let limit_us = self.now_us + limit_s * 1_000_000;
        while self.now_us < limit_us {
            let seen = self.events.len();
            self.step();
            if let Some(event) = self.events[seen..].iter().find(|event| done(event)) {
                return *event;
            }
        }
        panic!(
            "nothing of the kind within {limit_s} s; latest events: {:?}",
            self.events.iter().rev().take(8).collect::<Vec<_>>()
        );
    }

    pub fn finish(&mut self) -> FopEvent {
        self.run_until(
            600,
            |event| matches!(event, FopEvent::Task(status) if status.is_end()),
        )
    }

    pub fn deliver(&mut self, task: Task<'_>) -> FopEvent {
        assert!(self.fop.start(self.now_us, task));
        self.finish()
    }
}

pub fn route(seed: u64, count: usize) -> Vec<Waypoint> {
    let mut rng = Rng(seed);
    let mut part = || (rng.next() % 19_999) as i16 - 9999;
    (0..count)
        .map(|_| Waypoint {
            x_in: part(),
            y_in: part(),
        })
        .collect()
}

pub const DONE: FopEvent = FopEvent::Task(CommandStatus::Confirmed { digest: None });
pub const STOPPED: FopEvent = FopEvent::Stop(CommandStatus::Confirmed { digest: None });

pub const fn replaced(digest: u32) -> FopEvent {
    FopEvent::Task(CommandStatus::Confirmed {
        digest: Some(digest),
    })
}

pub const fn failed(failure: Failure) -> FopEvent {
    FopEvent::Task(CommandStatus::Failed(failure))
}
