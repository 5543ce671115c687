//! Configuration, tasks and events of the [`super::Fop`].

use crate::Waypoint;
use crate::command::Order;
use crate::telemetry::Outcome;

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
    Session(Result<(), Loss>),
    /// A frame of the task was sent, for the first time or again.
    Sent {
        /// Frames of the task sent so far.
        frames: u32,
    },
    /// The robot acknowledged more waypoints.
    Progress {
        /// Waypoints acknowledged.
        acknowledged: u16,
        /// Waypoints in the list.
        total: u16,
    },
    /// The robot acknowledged the command. With [`Outcome::Done`] for a list, it has verified the digest.
    Concluded {
        /// Result of the command.
        outcome: Outcome,
        /// Digest of the list; `None` for other orders.
        digest: Option<u32>,
    },
    /// The task failed without an acknowledgement.
    Failed(Loss),
    /// STOP was sent for the first time.
    StopSent,
    /// An acknowledgement proved the STOP.
    StopProven,
    /// STOP timed out without proof.
    StopFailed,
}

/// Reason why a task or session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Loss {
    /// No progress within [`Config::give_up_us`].
    TimedOut,
    /// The robot rebooted.
    RobotRestarted,
    /// Another station opened a session.
    TakenOver,
    /// A STOP, from this or another station, ended the session.
    Stopped,
    /// The caller cancelled the task.
    Cancelled,
}
