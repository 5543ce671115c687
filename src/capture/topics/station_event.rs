//! What the station knows that no byte says.

use foxglove::messages::Log;
use foxglove::messages::log::Level as LogLevel;
use groundwave_protocol::Waypoint;

use crate::capture::messages::{UplinkEvent, UplinkStep};
use crate::event::{CommandStep, Event, Level, LinkEvent, Reception};
use crate::request::Request;

/// Who says in the log that a moment was marked.
pub(in crate::capture) const MARK: &str = "mark";

/// An event of the station that belongs into a capture: the steps of commands, who asked for them,
/// the link's ups and downs, notices, and moments that the operator marked.
///
/// Lines, totals and statistics are no part of it, since they follow from the bytes; neither are keys.
#[derive(Clone, Debug, PartialEq)]
pub enum StationEvent {
    /// A command went a step further. Goes to `/uplink`; its end to `/log` too.
    Uplink(UplinkEvent),
    /// Something worth a line in `/log`. The time in it is set by the [`super::Deriver`].
    Log(Log),
}

impl StationEvent {
    /// What of an event belongs into a capture, if anything.
    #[must_use]
    pub fn from_event(event: &Event) -> Option<Self> {
        match event {
            Event::Command { id, step } => Some(Self::Uplink(UplinkEvent {
                command_id: Some(id.0),
                ..uplink(step)
            })),
            Event::Asked { id, by } => Some(Self::Uplink(UplinkEvent {
                command_id: Some(id.0),
                by: Some(by.clone()),
                ..UplinkEvent::new(UplinkStep::Asked)
            })),
            Event::Link(LinkEvent::Opened { name, .. }) => {
                Some(Self::log(LogLevel::Info, "link", format!("{name} is open")))
            }
            Event::Link(LinkEvent::Lost { reason }) => Some(Self::log(
                LogLevel::Warning,
                "link",
                format!("link lost: {reason}"),
            )),
            Event::Link(LinkEvent::Ended) => {
                Some(Self::log(LogLevel::Info, "link", "the link has ended"))
            }
            Event::Reception { reception, .. } => {
                let (level, text) = reception_words(*reception);
                Some(Self::log(level, "link", text))
            }
            Event::Notice { level, text } => {
                let level = match level {
                    Level::Info => LogLevel::Info,
                    Level::Warning => LogLevel::Warning,
                    Level::Alarm => LogLevel::Error,
                };
                Some(Self::log(level, "station", text.as_str()))
            }
            Event::Mark(mark) => Some(Self::log(LogLevel::Info, MARK, mark.to_string())),
            _ => None,
        }
    }

    /// Something that the station does, for the log.
    #[must_use]
    pub fn note(text: impl Into<String>) -> Self {
        Self::log(LogLevel::Info, "station", text)
    }

    /// Whether it shall be on the disk at once: a command begins or ends, or something is wrong.
    #[must_use]
    pub fn is_urgent(&self) -> bool {
        match self {
            Self::Uplink(event) => !matches!(
                event.step(),
                UplinkStep::Sent | UplinkStep::Progress | UplinkStep::Asked
            ),
            Self::Log(log) => log.level >= LogLevel::Warning as i32,
        }
    }

    fn log(level: LogLevel, name: &str, message: impl Into<String>) -> Self {
        Self::Log(Log {
            level: level as i32,
            name: name.to_owned(),
            message: message.into(),
            ..Log::default()
        })
    }
}

fn uplink(step: &CommandStep) -> UplinkEvent {
    match step {
        CommandStep::Queued(request) => {
            let waypoints: &[Waypoint] = match request {
                Request::Route(waypoints) => waypoints,
                _ => &[],
            };
            UplinkEvent {
                command: Some(request.to_string()),
                total: matches!(request, Request::Route(_)).then_some(waypoints.len() as u32),
                waypoints_x_in: waypoints.iter().map(|point| point.x_in.into()).collect(),
                waypoints_y_in: waypoints.iter().map(|point| point.y_in.into()).collect(),
                ..UplinkEvent::new(UplinkStep::Queued)
            }
        }
        CommandStep::Sent { frames } => UplinkEvent {
            frames: Some(*frames),
            ..UplinkEvent::new(UplinkStep::Sent)
        },
        CommandStep::Progress {
            acknowledged,
            total,
        } => UplinkEvent {
            acknowledged: Some((*acknowledged).into()),
            total: Some((*total).into()),
            ..UplinkEvent::new(UplinkStep::Progress)
        },
        CommandStep::Told(line) => UplinkEvent {
            parameter_name: Some(line.name.as_str().to_owned()),
            parameter_value: Some(line.value),
            ..UplinkEvent::new(UplinkStep::Told)
        },
        CommandStep::Proven { digest } => UplinkEvent {
            list_digest: *digest,
            ..UplinkEvent::new(UplinkStep::Proven)
        },
        CommandStep::Refused(outcome) => UplinkEvent {
            outcome: Some(*outcome as i32),
            ..UplinkEvent::new(UplinkStep::Refused)
        },
        CommandStep::Failed(failure) => UplinkEvent {
            reason: Some(failure.to_string()),
            ..UplinkEvent::new(UplinkStep::Failed)
        },
    }
}

const fn reception_words(reception: Reception) -> (LogLevel, &'static str) {
    match reception {
        Reception::Lines => (LogLevel::Info, "intact lines arrive"),
        Reception::Nothing => (LogLevel::Warning, "no bytes arrive"),
        Reception::Noise => (LogLevel::Warning, "only noise arrives"),
        Reception::Damaged => (LogLevel::Warning, "no line arrives intact"),
        Reception::WrongRate(_) => (LogLevel::Warning, "the radio has another baud rate"),
    }
}
