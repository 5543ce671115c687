//! A transcript of a robot at each level: the received frames and each line sent.
//!
//! The robot stands still, has the modes prowl and stop, the layers User and dead reckoning, lists of eight waypoints and no
//! parameters. Time is counted only in bytes; the uptime never advances.

use super::{describe, judge};
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::{Action, Farm};
use groundwave_protocol::command::{Command, Keepalive, Key, Message, Open, Order, Slots};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::parameter;
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{Arm, Bump, Cliff, Infrared, Layer, LayerMask, Link, Mode};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, AckLine, Body, CountersLine, Detail, Line, ListPlace, Outcome, StateLine,
    StatusLine, TextLine,
};
use serde_json::{Value, json};

const ROBOT_ID: u8 = 7;
const BOOTS: u16 = 12;
const CAPACITY: u16 = 8;
const OWNER: u16 = 677;

/// Number of lines A between two other lines, of lines between two lines B or T, and between two lines I.
const STATES_PER_OTHER: u8 = 5;
const APART: u8 = 3;
const INTRODUCTION_LINES: u8 = 48;

const LONG_LINES_ECHOED: u8 = 4;
const TURNS_A_LINE: u8 = 3;

/// The line after the current one.
#[derive(Clone, Copy, PartialEq)]
enum Next {
    Long,
    Acks(u8),
    GoAhead,
    Listen,
}

/// A robot at a level.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is what a rule of SPEC.md asks about"
)]
struct Robot {
    level: u8,
    is_half: bool,
    farm: Farm,
    receiver: Receiver,
    mode: Mode,
    allowed: LayerMask,
    failsafe: Option<Failsafe>,
    sequence: u8,
    boot_lines: u8,
    states: u8,
    is_after_state: bool,
    is_counters_turn: bool,
    is_status_due: bool,
    since_status: u8,
    since_text: u8,
    text: Option<&'static str>,
    is_introduction_due: bool,
    until_introduction: u8,
    echoes_due: u8,
    next: Next,
    turns: u8,
    rejected: u16,
}

fn fitted() -> LayerMask {
    LayerMask::NONE.with(Layer::User).with(Layer::DeadReckoning)
}

impl Robot {
    fn boot(level: u8, is_half: bool) -> Self {
        Self {
            level,
            is_half,
            farm: Farm::new(ROBOT_ID, BOOTS).with_capacity(CAPACITY),
            receiver: Receiver::default(),
            mode: Mode::Prowl,
            allowed: fitted(),
            failsafe: None,
            sequence: 99,
            boot_lines: level.saturating_sub(2).min(2),
            states: 0,
            is_after_state: level >= 3,
            is_counters_turn: true,
            is_status_due: false,
            since_status: APART,
            since_text: APART,
            text: None,
            is_introduction_due: false,
            until_introduction: 0,
            echoes_due: 0,
            next: Next::Long,
            turns: 0,
            rejected: 0,
        }
    }

    /// Takes bytes from the ground; returns the outcome of an order that the robot executes.
    fn hear(&mut self, bytes: &[u8]) -> Option<Outcome> {
        let mut outcome = None;
        for &byte in bytes {
            if byte == b'\n' && self.level >= 4 {
                self.echoes_due = LONG_LINES_ECHOED;
            }
            let key = self.farm.key();
            let Some(message) = self.receiver.handle_byte(byte, ROBOT_ID, key) else {
                continue;
            };
            outcome = self.take(message).or(outcome);
        }
        if self.next == Next::Listen {
            self.turns += 1;
            self.next = if self.turns < TURNS_A_LINE {
                Next::Acks(1)
            } else {
                Next::Long
            };
        }
        outcome
    }

    fn take(&mut self, message: Message) -> Option<Outcome> {
        let level = match &message {
            Message::Stop(_) | Message::Open(_) | Message::Command(_) => 2,
            Message::Waypoints(_) => 3,
            Message::Drive(_) | Message::Keepalive(_) => 4,
        };
        if level > self.level {
            self.rejected += 1;
            return None;
        }
        let message = match message {
            Message::Command(command) if command.order.level() > self.level => {
                Message::Command(Command {
                    order: Order::Unknown,
                    ..command
                })
            }
            message => message,
        };
        let before = self.farm.key();
        let action = self.farm.handle(&message);
        if matches!(message, Message::Open(_)) && self.farm.key() != before {
            self.is_introduction_due = true;
        }
        match action {
            Action::Stop => self.mode = Mode::Stop,
            Action::Execute(order) => {
                let outcome = self.execute(order);
                self.farm.conclude(outcome);
                return Some(outcome);
            }
            Action::ListReplaced => self.is_status_due = true,
            Action::Drive(_) | Action::Heard => {}
        }
        let is_list = matches!(
            message,
            Message::Command(Command {
                order: Order::Activate { .. },
                ..
            })
        );
        is_list.then(|| self.farm.ack().outcome)
    }

