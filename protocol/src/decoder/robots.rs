//! Distinguishes the lines of robots that share a channel.

use super::Received;
use crate::telemetry::SEQUENCE_MODULUS;

/// Number of consecutive lines of the other robot after which it replaces the followed one: five seconds of a busy radio.
const REPLACED_AFTER: u8 = 15;

/// The followed robot and another robot on its channel. Most lines contain their robot's id. Any other line belongs to the
/// robot with the same boot counter; if both robots have it, to the one whose sequence the line continues more closely.
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
    boot: u8,
    sequence: u8,
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
}

impl Robots {
    /// Takes a line; returns its sender. The first robot received is followed.
    pub(super) fn take(&mut self, received: &Received) -> Sender {
        let (boot, sequence) = (received.ack().boot, received.sequence());
        // No robot has the id 0.
        let Some(id) = received.robot_id().filter(|id| *id != 0) else {
            return if self.take_nameless(boot, sequence) {
                Sender::Own
            } else {
                Sender::Other
            };
        };
        let robot = Some(Robot { id, boot, sequence });
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

    fn take_nameless(&mut self, boot: u8, sequence: u8) -> bool {
        let (Some(own), Some(other)) = (&mut self.own, &mut self.other) else {
            if let Some(own) = &mut self.own {
                (own.boot, own.sequence) = (boot, sequence);
            }
            return true;
        };
        // Number of lines between the line and the robot's latest one. A robot does not send the same sequence twice in a row.
        let skipped =
            |robot: &Robot| (sequence + SEQUENCE_MODULUS - robot.sequence - 1) % SEQUENCE_MODULUS;
        let is_own = if own.boot == other.boot {
            skipped(own) <= skipped(other)
        } else {
            other.boot != boot
        };
        let robot = if is_own { own } else { other };
        (robot.boot, robot.sequence) = (boot, sequence);
        is_own
    }

    /// Id of the other robot; `None` if there is none.
    pub(super) fn other_id(&self) -> Option<u8> {
        self.other.map(|robot| robot.id)
    }
}
