//! The ground's end of delivery: delivers one task at a time and reports only acknowledged results.
//!
//! An acknowledgement that was latched after a frame's last byte was sent but does not show the frame's effect proves that the frame
//! was lost. A timer covers the time without any line.

mod abilities;
mod hearing;
mod interface;
mod late;
mod sending;
mod session;
mod turn;

pub use abilities::DRIVE_LEVEL;
pub use interface::{Config, Duplex, FopEvent, Task};

use super::US_PER_BYTE;
use super::pacer::Pacer;
use super::quality::Quality;
use super::status::{CommandStatus, Failure};
use super::transfer::Transfer;
use crate::command::{Command, Key, Order, RECEIPT_MAX};
use crate::telemetry::{AbilitiesLine, Ack, Detail};
use crate::{BYTES_PER_S, LINE_BYTES, WAYPOINTS_MAX, Waypoint};
use abilities::Unexplained;
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
        era: u16,
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
    /// Time at which the last byte was sent; `None` if the command must be sent again.
    ends_us: Option<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Stopping {
    since_us: u64,
    /// The receipt in the STOP, which an acknowledgement must return.
    receipt: u16,
    has_left: bool,
    /// Whether STOP was requested again since the latest STOP was sent; the next STOP then needs another receipt.
    is_renewed: bool,
    /// Number of earlier receipts that still confirm the requests before them.
    earlier: u16,
    /// Time at which to send the STOP again, microseconds.
    next_us: u64,
    /// Time at which to send the STOP even if a half-duplex robot has not announced that it listens, microseconds.
    blind_us: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct HandDrive {
    velocity_in_s: i8,
    rotation_in_s: i8,
    until_us: u64,
    next_us: u64,
}

/// Period of knocks, microseconds. Each knock requests acknowledgement lines for four lines.
const KNOCK_PERIOD_US: u64 = 1_000_000;

/// Maximum silence for judging the downlink, in bytes; a longer silence is an outage.
const FORGET_BYTES: u64 = 10 * LINE_BYTES as u64;

/// Number of long lines without a line G after which a robot of unknown duplex counts as full-duplex.
const LONG_LINES: u8 = 2;

/// Number of consecutive long lines without loss after which a robot that should take turns counts as full-duplex.
const LONG_LINES_IN_A_ROW: u8 = 3;

const EVENTS_MAX: usize = 8;
const DRIVE_PERIOD_US: u64 = 200_000;

/// Period of keepalives during hand drive, microseconds; a robot obeys drive frames only while a keepalive shows that they are fresh.
const ALIVE_PERIOD_US: u64 = 1_000_000;

/// Silence of a half-duplex robot after which a STOP is sent out of turn. After a shorter silence, it could collide with the robot's lines.
const STOP_BLIND_US: u64 = 700_000;

/// Number of keepalives sent per silence of the failsafe. At a bit error rate of 1e-3 one in seven is lost, and in half duplex one
/// in four has to wait.
const KEEPALIVES_PER_SILENCE: u64 = 10;

/// Number of bits of a receipt that count this station's STOPs; the other bits are its owner. A count repeats after more than the
/// longest delay of a line, because a station makes at most one receipt per [`STOP_PERIOD_US`].
const RECEIPT_COUNT_BITS: u32 = 5;
const RECEIPT_COUNT_MAX: u16 = (1 << RECEIPT_COUNT_BITS) - 1;

/// Period of STOP frames until one is confirmed, microseconds.
const STOP_PERIOD_US: u64 = 300_000;

/// Last sequence of a session's commands, and last tag of its lists; later ones would repeat earlier ones.
const SEQUENCE_LAST: u8 = 63;
const TAG_LAST: u8 = 15;

/// Number of digest mismatches after which a list fails.
const MISMATCHES_MAX: u8 = 3;

/// Number of bytes from the latching of an acknowledgement to the end of its line: 5 characters, CRC, CR LF.
const LATCH_TO_END_BYTES: u64 = 11;

/// The Frame Operation Procedure.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Fop {
    config: Config,
    robot_id: Option<u8>,
    latest_ack: Option<Ack>,
    /// Era of the session in the latest acknowledgement; `None` until a line in this life of the robot has shown it.
    era: Option<u16>,
    latest_line: u8,
    /// The robot's abilities, from its latest line I.
    abilities: Option<AbilitiesLine>,
    /// Rate of the link, bytes per second.
    link_bytes_per_s: Option<u32>,
    heard_us: u64,
    downlink: Quality,
    duplex: Duplex,
    /// Number of long lines received since the latest other line, while the robot was not known to be full-duplex; if it should take turns,
    /// only consecutive lines count.
    long_lines: u8,
    carrier: Carrier,
    /// The current turn to send, in half duplex.
    turn: Option<Turn>,
    /// Silence since the latest line while the robot was listening, byte times.
    paused_bytes: u64,
    /// Whether the robot has a failsafe, which keepalives prevent from acting.
    wants_keepalive: bool,
    /// The shortest silence of the failsafe ordered or reported in this session, microseconds.
    failsafe_silence_us: Option<u64>,
    /// Time at which the last byte of the latest frame was sent.
    spoke_us: u64,
    /// Time at which a keepalive is due during hand drive, microseconds.
    alive_us: u64,
    session: Session,
    sequence: u8,
    tag: u8,
    drive_count: u8,
    /// Number of receipts made.
    receipts: u16,
    work: Option<Work>,
    /// A refused task that waits for the robot's first line I.
    unexplained: Option<Unexplained>,
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
    /// A station that has just started.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            robot_id: config.robot_id,
            config,
            latest_ack: None,
            era: None,
            latest_line: 0,
            abilities: None,
            link_bytes_per_s: None,
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
            receipts: 0,
            work: None,
            unexplained: None,
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

    /// Whether a task is in progress.
    #[must_use]
    pub const fn is_busy(&self) -> bool {
        self.work.is_some() || self.unexplained.is_some()
    }

    /// Whether a session of this station is open, by the latest acknowledgement.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        matches!(self.session, Session::Open { .. })
    }

    /// Whether frames for one robot are under way, so that no other robot may take its place: a session, a command, hand drive or STOP.
    #[must_use]
    pub const fn holds_robot(&self) -> bool {
        self.is_open() || self.work.is_some() || self.drive.is_some() || self.stopping.is_some()
    }

    /// Whether both ends can send at the same time, as far as known.
    #[must_use]
    pub const fn duplex(&self) -> Duplex {
        self.duplex
    }

    /// Sets the rate of the link, bytes per second. Frames follow the robot's own rate if that is lower. Without a rate, as behind a
    /// network, they follow the robot's, and 2400 baud until it is known.
    pub fn set_rate(&mut self, bytes_per_s: u32) {
        self.link_bytes_per_s = Some(bytes_per_s);
        self.follow_rate();
    }

    /// Adapts a duration meant for 2400 baud: longer at lower rates.
    fn stretched(&self, us: u64) -> u64 {
        us * self.pacer.us_per_byte().max(US_PER_BYTE) / US_PER_BYTE
    }

    fn silence_us(&self) -> u64 {
        self.stretched(self.config.silence_us)
    }

    fn give_up_us(&self) -> u64 {
        self.stretched(self.config.give_up_us)
    }

    fn follow_rate(&mut self) {
        let own = self.abilities.map(|robot| robot.rate_bytes_per_s);
        let slower = [own, self.link_bytes_per_s].into_iter().flatten().min();
        self.pacer.set_rate(slower.unwrap_or(BYTES_PER_S));
    }

    fn is_half_duplex(&self) -> bool {
        self.duplex == Duplex::Half
    }

    /// Begins a task; returns `false` if another task is in progress or the list cannot be sent.
    pub fn start(&mut self, now_us: u64, task: Task<'_>) -> bool {
        if self.is_busy() || !can_be_sent(task) {
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

    /// Cancels the task. Commands already sent may still be executed.
    pub fn cancel(&mut self) {
        self.fail(Failure::Cancelled);
    }

    /// Gives up an unconfirmed STOP. A STOP already sent may still be executed.
    pub fn cancel_stop(&mut self) {
        if self.stopping.take().is_some() {
            self.push(FopEvent::Stop(CommandStatus::Failed(Failure::Cancelled)));
        }
    }

    /// Stops the robot, and sends nothing else until a line confirms the STOP. Ends task, hand drive and session. A
    /// further call extends the time for trying, and must be confirmed after the earlier calls.
    pub fn stop(&mut self, now_us: u64) {
        self.lose_session(Failure::Stopped);
        // Repeated keys must neither abort nor delay the frame.
        if let Some(stopping) = &mut self.stopping {
            stopping.since_us = now_us;
            stopping.is_renewed |= stopping.has_left;
            return;
        }
        self.pacer.abort();
        self.stopping = Some(Stopping {
            since_us: now_us,
            receipt: self.next_receipt(),
            has_left: false,
            is_renewed: false,
            earlier: 0,
            next_us: now_us,
            blind_us: now_us + STOP_BLIND_US,
        });
    }

    /// Drives by hand until `until_us`, then sends one frame with speed zero. Call again while the operator holds
    /// the key. Has no effect on a robot below level 4.
    pub fn drive(&mut self, now_us: u64, velocity_in_s: i8, rotation_in_s: i8, until_us: u64) {
        if !self.can_be_driven() {
            return;
        }
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

    /// A receipt that no other station makes, and that this station does not repeat for seconds.
    fn next_receipt(&mut self) -> u16 {
        self.receipts = self.receipts.wrapping_add(1);
        let count = self.receipts & RECEIPT_COUNT_MAX;
        (self.config.owner << RECEIPT_COUNT_BITS | count) & RECEIPT_MAX
    }

    fn next_tag(&mut self) -> u8 {
        self.tag = next_tag(self.tag);
        self.tag
    }

    /// Whether the robot reports that it cannot hear.
    fn is_unheard(&self) -> bool {
        self.latest_ack
            .is_some_and(|ack| matches!(ack.detail, Detail::CannotHear { .. }))
    }

    /// Ends everything that only a robot with a receiver can obey.
    fn refuse_unheard(&mut self) {
        if self.stopping.take().is_some() {
            self.push(FopEvent::Stop(CommandStatus::Failed(Failure::CannotHear)));
        }
        self.lose_session(Failure::CannotHear);
    }

    /// Handles timers that are due.
    pub fn handle_timeout(&mut self, now_us: u64) {
        if self.is_unheard() {
            self.refuse_unheard();
        }
        self.refuse_beyond();
        if self.explained_by_us().is_some_and(|us| now_us >= us) {
            self.settle_refusal();
        }
        if self
            .stopping
            .is_some_and(|s| now_us >= s.since_us + self.give_up_us())
        {
            self.stopping = None;
            self.push(FopEvent::Stop(CommandStatus::Failed(Failure::TimedOut)));
        }
        if self.work.is_some() && now_us >= self.progress_us + self.give_up_us() {
            self.fail(Failure::TimedOut);
        }
        if self.drive.is_some_and(|d| now_us >= d.until_us) && !self.is_open() {
            self.drive = None;
        }
        for sent_us in self.waiting().into_iter().flatten() {
            if now_us >= sent_us.max(self.heard_us) + self.silence_us() {
                self.resend();
                break;
            }
        }
    }

    /// Times at which the last byte of each unacknowledged frame was sent.
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

    /// Time at which to call [`Fop::handle_timeout`] and [`Fop::poll_transmit`] again, if nothing arrives before.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<u64> {
        if self.is_unheard()
            && (self.work.is_some() || self.stopping.is_some() || self.drive.is_some())
        {
            return Some(0);
        }
        if self.beyond().is_some() {
            return Some(0);
        }
        let silence = self
            .waiting()
            .into_iter()
            .flatten()
            .map(|sent_us| sent_us.max(self.heard_us) + self.silence_us())
            .min();
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
        // Due frames wait for the one being sent.
        let free = self.pacer.is_idle();
        [
            knock.filter(|_| free),
            self.pacer.poll_timeout(),
            silence,
            self.poll_give_up(),
            self.explained_by_us(),
            drive.filter(|_| free || !self.is_open()),
            stop.filter(|_| free),
            keepalive.filter(|_| free),
            turn.filter(|_| free),
        ]
        .into_iter()
        .flatten()
        .min()
    }

    /// Time at which the task or the STOP in progress is given up. While nothing can be sent, no other time matters.
    #[must_use]
    pub fn poll_give_up(&self) -> Option<u64> {
        let work = self.work.as_ref().map(|_| self.progress_us);
        let since = work.into_iter().chain(self.stopping.map(|s| s.since_us));
        since.min().map(|us| us + self.give_up_us())
    }

    /// The next event, or `None`.
    pub fn poll_event(&mut self) -> Option<FopEvent> {
        let event = self.events[0].take();
        self.events.rotate_left(1);
        event
    }

    /// Queues an event; drops it if the queue is full. The caller drains the queue after every call.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decoder::Decoder;
    use crate::telemetry::{Body, Line};

    /// The byte time after a line I with this rate, and the maximum time of a task without progress, microseconds.
    fn pace(link_bytes_per_s: impl Into<Option<u32>>, own_bytes_per_s: u32) -> (u64, u64) {
        let mut fop = Fop::new(Config::new(1));
        if let Some(link_bytes_per_s) = link_bytes_per_s.into() {
            fop.set_rate(link_bytes_per_s);
        }
        let line = Line {
            sequence: 0,
            body: Body::Abilities(AbilitiesLine {
                rate_bytes_per_s: own_bytes_per_s,
                ..AbilitiesLine::FULL
            }),
            ack: Ack::default(),
        };
        for received in Decoder::default().lines(&line.encode()) {
            fop.handle_received(0, &received);
        }
        (fop.pacer.us_per_byte(), fop.give_up_us())
    }

    #[test]
    fn the_slower_of_link_and_robot_sets_the_pace() {
        assert_eq!(pace(240, 99_999), (4166, 15_000_000));
        assert_eq!(pace(11_520, 11_520), (86, 15_000_000));
        assert_eq!(pace(11_520, 240), (4166, 15_000_000));
        assert_eq!(pace(None, 960), (1041, 15_000_000));
        let (us_per_byte, give_up_us) = pace(11_520, 120);
        assert_eq!(us_per_byte, 8333);
        assert!((30_000_000..30_010_000).contains(&give_up_us));
    }
}
