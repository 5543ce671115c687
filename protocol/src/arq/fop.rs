//! The ground's end: delivers one task at a time and claims only what an acknowledgement proves.
//!
//! Loss is found by snapshots: an acknowledgement latched after a frame's last byte had left, and
//! lacking its effect, means that the frame was lost. A timer stands behind that for the time when no
//! line comes down at all.

mod hearing;
mod interface;
mod late;
mod sending;
mod session;
mod turn;

pub use interface::{Config, Duplex, FopEvent, Loss, Task};

use super::pacer::Pacer;
use super::quality::Quality;
use super::transfer::Transfer;
use crate::command::{Command, Key, Order};
use crate::telemetry::Ack;
use crate::{BYTES_PER_S, LINE_BYTES, WAYPOINTS_MAX, Waypoint};
use turn::{Carrier, Turn};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Session {
    None,
    Opening {
        boot: u8,
        replaces: u8,
        sent_us: Option<u64>,
    },
    Open {
        boot: u8,
        number: u8,
        key: Key,
    },
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one, and no heap to put it on"
)]
enum Work {
    Order(Order),
    List(Transfer),
}

/// A sequenced command that has been sent at least once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Outstanding {
    command: Command,
    /// Last byte off at this instant; `None` when it has to go again.
    ends_us: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Stopping {
    since_us: u64,
    /// Boot, session and sequence that a STOP has to change.
    before: Option<(u8, u8, u8)>,
    has_left: bool,
    /// When it goes again.
    next_us: u64,
    /// When it goes although a half-duplex robot has not said that it listens.
    blind_us: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct HandDrive {
    velocity_in_s: i8,
    rotation_in_s: i8,
    until_us: u64,
    next_us: u64,
}

/// Acknowledgement lines keep coming for four lines after a knock.
const KNOCK_PERIOD_US: u64 = 1_000_000;

/// A longer silence is an outage and says nothing of single lines.
const FORGET_BYTES: u64 = 10 * LINE_BYTES as u64;

/// So many long lines without a line G among them, and the robot does not take turns.
const LONG_LINES: u8 = 2;

const EVENTS_MAX: usize = 8;
const DRIVE_PERIOD_US: u64 = 200_000;

/// A robot obeys drive frames only while it hears that they are not from long ago.
const ALIVE_PERIOD_US: u64 = 1_000_000;

/// A half-duplex robot that has not been heard for so long gets a STOP without having said that it
/// listens. More often, and this end would not hear what it says.
const STOP_BLIND_US: u64 = 700_000;

/// So many frames keep a robot alive through a silence that would make it act. Where one bit in a thousand
/// flips, every seventh gets lost, and where the ends take turns a quarter of them has to wait.
const KEEPALIVES_PER_SILENCE: u64 = 10;

/// What was heard longer ago says nothing of the robot before a STOP: it may have booted often since.
const STOP_BEFORE_US: u64 = 5_000_000;

/// STOP is repeated until it is proven: it costs seven bytes.
const STOP_PERIOD_US: u64 = 300_000;

/// A list that arrives whole and wrong this often is a robot at odds with this protocol.
const MISMATCHES_MAX: u8 = 3;
const US_PER_BYTE: u64 = 1_000_000 / BYTES_PER_S as u64;

/// From the latch of an acknowledgement to the end of its line: 5 characters of it, CRC, CR LF.
const LATCH_TO_END_US: u64 = 11 * US_PER_BYTE;

/// The Frame Operation Procedure.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fop {
    config: Config,
    robot_id: Option<u8>,
    latest_ack: Option<Ack>,
    latest_line: u8,
    heard_us: u64,
    downlink: Quality,
    duplex: Duplex,
    /// Long lines heard while it was unknown.
    long_lines: u8,
    carrier: Carrier,
    /// The robot's turn to listen, in half duplex.
    turn: Option<Turn>,
    /// Byte times that the robot was silent for since the latest line, listening.
    paused_bytes: u64,
    /// The robot acts, or will act, when the ground falls silent.
    wants_keepalive: bool,
    /// The shortest silence it has been ordered, or has said, to act on in this session.
    failsafe_silence_us: Option<u64>,
    /// The latest frame's last byte off.
    spoke_us: u64,
    /// When a keepalive is due beside hand drive.
    alive_us: u64,
    session: Session,
    sequence: u8,
    tag: u8,
    drive_count: u8,
    work: Option<Work>,
    outstanding: Option<Outstanding>,
    frames: u32,
    mismatches: u8,
    progress_us: u64,
    knock_us: u64,
    stopping: Option<Stopping>,
    drive: Option<HandDrive>,
    pacer: Pacer,
    events: [Option<FopEvent>; EVENTS_MAX],
}

