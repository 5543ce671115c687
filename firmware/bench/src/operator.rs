//! A ground station that repeats each command until the robot has executed it.

use std::collections::VecDeque;

use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Command, Drive, Key, Message, Open, Order, Slots};
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::digest::digest;
use groundwave_protocol::telemetry::{Ack, Outcome};

/// Robot number of every run.
pub(crate) const ROBOT_ID: u8 = 4;

/// Owner of the operator's sessions.
pub(crate) const OWNER: u16 = 7;

/// Time between two attempts, milliseconds.
const REPEAT_MS: u64 = 600;

/// Time between two drive frames, milliseconds.
const DRIVE_MS: u64 = 200;

/// Number of a route in its session.
const TAG: u8 = 1;

/// Number of waypoints in a frame, and number of blocks that they fill.
const FRAME_WAYPOINTS: usize = 16;
const FRAME_BLOCKS: u8 = 4;

/// A task of the operator.
#[derive(Clone, Debug)]
pub(crate) enum Task {
    Order(Order),
    Route(Vec<Waypoint>),
    Stop,
}

/// The station.
#[derive(Default)]
pub(crate) struct Operator {
    tasks: VecDeque<Task>,
    /// Speed and rotation of hand driving.
    drive: Option<(i8, i8)>,
    drive_count: u8,
    decoder: Decoder,
    /// Number of the newest received line.
    heard: u8,
    /// Boot, number and key of the open session.
    session: Option<(u8, u8, Key)>,
    /// Boot and number of the session that an open frame replaces.
    opening: Option<(u8, u8)>,
    /// Sequence of the latest command, and whether it still waits for its outcome.
    sequence: u8,
    is_waiting: bool,
    next_ms: u64,
    next_drive_ms: u64,
}

impl Operator {
    pub(crate) fn queue(&mut self, task: Task) {
        self.tasks.push_back(task);
    }

    /// Whether every task is done.
    pub(crate) fn is_idle(&self) -> bool {
        self.tasks.is_empty()
    }

    pub(crate) fn drive(&mut self, speeds: Option<(i8, i8)>) {
        self.drive = speeds;
    }

    /// Takes a byte from the radio.
    pub(crate) fn receive(&mut self, byte: u8) {
        match self.decoder.lines(&[byte]).next() {
            Some(Received::Line(line, _)) => self.heard = line.sequence,
            Some(Received::Ack(line)) => self.heard = line.sequence,
            None => {}
        }
    }

    /// Bytes to send now, with the robot's true acknowledgement.
    pub(crate) fn transmit(&mut self, now_ms: u64, ack: Ack) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.take(ack);
        if now_ms >= self.next_ms && !self.tasks.is_empty() {
            self.next_ms = now_ms + REPEAT_MS;
            self.attempt(ack, &mut bytes);
        }
        if let (Some((velocity_in_s, rotation_in_s)), Some((_, _, key))) =
            (self.drive, self.session)
            && now_ms >= self.next_drive_ms
        {
            self.next_drive_ms = now_ms + DRIVE_MS;
            self.drive_count = (self.drive_count + 1) % 16;
            let message = Message::Drive(Drive {
                velocity_in_s,
                rotation_in_s,
                heard: self.heard,
                count: self.drive_count,
            });
            bytes.extend_from_slice(message.encode(key).as_bytes());
        }
        bytes
    }

    /// Takes an acknowledgement of the robot, and records which commands it has executed.
    fn take(&mut self, ack: Ack) {
        let present = (ack.boot, ack.session);
        if let Some(replaced) = self.opening
            && present != replaced
        {
            self.opening = None;
            self.sequence = 0;
            self.is_waiting = false;
            let key = Key::session(ROBOT_ID, ack.boot, ack.session, OWNER);
            self.session = Some((ack.boot, ack.session, key));
            self.next_ms = 0;
        }
        let is_present = |&(boot, session, _): &(u8, u8, Key)| (boot, session) == present;
        self.session = self.session.filter(is_present);
        if self.session.is_some() && self.is_waiting && ack.sequence == self.sequence & 7 {
            self.is_waiting = false;
            self.next_ms = 0;
            // An incomplete route is sent again.
            let is_retried = matches!(ack.outcome, Outcome::ListIncomplete);
            if !is_retried {
                self.tasks.pop_front();
            }
        }
    }

    fn attempt(&mut self, ack: Ack, bytes: &mut Vec<u8>) {
        let Some(task) = self.tasks.front().cloned() else {
            return;
        };
        let mut send = |message: &Message, key| {
            bytes.extend_from_slice(message.encode(key).as_bytes());
        };
        if matches!(task, Task::Stop) {
            send(&Message::Stop(None), Key::robot(ROBOT_ID));
            self.tasks.pop_front();
            return;
        }
        let Some((_, _, key)) = self.session else {
            let open = Open {
                boot: ack.boot,
                replaces: ack.session,
                owner: OWNER,
                era: None,
            };
            self.opening = Some((ack.boot, ack.session));
            send(&Message::Open(open), Key::robot(ROBOT_ID));
            return;
        };
        if !self.is_waiting {
            self.sequence = self.sequence % 63 + 1;
            self.is_waiting = true;
        }
        let order = match task {
            Task::Order(order) => order,
            Task::Route(route) => {
                for (frame, points) in route.chunks(FRAME_WAYPOINTS).enumerate() {
                    let slots = Slots::new(TAG, frame as u8 * FRAME_BLOCKS, points);
                    send(&Message::Waypoints(slots), key);
                }
                Order::Activate {
                    tag: TAG,
                    count: route.len() as u16,
                    digest: digest(route.iter()),
                }
            }
            Task::Stop => return,
        };
        let sequence = self.sequence;
        send(&Message::Command(Command { sequence, order }), key);
    }
}
