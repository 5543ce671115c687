//! Events that are not in the radio's bytes, as a protobuf message.

use crate::estimate::{EstimateMessage, FloorMessage};
use crate::event::{
    AlarmEvent, AlarmStatus, CommandStatus, Figure, Level, LinkEvent, Mark, Moment, NoticeCode,
    Reception, SuggestionCode, SuggestionEvent, SuggestionStatus,
};
use crate::uplink_event::UplinkEvent;

/// Maximum accepted length of a recorded event, bytes. A route of 255 waypoints has 4 kB, the floor of a large hall 16 kB.
pub(crate) const EVENT_BYTES_MAX: usize = 32_768;

/// An event of the station, recorded on `/station`; `/uplink`, `/log`, `/pose_corrected`, `/tf_map` and `/map` are derived from it and the bytes.
/// Programs read codes and numbers; texts are for display.
#[derive(Clone, PartialEq, prost::Message)]
pub struct StationEvent {
    /// The event; `None` for one of a newer version.
    #[prost(oneof = "StationEventKind", tags = "1, 2, 3, 4, 5, 6, 7, 8, 9, 10")]
    pub kind: Option<StationEventKind>,
}

/// Kinds of [`StationEvent`].
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum StationEventKind {
    /// A command has a new status.
    #[prost(message, tag = 1)]
    Command(UplinkEvent),
    /// The connection to the radio changed.
    #[prost(message, tag = 2)]
    Link(LinkMessage),
    /// The kind of arriving bytes changed; a code of [`Reception`].
    #[prost(string, tag = 3)]
    Reception(String),
    /// The operator set or cleared a mark.
    #[prost(message, tag = 4)]
    Mark(MarkMessage),
    /// A line for the log.
    #[prost(message, tag = 5)]
    Notice(NoticeMessage),
    /// The station was suspended until now.
    #[prost(message, tag = 6)]
    Suspension(SuspensionMessage),
    /// Something happened to an alarm.
    #[prost(message, tag = 7)]
    Alarm(AlarmMessage),
    /// A suggestion has a new status.
    #[prost(message, tag = 8)]
    Suggestion(SuggestionMessage),
    /// The ground's estimate of the robot's pose.
    #[prost(message, tag = 9)]
    Estimate(EstimateMessage),
    /// The floor that the robot has seen.
    #[prost(message, tag = 10)]
    Floor(FloorMessage),
}

/// A [`SuggestionEvent`].
#[derive(Clone, PartialEq, prost::Message)]
pub struct SuggestionMessage {
    /// A code of [`SuggestionCode`].
    #[prost(string, tag = 1)]
    pub code: String,
    /// A code of [`SuggestionStatus`].
    #[prost(string, tag = 2)]
    pub status: String,
    /// The commands in words.
    #[prost(string, repeated, tag = 3)]
    pub commands: Vec<String>,
    /// The reason in figures.
    #[prost(message, repeated, tag = 4)]
    pub figures: Vec<Figure>,
}

/// An [`AlarmEvent`].
#[derive(Clone, PartialEq, prost::Message)]
pub struct AlarmMessage {
    /// Stable code of the alarm.
    #[prost(string, tag = 1)]
    pub code: String,
    /// Name of the alarm, for display.
    #[prost(string, tag = 2)]
    pub name: String,
    /// A code of [`Level`].
    #[prost(string, tag = 3)]
    pub severity: String,
    /// A code of [`AlarmStatus`].
    #[prost(string, tag = 4)]
    pub status: String,
    /// Time from the beginning of the cause to this message, nanoseconds; absent from an answer to an alarm that is not on.
    #[prost(uint64, optional, tag = 5)]
    pub ago_ns: Option<u64>,
    /// Latest measured value.
    #[prost(double, optional, tag = 6)]
    pub value: Option<f64>,
    /// Limit of the value.
    #[prost(double, optional, tag = 7)]
    pub limit: Option<f64>,
    /// Unit of value and limit.
    #[prost(string, tag = 8)]
    pub unit: String,
    /// Time for which the alarm is shelved, nanoseconds.
    #[prost(uint64, optional, tag = 9)]
    pub shelved_ns: Option<u64>,
    /// The other program whose operator answered.
    #[prost(string, optional, tag = 10)]
    pub by: Option<String>,
}

