//! Configuration, tasks and events of the [`super::Fop`].

use super::super::status::{CommandStatus, Failure};
use crate::Waypoint;
use crate::command::Order;

/// Configuration of the [`super::Fop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Nonce of this station, 10 bits, not 0. Use a random number.
    pub owner: u16,
    /// Id of the robot; `None` to learn it from lines before a session is opened. Lines of other robots are ignored.
    pub robot_id: Option<u8>,
    /// Latency of the link in addition to the time on the wire, in both directions together, microseconds.
    pub latency_us: u64,
    /// Whether both ends can send at the same time.
    pub duplex: Duplex,
    /// Silence of the robot after which unacknowledged frames are sent again, microseconds.
    pub silence_us: u64,
    /// Time without progress after which a task fails, microseconds.
    pub give_up_us: u64,
}

impl Config {
    /// The configuration for an unknown robot and radio.
    #[must_use]
    pub const fn new(owner: u16) -> Self {
        Self {
            owner,
            robot_id: None,
            latency_us: 40_000,
            duplex: Duplex::Unknown,
            silence_us: 2_000_000,
            give_up_us: 15_000_000,
        }
    }
}

/// Whether both ends can send at the same time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Duplex {
    /// Unknown: to be learned from the robot's lines.
    Unknown,
    /// Both ends can send at the same time.
    Full,
    /// The ends take turns: the ground sends only while the robot listens.
    Half,
}

/// A task to deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Task<'a> {
    /// Any order except [`Order::Activate`].
    Order(Order),
    /// Replace the robot's list by this list of at most [`crate::WAYPOINTS_MAX`] valid waypoints.
    List(&'a [Waypoint]),
}

/// An event of the [`super::Fop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FopEvent {
    /// A session was opened, or lost for a reason.
    Session(Result<(), Failure>),
    /// The task has a new status.
    Task(CommandStatus),
    /// STOP has a new status: sent, confirmed or failed. A confirmation applies to the requests before the latest STOP sent; later
    /// requests still wait.
    Stop(CommandStatus),
    /// A STOP before the latest one sent is confirmed, and with it the requests before it was sent.
    EarlierStop {
        /// Number of STOPs with another receipt that were sent after it, at most 31.
        later: u16,
    },
}