    fn execute(&mut self, order: Order) -> Outcome {
        let has = |mode| matches!(mode, Mode::Prowl | Mode::Stop);
        match order {
            Order::Mode(mode) if has(mode) => self.mode = mode,
            Order::Layers { which, allowed } if allowed.and(fitted()) == allowed => {
                let others = self.allowed.and(LayerMask::from_bits(!which.bits()));
                self.allowed = LayerMask::from_bits(others.bits() | allowed.bits());
                self.is_status_due = true;
            }
            Order::Failsafe(Some(failsafe)) if !failsafe.is_valid() => return Outcome::BadValue,
            Order::Failsafe(failsafe) if failsafe.is_none_or(|it| has(it.mode)) => {
                self.failsafe = failsafe;
            }
            Order::Mode(_) | Order::Layers { .. } | Order::Failsafe(_) | Order::Scan => {
                return Outcome::NotFitted;
            }
            Order::ReadParameters { place } if place > 0 => return Outcome::BadValue,
            Order::Pose { .. } | Order::ReadParameters { .. } | Order::KeepParameters => {}
            _ => return Outcome::Unknown,
        }
        Outcome::Done
    }

    /// The next line.
    fn send(&mut self) -> Vec<u8> {
        if self.next == Next::Listen {
            self.next = Next::Long;
        }
        let is_long = self.next == Next::Long;
        // The kind of a line is chosen before its number is counted.
        let body = is_long.then(|| self.choose());
        self.sequence = (self.sequence + 1) % 100;
        let ack = match self.level {
            1 => Ack {
                detail: Detail::CannotHear { robot_id: ROBOT_ID },
                ..Ack::default()
            },
            _ => self.farm.ack_in(self.sequence),
        };
        if let Some(body) = body {
            self.follow_long();
            let sequence = self.sequence;
            return Line {
                sequence,
                body,
                ack,
            }
            .encode()
            .to_vec();
        }
        let listens = self.next == Next::GoAhead;
        self.next = match self.next {
            Next::Acks(more) if more > 1 => Next::Acks(more - 1),
            Next::Acks(_) if self.is_half => Next::GoAhead,
            Next::GoAhead => Next::Listen,
            _ => Next::Long,
        };
        let line = AckLine {
            sequence: self.sequence,
            ack,
            listens,
        };
        line.encode().to_vec()
    }

    /// Decides which line follows a long line.
    fn follow_long(&mut self) {
        let is_talked_to = self.echoes_due > 0;
        self.echoes_due -= u8::from(is_talked_to);
        self.turns = 0;
        self.next = match (self.is_half, is_talked_to) {
            (true, true) => Next::Acks(1),
            (true, false) => Next::GoAhead,
            (false, true) => Next::Acks(3),
            (false, false) => Next::Long,
        };
    }

    fn choose(&mut self) -> Body {
        self.since_status = self.since_status.saturating_add(1);
        self.since_text = self.since_text.saturating_add(1);
        if self.level >= 2 {
            if self.until_introduction == 0 {
                self.is_introduction_due = true;
                self.until_introduction = INTRODUCTION_LINES;
            }
            self.until_introduction -= 1;
        }
        let body = self.other().unwrap_or_else(|| {
            self.states += 1;
            Body::State(self.state())
        });
        self.is_after_state = matches!(body, Body::State(_));
        body
    }