impl Fop {
    /// A station that has just started and has heard nothing.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            robot_id: config.robot_id,
            config,
            latest_ack: None,
            latest_line: 0,
            heard_us: 0,
            downlink: Quality::default(),
            duplex: config.duplex,
            long_lines: 0,
            carrier: Carrier::default(),
            turn: None,
            paused_bytes: 0,
            wants_keepalive: false,
            failsafe_silence_us: None,
            spoke_us: 0,
            alive_us: 0,
            session: Session::None,
            sequence: 0,
            tag: 0,
            drive_count: 0,
            work: None,
            outstanding: None,
            frames: 0,
            mismatches: 0,
            progress_us: 0,
            knock_us: 0,
            stopping: None,
            drive: None,
            pacer: Pacer::default(),
            events: [None; EVENTS_MAX],
        }
    }

    /// Whether a task is under way.
    #[must_use]
    pub const fn is_busy(&self) -> bool {
        self.work.is_some()
    }

    /// Whether a session of ours is open, as far as the latest acknowledgement says.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        matches!(self.session, Session::Open { .. })
    }

    /// Whether both ends can talk at once, as far as is known.
    #[must_use]
    pub const fn duplex(&self) -> Duplex {
        self.duplex
    }

    fn is_half_duplex(&self) -> bool {
        self.duplex == Duplex::Half
    }

    /// Begins a task; returns whether it was taken, which it is unless one is under way or it is a
    /// list that cannot be sent.
    pub fn start(&mut self, now_us: u64, task: Task<'_>) -> bool {
        if self.work.is_some() || !can_be_sent(task) {
            return false;
        }
        self.work = Some(match task {
            Task::List(waypoints) if !waypoints.is_empty() => {
                let tag = self.next_tag();
                Work::List(Transfer::new(waypoints, tag, self.downlink.as_guess()))
            }
            Task::List(_) => Work::Order(Order::Activate {
                tag: 0,
                count: 0,
                digest: crate::digest::digest([].iter()),
            }),
            Task::Order(order) => Work::Order(order),
        });
        self.frames = 0;
        self.mismatches = 0;
        self.progress_us = now_us;
        true
    }

    /// Gives the task up. What has been sent of it may still be executed.
    pub fn cancel(&mut self) {
        self.fail(Loss::Cancelled);
    }

    /// Stops the robot before anything else, and says nothing else until a line proves that it has
    /// stopped. Ends the task, the hand drive and the session. Asked again meanwhile, it tries for longer.
    pub fn stop(&mut self, now_us: u64) {
        self.lose_session(Loss::Stopped);
        // An operator who hammers the key must not keep aborting the frame, nor put it off.
        if let Some(stopping) = &mut self.stopping {
            stopping.since_us = now_us;
            return;
        }
        self.pacer.abort();
        let is_news = now_us < self.heard_us + STOP_BEFORE_US;
        self.stopping = Some(Stopping {
            since_us: now_us,
            before: self
                .latest_ack
                .filter(|_| is_news)
                .map(|ack| (ack.boot, ack.session, ack.sequence)),
            has_left: false,
            next_us: now_us,
            blind_us: now_us + STOP_BLIND_US,
        });
    }

    /// Drives by hand until `until_us`, then says once to stand still; to be called again while the
    /// operator holds the key.
    pub fn drive(&mut self, now_us: u64, velocity_in_s: i8, rotation_in_s: i8, until_us: u64) {
        let changed = self
            .drive
            .is_none_or(|d| (d.velocity_in_s, d.rotation_in_s) != (velocity_in_s, rotation_in_s));
        let next_us = self.drive.map_or(now_us, |d| d.next_us);
        self.drive = Some(HandDrive {
            velocity_in_s,
            rotation_in_s,
            until_us,
            next_us: if changed { now_us } else { next_us },
        });
    }

    fn next_tag(&mut self) -> u8 {
        self.tag = next_tag(self.tag);
        self.tag
    }

    /// Lets time pass.
    pub fn handle_timeout(&mut self, now_us: u64) {
        if self
            .stopping
            .is_some_and(|s| now_us >= s.since_us + self.config.give_up_us)
        {
            self.stopping = None;
            self.push(FopEvent::StopFailed);
        }
        if self.work.is_some() && now_us >= self.progress_us + self.config.give_up_us {
            self.fail(Loss::TimedOut);
        }
        if self.drive.is_some_and(|d| now_us >= d.until_us) && !self.is_open() {
            self.drive = None;
        }
        for sent_us in self.waiting().into_iter().flatten() {
            if now_us >= sent_us.max(self.heard_us) + self.config.silence_us {
                self.resend();
                break;
            }
        }
    }

    /// When what is waited for ended, for each thing waited for.
    fn waiting(&self) -> [Option<u64>; 2] {
        [
            self.outstanding.and_then(|o| o.ends_us),
            match self.session {
                Session::Opening { sent_us, .. } => sent_us,
                _ => None,
            },
        ]
    }

    fn resend(&mut self) {
        if let Some(outstanding) = &mut self.outstanding {
            outstanding.ends_us = None;
        }
        if let Session::Opening { sent_us, .. } = &mut self.session {
            *sent_us = None;
        }
        if let Some(Work::List(transfer)) = &mut self.work {
            transfer.resend();
        }
    }

    /// When to call [`Fop::handle_timeout`] and [`Fop::poll_transmit`] again, if nothing arrives
    /// before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<u64> {
        let silence = self
            .waiting()
            .into_iter()
            .flatten()
            .map(|sent_us| sent_us.max(self.heard_us) + self.config.silence_us)
            .min();
        let give_up = [
            self.work.as_ref().map(|_| self.progress_us),
            self.stopping.map(|s| s.since_us),
        ];
        let give_up = give_up
            .into_iter()
            .flatten()
            .min()
            .map(|us| us + self.config.give_up_us);
        let may_speak = !self.is_half_duplex() || self.turn.is_some();
        let drive = self.drive.map(|d| {
            if self.is_open() && may_speak {
                d.next_us.min(d.until_us)
            } else {
                d.until_us
            }
        });
        let knock = self.must_knock().then_some(self.knock_us);
        let stop = self.stopping.map(|stopping| {
            if may_speak {
                stopping.next_us
            } else {
                stopping.next_us.max(stopping.blind_us)
            }
        });
        let keepalive = self.keepalive_us().filter(|_| may_speak);
        let turn = self.silent_at_us();
        // What is due to be said waits for the frame that is being said.
        let free = self.pacer.is_idle();
        [
            knock.filter(|_| free),
            self.pacer.poll_timeout(),
            silence,
            give_up,
            drive.filter(|_| free || !self.is_open()),
            stop.filter(|_| free),
            keepalive.filter(|_| free),
            turn.filter(|_| free),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// What has happened since the last call.
    pub fn poll_event(&mut self) -> Option<FopEvent> {
        let event = self.events[0].take();
        self.events.rotate_left(1);
        event
    }

    /// Events beyond the queue's room are dropped; the caller drains it after every call.
    fn push(&mut self, event: FopEvent) {
        if let Some(slot) = self.events.iter_mut().find(|slot| slot.is_none()) {
            *slot = Some(event);
        }
    }
}

fn can_be_sent(task: Task<'_>) -> bool {
    let Task::List(list) = task else {
        return true;
    };
    list.len() <= WAYPOINTS_MAX && list.iter().all(|w| Waypoint::new(w.x_in, w.y_in).is_some())
}

const fn next_tag(tag: u8) -> u8 {
    tag % 31 + 1
}
