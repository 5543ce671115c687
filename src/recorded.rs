//! Converts the station's events to their recorded form and back.

use groundwave_captures::messages::{StationEvent, StationEventKind, UplinkEvent};
use groundwave_protocol::Waypoint;

use crate::event::{CommandId, CommandStatus, Event, Mark, Moment, Notice, NoticeCode};
use crate::request::Request;

/// The recorded form of an event `at` a time of the session; `None` for an event derived from the bytes.
#[must_use]
pub fn to_recorded(at: Moment, event: &Event) -> Option<StationEvent> {
    match event {
        Event::Asked { id, request, by } => Some(asked(*id, request, by.clone()).into()),
        Event::Command { id, status } => Some(UplinkEvent::of_command(*id, status).into()),
        Event::Link(link) => Some(link.into()),
        Event::Reception { reception, .. } => Some((*reception).into()),
        Event::Notice(notice) => Some(StationEvent::notice(
            notice.code,
            notice.level,
            notice.text.as_str(),
        )),
        Event::Mark(mark) => Some((*mark).into()),
        Event::Suspended(duration) => Some(StationEvent::suspended(*duration)),
        Event::Alarm(alarm) => Some(StationEvent::alarm(at, alarm)),
        Event::Suggestion(suggestion) => Some(suggestion.into()),
        Event::Estimate(estimate) => Some(StationEventKind::Estimate(*estimate).into()),
        Event::Floor(floor) => Some(StationEventKind::Floor((**floor).clone()).into()),
        _ => None,
    }
}

/// The event of a recorded form, recorded `at` a time of the session; `None` for an event derived from the bytes, or of a newer version.
#[must_use]
pub fn from_recorded(at: Moment, recorded: &StationEvent) -> Option<Event> {
    match recorded.kind.as_ref()? {
        StationEventKind::Command(event) => command(event),
        StationEventKind::Link(link) => link.event().map(Event::Link),
        // They follow from the bytes again.
        StationEventKind::Reception(_)
        | StationEventKind::Estimate(_)
        | StationEventKind::Floor(_) => None,
        StationEventKind::Alarm(alarm) => alarm.event(at).map(Event::Alarm),
        StationEventKind::Suggestion(suggestion) => suggestion.event().map(Event::Suggestion),
        StationEventKind::Mark(mark) => Some(Event::Mark(Mark::from(*mark))),
        StationEventKind::Suspension(it) => {
            Some(Event::Suspended(Moment::from_nanos(it.duration_ns)))
        }
        StationEventKind::Notice(notice) => {
            let code = NoticeCode::from_code(&notice.code).unwrap_or(NoticeCode::Other);
            let is_of_recorder = matches!(
                code,
                NoticeCode::RecordingBegun | NoticeCode::RecordingEnded
            );
            (!is_of_recorder)
                .then(|| Event::Notice(Notice::new(code, notice.level(), notice.text.as_str())))
        }
    }
}

fn asked(id: CommandId, request: &Request, by: Option<String>) -> UplinkEvent {
    let waypoints: &[Waypoint] = match request {
        Request::Route(waypoints) => waypoints,
        _ => &[],
    };
    UplinkEvent {
        command: Some(request.to_string()),
        by,
        total: matches!(request, Request::Route(_)).then_some(waypoints.len() as u32),
        waypoints_x_in: waypoints.iter().map(|point| point.x_in.into()).collect(),
        waypoints_y_in: waypoints.iter().map(|point| point.y_in.into()).collect(),
        ..UplinkEvent::of_command(id, &CommandStatus::Queued)
    }
}

fn command(message: &UplinkEvent) -> Option<Event> {
    let id = CommandId(message.command_id?);
    let status = message.command_status()?;
    if status != CommandStatus::Queued {
        return Some(Event::Command { id, status });
    }
    let request = request(message)?;
    let by = message.by.clone();
    Some(Event::Asked { id, request, by })
}