    fn other(&mut self) -> Option<Body> {
        if self.boot_lines > 0 {
            self.boot_lines -= 1;
            return Some(if self.boot_lines == 1 {
                Body::Counters(self.counters())
            } else {
                Body::Status(self.status())
            });
        }
        if !self.is_after_state {
            return None;
        }
        if self.level >= 3 && self.states >= STATES_PER_OTHER {
            let is_status = self.level == 3 || self.is_counters_turn;
            if !is_status || self.since_status >= APART {
                self.states = 0;
                self.is_counters_turn = !self.is_counters_turn;
                return Some(if is_status {
                    Body::Status(self.status())
                } else {
                    Body::Counters(self.counters())
                });
            }
        }
        if self.level >= 3 && self.is_status_due && self.since_status >= APART {
            return Some(Body::Status(self.status()));
        }
        if self.since_text >= APART
            && let Some(text) = self.text.take()
        {
            self.since_text = 0;
            return Some(Body::Text(TextLine::new(text)));
        }
        if std::mem::take(&mut self.is_introduction_due) {
            return Some(Body::Abilities(self.abilities()));
        }
        None
    }

    fn state(&self) -> StateLine {
        let is_armed = self.failsafe.is_some() && self.farm.is_open();
        StateLine {
            bump: Bump::NotFitted,
            infrared: Infrared::NotFitted,
            cliff: Cliff::NotFitted,
            arm: Arm::NotFitted,
            link: if is_armed { Link::Armed } else { Link::Ok },
            mode: self.mode,
            ..StateLine::BLANK
        }
    }

    fn status(&mut self) -> StatusLine {
        self.is_status_due = false;
        self.since_status = 0;
        let lists = self.farm.lists();
        StatusLine {
            robot_id: ROBOT_ID,
            battery_dv: 0,
            target_in: None,
            list: ListPlace {
                driven: 0,
                count: lists.active().len() as u16,
            },
            digest: lists.active_digest(),
            max_count: 0,
            photo_left: None,
            photo_right: None,
            fitted: fitted(),
            allowed: self.allowed,
            boots: BOOTS,
            odometer_resets: 0,
        }
    }

    fn counters(&self) -> CountersLine {
        let heard = self.receiver.counters();
        CountersLine {
            robot_id: ROBOT_ID,
            boots: BOOTS,
            frames_heard: heard.frames - self.rejected,
            frames_rejected: heard.rejected() + self.rejected,
            failsafe: self.failsafe,
            ..CountersLine::default()
        }
    }

    const fn abilities(&self) -> AbilitiesLine {
        AbilitiesLine {
            robot_id: ROBOT_ID,
            level: self.level,
            capacity: if self.level >= 3 { CAPACITY } else { 0 },
            modes: 0b1001,
            ..AbilitiesLine::FULL
        }
    }
}

/// Steps of a transcript.
struct Script {
    robot: Robot,
    steps: Vec<Value>,
    sequence: u8,
}

impl Script {
    fn boot(&mut self, about: &str, is_half: bool) {
        let level = self.robot.level;
        self.robot = Robot::boot(level, is_half);
        self.sequence = 0;
        self.steps.push(json!({
            "about": about,
            "boots": BOOTS,
            "robot_id": ROBOT_ID,
            "patience_bytes": if is_half { 16 } else { 0 },
        }));
    }

    /// Adds a number of lines sent by the robot.
    fn listen(&mut self, about: &str, lines: usize) {
        for _ in 0..lines {
            let line = self.robot.send();
            let mut decoder = Decoder::default();
            let received: Option<Received> = decoder.lines(&line).next();
            let fields = received.map(|received| describe::received(&received));
            let line = judge::text(&line);
            self.steps
                .push(json!({ "about": about, "line": line, "fields": fields }));
        }
    }

    fn say(&mut self, about: &str, message: &Message) {
        let key = if message.is_sessionless() {
            Key::robot(ROBOT_ID)
        } else {
            self.robot.farm.key().unwrap_or(Key::robot(ROBOT_ID))
        };
        let mut frame = message.encode(key).as_bytes().to_vec();
        if self.robot.next == Next::Listen {
            frame.extend(b"\n\n");
        }
        let outcome = self.robot.hear(&frame);
        let mut step = json!({ "about": about, "hears": judge::text(&frame) });
        if let Some(outcome) = outcome {
            step["outcome"] = Value::from(outcome as u8);
        }
        self.steps.push(step);
    }

    fn open(&mut self) {
        let ack = self.robot.farm.ack_in(1);
        let Detail::Era { era } = ack.detail else {
            unreachable!("every line 1 has the era")
        };
        let open = Open {
            boot: ack.boot,
            replaces: ack.session,
            owner: OWNER,
            era: Some(era),
        };
        self.say("a session is opened", &Message::Open(open));
        self.sequence = 0;
    }

