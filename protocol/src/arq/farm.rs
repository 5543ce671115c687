//! The robot's end of delivery: accepts each command exactly once and acknowledges it in every line.

use super::{Lists, session_after};
use crate::command::{Drive, ERA_MAX, Key, Message, Open, Order};
use crate::telemetry::{Ack, Detail, Outcome};

/// Action of the robot on a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Switch the motors off at once.
    Stop,
    /// Carry out the order, then call [`Farm::conclude`] with its outcome.
    Execute(Order),
    /// The active list was replaced.
    ListReplaced,
    /// Drive by hand for the next second, if the frame is fresh; then call [`Farm::take_drive`].
    Drive(Drive),
    /// No action: the message only shows that the ground is alive.
    Heard,
}

/// Number of eras between the beginnings of two lives with the same boot counter modulo 8. Sixteen of these steps fill the range.
const ERAS_OF_LIFE: u16 = 1021;

/// The Frame Acceptance and Reporting Mechanism.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Farm {
    robot_id: u8,
    boot: u8,
    session: u8,
    /// Count of rounds of session numbers, 14 bits.
    era: u16,
    /// Whether the session was opened by its full number, including the era.
    is_numbered: bool,
    /// Owner of the session; `None` if no session is open.
    owner: Option<u16>,
    /// Sequence of the latest command, 6 bits; the number of STOPs while no session is open.
    sequence: u8,
    outcome: Outcome,
    drive_count: u8,
    /// Receipt of the STOP that closed the session, or of a later STOP.
    receipt: Option<u16>,
    lists: Lists,
}

impl Farm {
    /// A robot that has just booted. `boots` must differ from that of its previous life.
    #[must_use]
    pub fn new(robot_id: u8, boots: u16) -> Self {
        Self {
            robot_id,
            boot: (boots & 7) as u8,
            session: 0,
            era: (boots >> 3).wrapping_mul(ERAS_OF_LIFE) & ERA_MAX,
            is_numbered: false,
            owner: None,
            sequence: 0,
            outcome: Outcome::Done,
            drive_count: 0,
            receipt: None,
            lists: Lists::default(),
        }
    }

    /// The same robot with lists of at most `capacity` waypoints, and never more than [`crate::WAYPOINTS_MAX`].
    #[must_use]
    pub const fn with_capacity(mut self, capacity: u16) -> Self {
        self.lists.limit(capacity);
        self
    }

    /// The key for checking frames of the open session; `None` if no session is open.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        let era = if self.is_numbered { self.era } else { 0 };
        self.owner
            .map(|owner| Key::session(self.robot_id, self.boot, self.session, owner).in_era(era))
    }

    /// The current acknowledgement.
    #[must_use]
    pub fn ack(&self) -> Ack {
        let receipt = self.receipt.map(|receipt| Detail::Stopped { receipt });
        let detail = self.lists.detail().or(receipt);
        self.ack_with(detail.unwrap_or(self.idle()))
    }

    /// The acknowledgement in the line with this sequence. One line in three contains the era or, alternately, the robot's id
    /// instead of a receipt, for stations that have just started.
    #[must_use]
    pub fn ack_in(&self, sequence: u8) -> Ack {
        match sequence % 6 {
            4 if self.receipt.is_some() => self.ack_with(self.idle()),
            1 | 4 => self.ack_with(Detail::Era { era: self.era }),
            _ => self.ack(),
        }
    }

    const fn ack_with(&self, detail: Detail) -> Ack {
        Ack {
            boot: self.boot,
            session: self.session,
            sequence: self.sequence & 7,
            outcome: self.outcome,
            detail,
        }
    }

    const fn idle(&self) -> Detail {
        let owner = match self.owner {
            Some(owner) => owner,
            None => 0,
        };
        Detail::Idle {
            owner,
            robot_id: self.robot_id,
        }
    }

    /// Both waypoint banks.
    #[must_use]
    pub const fn lists(&self) -> &Lists {
        &self.lists
    }

    /// Whether a station has opened a session since boot or since the latest STOP.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        self.owner.is_some()
    }

    /// Takes an intact message; returns the robot's action. Each order is returned only once.
    pub fn handle(&mut self, message: &Message) -> Action {
        match message {
            Message::Stop(receipt) => {
                if self.owner.is_some() {
                    self.begin_session(None);
                } else {
                    // Without a session, the sequence counts STOPs, so that the acknowledgement shows each STOP.
                    self.sequence = (self.sequence + 1) & 0x3F;
                }
                self.receipt = *receipt;
                Action::Stop
            }
            Message::Open(open) => {
                self.open(*open);
                Action::Heard
            }
            Message::Command(command) if command.sequence == (self.sequence + 1) & 0x3F => {
                self.sequence = command.sequence;
                self.outcome = Outcome::Failed;
                if let Order::Activate { tag, count, digest } = command.order {
                    self.outcome = self.lists.activate(tag, count, digest);
                    if self.outcome == Outcome::Done {
                        Action::ListReplaced
                    } else {
                        Action::Heard
                    }
                } else {
                    Action::Execute(command.order)
                }
            }
            Message::Waypoints(slots) => {
                self.lists.stage(slots);
                Action::Heard
            }
            Message::Drive(drive) => {
                let ahead = drive.count.wrapping_sub(self.drive_count) & 0xF;
                if (1..8).contains(&ahead) {
                    Action::Drive(*drive)
                } else {
                    Action::Heard
                }
            }
            Message::Command(_) | Message::Keepalive(_) => Action::Heard,
        }
    }

    /// Takes the count of an obeyed drive frame; neither this frame nor older ones are obeyed again.
    pub fn take_drive(&mut self, drive: &Drive) {
        self.drive_count = drive.count;
    }

    /// Takes the outcome of the order of the latest [`Action::Execute`].
    pub fn conclude(&mut self, outcome: Outcome) {
        self.outcome = outcome;
    }

    /// Opens a session, unless the request is for an older boot or session.
    fn open(&mut self, open: Open) {
        let is_present = open.era.is_none_or(|era| era == self.era);
        if is_present && open.boot == self.boot && open.replaces == self.session {
            self.begin_session(Some(open.owner));
            self.is_numbered = open.era.is_some();
        }
    }

    fn begin_session(&mut self, owner: Option<u16>) {
        (self.era, self.session) = session_after(self.era, self.session);
        self.owner = owner;
        self.sequence = 0;
        self.outcome = Outcome::Done;
        self.drive_count = 0;
        self.receipt = None;
        self.lists.abandon();
    }
}
