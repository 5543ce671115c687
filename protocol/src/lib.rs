//! The wire between an SR04 robot and its ground station.
//!
//! Downlink: lines of 80 bytes at 2400 baud ([`telemetry`]), which [`decoder::Decoder`] finds in a noisy
//! stream. Uplink: short frames between line feeds ([`command`]), which [`receiver::Receiver`] finds. On top
//! of both, [`arq`] delivers each command exactly once. `SPEC.md` specifies the protocol, for other robots
//! and languages.
//!
//! No heap, no floats, no clock: `now` is always a parameter.
#![no_std]
#![deny(clippy::float_arithmetic)]

#[cfg(test)]
extern crate std;

pub mod arq;
pub mod command;
pub mod crc;
pub mod decoder;
pub mod digest;
pub mod failsafe;
pub mod life;
pub mod parameter;
mod received;
pub mod receiver;
pub mod sixbit;
pub mod status_codes;
pub mod telemetry;

/// Length of a line including CR LF, bytes.
pub const LINE_BYTES: usize = 80;

/// Number of bytes per second at 2400 baud 8N1.
pub const BYTES_PER_S: u32 = 240;

/// Maximum number of waypoints in a list.
pub const WAYPOINTS_MAX: usize = 300;

/// Maximum magnitude of a waypoint's coordinate, inches.
pub const WAYPOINT_LIMIT_IN: i16 = 9999;

/// A point to drive to, in inches from the robot's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Waypoint {
    /// X, inches; positive at heading 90 degrees.
    pub x_in: i16,
    /// Y, inches; positive at heading 0 degrees.
    pub y_in: i16,
}

impl Waypoint {
    /// A waypoint; `None` if a coordinate is beyond [`WAYPOINT_LIMIT_IN`].
    #[must_use]
    pub const fn new(x_in: i16, y_in: i16) -> Option<Self> {
        const LIMIT: i16 = WAYPOINT_LIMIT_IN;
        if x_in < -LIMIT || x_in > LIMIT || y_in < -LIMIT || y_in > LIMIT {
            None
        } else {
            Some(Self { x_in, y_in })
        }
    }
}