/// A [`LinkEvent`].
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct LinkMessage {
    /// A code: `open`, `lost` or `ended`.
    #[prost(string, tag = 1)]
    pub state: String,
    /// Device, address or file, when open.
    #[prost(string, optional, tag = 2)]
    pub name: Option<String>,
    /// Reason for the loss, for display.
    #[prost(string, optional, tag = 3)]
    pub text: Option<String>,
}

/// A [`Mark`].
#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct MarkMessage {
    /// Time from the marked moment to this message, nanoseconds.
    #[prost(uint64, tag = 1)]
    pub ago_ns: u64,
    /// Whether the mark was set; `false` if it was cleared.
    #[prost(bool, tag = 2)]
    pub is_set: bool,
}

/// A suspension of the station.
#[derive(Clone, Copy, PartialEq, Eq, prost::Message)]
pub struct SuspensionMessage {
    /// Duration, nanoseconds.
    #[prost(uint64, tag = 1)]
    pub duration_ns: u64,
}

/// A notice.
#[derive(Clone, PartialEq, Eq, prost::Message)]
pub struct NoticeMessage {
    /// A code of [`NoticeCode`].
    #[prost(string, tag = 1)]
    pub code: String,
    /// A code of [`Level`].
    #[prost(string, tag = 2)]
    pub level: String,
    /// Text in one line, for display.
    #[prost(string, tag = 3)]
    pub text: String,
}

impl LinkMessage {
    const OPEN: &str = "open";
    const LOST: &str = "lost";
    const ENDED: &str = "ended";

    /// The event; `None` for an unknown code. A recording does not say whether commands could be sent.
    #[must_use]
    pub fn event(&self) -> Option<LinkEvent> {
        Some(match self.state.as_str() {
            Self::OPEN => LinkEvent::Opened {
                name: self.name.clone()?,
                can_send: false,
            },
            Self::LOST => LinkEvent::Lost {
                reason: self.text.clone().unwrap_or_default(),
            },
            Self::ENDED => LinkEvent::Ended,
            _ => return None,
        })
    }
}

impl NoticeMessage {
    /// Severity of the notice; an unknown code counts as information.
    #[must_use]
    pub fn level(&self) -> Level {
        Level::from_code(&self.level).unwrap_or(Level::Info)
    }
}

impl AlarmMessage {
    /// The event, recorded `at` a time of the session; `None` for a status of a newer version.
    #[must_use]
    pub fn event(&self, at: Moment) -> Option<AlarmEvent> {
        let began_at = |ns| at.saturating_sub(Moment::from_nanos(ns));
        Some(AlarmEvent {
            code: self.code.clone(),
            name: self.name.clone(),
            level: Level::from_code(&self.severity).unwrap_or(Level::Info),
            status: AlarmStatus::from_code(&self.status)?,
            began_at: self.ago_ns.map(began_at),
            value: self.value,
            limit: self.limit,
            unit: self.unit.clone(),
            shelved_for: self.shelved_ns.map(Moment::from_nanos),
            by: self.by.clone(),
        })
    }
}

impl SuggestionMessage {
    /// The event; `None` for a code or a status of a newer version.
    #[must_use]
    pub fn event(&self) -> Option<SuggestionEvent> {
        Some(SuggestionEvent {
            code: SuggestionCode::from_code(&self.code)?,
            status: SuggestionStatus::from_code(&self.status)?,
            commands: self.commands.clone(),
            figures: self.figures.clone(),
        })
    }
}

impl From<&SuggestionEvent> for StationEvent {
    fn from(event: &SuggestionEvent) -> Self {
        StationEventKind::Suggestion(SuggestionMessage {
            code: event.code.code().to_owned(),
            status: event.status.code().to_owned(),
            commands: event.commands.clone(),
            figures: event.figures.clone(),
        })
        .into()
    }
}

impl StationEvent {
    /// The recorded form of a change of an alarm `at` a time of the session.
    #[must_use]
    pub fn alarm(at: Moment, event: &AlarmEvent) -> Self {
        let ago = |began_at| nanoseconds(at.saturating_sub(began_at));
        StationEventKind::Alarm(AlarmMessage {
            code: event.code.clone(),
            name: event.name.clone(),
            severity: event.level.code().to_owned(),
            status: event.status.code().to_owned(),
            ago_ns: event.began_at.map(ago),
            value: event.value,
            limit: event.limit,
            unit: event.unit.clone(),
            shelved_ns: event.shelved_for.map(nanoseconds),
            by: event.by.clone(),
        })
        .into()
    }
}

