//! A command's status as JSON, for the shared socket, `send --json` and `watch --headless`.

use groundwave_protocol::telemetry::{Outcome, ParameterLine, ParameterName, Printable};
use serde::{Deserialize, Serialize};

use crate::event::{CommandStatus, Failure, Shortfall};
use crate::request::outcome_words;

/// A status in JSON: `{"status":"refused","code":"bad-value","text":"a value is out of range"}`. Codes are stable; the
/// text is for display.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatusJson {
    /// Code of the status.
    pub status: String,
    /// Reason why the command was refused or failed, as a stable code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub code: Option<String>,
    /// The reason as text, for display.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
    /// Number of frames sent so far.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<u32>,
    /// Number of acknowledged waypoints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acknowledged: Option<u16>,
    /// Number of waypoints in the list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub total: Option<u16>,
    /// Level or capacity that the robot reports, if the command was not sent because it needs more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub has: Option<u16>,
    /// Level or capacity that the command needs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub needs: Option<u16>,
    /// Digest of the confirmed list, eight hexadecimal digits.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
    /// The parameter that the robot reported.
    #[serde(flatten)]
    pub parameter: Option<ParameterJson>,
}

/// A parameter of the robot.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ParameterJson {
    name: String,
    /// Current value.
    value: i32,
    /// Value after a reset.
    kept: i32,
    /// Minimum value.
    least: i32,
    /// Maximum value.
    most: i32,
    unit: String,
    /// Number of the parameter in the robot's list, from 1.
    place: u8,
    /// Number of parameters in the robot's list.
    count: u8,
}

impl StatusJson {
    /// A failure that is not a [`CommandStatus`], with its code and text.
    #[must_use]
    pub fn failed(code: &str, text: impl Into<String>) -> Self {
        Self {
            status: CommandStatus::FAILED.to_owned(),
            code: Some(code.to_owned()),
            text: Some(text.into()),
            ..Self::default()
        }
    }

    /// The status; `None` for a code of a newer station.
    #[must_use]
    pub fn status(&self) -> Option<CommandStatus> {
        let code = self.code.as_deref();
        Some(match self.status.as_str() {
            CommandStatus::QUEUED => CommandStatus::Queued,
            CommandStatus::SENT => CommandStatus::Sent {
                frames: self.frames?,
            },
            CommandStatus::PROGRESS => CommandStatus::Progress {
                acknowledged: self.acknowledged?,
                total: self.total?,
            },
            CommandStatus::REPORTED => CommandStatus::Reported(self.parameter.as_ref()?.into()),
            CommandStatus::CONFIRMED => CommandStatus::Confirmed {
                digest: match &self.digest {
                    Some(digits) => Some(u32::from_str_radix(digits, 16).ok()?),
                    None => None,
                },
            },
            CommandStatus::ECHOED => CommandStatus::Echoed,
            CommandStatus::REFUSED => CommandStatus::Refused(Outcome::from_code(code?)?),
            CommandStatus::FAILED => {
                CommandStatus::Failed(Failure::from_code(code?, self.shortfall())?)
            }
            _ => return None,
        })
    }

    fn shortfall(&self) -> Option<Shortfall> {
        Some(Shortfall {
            has: self.has?,
            needs: self.needs?,
        })
    }
}

impl From<&CommandStatus> for StatusJson {
    fn from(status: &CommandStatus) -> Self {
        let mut json = Self {
            status: status.code().to_owned(),
            code: status.reason_code().map(str::to_owned),
            ..Self::default()
        };
        match status {
            CommandStatus::Queued
            | CommandStatus::Echoed
            | CommandStatus::Confirmed { digest: None } => {}
            CommandStatus::Sent { frames } => json.frames = Some(*frames),
            CommandStatus::Progress {
                acknowledged,
                total,
            } => {
                json.acknowledged = Some(*acknowledged);
                json.total = Some(*total);
            }
            CommandStatus::Reported(line) => json.parameter = Some(line.into()),
            CommandStatus::Confirmed {
                digest: Some(digest),
            } => json.digest = Some(format!("{digest:08x}")),
            CommandStatus::Refused(outcome) => json.text = Some(outcome_words(*outcome).to_owned()),
            CommandStatus::Failed(failure) => {
                json.text = Some(failure.to_string());
                json.has = failure.shortfall().map(|it| it.has);
                json.needs = failure.shortfall().map(|it| it.needs);
            }
        }
        json
    }
}

impl From<&ParameterLine> for ParameterJson {
    fn from(line: &ParameterLine) -> Self {
        Self {
            name: line.name.as_str().to_owned(),
            value: line.value,
            kept: line.kept,
            least: line.least,
            most: line.most,
            unit: line.unit.as_str().to_owned(),
            place: line.place,
            count: line.count,
        }
    }
}

impl From<&ParameterJson> for ParameterLine {
    fn from(json: &ParameterJson) -> Self {
        Self {
            place: json.place,
            count: json.count,
            name: ParameterName::new(&json.name),
            value: json.value,
            kept: json.kept,
            least: json.least,
            most: json.most,
            unit: Printable::new(&json.unit),
        }
    }
}