/// The request of a queued command: a list from its waypoints, any other from its text.
fn request(message: &UplinkEvent) -> Option<Request> {
    if message.total.is_none() {
        let words: Vec<&str> = message.command.as_deref()?.split(' ').collect();
        let own = || Request::Own(words.join(" "));
        return Some(Request::from_words(&words).unwrap_or_else(|_| own()));
    }
    let xs = message.waypoints_x_in.iter();
    let waypoints = xs.zip(&message.waypoints_y_in).map(|(&x_in, &y_in)| {
        Some(Waypoint {
            x_in: i16::try_from(x_in).ok()?,
            y_in: i16::try_from(y_in).ok()?,
        })
    });
    waypoints.collect::<Option<_>>().map(Request::Route)
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use groundwave_protocol::telemetry::Outcome;

    use super::*;
    use crate::event::{
        AlarmEvent, AlarmStatus, Failure, Figure, Level, LinkEvent, SuggestionCode,
        SuggestionEvent, SuggestionStatus,
    };
    use crate::request::testing::samples;

    fn assert_comes_back(event: &Event) {
        let at = Duration::from_hours(1);
        let recorded = to_recorded(at, event).expect("it belongs into a capture");
        assert_eq!(from_recorded(at, &recorded).as_ref(), Some(event));
    }

    #[test]
    fn commands_come_back_from_their_codes() {
        let id = CommandId(4);
        for request in samples() {
            for by in [None, Some("pid 7".to_owned())] {
                let request = request.clone();
                assert_comes_back(&Event::Asked { id, request, by });
            }
        }
        let statuses = [
            CommandStatus::Sent { frames: 3 },
            CommandStatus::Progress {
                acknowledged: 2,
                total: 9,
            },
            CommandStatus::Confirmed { digest: None },
            CommandStatus::Confirmed { digest: Some(7) },
        ]
        .into_iter()
        .chain(Outcome::ALL.map(CommandStatus::Refused))
        .chain(Failure::ALL.map(CommandStatus::Failed));
        for status in statuses {
            assert_comes_back(&Event::Command { id, status });
        }
    }

    #[test]
    fn notices_marks_and_changes_of_the_link_come_back() {
        for level in [Level::Info, Level::Warning, Level::Alarm] {
            let notice = Notice::new(NoticeCode::Radio, level, "words");
            assert_comes_back(&Event::Notice(notice));
        }
        for (ago, is_set) in [
            (Duration::from_nanos(61_250_000_001), true),
            (Duration::ZERO, false),
        ] {
            assert_comes_back(&Event::Mark(Mark { ago, is_set }));
        }
        assert_comes_back(&Event::Suspended(Duration::from_millis(61_250)));
        for (status, value) in [
            (AlarmStatus::Begun, Some(11.5)),
            (AlarmStatus::Ended, None),
            (AlarmStatus::Acknowledged, None),
            (AlarmStatus::Shelved, None),
            (AlarmStatus::Unshelved, None),
        ] {
            assert_comes_back(&Event::Alarm(AlarmEvent {
                code: "battery_low".to_owned(),
                name: "battery low".to_owned(),
                level: Level::Alarm,
                status,
                began_at: value.map(|_| Duration::from_millis(5250)),
                value,
                limit: value,
                unit: "V".to_owned(),
                shelved_for: (status == AlarmStatus::Shelved).then_some(Duration::from_mins(10)),
                by: (status == AlarmStatus::Acknowledged).then(|| "pid 7".to_owned()),
            }));
        }
        for (code, figures) in [
            (
                SuggestionCode::PoseOff,
                vec![Figure {
                    code: "heading".to_owned(),
                    value: 9.25,
                    half: Some(4.0),
                    unit: "deg".to_owned(),
                }],
            ),
            (SuggestionCode::HeadingUnknown, Vec::new()),
        ] {
            assert_comes_back(&Event::Suggestion(SuggestionEvent {
                code,
                status: SuggestionStatus::Begun,
                commands: vec!["scan".to_owned()],
                figures,
            }));
        }
        for link in [
            LinkEvent::Lost {
                reason: "unplugged".to_owned(),
            },
            LinkEvent::Opened {
                name: "radio".to_owned(),
                can_send: false,
            },
            LinkEvent::Ended,
        ] {
            assert_comes_back(&Event::Link(link));
        }
    }
}