/// A duration in nanoseconds, as recordings contain it.
fn nanoseconds(duration: Moment) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

impl From<StationEventKind> for StationEvent {
    fn from(kind: StationEventKind) -> Self {
        Self { kind: Some(kind) }
    }
}

impl From<UplinkEvent> for StationEvent {
    fn from(event: UplinkEvent) -> Self {
        StationEventKind::Command(event).into()
    }
}

impl From<&LinkEvent> for StationEvent {
    fn from(event: &LinkEvent) -> Self {
        let (state, name, text) = match event {
            LinkEvent::Opened { name, .. } => (LinkMessage::OPEN, Some(name), None),
            LinkEvent::Lost { reason } => (LinkMessage::LOST, None, Some(reason)),
            LinkEvent::Ended => (LinkMessage::ENDED, None, None),
        };
        let message = LinkMessage {
            state: state.to_owned(),
            name: name.cloned(),
            text: text.cloned(),
        };
        StationEventKind::Link(message).into()
    }
}

impl From<Reception> for StationEvent {
    fn from(reception: Reception) -> Self {
        StationEventKind::Reception(reception.code().to_owned()).into()
    }
}

impl From<Mark> for StationEvent {
    fn from(mark: Mark) -> Self {
        StationEventKind::Mark(MarkMessage {
            ago_ns: nanoseconds(mark.ago),
            is_set: mark.is_set,
        })
        .into()
    }
}

impl From<MarkMessage> for Mark {
    fn from(message: MarkMessage) -> Self {
        Self {
            ago: Moment::from_nanos(message.ago_ns),
            is_set: message.is_set,
        }
    }
}

impl StationEvent {
    /// A line for the log.
    #[must_use]
    pub fn notice(code: NoticeCode, level: Level, text: impl Into<String>) -> Self {
        StationEventKind::Notice(NoticeMessage {
            code: code.code().to_owned(),
            level: level.code().to_owned(),
            text: text.into(),
        })
        .into()
    }

    /// Whether the event must reach the disk at once: a command begins or ends, or there is a problem.
    #[must_use]
    pub fn is_urgent(&self) -> bool {
        match &self.kind {
            Some(StationEventKind::Command(event)) => event
                .command_status()
                .is_some_and(|status| status == CommandStatus::Queued || status.is_end()),
            Some(StationEventKind::Link(link)) => link.state == LinkMessage::LOST,
            Some(StationEventKind::Reception(code)) => {
                Reception::from_code(code) != Some(Reception::Lines)
            }
            Some(StationEventKind::Notice(notice)) => notice.level() > Level::Info,
            Some(StationEventKind::Alarm(_)) => true,
            Some(
                StationEventKind::Mark(_)
                | StationEventKind::Suspension(_)
                | StationEventKind::Suggestion(_)
                | StationEventKind::Estimate(_)
                | StationEventKind::Floor(_),
            )
            | None => false,
        }
    }

    /// Whether the link was lost; no line spans a loss.
    #[must_use]
    pub fn is_loss_of_link(&self) -> bool {
        matches!(&self.kind, Some(StationEventKind::Link(link)) if link.state == LinkMessage::LOST)
    }

    /// Event for the end of a suspension of this duration.
    #[must_use]
    pub fn suspended(duration: Moment) -> Self {
        StationEventKind::Suspension(SuspensionMessage {
            duration_ns: nanoseconds(duration),
        })
        .into()
    }

    /// Duration of the suspension that ends with this event; `None` for other events.
    #[must_use]
    pub fn suspension(&self) -> Option<Moment> {
        match &self.kind {
            Some(StationEventKind::Suspension(it)) => Some(Moment::from_nanos(it.duration_ns)),
            _ => None,
        }
    }

    /// The mark that this event set or removed; `None` for other events.
    #[must_use]
    pub fn mark(&self) -> Option<Mark> {
        match &self.kind {
            Some(StationEventKind::Mark(mark)) => Some((*mark).into()),
            _ => None,
        }
    }

    /// Whether the event is a notice with this code.
    #[must_use]
    pub fn is_notice(&self, code: NoticeCode) -> bool {
        matches!(&self.kind, Some(StationEventKind::Notice(notice)) if notice.code == code.code())
    }
}
