//! Vectors of a conversation: frames, and the robot's acknowledgements.

use super::{describe, judge};
use groundwave_protocol::arq::{Action, Farm};
use groundwave_protocol::command::{Command, Drive, Keepalive, Key, Message, Open, Order, Slots};
use groundwave_protocol::receiver::Receiver;
use groundwave_protocol::status_codes::{LayerMask, Mode};
use groundwave_protocol::telemetry::Outcome;
use groundwave_protocol::{Waypoint, digest::digest};
use serde_json::{Value, json};

pub const ROBOT_ID: u8 = 7;

/// The robot's receiver in the conversation.
pub struct Robot {
    farm: Farm,
    receiver: Receiver,
}

impl Robot {
    pub fn boot(boots: u16) -> Self {
        Self {
            farm: Farm::new(ROBOT_ID, boots),
            receiver: Receiver::default(),
        }
    }

    pub fn key(&self) -> Option<Key> {
        self.farm.key()
    }

    /// Passes a frame to the robot; returns message, action and acknowledgement. Orders other than activations end with
    /// `outcome`.
    pub fn hear(&mut self, frame: &[u8], outcome: Outcome) -> Value {
        let mut message = None;
        for &byte in frame {
            let key = self.farm.key();
            message = self.receiver.handle_byte(byte, ROBOT_ID, key).or(message);
        }
        let action = message.map(|message| self.farm.handle(&message));
        let name = match action {
            None => "not heard",
            Some(Action::Stop) => "stop",
            Some(Action::Execute(_)) => "execute",
            Some(Action::ListReplaced) => "list replaced",
            Some(Action::Drive(drive)) => {
                self.farm.take_drive(&drive);
                "drive"
            }
            Some(Action::Heard) => "nothing",
        };
        let mut step = json!({
            "frame": judge::text(frame),
            "message": message.map(|message| describe::message(&message)),
            "action": name,
        });
        if name == "execute" {
            self.farm.conclude(outcome);
            step["outcome"] = Value::from(outcome as u8);
        }
        self.acknowledge(step)
    }

    /// Adds the acknowledgement and the active list.
    pub fn acknowledge(&self, mut step: Value) -> Value {
        let ack = self.farm.ack();
        step["ack"] = describe::ack(ack);
        step["ack_characters"] = Value::from(judge::text(&ack.encode()));
        let lists = self.farm.lists();
        step["active_count"] = Value::from(lists.active().len());
        step["active_digest"] = Value::from(lists.active_digest());
        step
    }
}

struct Script {
    robot: Robot,
    steps: Vec<Value>,
    /// The key of the session that the station has opened.
    key: Key,
}

impl Script {
    fn boot(&mut self, about: &str, boots: u16) {
        self.robot = Robot::boot(boots);
        let step = json!({ "about": about, "robot_id": ROBOT_ID, "boots": boots });
        self.steps.push(self.robot.acknowledge(step));
    }

    fn say_with(&mut self, about: &str, message: Message, outcome: Outcome) {
        let key = if message.is_sessionless() {
            Key::robot(ROBOT_ID)
        } else {
            self.key
        };
        let mut step = self.robot.hear(message.encode(key).as_bytes(), outcome);
        step["about"] = Value::from(about);
        self.steps.push(step);
    }

    fn say(&mut self, about: &str, message: Message) {
        self.say_with(about, message, Outcome::Done);
    }

    fn order(&mut self, about: &str, sequence: u8, order: Order, outcome: Outcome) {
        self.say_with(
            about,
            Message::Command(Command { sequence, order }),
            outcome,
        );
    }

    fn activate(&mut self, about: &str, sequence: u8, tag: u8, list: &[Waypoint], digest: u32) {
        let order = Order::Activate {
            tag,
            count: list.len() as u16,
            digest,
        };
        self.order(about, sequence, order, Outcome::Done);
    }

    fn open(&mut self, about: &str, boot: u8, replaces: u8, owner: u16) {
        self.open_in(about, boot, replaces, owner, None);
    }

    fn open_in(&mut self, about: &str, boot: u8, replaces: u8, owner: u16, era: Option<u16>) {
        let open = Open {
            boot,
            replaces,
            owner,
            era,
        };
        self.say(about, Message::Open(open));
        self.key = self.robot.key().unwrap_or(self.key);
    }
}

/// The whole conversation, beginning with the first boot.
pub fn conversation() -> Vec<Value> {
    let mut script = Script {
        robot: Robot::boot(9),
        steps: Vec::new(),
        key: Key::session(ROBOT_ID, 1, 1, 0x2A5),
    };
    script.boot("the robot boots for the ninth time", 9);
    commands(&mut script);
    lists(&mut script);
    stop_and_takeover(&mut script);
    reboot(&mut script);
    drive_counts(&mut script);
    sequences(&mut script);
    tags_and_windows(&mut script);
    longest_list(&mut script);
    short_blocks(&mut script);
    script.steps
}

