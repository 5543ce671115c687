//! What the caller says to the ground's end and hears from it.

use crate::Waypoint;
use crate::command::Order;
use crate::telemetry::Outcome;

/// How the ground's end behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Config {
    /// Tells this station from others; 10 bits, not 0. Draw it at random.
    pub owner: u16,
    /// The robot's id when it is known beforehand; otherwise learned from what is heard before a
    /// session opens. Lines that name another robot are not acted on.
    pub robot_id: Option<u8>,
    /// What the link may add to the time on the wire, both ways together.
    pub latency_us: u64,
    /// Whether both ends can talk at once.
    pub duplex: Duplex,
    /// Without any line, what is outstanding is sent again after this.
    pub silence_us: u64,
    /// Without any progress, a task fails after this.
    pub give_up_us: u64,
}

impl Config {
    /// Robot and radio unknown.
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
    /// To be found out: a half-duplex robot says when it listens.
    Unknown,
    /// They can.
    Full,
    /// They take turns: this end speaks only when the robot listens.
    Half,
}

/// One thing to deliver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Task<'a> {
    /// Any order but [`Order::Activate`].
    Order(Order),
    /// Replace the robot's list by this one: at most [`crate::WAYPOINTS_MAX`], each as [`Waypoint::new`] makes
    /// it.
    List(&'a [Waypoint]),
}

/// What the ground's end has to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FopEvent {
    /// A session was opened; or lost, with the reason why.
    Session(Result<(), Loss>),
    /// Frames of the task went out for the first time, or something had to be repeated.
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
    /// The robot took the command. For a list that is [`Outcome::Done`], it has verified the digest.
    Concluded {
        /// What became of it.
        outcome: Outcome,
        /// Digest of the list, if it was one.
        digest: Option<u32>,
    },
    /// The task ended without proof.
    Failed(Loss),
    /// STOP has left for the first time.
    StopSent,
    /// An acknowledgement that only a STOP brings about came after STOP had left.
    StopProven,
    /// STOP was given up without proof.
    StopFailed,
}

/// Why something ended without proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Loss {
    /// No progress within [`Config::give_up_us`].
    TimedOut,
    /// The robot booted.
    RobotRestarted,
    /// Another station opened a session.
    TakenOver,
    /// STOP, from here or from elsewhere, ended the session.
    Stopped,
    /// Given up by the caller.
    Cancelled,
}
