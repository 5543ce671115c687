//! The wire between an SR04 robot and its ground station.
//!
//! Down: lines of exactly 80 bytes at 2400 baud ([`telemetry`], found in a noisy stream by
//! [`decoder::Decoder`]). Up: short frames between line feeds ([`command`], found by
//! [`receiver::Receiver`]). Between them, [`arq`] makes every command execute exactly once and
//! proves it. `SPEC.md` beside this crate says the same for people with another robot and another
//! language.
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
pub mod letters;
pub mod life;
pub mod parameter;
pub mod receiver;
pub mod sixbit;
pub mod telemetry;

/// Bytes in a telemetry line, CR LF included.
pub const LINE_BYTES: usize = 80;

/// Bytes a second at 2400 baud 8N1.
pub const BYTES_PER_S: u32 = 240;

/// Most waypoints a list can hold.
pub const WAYPOINTS_MAX: usize = 300;

/// Farthest a waypoint may lie from the origin along either axis, in inches.
pub const WAYPOINT_LIMIT_IN: i16 = 9999;

/// A point to drive to, in whole inches from the robot's origin.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Waypoint {
    /// East of the origin when negative X is west: the robot's X at theta 90.
    pub x_in: i16,
    /// Ahead of the origin: the robot's Y at theta 0.
    pub y_in: i16,
}

impl Waypoint {
    /// A waypoint, or `None` when a coordinate lies beyond [`WAYPOINT_LIMIT_IN`].
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
