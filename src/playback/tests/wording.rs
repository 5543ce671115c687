//! Wording has no meaning: a recording with other texts replays the same.

use std::borrow::Cow;
use std::io::Cursor;

use foxglove::messages::Log;
use groundwave_protocol::telemetry::Outcome;
use prost::Message as _;

use super::*;
use crate::capture::Capture;
use crate::capture::info::Info;
use crate::capture::messages::{StationEvent, StationEventKind};
use crate::capture::runs::Course;
use crate::event::{CommandStatus, Failure, Level, LinkEvent, Mark, Notice, NoticeCode, Reception};
use crate::recorded::to_recorded;

/// Number of messages of the demo between two further events.
const SPACING_MESSAGES: usize = 60;

/// Events of every kind that a recording holds.
fn events() -> Vec<Event> {
    let (first, second) = (CommandId(11), CommandId(12));
    let asked = |id, request| Event::Asked {
        id,
        request,
        by: Some("pid 7".to_owned()),
    };
    let status = |id, status| Event::Command { id, status };
    let mark = |is_set| {
        Event::Mark(Mark {
            ago: Moment::from_millis(1500),
            is_set,
        })
    };
    let mut events = vec![
        asked(first, Request::Scan),
        status(first, CommandStatus::Sent { frames: 2 }),
        status(first, CommandStatus::Refused(Outcome::NotFitted)),
        mark(true),
        asked(second, Request::Stop),
        status(second, CommandStatus::Failed(Failure::TimedOut)),
        Event::Reception {
            reception: Reception::Noise,
            since: Moment::ZERO,
        },
        Event::Link(LinkEvent::Lost {
            reason: "unplugged".to_owned(),
        }),
        Event::Link(LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: true,
        }),
        mark(true),
    ];
    let notices = [Level::Info, Level::Warning, Level::Alarm]
        .map(|level| Event::Notice(Notice::new(NoticeCode::Radio, level, "a notice")));
    events.extend(notices);
    events
}

/// Another wording of a text.
fn reworded(text: &str) -> String {
    format!("~{}", text.to_uppercase().chars().rev().collect::<String>())
}

/// Rewords each text of a message; other topics have none.
fn reword(topic: &str, data: &[u8], texts: &mut Vec<String>) -> Option<Vec<u8>> {
    let mut change = |text: &mut String| {
        texts.push(text.clone());
        *text = reworded(text);
    };
    match topic {
        "/log" => {
            let mut log = Log::decode(data).unwrap();
            change(&mut log.message);
            Some(log.encode_to_vec())
        }
        "/station" => {
            let mut event = StationEvent::decode(data).unwrap();
            match event.kind.as_mut().unwrap() {
                StationEventKind::Link(link) => {
                    link.text.iter_mut().chain(&mut link.name).for_each(change);
                }
                StationEventKind::Notice(notice) => change(&mut notice.text),
                StationEventKind::Alarm(alarm) => change(&mut alarm.name),
                StationEventKind::Command(_)
                | StationEventKind::Reception(_)
                | StationEventKind::Mark(_)
                | StationEventKind::Suspension(_)
                | StationEventKind::Suggestion(_)
                | StationEventKind::Estimate(_)
                | StationEventKind::Floor(_) => {}
            }
            Some(event.encode_to_vec())
        }
        _ => None,
    }
}

/// The demo with further events, unchanged or with every text reworded, and its texts.
fn recording(is_reworded: bool) -> (Vec<u8>, Vec<String>) {
    let path = groundwave_captures::samples().join("demo-commands.mcap");
    let demo = std::fs::read(path).unwrap();
    let messages: Vec<mcap::Message<'_>> = mcap::MessageStream::new(&demo)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let is_station = |message: &&mcap::Message<'_>| message.channel.topic == "/station";
    let station = messages.iter().find(is_station).unwrap().channel.clone();
    let mut events = events().into_iter();
    let mut writer = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let mut texts = Vec::new();
    for (n, message) in messages.into_iter().enumerate() {
        let mut both = vec![message.clone()];
        if n % SPACING_MESSAGES == SPACING_MESSAGES - 1 {
            both.extend(events.next().map(|event| mcap::Message {
                channel: station.clone(),
                data: Cow::Owned(to_recorded(Moment::ZERO, &event).unwrap().encode_to_vec()),
                ..message
            }));
        }
        for mut message in both {
            let other = reword(&message.channel.topic, &message.data, &mut texts);
            if let Some(other) = other.filter(|_| is_reworded) {
                message.data = Cow::Owned(other);
            }
            writer.write(&message).unwrap();
        }
    }
    assert_eq!(
        events.next(),
        None,
        "the demo is long enough for all events"
    );
    writer.finish().unwrap();
    texts.sort_unstable_by_key(|text| std::cmp::Reverse(text.len()));
    texts.dedup();
    (writer.into_inner().into_inner(), texts)
}

/// The facts every two seconds, the marks, and the figures of the whole recording.
fn replayed(bytes: &[u8]) -> Vec<String> {
    let open = || index::read(Arc::new(bytes.to_vec()), Path::new("x.mcap")).unwrap();
    let mut reader = open();
    let first = CaptureState::new("radio", Arc::default(), &*reader);
    let mut marks = Vec::new();
    read_through(
        first,
        &mut reader,
        || true,
        |finding| {
            if let Finding::Marks(found) = finding {
                marks = found;
            }
            true
        },
    );
    assert_eq!(marks.len(), 2);
    let mut seen = vec![format!("{marks:?}")];
    let (mut timeline, end) = read_whole(open());
    for s in (0..end.as_secs()).step_by(2) {
        timeline.seek(Moment::from_secs(s));
        seen.push(text_of(timeline.facts()));
    }
    timeline.seek(end);
    seen.push(text_of(timeline.facts()));
    let capture = || Capture::read("x.mcap", Box::new(Cursor::new(bytes.to_vec()))).unwrap();
    let info = Info::read(&mut capture());
    let (course, counters, problem) = Course::read(&mut capture());
    let course = (course.bumps(), course.distance_in(), course.points().len());
    seen.push(format!("{info:?} {course:?} {counters:?} {problem:?}"));
    seen
}

#[test]
fn a_recording_with_other_texts_replays_as_the_same() {
    let (plain, texts) = recording(false);
    let (other, _) = recording(true);
    let (plain, other) = (replayed(&plain), replayed(&other));
    assert_eq!(plain.len(), other.len());
    for (plain, other) in plain.into_iter().zip(other) {
        let back = texts
            .iter()
            .fold(other, |seen, text| seen.replace(&reworded(text), text));
        assert_eq!(back, plain);
    }
}