/// A second conversation, about receipts and eras.
pub fn sessions() -> Vec<Value> {
    let mut script = Script {
        robot: Robot::boot(1),
        steps: Vec::new(),
        key: Key::session(ROBOT_ID, 1, 1, 0x2A5),
    };
    script.boot("the robot boots for the first time", 1);
    receipts(&mut script);
    eras(&mut script);
    script.steps
}

fn eras(s: &mut Script) {
    let reactive = Order::Mode(Mode::Reactive);
    s.open_in("a request for another era", 2, 0, 0x2A5, Some(1));
    s.open_in("the first session", 2, 0, 0x2A5, Some(0));
    s.order("its command", 1, reactive, Outcome::Done);
    for replaces in 1..7 {
        let about = format!("session {}", replaces + 1);
        s.open_in(&about, 2, replaces, 0x2A5, Some(0));
    }
    s.open_in("a new era begins after session 7", 2, 7, 0x2A5, Some(0));
    let key = std::mem::replace(&mut s.key, Key::session(ROBOT_ID, 2, 1, 0x2A5));
    s.order("the command of the era before", 1, reactive, Outcome::Done);
    s.key = key;
    s.order("a command", 1, reactive, Outcome::Done);
    s.open_in("the request of the era before", 2, 1, 0x2A5, Some(0));
    s.open("a session without an era", 2, 1, 0x2A5);
    s.order("has a key without one", 1, reactive, Outcome::Done);
    s.boot("the eras of the eighth boot begin at 1021", 8);
    s.open_in("so era 0 has passed", 0, 0, 0x2A5, Some(0));
    s.open_in("and this is the first", 0, 0, 0x2A5, Some(1021));
    s.order("its command", 1, reactive, Outcome::Done);
}

fn receipts(s: &mut Script) {
    let stop = |receipt| Message::Stop(Some(receipt));
    s.say("STOP without a session", stop(0x54A1));
    s.say("the same STOP again counts again", stop(0x54A1));
    s.open("a session has no receipt", 1, 0, 0x2A5);
    s.say("STOP ends it", stop(0x54A2));
    s.say("the STOP of another station", stop(0x2221));
    s.say("STOP without a receipt", Message::Stop(None));
    s.say("the greatest receipt", stop(0x7FFF));
    s.boot("the robot boots again: no receipt", 2);
}

fn commands(s: &mut Script) {
    let reactive = Order::Mode(Mode::Reactive);
    let layers = Order::Layers {
        which: LayerMask::ALL,
        allowed: LayerMask::from_bits(0b1001_0010),
    };
    s.order("a command without a session", 1, reactive, Outcome::Done);
    s.open("a request for another boot", 2, 0, 0x2A5);
    s.open(
        "a request to replace a session that is not there",
        1,
        1,
        0x2A5,
    );
    s.open("the first session", 1, 0, 0x2A5);
    s.open("its request repeated", 1, 0, 0x2A5);
    s.order("the first command", 1, reactive, Outcome::Done);
    s.order(
        "repeated, it has no second effect",
        1,
        reactive,
        Outcome::Done,
    );
    s.order("refused: not fitted", 2, Order::Scan, Outcome::NotFitted);
    s.order("one is missing in between", 4, layers, Outcome::Done);
    s.order("the missing one", 3, layers, Outcome::Done);
    s.order(
        "an unreadable order is refused as unknown",
        4,
        Order::Unknown,
        Outcome::Unknown,
    );
    s.say("hand drive", drive(1));
    s.say("repeated", drive(1));
    s.say("the next but six", drive(8));
    s.say("an older one, late", drive(7));
    s.say("keepalive", Message::Keepalive(Keepalive { heard: 42 }));
}

fn drive(count: u8) -> Message {
    Message::Drive(Drive {
        velocity_in_s: 6,
        rotation_in_s: 0,
        heard: 42,
        count,
    })
}

fn lists(s: &mut Script) {
    let list: Vec<_> = (0..10)
        .map(|i| Waypoint {
            x_in: 12 * i,
            y_in: 100 - i,
        })
        .collect();
    let good = digest(list.iter());
    let slots = |tag, block: usize| {
        let part = &list[4 * block..list.len().min(4 * block + 4)];
        Message::Waypoints(Slots::new(tag, block as u8, part))
    };
    s.say("the first block of a list", slots(1, 0));
    s.say("the third", slots(1, 2));
    s.activate("too early", 5, 1, &list, good);
    s.say("the second", slots(1, 1));
    s.activate("with the digest of another list", 6, 1, &list, good ^ 1);
    s.activate("with another tag", 7, 2, &list, good);
    s.activate("whole and verified", 8, 1, &list, good);
    s.activate("repeated", 8, 1, &list, good);
    s.say("a block that comes late stages nothing", slots(1, 1));
    s.say("a block of the next list", slots(2, 0));
    let whole = Message::Waypoints(Slots::new(3, 0, &list));
    s.say("a newer list in one frame replaces what is staged", whole);
    s.say("a block of the older list is late", slots(2, 1));
    let beyond = Order::Activate {
        tag: 3,
        count: 301,
        digest: good,
    };
    s.order(
        "more waypoints than there is room for",
        9,
        beyond,
        Outcome::Done,
    );
}

