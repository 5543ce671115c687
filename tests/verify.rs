//! Findings of `verify`: messages that differ from those derived from the bytes, and lost lines.

use crate::streams;
use std::fs;
use std::io::Cursor;
use std::time::Duration;

use crate::programs::scratch;
use crate::recordings::{session, wall};
use groundwave::capture::convert::convert_raw;
use groundwave::capture::info::Info;
use groundwave::capture::topics::{Origin, Topic};
use groundwave::capture::verify::verify_mcap;
use groundwave::capture::{Capture, Existing, Recorder};
use groundwave::event::{Event, LinkEvent};
use groundwave::recorded::to_recorded;

fn converted(raw: &[u8]) -> Vec<u8> {
    let mut mcap = Vec::new();
    convert_raw(raw, Some(1_741_944_413_000_000_000), &mut mcap).unwrap();
    mcap
}

/// The messages of one topic.
fn messages<'a>(mcap: &'a [u8], topic: &str) -> Vec<mcap::Message<'a>> {
    let stream = mcap::MessageStream::new(mcap).unwrap();
    stream
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == topic)
        .collect()
}

/// A message that contradicts the bytes is a fault.
#[test]
fn disagreement_with_the_bytes_is_found_on_every_topic() {
    let mcap = converted(&streams::clean(300));
    // The stream has no outage, and no line of the robot's own form.
    let derived = |topic: &Topic| {
        matches!(topic.origin(), Origin::Line | Origin::History)
            && !matches!(topic, Topic::Outages | Topic::Values)
    };
    for wrong in Topic::ALL.into_iter().filter(derived).map(Topic::name) {
        let mut spoilt = Vec::new();
        let mut writer = mcap::WriteOptions::new()
            .library(concat!(
                "groundwave ",
                env!("CARGO_PKG_VERSION"),
                ", fixed topics"
            ))
            .create(Cursor::new(&mut spoilt))
            .unwrap();
        let mut count = 0;
        for message in mcap::MessageStream::new(&mcap).unwrap() {
            let mut message = message.unwrap();
            if message.channel.topic == wrong {
                count += 1;
                // Not the first message of `/log`, which reports the beginning.
                if count == 2 {
                    let mut data = message.data.into_owned();
                    *data.last_mut().unwrap() ^= 1;
                    message.data = data.into();
                }
            }
            writer.write(&message).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        assert!(count >= 2, "{wrong}");
        let verdict = verify_mcap(&spoilt[..], None).unwrap();
        let is_found = |fault: &String| {
            fault.starts_with(wrong) && fault.ends_with("is not what /raw/rx decodes to")
        };
        assert!(
            verdict.faults.iter().any(is_found),
            "{wrong}: {:?}",
            verdict.faults
        );
    }
}

/// Messages of another version may differ from those derived today; the difference is not a fault.
#[test]
fn difference_of_another_version_is_not_a_fault() {
    let mcap = converted(&streams::clean(300));
    for (library, is_good) in [
        (
            concat!("groundwave ", env!("CARGO_PKG_VERSION"), ", fixed topics"),
            false,
        ),
        ("groundwave 0.0.9, fixed topics", true),
    ] {
        let mut other = Vec::new();
        let options = mcap::WriteOptions::new().library(library);
        let mut writer = options.create(Cursor::new(&mut other)).unwrap();
        for message in mcap::MessageStream::new(&mcap).unwrap() {
            let mut message = message.unwrap();
            if message.channel.topic == "/path" {
                message.data.to_mut().reverse();
            }
            writer.write(&message).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let verdict = verify_mcap(&other[..], None).unwrap();
        assert_eq!(
            verdict.is_good(),
            is_good,
            "{library}: {:?}",
            verdict.faults
        );
        assert!(verdict.derived_unchecked > 0, "{library}");
    }
}

#[test]
fn telemetry_that_is_not_what_was_received_is_found() {
    let raw = streams::clean(60);
    let other = streams::noisy(60, 5);
    let mut mcap = Vec::new();
    let good = converted(&raw);
    let lies = converted(&other);
    // The telemetry of one capture and the bytes of another.
    let mut writer = mcap::Writer::new(Cursor::new(&mut mcap)).unwrap();
    for message in messages(&good, "/raw/rx") {
        writer.write(&message).unwrap();
    }
    for message in messages(&lies, "/telemetry") {
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let verdict = verify_mcap(&mcap[..], None).unwrap();
    let found = verdict
        .faults
        .iter()
        .any(|f| f.contains("is not what /raw/rx decodes to"));
    assert!(found, "{:?}", verdict.faults);
}

/// Lines sent while the link was lost do not count as lost; `info` and `verify` agree.
#[test]
fn lines_sent_while_the_link_was_lost_count_as_lost() {
    let folder = scratch("verify-lost-link");
    let path = folder.join("a.mcap");
    let stream = streams::lines(300);
    let (before, after) = (&stream[..8040], &stream[12_030..]);
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    recorder.handle_rx(Duration::ZERO, wall(Duration::ZERO), before);
    let now = Duration::from_secs(30);
    let reason = "unplugged".to_owned();
    let lost = Event::Link(LinkEvent::Lost { reason });
    let lost = to_recorded(Duration::ZERO, &lost).unwrap();
    recorder.handle_event(now, wall(now), &lost);
    recorder.handle_rx(2 * now, wall(2 * now), after);
    recorder.finish().unwrap();
    let verdict = verify_mcap(fs::File::open(&path).unwrap(), None).unwrap();
    let info = Info::read(&mut Capture::open(&path).unwrap());
    assert_eq!(info.loss.lines_lost, 50);
    assert_eq!(
        (verdict.lines, verdict.loss.lines_lost, verdict.gaps),
        (info.lines.total(), info.loss.lines_lost, 1)
    );
    assert!(verdict.is_good(), "{verdict:?}");
    fs::remove_dir_all(folder).unwrap();
}
