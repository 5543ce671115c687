//! Configuration, tasks and events of the [`super::Fop`].

use super::super::status::{CommandStatus, Failure};
use crate::Waypoint;
use crate::command::Order;

/// Configuration of the [`super::Fop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Nonce of this station, 10 bits, not 0. Draw it at random.
    pub owner: u16,
    /// Id of the robot; `None`: learn it from the lines before a session opens. Lines of other robots are ignored.
    pub robot_id: Option<u8>,
    /// Latency of the link in addition to the time on the wire, both ways together.
    pub latency_us: u64,
    /// Whether both ends can talk at once.
    pub duplex: Duplex,
    /// Silence of the robot after which unacknowledged frames are sent again.
    pub silence_us: u64,
    /// Time without progress after which a task fails.
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

/// Whether both ends can talk at once.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Duplex {
    /// Unknown: to be learned from the robot's lines.
    Unknown,
    /// Both ends can send at once.
    Full,
    /// The ends take turns: the ground sends only while the robot listens.
    Half,
}

/// A task to deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Task<'a> {
    /// Any order but [`Order::Activate`].
    Order(Order),
    /// Replace the robot's list by this one, of at most [`crate::WAYPOINTS_MAX`] valid waypoints.
    List(&'a [Waypoint]),
}

/// An event of the [`super::Fop`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FopEvent {
    /// A session was opened, or lost for a reason.
    Session(Result<(), Failure>),
    /// The task has a new status.
    Task(CommandStatus),
    /// STOP has a new status: sent, confirmed or failed. Confirmed are the requests before the latest one sent; later
    /// ones still wait.
    Stop(CommandStatus),
    /// A STOP is confirmed that is not the latest one sent, and with it the requests before it left.
    EarlierStop {
        /// STOPs with a receipt of their own that left after it, at most 31.
        later: u16,
    },
}
