//! Delivery of commands, as pure state machines after CCSDS COP-1: the robot's [`Farm`] and the ground's [`Fop`].

mod farm;
mod fop;
mod lists;
mod pacer;
mod quality;
mod status;
mod transfer;

pub use farm::{Action, Farm};
pub use fop::{Config, DRIVE_LEVEL, Duplex, Fop, FopEvent, Task};
pub use lists::Lists;
pub use status::{CommandStatus, Failure, Shortfall};

use crate::command::ERA_MAX;

/// Time of a byte at 2400 baud, microseconds.
const US_PER_BYTE: u64 = 1_000_000 / crate::BYTES_PER_S as u64;

/// The last session number of an era. Numbers begin with 1; 0 precedes the first session of a life.
const SESSION_LAST: u8 = 7;

/// Era and number of the next session.
#[must_use]
pub const fn session_after(era: u16, session: u8) -> (u16, u8) {
    if session == SESSION_LAST {
        ((era + 1) & ERA_MAX, 1)
    } else {
        (era, session + 1)
    }
}
