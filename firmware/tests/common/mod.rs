//! The robot on a bench in virtual time, with small motor models and a perfect radio.

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Drive, Keepalive, Key, Message, Open, Order, Slots};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::LayerMask;
use groundwave_protocol::telemetry::{Body, CountersLine, Line, StateLine, StatusLine};
use sr04_firmware::board::{Duplex, Identity, Inputs, Outputs};
use sr04_firmware::robot::Robot;

/// Number of every robot in these tests.
pub const ROBOT_ID: u8 = 7;
pub const BOOTS: u16 = 13;

/// A gear motor: a gain of 1.28 counts a second per 1/255 of pulse width, a time constant of 1/6 s, dry friction.
#[derive(Default)]
pub struct Motor {
    pub speed_cps: f64,
    position: f64,
    edges: u16,
    taken: f64,
}

impl Motor {
    /// Number of counts per second at full pulse width and 12 V without load.
    const FULL_CPS: f64 = 326.0;

    pub fn step_ms(&mut self, pwm: i16, battery_v: f64, load: f64) {
        let drive = f64::from(pwm) / 255.0 * (battery_v - 1.8) / 10.2 * Self::FULL_CPS;
        self.speed_cps += (drive - self.speed_cps) * 0.006;
        let brake = load * Self::FULL_CPS * 0.006;
        self.speed_cps -= self.speed_cps.clamp(-brake, brake);
        let before = self.position.floor();
        self.position += self.speed_cps / 1000.0;
        self.edges += (self.position.floor() - before).abs() as u16;
    }

    /// Signed number of counts that the motor has actually turned since the last call.
    pub fn take_way(&mut self) -> f64 {
        let way = self.position - self.taken;
        self.taken = self.position;
        way
    }

    pub fn take_edges(&mut self) -> u16 {
        std::mem::take(&mut self.edges)
    }
}

pub struct Bench {
    pub robot: Robot,
    pub inputs: Inputs,
    pub outputs: Outputs,
    pub left: Motor,
    pub right: Motor,
    /// Whether an obstacle reflects infrared on the left and on the right.
    pub reflects: (bool, bool),
    leds_on: bool,
    pub battery_v: f64,
    pub load: f64,
    pub now_ms: u32,
    pub decoder: Decoder,
    /// Long lines in order, each with the time of its last byte.
    pub lines: Vec<(u32, Line)>,
    pub ack_lines: usize,
    /// All bytes sent, without idle byte times.
    pub sent: Vec<u8>,
    pub idle: usize,
    /// The byte sent in each byte time.
    pub air: Vec<Option<u8>>,
    byte_time: u32,
    sequence: u8,
}

/// The command that allows exactly these layers.
pub fn only(allowed: LayerMask) -> Order {
    Order::Layers {
        which: LayerMask::ALL,
        allowed,
    }
}

impl Bench {
    pub fn new() -> Self {
        Self::with_duplex(Duplex::Full)
    }

    pub fn with_duplex(duplex: Duplex) -> Self {
        Self::with_identity(Identity::new(ROBOT_ID, BOOTS, 1, duplex))
    }

    pub fn with_identity(identity: Identity) -> Self {
        Self {
            robot: Robot::new(identity),
            inputs: Inputs {
                battery_dv: 124,
                ..Inputs::default()
            },
            outputs: Outputs::default(),
            left: Motor::default(),
            right: Motor::default(),
            reflects: (false, false),
            leds_on: false,
            battery_v: 12.0,
            load: 0.08,
            now_ms: 0,
            decoder: Decoder::default(),
            lines: Vec::new(),
            ack_lines: 0,
            sent: Vec::new(),
            idle: 0,
            air: Vec::new(),
            byte_time: 0,
            sequence: 0,
        }
    }

    pub fn run_ms(&mut self, time_ms: u32) {
        for _ in 0..time_ms {
            self.now_ms += 1;
            let (battery_v, load) = (self.battery_v, self.load);
            self.left.step_ms(self.outputs.pwm_left, battery_v, load);
            self.right.step_ms(self.outputs.pwm_right, battery_v, load);
            if self.now_ms.is_multiple_of(4) {
                let (left, right) = self.reflects;
                let lit = self.leds_on;
                self.leds_on = self.robot.infrared_sample(lit && left, lit && right);
            }
            if self.now_ms.is_multiple_of(50) {
                self.inputs.counts_left = self.left.take_edges();
                self.inputs.counts_right = self.right.take_edges();
                self.outputs = self.robot.tick(&self.inputs);
            }
            self.byte_time += 240;
            if self.byte_time >= 1000 {
                self.byte_time -= 1000;
                self.pass_byte();
            }
        }
    }

