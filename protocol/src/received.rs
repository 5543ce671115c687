//! A received line of any type.

use crate::LINE_BYTES;
use crate::telemetry::{Ack, AckLine, Body, Detail, Line};

/// A line found in a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Received {
    /// An intact line, and its 80 bytes.
    Line(Line, [u8; LINE_BYTES]),
    /// An intact acknowledgement line.
    Ack(AckLine),
}

impl Received {
    /// The acknowledgement in this line.
    #[must_use]
    pub const fn ack(&self) -> &Ack {
        match self {
            Self::Line(line, _) => &line.ack,
            Self::Ack(line) => &line.ack,
        }
    }

    /// Id of the robot that sent the line; `None` if the line does not contain it.
    #[must_use]
    pub const fn robot_id(&self) -> Option<u8> {
        match (self, self.ack().detail) {
            (_, Detail::Idle { robot_id, .. } | Detail::CannotHear { robot_id }) => Some(robot_id),
            (Self::Line(line, _), _) => match &line.body {
                Body::Status(status) => Some(status.robot_id),
                Body::Counters(counters) => Some(counters.robot_id),
                Body::Abilities(abilities) => Some(abilities.robot_id),
                Body::State(_)
                | Body::Text(_)
                | Body::Parameter(_)
                | Body::Song(_)
                | Body::Field(_)
                | Body::Values(_) => None,
            },
            (Self::Ack(_), _) => None,
        }
    }

    /// Uptime in a line C, seconds since boot modulo 1,000,000; `None` for other lines.
    #[must_use]
    pub const fn uptime_s(&self) -> Option<u32> {
        match self.clock() {
            Some((uptime_s, _)) => Some(uptime_s),
            None => None,
        }
    }

    /// Uptime and number of frames heard in a line C.
    pub(crate) const fn clock(&self) -> Option<(u32, u16)> {
        match self {
            Self::Line(line, _) => match &line.body {
                Body::Counters(counters) => Some((counters.uptime_s, counters.frames_heard)),
                _ => None,
            },
            Self::Ack(_) => None,
        }
    }

    /// The line's number, 0 to 99.
    #[must_use]
    pub const fn sequence(&self) -> u8 {
        match self {
            Self::Line(line, _) => line.sequence,
            Self::Ack(line) => line.sequence,
        }
    }
}
