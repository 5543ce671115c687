//! The robot's end of delivery: accepts each command exactly once and acknowledges it in every line.

use super::Lists;
use crate::command::{Drive, Key, Message, Open, Order};
use crate::telemetry::{Ack, Detail, Outcome};

/// Action of the robot on a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Motors off, at once.
    Stop,
    /// Carry out the order, then call [`Farm::conclude`] with its outcome.
    Execute(Order),
    /// The active list was replaced.
    ListReplaced,
    /// Drive by hand for the next second, if the frame is fresh; then call [`Farm::take_drive`].
    Drive(Drive),
    /// None: the message only shows that the ground is there.
    Heard,
}

/// The Frame Acceptance and Reporting Mechanism.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Farm {
    robot_id: u8,
    boot: u8,
    session: u8,
    /// Owner of the session; `None` when none is open.
    owner: Option<u16>,
    /// Sequence of the latest command, 6 bits; the number of STOPs while no session is open.
    sequence: u8,
    outcome: Outcome,
    drive_count: u8,
    /// Receipt of the STOP that closed the session, or of a later one.
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
            owner: None,
            sequence: 0,
            outcome: Outcome::Done,
            drive_count: 0,
            receipt: None,
            lists: Lists::default(),
        }
    }

    /// The key that frames of the open session are checked with; `None` when none is open.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        self.owner
            .map(|owner| Key::session(self.robot_id, self.boot, self.session, owner))
    }

    /// The acknowledgement.
    #[must_use]
    pub fn ack(&self) -> Ack {
        let receipt = self.receipt.map(|receipt| Detail::Stopped { receipt });
        let detail = self.lists.detail().or(receipt);
        self.ack_with(detail.unwrap_or(self.idle()))
    }

    /// The acknowledgement in the line of this sequence: one line in three has the robot's id instead of a receipt, for
    /// stations that have just started.
    #[must_use]
    pub fn ack_in(&self, sequence: u8) -> Ack {
        if self.receipt.is_some() && sequence % 3 == 1 {
            self.ack_with(self.idle())
        } else {
            self.ack()
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

    /// Takes an intact message; returns the robot's action. It returns each order once only.
    pub fn handle(&mut self, message: &Message) -> Action {
        match message {
            Message::Stop(receipt) => {
                if self.owner.is_some() {
                    self.begin_session(None);
                } else {
                    // Without a session the sequence counts STOPs, so that each shows in the acknowledgement.
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

    /// Takes the count of a drive frame that was obeyed, so that neither it nor older ones are obeyed again.
    pub fn take_drive(&mut self, drive: &Drive) {
        self.drive_count = drive.count;
    }

    /// Takes the outcome of the order of the latest [`Action::Execute`].
    pub fn conclude(&mut self, outcome: Outcome) {
        self.outcome = outcome;
    }

    /// Opens a session, unless the request is for an older boot or session.
    fn open(&mut self, open: Open) {
        if open.boot == self.boot && open.replaces == self.session {
            self.begin_session(Some(open.owner));
        }
    }

    fn begin_session(&mut self, owner: Option<u16>) {
        self.session = self.session % 7 + 1;
        self.owner = owner;
        self.sequence = 0;
        self.outcome = Outcome::Done;
        self.drive_count = 0;
        self.receipt = None;
        self.lists.abandon();
    }
}