fn stop_and_takeover(s: &mut Script) {
    let list = [Waypoint { x_in: 5, y_in: 5 }];
    let slots = |tag| Message::Waypoints(Slots::new(tag, 0, &list));
    s.say(
        "STOP ends the session and drops what is staged",
        Message::Stop(None),
    );
    s.order(
        "a command of the ended session",
        10,
        Order::Scan,
        Outcome::Done,
    );
    s.say("STOP again", Message::Stop(None));
    s.open("the request of the ended session, late", 1, 0, 0x2A5);
    s.open("a new session", 1, 2, 0x2A5);
    s.order(
        "commands count from one again",
        1,
        Order::Mode(Mode::Prowl),
        Outcome::Done,
    );
    s.say("tags count from one again", slots(1));
    s.activate(
        "clearing the list drops what is staged",
        2,
        0,
        &[],
        digest([].iter()),
    );
    s.say("its tag is spent", slots(1));
    s.say("the next tag is not", slots(2));
    s.open("another station takes over", 1, 3, 0x111);
    for (replaces, about) in [(4, "5"), (5, "6"), (6, "7"), (7, "and 1 after 7")] {
        s.open(&format!("sessions count {about}"), 1, replaces, 0x111);
    }
    s.say("a list is staged", slots(1));
    s.activate("and driven", 1, 1, &list, digest(list.iter()));
}

fn reboot(s: &mut Script) {
    s.boot("the robot boots again: no session, no list", 10);
    s.order(
        "a command of its former life",
        2,
        Order::Scan,
        Outcome::Done,
    );
    s.open("a request made to its former life", 1, 1, 0x2A5);
    s.open("the first session of the new one", 2, 0, 0x2A5);
    s.order(
        "and its first command",
        1,
        Order::Mode(Mode::Prowl),
        Outcome::Done,
    );
}

fn drive_counts(s: &mut Script) {
    s.say("hand drive, seven ahead", drive(7));
    s.say("eight ahead is late", drive(15));
    s.open("a new session", 2, 1, 0x2A5);
    s.say("drives count from zero again", drive(7));
}

fn sequences(s: &mut Script) {
    let reactive = Order::Mode(Mode::Reactive);
    for sequence in 1..=63 {
        s.order("commands count on", sequence, reactive, Outcome::Done);
    }
    s.order("the last one repeated", 63, reactive, Outcome::Done);
    s.order("0 follows 63", 0, reactive, Outcome::Done);
    s.order("and 1 follows 0", 1, reactive, Outcome::Done);
}

/// A list that differs from others in its coordinates.
fn route(count: i16) -> Vec<Waypoint> {
    (0..count)
        .map(|i| Waypoint {
            x_in: 30 * i - 4000,
            y_in: 17 - i,
        })
        .collect()
}

fn tags_and_windows(s: &mut Script) {
    let list = route(4);
    let slots = |tag, block| Message::Waypoints(Slots::new(tag, block, &list));
    s.say("a tag fifteen ahead is newer", slots(15, 0));
    s.say("sixteen ahead is older", slots(31, 1));
    s.say("fifteen ahead again", slots(30, 0));
    s.say("the last tag", slots(31, 0));
    s.say("1 follows 31", slots(1, 0));
    s.say("the last block of the window", slots(1, 9));
    s.say("beyond the window", slots(1, 10));
    s.say("the window moves on", slots(1, 1));
    s.activate(
        "clearing the list with a wrong digest changes nothing",
        2,
        1,
        &[],
        digest([].iter()) ^ 1,
    );
}

fn longest_list(s: &mut Script) {
    let list = route(300);
    let beyond = route(301);
    let slots = |first_block: usize, end: usize| {
        let part = &beyond[4 * first_block..end];
        Message::Waypoints(Slots::new(2, first_block as u8, part))
    };
    for frame in 0..18 {
        let about = format!("part {} of the longest list", frame + 1);
        s.say(&about, slots(4 * frame, 16 * frame + 16));
    }
    s.say(
        "a frame that reaches beyond the 300th is not stored",
        slots(73, 301),
    );
    s.say("its last part", slots(72, 300));
    s.activate("300 waypoints", 3, 2, &list, digest(list.iter()));
}

fn short_blocks(s: &mut Script) {
    let list = route(10);
    let good = digest(list.iter());
    let slots =
        |first: usize, end| Message::Waypoints(Slots::new(3, (first / 4) as u8, &list[first..end]));
    s.say("two blocks of three", slots(0, 8));
    s.activate("the last block, a short one, is missing", 4, 3, &list, good);
    s.say("it comes, but one waypoint short", slots(8, 9));
    s.activate("so the digest is another", 5, 3, &list, good);
    s.say("it comes whole", slots(8, 10));
    s.activate("and the list is driven", 6, 3, &list, good);
}
