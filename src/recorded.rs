//! The station's events as a capture keeps them, and back.

use foxglove::messages::Log;
use foxglove::messages::log::Level as LogLevel;
use groundwave_captures::composer::is_beginning;
use groundwave_captures::messages::{UplinkEvent, UplinkStep};
use groundwave_captures::topics::{MARK, StationEvent};
use groundwave_protocol::Waypoint;
use groundwave_protocol::telemetry::Outcome;

use crate::event::{CommandId, CommandStep, Event, Failure, Level, LinkEvent, Mark, Reception};
use crate::request::Request;

/// What of an event belongs into a capture, if anything.
#[must_use]
pub fn to_recorded(event: &Event) -> Option<StationEvent> {
    match event {
        Event::Command { id, step } => Some(StationEvent::Uplink(UplinkEvent {
            command_id: Some(id.0),
            ..uplink(step)
        })),
        Event::Asked { id, by } => Some(StationEvent::Uplink(UplinkEvent {
            command_id: Some(id.0),
            by: Some(by.clone()),
            ..UplinkEvent::new(UplinkStep::Asked)
        })),
        Event::Link(LinkEvent::Opened { name, .. }) => Some(StationEvent::log(
            LogLevel::Info,
            "link",
            format!("{name} is open"),
        )),
        Event::Link(LinkEvent::Lost { reason }) => Some(StationEvent::log(
            LogLevel::Warning,
            "link",
            format!("link lost: {reason}"),
        )),
        Event::Link(LinkEvent::Ended) => Some(StationEvent::log(
            LogLevel::Info,
            "link",
            "the link has ended",
        )),
        Event::Reception { reception, .. } => {
            let (level, text) = reception_words(*reception);
            Some(StationEvent::log(level, "link", text))
        }
        Event::Notice { level, text } => {
            let level = match level {
                Level::Info => LogLevel::Info,
                Level::Warning => LogLevel::Warning,
                Level::Alarm => LogLevel::Error,
            };
            Some(StationEvent::log(level, "station", text.as_str()))
        }
        Event::Mark(mark) => Some(StationEvent::log(LogLevel::Info, MARK, mark.to_string())),
        _ => None,
    }
}

/// The event that was recorded; `None` for what follows from the robot's lines.
#[must_use]
pub fn from_recorded(recorded: &StationEvent) -> Option<Event> {
    match recorded {
        StationEvent::Uplink(message) => command(message),
        StationEvent::Log(log) => notice(log),
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

/// The event that a message of `/uplink` was made of; `None` for what follows from the robot's lines.
fn command(message: &UplinkEvent) -> Option<Event> {
    let id = CommandId(message.command_id?);
    let step = match message.step() {
        UplinkStep::Queued => CommandStep::Queued(request(message)?),
        UplinkStep::Sent => CommandStep::Sent {
            frames: message.frames.unwrap_or_default(),
        },
        UplinkStep::Progress => CommandStep::Progress {
            acknowledged: message.acknowledged.unwrap_or_default() as u16,
            total: message.total.unwrap_or_default() as u16,
        },
        UplinkStep::Proven => CommandStep::Proven {
            digest: message.list_digest,
        },
        UplinkStep::Refused => CommandStep::Refused(outcome(message.outcome?)?),
        UplinkStep::Failed => CommandStep::Failed(failure(message.reason.as_deref()?)?),
        UplinkStep::Asked => {
            let by = message.by.clone()?;
            return Some(Event::Asked { id, by });
        }
        // A parameter's limits are not in it, and the ledger shows nothing of it.
        UplinkStep::Told | UplinkStep::Acknowledged | UplinkStep::List => return None,
    };
    Some(Event::Command { id, step })
}

fn request(message: &UplinkEvent) -> Option<Request> {
    if message.total.is_some() {
        let xs = message.waypoints_x_in.iter();
        let waypoints = xs
            .zip(&message.waypoints_y_in)
            .map(|(&x_in, &y_in)| Waypoint {
                x_in: x_in as i16,
                y_in: y_in as i16,
            });
        return Some(Request::Route(waypoints.collect()));
    }
    let words: Vec<&str> = message.command.as_deref()?.split_whitespace().collect();
    let requests = Request::all_from_words(&words).ok()?;
    requests.into_iter().next()
}

fn outcome(place: i32) -> Option<Outcome> {
    let place = usize::try_from(place).ok()?;
    Outcome::ALL.get(place).copied()
}

fn failure(reason: &str) -> Option<Failure> {
    let mut all = Failure::ALL.into_iter();
    all.find(|failure| failure.to_string() == reason)
}

/// The event that a message of `/log` was made of, if it was one that no byte tells of.
fn notice(log: &Log) -> Option<Event> {
    match log.name.as_str() {
        // The recorder's own word: no station told it.
        _ if is_beginning(log) => None,
        MARK => Mark::from_words(&log.message).map(Event::Mark),
        "station" => Some(Event::Notice {
            level: match log.level {
                level if level >= LogLevel::Error as i32 => Level::Alarm,
                level if level == LogLevel::Warning as i32 => Level::Warning,
                _ => Level::Info,
            },
            text: log.message.clone(),
        }),
        "link" => {
            if let Some(reason) = log.message.strip_prefix("link lost: ") {
                let reason = reason.to_owned();
                return Some(Event::Link(LinkEvent::Lost { reason }));
            }
            let name = log.message.strip_suffix(" is open")?.to_owned();
            Some(Event::Link(LinkEvent::Opened {
                name,
                can_send: false,
            }))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn what_was_recorded_of_a_command_is_what_happened() {
        let route = Request::Route(vec![Waypoint { x_in: 5, y_in: -9 }, Waypoint::default()]);
        let steps = [
            CommandStep::Queued(route),
            CommandStep::Queued(Request::Route(Vec::new())),
            CommandStep::Queued(Request::Stop),
            CommandStep::Queued(Request::Scan),
            CommandStep::Sent { frames: 3 },
            CommandStep::Progress {
                acknowledged: 2,
                total: 9,
            },
            CommandStep::Proven { digest: None },
            CommandStep::Proven { digest: Some(7) },
        ]
        .into_iter()
        .chain(Outcome::ALL.map(CommandStep::Refused))
        .chain(Failure::ALL.map(CommandStep::Failed));
        for step in steps {
            let id = CommandId(4);
            let event = Event::Command { id, step };
            let Some(StationEvent::Uplink(message)) = to_recorded(&event) else {
                panic!("{event:?} belongs into a capture");
            };
            assert_eq!(command(&message), Some(event));
        }
    }

    #[test]
    fn what_the_station_said_and_the_links_ups_and_downs_come_back() {
        let notice_of = |level| Event::Notice {
            level,
            text: "words".to_owned(),
        };
        for event in [
            notice_of(Level::Info),
            notice_of(Level::Warning),
            notice_of(Level::Alarm),
            Event::Mark(Mark {
                ago: Duration::from_millis(61_250),
                is_set: true,
            }),
            Event::Mark(Mark {
                ago: Duration::ZERO,
                is_set: false,
            }),
            Event::Link(LinkEvent::Lost {
                reason: "unplugged".to_owned(),
            }),
            Event::Link(LinkEvent::Opened {
                name: "radio".to_owned(),
                can_send: false,
            }),
        ] {
            let Some(StationEvent::Log(log)) = to_recorded(&event) else {
                panic!("{event:?} belongs into a capture");
            };
            assert_eq!(notice(&log), Some(event));
        }
    }
}