    fn order(&mut self, about: &str, order: Order) {
        self.sequence += 1;
        let sequence = self.sequence;
        self.say(about, &Message::Command(Command { sequence, order }));
    }

    fn list(&mut self, about: &str, tag: u8, count: i16) {
        let list: Vec<_> = (0..count)
            .map(|n| Waypoint {
                x_in: 10 * n,
                y_in: -n,
            })
            .collect();
        for (block, waypoints) in (0..).zip(list.chunks(4)) {
            let slots = Slots::new(tag, block, waypoints);
            self.say(about, &Message::Waypoints(slots));
        }
        let order = Order::Activate {
            tag,
            count: list.len() as u16,
            digest: digest(list.iter()),
        };
        self.order(about, order);
    }
}

/// The transcript of a level.
pub fn level(level: u8) -> Vec<Value> {
    let mut script = Script {
        robot: Robot::boot(level, false),
        steps: Vec::new(),
        sequence: 0,
    };
    script.boot("the robot boots", false);
    if level == 1 {
        script.listen("lines A alone", 4);
        return script.steps;
    }
    script.listen("after boot, nothing is heard", 60);
    orders(&mut script);
    if level == 5 {
        script.boot("the robot boots in half duplex", true);
        script.listen("a line G after each long line", 7);
        while script.robot.next != Next::Listen {
            script.listen("until a turn", 1);
        }
        script.open();
        script.listen("a line K before the line G, while turns follow at once", 2);
        script.order("prowl, in the second turn", Order::Mode(Mode::Prowl));
        script.listen("the third turn at once", 2);
        script.order("stop, in the third turn", Order::Mode(Mode::Stop));
        script.listen("a long line after three turns", 10);
    }
    script.steps
}

/// Adds every order; most of them at every level.
fn orders(script: &mut Script) {
    let layers = |which, allowed| Order::Layers {
        which: LayerMask::from_bits(which),
        allowed: LayerMask::from_bits(allowed),
    };
    let failsafe = |silence_s, mode| Order::Failsafe(Some(Failsafe { silence_s, mode }));
    let key = parameter::key("top-speed");
    script.open();
    script.listen("the robot introduces itself", 3);
    script.order("stop by mode", Order::Mode(Mode::Stop));
    script.order("prowl", Order::Mode(Mode::Prowl));
    script.order("a mode that is not fitted", Order::Mode(Mode::Forage));
    script.listen("the outcome of the latest", 2);
    script.order("dead reckoning off", layers(0b1000_0000, 0));
    script.order("a layer that is not fitted", layers(0b11, 0b11));
    script.order(
        "not fitted in which alone",
        layers(0b1000_0010, 0b1000_0000),
    );
    script.listen("an extra line B from level 3 on", 4);
    script.list("two waypoints", 1, 2);
    script.listen("the list is active from level 3 on", 5);
    script.list("as many as it keeps", 2, 8);
    script.listen("likewise", 5);
    script.list("one more than it keeps", 3, 9);
    script.listen("the old list stays", 3);
    script.order("scan", Order::Scan);
    script.order(
        "a pose",
        Order::Pose {
            position: Waypoint { x_in: 12, y_in: 24 },
            theta_deg: 90,
        },
    );
    script.order("a failsafe too soon", failsafe(9, Mode::Forage));
    script.order("a failsafe without its mode", failsafe(30, Mode::GoHome));
    script.order("a failsafe", failsafe(30, Mode::Stop));
    script.listen("column 59 of line A", 2);
    script.say(
        "a keepalive",
        &Message::Keepalive(Keepalive {
            heard: script.robot.sequence,
        }),
    );
    script.order("an unknown parameter", Order::ReadParameter { key });
    script.order("likewise, set", Order::SetParameter { key, value: 1 });
    script.order(
        "a place beyond the table",
        Order::ReadParameters { place: 1 },
    );
    script.order("all of none", Order::ReadParameters { place: 0 });
    script.order("keep them", Order::KeepParameters);
    script.listen("the outcome of the latest", 14);
    script.say("STOP with a receipt", &Message::Stop(Some(OWNER << 5 | 1)));
    script.listen("the receipt, and in turn the era and the id", 7);
    script.say("STOP again", &Message::Stop(Some(OWNER << 5 | 2)));
    script.listen("likewise", 20);
}
