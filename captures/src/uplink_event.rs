//! Status of commands and the robot's acknowledgements, as a protobuf message.

use groundwave_protocol::arq::{CommandStatus, Failure, Shortfall};
use groundwave_protocol::telemetry::Outcome;

use crate::event::CommandId;

/// A command's new status, or a change in the robot's acknowledgement. Absent fields do not apply.
#[derive(Clone, PartialEq, prost::Message)]
pub struct UplinkEvent {
    /// Code of the status, or [`Self::ACKNOWLEDGEMENT`] or [`Self::LIST`].
    #[prost(string, tag = 1)]
    pub status: String,
    /// Number of the command in its session at the station, from 1.
    #[prost(uint32, optional, tag = 2)]
    pub command_id: Option<u32>,
    /// The command as typed on the command line, when it is queued.
    #[prost(string, optional, tag = 3)]
    pub command: Option<String>,
    /// Number of frames sent for the command so far, repetitions included.
    #[prost(uint32, optional, tag = 4)]
    pub frames: Option<u32>,
    /// Number of waypoints that the robot acknowledged.
    #[prost(uint32, optional, tag = 5)]
    pub acknowledged: Option<u32>,
    /// Number of waypoints in the list.
    #[prost(uint32, optional, tag = 6)]
    pub total: Option<u32>,
    /// Digest of a waypoint list that the robot confirmed.
    #[prost(uint32, optional, tag = 7)]
    pub list_digest: Option<u32>,
    /// Stable code: why the command was refused or failed, or the outcome that the robot acknowledged.
    #[prost(string, optional, tag = 8)]
    pub code: Option<String>,
    /// The client that gave the command, if the link is shared.
    #[prost(string, optional, tag = 9)]
    pub by: Option<String>,
    /// Low 3 bits of the robot's boot counter.
    #[prost(uint32, optional, tag = 10)]
    pub boot: Option<u32>,
    /// Session, 1 to 7 in turn; 0 before the first.
    #[prost(uint32, optional, tag = 11)]
    pub session: Option<u32>,
    /// Sequence of the latest command taken, low 3 bits.
    #[prost(uint32, optional, tag = 12)]
    pub sequence: Option<u32>,
    /// X of each waypoint of a queued list, inches.
    #[prost(sint32, repeated, tag = 13)]
    pub waypoints_x_in: Vec<i32>,
    /// Y of each waypoint of a queued list, inches.
    #[prost(sint32, repeated, tag = 14)]
    pub waypoints_y_in: Vec<i32>,
    /// Name of a parameter that the robot reported.
    #[prost(string, optional, tag = 15)]
    pub parameter_name: Option<String>,
    /// Value of the reported parameter.
    #[prost(sint32, optional, tag = 16)]
    pub parameter_value: Option<i32>,
    /// Level or capacity that the robot reports, if the command was not sent because it needs more.
    #[prost(uint32, optional, tag = 17)]
    pub has: Option<u32>,
    /// Level or capacity that the command needs.
    #[prost(uint32, optional, tag = 18)]
    pub needs: Option<u32>,
}

impl UplinkEvent {
    /// Status code: the robot acknowledges another command than before. Derived from its lines.
    pub const ACKNOWLEDGEMENT: &str = "acknowledgement";
    /// Status code: the robot holds another list than before. Derived from its lines.
    pub const LIST: &str = "list";

    /// An event with a status and no other field.
    #[must_use]
    pub fn new(status: &str) -> Self {
        Self {
            status: status.to_owned(),
            ..Self::default()
        }
    }

    /// A command's new status.
    #[must_use]
    pub fn of_command(id: CommandId, status: &CommandStatus) -> Self {
        let mut event = Self {
            command_id: Some(id.0),
            code: status.reason_code().map(str::to_owned),
            ..Self::new(status.code())
        };
        match status {
            CommandStatus::Queued | CommandStatus::Echoed | CommandStatus::Refused(_) => {}
            CommandStatus::Failed(failure) => {
                let shortfall = failure.shortfall();
                event.has = shortfall.map(|it| it.has.into());
                event.needs = shortfall.map(|it| it.needs.into());
            }
            CommandStatus::Sent { frames } => event.frames = Some(*frames),
            CommandStatus::Progress {
                acknowledged,
                total,
            } => {
                event.acknowledged = Some((*acknowledged).into());
                event.total = Some((*total).into());
            }
            CommandStatus::Reported(line) => {
                event.parameter_name = Some(line.name.as_str().to_owned());
                event.parameter_value = Some(line.value);
            }
            CommandStatus::Confirmed { digest } => event.list_digest = *digest,
        }
        event
    }

    /// Status of the command; `None` for an unknown code, and for a reported parameter, whose line is among the
    /// received bytes.
    #[must_use]
    pub fn command_status(&self) -> Option<CommandStatus> {
        let code = self.code.as_deref();
        Some(match self.status.as_str() {
            CommandStatus::QUEUED => CommandStatus::Queued,
            CommandStatus::SENT => CommandStatus::Sent {
                frames: self.frames?,
            },
            CommandStatus::PROGRESS => CommandStatus::Progress {
                acknowledged: u16::try_from(self.acknowledged?).ok()?,
                total: u16::try_from(self.total?).ok()?,
            },
            CommandStatus::CONFIRMED => CommandStatus::Confirmed {
                digest: self.list_digest,
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
            has: u16::try_from(self.has?).ok()?,
            needs: u16::try_from(self.needs?).ok()?,
        })
    }
}
