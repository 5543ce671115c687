//! What a recording knows besides bytes: the events of its station again.

use foxglove::messages::Log;
use foxglove::messages::log::Level as LogLevel;
use groundwave_protocol::Waypoint;
use groundwave_protocol::telemetry::Outcome;

use crate::capture::composer::is_beginning;
use crate::capture::messages::{UplinkEvent, UplinkStep};
use crate::capture::topics::MARK;
use crate::event::{CommandId, CommandStep, Event, Failure, Level, LinkEvent};
use crate::request::Request;
use crate::travel::Mark;

/// The event that a message of `/uplink` was made of; `None` for what follows from the robot's lines.
pub(super) fn command(message: &UplinkEvent) -> Option<Event> {
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
pub(super) fn notice(log: &Log) -> Option<Event> {
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

/// Whether the link went.
pub(in crate::capture) fn is_loss_of_link(log: &Log) -> bool {
    matches!(notice(log), Some(Event::Link(LinkEvent::Lost { .. })))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::topics::StationEvent;
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
            let Some(StationEvent::Uplink(message)) = StationEvent::from_event(&event) else {
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
            let Some(StationEvent::Log(log)) = StationEvent::from_event(&event) else {
                panic!("{event:?} belongs into a capture");
            };
            assert_eq!(notice(&log), Some(event));
        }
    }
}