    pub fn run_ticks(&mut self, ticks: u32) {
        self.run_ms(ticks * 50);
    }

    fn pass_byte(&mut self) {
        let byte = self.robot.poll_downlink();
        self.air.push(byte);
        let Some(byte) = byte else {
            self.idle += 1;
            return;
        };
        self.sent.push(byte);
        match self.decoder.lines(&[byte]).next() {
            Some(Received::Line(line, _)) => self.lines.push((self.now_ms, line)),
            Some(Received::Ack(_)) => self.ack_lines += 1,
            None => {}
        }
    }

    /// Runs until the current line has ended and the next has begun.
    pub fn run_to_line_end(&mut self) {
        let count = self.lines.len();
        while self.lines.len() == count {
            self.run_ms(1);
        }
    }

    pub fn latest_sequence(&self) -> u8 {
        self.lines.last().expect("a line was received").1.sequence
    }

    pub fn states(&self) -> impl Iterator<Item = &StateLine> {
        self.lines.iter().filter_map(|(_, line)| match &line.body {
            Body::State(state) => Some(state),
            _ => None,
        })
    }

    pub fn latest_state(&self) -> StateLine {
        *self.states().last().expect("a line A was received")
    }

    /// Contents of the latest line B.
    pub fn latest_status(&self) -> StatusLine {
        let status = self
            .lines
            .iter()
            .rev()
            .find_map(|(_, line)| match line.body {
                Body::Status(status) => Some(status),
                _ => None,
            });
        status.expect("a line B was received")
    }

    /// Contents of the latest line C.
    pub fn latest_counters(&self) -> CountersLine {
        let counters = self
            .lines
            .iter()
            .rev()
            .find_map(|(_, line)| match line.body {
                Body::Counters(counters) => Some(counters),
                _ => None,
            });
        counters.expect("a line C was received")
    }

    /// Sends a frame at once.
    pub fn send(&mut self, message: &Message, key: Key) {
        for &byte in message.encode(key).as_bytes() {
            self.robot.handle_uplink(byte);
        }
    }

    pub fn session_key(&self, owner: u16) -> Key {
        let ack = self.robot.ack();
        Key::session(ROBOT_ID, ack.boot, ack.session, owner)
    }

    /// Opens a session and returns its key.
    pub fn open(&mut self, owner: u16) -> Key {
        let ack = self.robot.ack();
        let open = Open {
            boot: ack.boot,
            replaces: ack.session,
            owner,
            era: None,
        };
        self.send(&Message::Open(open), Key::robot(ROBOT_ID));
        self.sequence = 0;
        self.session_key(owner)
    }

    /// Sends the session's next command.
    pub fn order(&mut self, key: Key, order: Order) -> Message {
        self.sequence = (self.sequence + 1) % 64;
        let message = Message::Command(Command {
            sequence: self.sequence,
            order,
        });
        self.send(&message, key);
        message
    }
}

/// Owner of the session.
pub const OWNER: u16 = 345;

/// A robot that has been on for two seconds, with an open session.
pub fn running() -> (Bench, Key) {
    let mut bench = Bench::new();
    bench.run_ms(2000);
    let key = bench.open(OWNER);
    (bench, key)
}

/// Sends STOP to the robot.
pub fn stop(bench: &mut Bench) {
    bench.send(&Message::Stop(None), Key::robot(ROBOT_ID));
}

/// Sends a route and the command that activates it.
pub fn activate(bench: &mut Bench, key: Key, tag: u8, list: &[Waypoint]) {
    for (n, chunk) in list.chunks(16).enumerate() {
        let slots = Slots::new(tag, n as u8 * 4, chunk);
        bench.send(&Message::Waypoints(slots), key);
    }
    let order = Order::Activate {
        tag,
        count: list.len() as u16,
        digest: digest(list.iter()),
    };
    bench.order(key, order);
}

/// A drive frame that names the newest line.
pub fn drive(bench: &Bench, count: u8, velocity_in_s: i8, rotation_in_s: i8) -> Message {
    Message::Drive(Drive {
        velocity_in_s,
        rotation_in_s,
        heard: bench.lines.last().expect("a line was received").1.sequence,
        count,
    })
}

/// Sends a keepalive that names the newest line.
pub fn live(bench: &mut Bench, key: Key) {
    let heard = bench.lines.last().expect("a line was received").1.sequence;
    bench.send(&Message::Keepalive(Keepalive { heard }), key);
}

/// All texts of lines T.
pub fn texts(bench: &Bench) -> Vec<String> {
    let text = |body: &Body| match body {
        Body::Text(text) => Some(text.as_str().to_owned()),
        _ => None,
    };
    bench
        .lines
        .iter()
        .filter_map(|(_, line)| text(&line.body))
        .collect()
}
