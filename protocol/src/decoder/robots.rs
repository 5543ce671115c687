//! Tells apart the lines of robots that share a channel.

use super::Received;
use crate::telemetry::SEQUENCE_MODULUS;

/// Lines of the other robot in a row after which it replaces the followed one: five seconds of a busy radio.
const REPLACED_AFTER: u8 = 15;

/// The robot that is followed and another one on its channel. Most lines hold their robot's id. Any other line belongs to the
/// robot with its boot counter; if both have the same, to the one whose sequence it continues more closely.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Robots {
    own: Option<Robot>,
    other: Option<Robot>,
    /// Lines of the other robot since the latest own one.
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
    /// The one that is followed.
    Own,
    /// Another one.
    Other,
    /// Another one, which is followed from this line on.
    Successor,
}

impl Robots {
    /// Takes a line; returns its sender. The first robot heard is followed.
    pub(super) fn take(&mut self, received: &Received) -> Sender {
        let (boot, sequence) = (received.ack().boot, received.sequence());
        // 0 is the id of no robot.
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
        // Lines between it and the robot's latest one. A robot does not send a sequence twice in a row.
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

    /// Id of the other robot; `None` while there is none.
    pub(super) fn other_id(&self) -> Option<u8> {
        self.other.map(|robot| robot.id)
    }
}
