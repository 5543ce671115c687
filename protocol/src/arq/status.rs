//! Status of a command: the same type in delivery, on the screen, in recordings and in JSON.

use core::fmt;

use crate::telemetry::{Outcome, ParameterLine};

/// Status of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CommandStatus {
    /// The command waits for its turn.
    Queued,
    /// Frames of the command were sent to the radio.
    Sent {
        /// Number of frames sent for the command, including repetitions.
        frames: u32,
    },
    /// The robot acknowledged some waypoints of a list.
    Progress {
        /// Number of acknowledged waypoints.
        acknowledged: u16,
        /// Number of waypoints in the list.
        total: u16,
    },
    /// The robot reported a parameter that the command requested.
    Reported(ParameterLine),
    /// The robot acknowledged that it executed the command; for a list, that the digest matched.
    Confirmed {
        /// Digest of the list, for a list command.
        digest: Option<u32>,
    },
    /// A robot without acknowledgements sent the expected text. The text may be late, or an answer to another command.
    Echoed,
    /// The robot refused the command.
    Refused(Outcome),
    /// The command ended without confirmation.
    Failed(Failure),
}

impl CommandStatus {
    /// Stable code of [`Self::Queued`].
    pub const QUEUED: &str = "queued";
    /// Stable code of [`Self::Sent`].
    pub const SENT: &str = "sent";
    /// Stable code of [`Self::Progress`].
    pub const PROGRESS: &str = "progress";
    /// Stable code of [`Self::Reported`].
    pub const REPORTED: &str = "reported";
    /// Stable code of [`Self::Confirmed`].
    pub const CONFIRMED: &str = "confirmed";
    /// Stable code of [`Self::Echoed`].
    pub const ECHOED: &str = "echoed";
    /// Stable code of [`Self::Refused`].
    pub const REFUSED: &str = "refused";
    /// Stable code of [`Self::Failed`].
    pub const FAILED: &str = "failed";

    /// Stable code of the status.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Queued => Self::QUEUED,
            Self::Sent { .. } => Self::SENT,
            Self::Progress { .. } => Self::PROGRESS,
            Self::Reported(_) => Self::REPORTED,
            Self::Confirmed { .. } => Self::CONFIRMED,
            Self::Echoed => Self::ECHOED,
            Self::Refused(_) => Self::REFUSED,
            Self::Failed(_) => Self::FAILED,
        }
    }

    /// Stable code of the reason why the command was refused or failed.
    #[must_use]
    pub const fn reason_code(&self) -> Option<&'static str> {
        match self {
            Self::Refused(outcome) => Some(outcome.code()),
            Self::Failed(failure) => Some(failure.code()),
            _ => None,
        }
    }

    /// Whether the command has ended.
    #[must_use]
    pub const fn is_end(&self) -> bool {
        matches!(
            self,
            Self::Confirmed { .. } | Self::Echoed | Self::Refused(_) | Self::Failed(_)
        )
    }
}

/// The amount that a robot reports, and the larger amount that a command needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Shortfall {
    /// The amount that the robot has.
    pub has: u16,
    /// The amount that the command needs.
    pub needs: u16,
}

/// Reason why a command ended without confirmation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Failure {
    /// No acknowledgement arrived in time.
    TimedOut,
    /// No frame of the command was sent in time, because the link was lost or nothing was received.
    NotSent,
    /// The robot restarted.
    RobotRestarted,
    /// Another station opened a session.
    TakenOver,
    /// STOP, from this station or another, ended the session.
    Stopped,
    /// The operator cancelled the command.
    Cancelled,
    /// The link is receive-only.
    ReceiveOnly,
    /// The robot reports that it cannot hear.
    CannotHear,
    /// The command needs a higher level than the robot reports.
    BeyondLevel(Shortfall),
    /// The list has more waypoints than the robot reports that it can hold.
    BeyondCapacity(Shortfall),
    /// The robot has command strings, but none for this command.
    NotConfigured,
}

impl Failure {
    /// All failures; shortfalls are examples.
    pub const ALL: [Self; 11] = [
        Self::TimedOut,
        Self::NotSent,
        Self::RobotRestarted,
        Self::TakenOver,
        Self::Stopped,
        Self::Cancelled,
        Self::ReceiveOnly,
        Self::CannotHear,
        Self::BeyondLevel(Shortfall { has: 2, needs: 3 }),
        Self::BeyondCapacity(Shortfall { has: 8, needs: 9 }),
        Self::NotConfigured,
    ];

    /// Stable code.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::TimedOut => "timed-out",
            Self::NotSent => "not-sent",
            Self::RobotRestarted => "robot-restarted",
            Self::TakenOver => "taken-over",
            Self::Stopped => "stopped",
            Self::Cancelled => "cancelled",
            Self::ReceiveOnly => "receive-only",
            Self::CannotHear => "cannot-hear",
            Self::BeyondLevel(_) => "beyond-level",
            Self::BeyondCapacity(_) => "beyond-capacity",
            Self::NotConfigured => "not-configured",
        }
    }

    /// The robot's shortfall, if it is the reason.
    #[must_use]
    pub const fn shortfall(self) -> Option<Shortfall> {
        match self {
            Self::BeyondLevel(shortfall) | Self::BeyondCapacity(shortfall) => Some(shortfall),
            _ => None,
        }
    }

    /// The failure with a code; `None` for an unknown one, or if its shortfall is missing.
    #[must_use]
    pub fn from_code(code: &str, shortfall: Option<Shortfall>) -> Option<Self> {
        let failure = Self::ALL
            .into_iter()
            .find(|failure| failure.code() == code)?;
        Some(match failure {
            Self::BeyondLevel(_) => Self::BeyondLevel(shortfall?),
            Self::BeyondCapacity(_) => Self::BeyondCapacity(shortfall?),
            _ => failure,
        })
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TimedOut => "not confirmed: the robot may or may not have heard it",
            Self::NotSent => "not sent: the link was lost, or no line came from the robot",
            Self::RobotRestarted => "the robot restarted before it confirmed",
            Self::TakenOver => "another station took over the robot",
            Self::Stopped => "cancelled by STOP",
            Self::Cancelled => "cancelled",
            Self::ReceiveOnly => "the link is receive-only",
            Self::NotConfigured => {
                "not sent: the robot has no such command string, or not with these arguments"
            }
            Self::CannotHear => "the robot reports that it cannot hear: it has no receiver",
            Self::BeyondLevel(Shortfall { has, needs }) => {
                return write!(f, "needs level {needs}, the robot has level {has}");
            }
            Self::BeyondCapacity(Shortfall { has, needs }) => {
                return write!(f, "has {needs} waypoints, the robot holds {has}");
            }
        })
    }
}

impl core::error::Error for Failure {}
