//! The steps of a command as JSON, for programs: on the shared socket and from `send --json`.

use groundwave_protocol::telemetry::{Outcome, ParameterLine, ParameterName, Printable};
use serde::{Deserialize, Serialize};

use crate::event::{CommandStep, Failure};
use crate::request::Request;

/// A step in the life of a command, as it is written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "stage", rename_all = "lowercase")]
pub enum Stage {
    /// Waits for its turn.
    Queued,
    /// A frame of it went to the radio.
    Sent {
        /// Frames sent so far.
        frames: u32,
    },
    /// Blocks of a waypoint list were acknowledged.
    Progress {
        /// Waypoints acknowledged.
        acknowledged: u16,
        /// Waypoints in the list.
        total: u16,
    },
    /// The robot told of a parameter that was asked for.
    Told {
        /// Its name.
        name: String,
        /// What it is now.
        value: i32,
        /// What a reset brings back.
        kept: i32,
        /// Least value that the robot takes.
        least: i32,
        /// Most.
        most: i32,
        /// What it counts.
        unit: String,
        /// Which of them it is, from 1.
        place: u8,
        /// How many the robot has.
        count: u8,
    },
    /// The robot's own acknowledgement says so.
    Proven {
        /// Digest of the list now active, eight hexadecimal digits.
        digest: Option<String>,
    },
    /// The robot refused.
    Refused {
        /// Why, for a program.
        code: String,
        /// Why, for a person.
        reason: String,
    },
    /// Given up without proof.
    Failed {
        /// Why, for a program.
        code: String,
        /// Why, for a person.
        reason: String,
    },
}

impl Stage {
    /// How a step is written.
    #[must_use]
    pub fn of(step: &CommandStep) -> Self {
        match step {
            CommandStep::Queued(_) => Self::Queued,
            CommandStep::Sent { frames } => Self::Sent { frames: *frames },
            CommandStep::Progress {
                acknowledged,
                total,
            } => Self::Progress {
                acknowledged: *acknowledged,
                total: *total,
            },
            CommandStep::Told(line) => Self::Told {
                name: line.name.as_str().to_owned(),
                value: line.value,
                kept: line.kept,
                least: line.least,
                most: line.most,
                unit: line.unit.as_str().to_owned(),
                place: line.place,
                count: line.count,
            },
            CommandStep::Proven { digest } => Self::Proven {
                digest: digest.map(|digest| format!("{digest:08x}")),
            },
            CommandStep::Refused(outcome) => Self::Refused {
                code: outcome_code(*outcome).to_owned(),
                reason: why_refused(*outcome).to_owned(),
            },
            CommandStep::Failed(failure) => Self::Failed {
                code: failure_code(*failure).to_owned(),
                reason: failure.to_string(),
            },
        }
    }

    /// The step that was written, of a command that asked for `request`; `None` for a code of a newer
    /// station's.
    #[must_use]
    pub fn step(&self, request: &Request) -> Option<CommandStep> {
        Some(match self {
            Self::Queued => CommandStep::Queued(request.clone()),
            Self::Sent { frames } => CommandStep::Sent { frames: *frames },
            Self::Progress {
                acknowledged,
                total,
            } => CommandStep::Progress {
                acknowledged: *acknowledged,
                total: *total,
            },
            Self::Told {
                name,
                value,
                kept,
                least,
                most,
                unit,
                place,
                count,
            } => CommandStep::Told(Box::new(ParameterLine {
                place: *place,
                count: *count,
                name: ParameterName::new(name),
                value: *value,
                kept: *kept,
                least: *least,
                most: *most,
                unit: Printable::new(unit),
            })),
            Self::Proven { digest } => CommandStep::Proven {
                digest: match digest {
                    Some(digits) => Some(u32::from_str_radix(digits, 16).ok()?),
                    None => None,
                },
            },
            Self::Refused { code, .. } => CommandStep::Refused(
                Outcome::ALL
                    .into_iter()
                    .find(|outcome| outcome_code(*outcome) == code)?,
            ),
            Self::Failed { code, .. } => CommandStep::Failed(
                Failure::ALL
                    .into_iter()
                    .find(|failure| failure_code(*failure) == code)?,
            ),
        })
    }
}

const fn outcome_code(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "done",
        Outcome::NotFitted => "not-fitted",
        Outcome::BadValue => "bad-value",
        Outcome::ListIncomplete => "list-incomplete",
        Outcome::DigestMismatch => "digest-mismatch",
        Outcome::NotNow => "not-now",
        Outcome::Unknown => "unknown",
        Outcome::Failed => "failed",
    }
}

const fn failure_code(failure: Failure) -> &'static str {
    match failure {
        Failure::TimedOut => "timed-out",
        Failure::RobotRestarted => "robot-restarted",
        Failure::TakenOver => "taken-over",
        Failure::Stopped => "stopped",
        Failure::Cancelled => "cancelled",
        Failure::ReceiveOnly => "receive-only",
    }
}

/// The robot's reason in words.
#[must_use]
pub const fn why_refused(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Done => "it did not refuse",
        Outcome::NotFitted => "this robot has no such layer or mode",
        Outcome::BadValue => "a value is out of range",
        Outcome::ListIncomplete => "waypoints are missing",
        Outcome::DigestMismatch => "the list it holds is not the one that was announced",
        Outcome::NotNow => "not in its present state",
        Outcome::Unknown => "its firmware does not know this command",
        Outcome::Failed => "it tried and could not",
    }
}
