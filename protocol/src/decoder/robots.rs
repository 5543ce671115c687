//! Distinguishes the lines of robots that share a channel.

use super::{LATE_LINES_MAX, Received};
use crate::telemetry::SEQUENCE_MODULUS;

/// Number of consecutive lines of the other robot after which it replaces the followed one: five seconds of a busy radio.
const REPLACED_AFTER: u8 = 15;

/// Maximum number of lines missing between two lines that are taken for the same robot's without its id.
const NEAR: u8 = 8;

/// The followed robot and another robot on its channel. Most lines contain their robot's id. Any other line belongs to the
/// robot with the same boot counter; if both robots have it, to the one whose sequence the line continues more closely. If it continues no
/// known robot, the next line decides: the robot may have restarted, or was not heard for long, or another robot may be on the channel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Robots {
    own: Option<Robot>,
    other: Option<Robot>,
    /// Number of lines of the other robot since the latest line of the followed one.
    in_a_row: u8,
}

#[derive(Clone, Copy, Debug)]
struct Robot {
    id: u8,
    latest: Place,
}

/// A line's place in a robot's life.
#[derive(Clone, Copy, Debug)]
struct Place {
    boot: u8,
    sequence: u8,
}

impl Place {
    const fn of(received: &Received) -> Self {
        Self {
            boot: received.ack().boot,
            sequence: received.sequence(),
        }
    }

    /// Number of lines between an earlier line of the same boot and this one. A robot does not send the same sequence twice in a row.
    const fn skipped_since(self, earlier: Self) -> u8 {
        (self.sequence + SEQUENCE_MODULUS - earlier.sequence - 1) % SEQUENCE_MODULUS
    }

    /// Whether this line comes soon after another one of the same boot.
    const fn follows(self, earlier: Self) -> bool {
        self.boot == earlier.boot && self.skipped_since(earlier) <= NEAR
    }

    /// Whether this line may be of the robot whose latest line is given, or a late one of it.
    const fn continues(self, latest: Self) -> bool {
        let is_late = latest.skipped_since(self) < LATE_LINES_MAX;
        let is_repeated = latest.sequence == self.sequence;
        self.boot == latest.boot && (self.follows(latest) || is_late || is_repeated)
    }
}

/// The robot that sent a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sender {
    /// The followed robot.
    Own,
    /// Another robot.
    Other,
    /// Another robot, which is followed from this line on.
    Successor,
    /// The next line decides, with [`Robots::sent_own`].
    Undecided,
}

impl Robots {
    /// Takes a line; returns its sender. The first robot received is followed. After a silence, an only robot's lines are not expected to be
    /// near each other.
    pub(super) fn take(&mut self, received: &Received, is_after_silence: bool) -> Sender {
        let latest = Place::of(received);
        let Some(id) = id_of(received) else {
            let sender = self.sender_of(latest, is_after_silence);
            self.follow(sender, latest);
            return sender;
        };
        let robot = Some(Robot { id, latest });
        if self.own.is_none_or(|own| own.id == id) {
            self.own = robot;
            self.in_a_row = 0;
            return Sender::Own;
        }
        self.other = robot;
        self.in_a_row += 1;
        if self.in_a_row < REPLACED_AFTER {
            return Sender::Other;
        }
        *self = Self {
            own: robot,
            ..Self::default()
        };
        Sender::Successor
    }

    /// The sender of a line without an id.
    fn sender_of(&self, line: Place, is_after_silence: bool) -> Sender {
        let Some(own) = self.own else {
            return Sender::Own;
        };
        match self.other {
            None if line.continues(own.latest)
                || is_after_silence && line.boot == own.latest.boot =>
            {
                Sender::Own
            }
            Some(other) if line.boot == own.latest.boot => {
                let is_own = line.boot != other.latest.boot
                    || line.skipped_since(own.latest) <= line.skipped_since(other.latest);
                if is_own { Sender::Own } else { Sender::Other }
            }
            Some(other) if line.boot == other.latest.boot => Sender::Other,
            None | Some(_) => Sender::Undecided,
        }
    }

    fn follow(&mut self, sender: Sender, line: Place) {
        let robot = match sender {
            Sender::Other => &mut self.other,
            Sender::Own | Sender::Successor => &mut self.own,
            Sender::Undecided => return,
        };
        if let Some(robot) = robot {
            robot.latest = line;
        }
    }

    /// Decides by the `next` line, which is not taken yet, whether the followed robot sent an undecided line; `None` if that remains open.
    pub(super) fn sent_own(
        &mut self,
        undecided: &Received,
        next: &Received,
        is_after_silence: bool,
    ) -> Option<bool> {
        let own = self.own?;
        let (line, next_line) = (Place::of(undecided), Place::of(next));
        let follows = next_line.follows(line);
        let skipped = next_line.skipped_since(own.latest);
        let is_own = match id_of(next) {
            Some(id) if id != own.id => {
                return follows.then_some(false);
            }
            None if self.sender_of(next_line, is_after_silence) == Sender::Other => return None,
            // The robot is where it was before, unless it numbers its lines through and shows a wrong boot.
            _ if next_line.continues(own.latest)
                && !(follows && next_line.skipped_since(line) < skipped) =>
            {
                line.skipped_since(own.latest) < skipped
            }
            _ => true,
        };
        if is_own {
            self.follow(Sender::Own, line);
        }
        Some(is_own)
    }

    /// Id of the other robot; `None` if there is none.
    pub(super) fn other_id(&self) -> Option<u8> {
        self.other.map(|robot| robot.id)
    }
}

/// The id in a line. No robot has the id 0.
fn id_of(received: &Received) -> Option<u8> {
    received.robot_id().filter(|id| *id != 0)
}
