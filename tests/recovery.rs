//! Recovery of killed, cut and damaged recordings: received bytes are kept, and losses are reported.

use crate::streams;
use std::fs;
use std::time::Duration;

use crate::recordings::{
    chunks, concatenated, feed, finished, killed, messages, received, session, wait_until_written,
    wall,
};
use crate::streams::Rng;
use groundwave::capture::interrupted::{find_interrupted, set_aside};
use groundwave::capture::messages::{RawBytes, StationEvent};
use groundwave::capture::recover::{Outcome, Recovery, recover};
use groundwave::capture::topics::Topic;
use groundwave::capture::{CaptureError, Existing, Recorder};
use groundwave::event::{Level, NoticeCode};
use mcap::records::op;
use prost::Message as _;
use tempfile::TempDir;

/// Checks that every piece equals the received bytes, that pieces are in order, and that every gap is reported.
fn assert_honest(recovery: &Recovery, stream: &[u8], what: &str) {
    let mut steps = Vec::new();
    let mut end = 0;
    for (offset, data) in received(&recovery.path) {
        let at = offset as usize;
        assert_eq!(stream.get(at..at + data.len()), Some(&*data), "{what}");
        assert!(offset >= end, "{what}: out of order");
        if offset > end {
            steps.push((end, offset - end));
        }
        end = offset + data.len() as u64;
    }
    let named: Vec<_> = recovery
        .rx_missing
        .iter()
        .map(|missing| (missing.offset, missing.bytes))
        .collect();
    assert_eq!(named, steps, "{what}");
    let lost: u64 = steps.iter().map(|step| step.1).sum();
    assert_eq!(recovery.rx_bytes, end - lost, "{what}");
    if end < stream.len() as u64 || lost > 0 {
        assert_eq!(recovery.outcome, Outcome::Partly, "{what}: {recovery:?}");
    }
}

#[test]
fn a_killed_recording_has_everything_again() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(200, 1);
    let path = killed(folder.path(), &stream);
    assert_eq!(find_interrupted(folder.path()), std::slice::from_ref(&path));
    let recovery = recover(&path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Recovered);
    assert_eq!(recovery.rx_bytes, stream.len() as u64);
    assert_honest(&recovery, &stream, "killed");
    assert!(find_interrupted(folder.path()).is_empty());
    // The result equals a finished recording.
    let whole = finished(folder.path(), &stream);
    assert_eq!(fs::read(&path).unwrap(), fs::read(&whole).unwrap());
    let again = recover(&path).unwrap();
    assert_eq!(again.outcome, Outcome::Whole);
    assert_eq!(again.rx_bytes, stream.len() as u64);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

/// Every message of an unfinished recording, read by the `mcap` crate alone.
fn messages_by_others(bytes: &[u8]) -> Vec<(String, u64, Vec<u8>)> {
    let options = mcap::read::Options::IgnoreEndMagic;
    mcap::MessageStream::new_with_options(bytes, options.into())
        .unwrap()
        .map_while(Result::ok)
        .map(|message| {
            let topic = message.channel.topic.clone();
            (topic, message.log_time, message.data.into_owned())
        })
        .collect()
}

#[test]
fn an_unfinished_recording_is_read_by_any_mcap_reader() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(200, 10);
    let path = killed(folder.path(), &stream);
    let messages = messages_by_others(&fs::read(&path).unwrap());
    let bytes = messages
        .iter()
        .filter(|(topic, ..)| topic == "/raw/rx")
        .flat_map(|(.., data)| RawBytes::decode(&**data).unwrap().data);
    assert_eq!(bytes.collect::<Vec<u8>>(), stream);
    assert!(messages.iter().any(|(topic, ..)| topic == "/raw/tx"));
    assert!(messages.iter().any(|(topic, ..)| topic == "/station"));
    assert!(messages.is_sorted_by_key(|(_, at_ns, _)| at_ns));
}

/// The file may end anywhere after a power cut.
#[test]
fn a_cut_anywhere_loses_no_whole_message_before_it() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 2);
    let whole = fs::read(killed(folder.path(), &stream)).unwrap();
    let mut rng = Rng(1);
    let path = folder.path().join("cut.mcap");
    for _ in 0..250 {
        let bytes = rng.below(whole.len() + 1);
        fs::write(&path, &whole[..bytes]).unwrap();
        let what = format!("{bytes} bytes");
        let readable = if bytes < mcap::MAGIC.len() {
            Vec::new()
        } else {
            messages_by_others(&whole[..bytes])
        };
        if readable.is_empty() {
            let error = recover(&path).unwrap_err();
            assert!(matches!(error, CaptureError::NothingLeft(_)), "{error}");
            assert!(path.exists(), "what cannot be saved is left alone");
            continue;
        }
        let recovery = recover(&path).unwrap();
        let have = concatenated(&path);
        let expected = readable
            .iter()
            .filter(|(topic, ..)| topic == "/raw/rx")
            .flat_map(|(.., data)| RawBytes::decode(&**data).unwrap().data);
        assert_eq!(have, expected.collect::<Vec<u8>>(), "{what}");
        assert!(stream.starts_with(&have), "{what}");
        assert_eq!(recovery.outcome, Outcome::Recovered, "{what}");
        assert_eq!(recovery.rx_bytes, have.len() as u64, "{what}");
        assert_eq!(recovery.original, None, "{what}");
        assert_eq!(recover(&path).unwrap().outcome, Outcome::Whole, "{what}");
    }
}

#[test]
fn a_flipped_bit_of_a_finished_recording_is_found_and_costs_little() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 4);
    let good = fs::read(finished(folder.path(), &stream)).unwrap();
    let mut rng = Rng(3);
    let mut kept = 0;
    for round in 0..250 {
        let path = folder.path().join(format!("flipped-{round}.mcap"));
        let (byte, bit) = (rng.below(good.len()), rng.below(8));
        let mut bad = good.clone();
        bad[byte] ^= 1 << bit;
        fs::write(&path, &bad).unwrap();
        let what = format!("bit {bit} of byte {byte}");
        let recovery = recover(&path).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_ne!(recovery.outcome, Outcome::Whole, "{what}");
        assert_honest(&recovery, &stream, &what);
        kept += recovery.rx_bytes;
        if let Some(original) = &recovery.original {
            assert_eq!(fs::read(original).unwrap(), bad, "{what}");
        }
        let again = recover(&path).unwrap();
        assert_eq!(again.rx_bytes, recovery.rx_bytes, "{what}");
    }
    let share = kept as f64 / 250.0 / stream.len() as f64;
    assert!(share > 0.8, "{share} of the bytes are kept on average");
}

#[test]
fn a_flipped_bit_of_an_unfinished_recording_costs_one_message() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 5);
    let good = fs::read(killed(folder.path(), &stream)).unwrap();
    let mut rng = Rng(4);
    for round in 0..250 {
        let path = folder.path().join(format!("flipped-{round}.mcap"));
        let (byte, bit) = (rng.below(good.len()), rng.below(8));
        let mut bad = good.clone();
        bad[byte] ^= 1 << bit;
        fs::write(&path, &bad).unwrap();
        let what = format!("round {round}: bit {bit} of byte {byte}");
        let recovery = recover(&path).unwrap_or_else(|error| panic!("{what}: {error}"));
        // A loss at the end leaves no gap; the rest equals the received bytes.
        let lost = stream.len() as u64 - recovery.rx_bytes;
        assert!(lost <= 33, "{what}: {recovery:?}");
        if lost > 0 {
            assert_eq!(recovery.outcome, Outcome::Partly, "{what}: {recovery:?}");
        }
        for (offset, data) in received(&path) {
            let at = offset as usize;
            assert_eq!(stream.get(at..at + data.len()), Some(&*data), "{what}");
        }
        if let Some(original) = &recovery.original {
            assert_eq!(fs::read(original).unwrap(), bad, "{what}");
        }
        assert_eq!(
            recover(&path).unwrap().rx_bytes,
            recovery.rx_bytes,
            "{what}"
        );
    }
}

/// Several damaged places cost only the parts in which they are; station events are kept, too.
#[test]
fn everything_between_damaged_places_is_saved() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(400, 7);
    let good = fs::read(killed(folder.path(), &stream)).unwrap();
    let whole = messages(&finished(folder.path(), &stream));
    let mut rng = Rng(5);
    for round in 0..60 {
        let path = folder.path().join(format!("both-{round}.mcap"));
        let mut bad = good.clone();
        let flips = round % 5 + 1;
        for _ in 0..flips {
            // Other tests damage header, topics and session.
            let byte = good.len() / 2 + rng.below(good.len() / 2);
            bad[byte] ^= 1 << rng.below(8);
        }
        fs::write(&path, &bad).unwrap();
        let recovery = recover(&path).unwrap();
        let what = format!("round {round}: {recovery:?}");
        let lost = stream.len() as u64 - recovery.rx_bytes;
        assert!(lost <= 33 * flips, "{what}");
        let have = messages(&path);
        let uplinks = (have["/uplink"].len(), whole["/uplink"].len());
        assert!(
            uplinks.0 <= uplinks.1 && uplinks.0 + flips as usize >= uplinks.1,
            "{uplinks:?} {what}"
        );
        if let Some(original) = recovery.original {
            assert_eq!(fs::read(original).unwrap(), bad, "{what}");
        }
    }
}

/// A report has the totals of all losses and a list of the first ones.
#[test]
fn a_report_of_many_losses_is_short() {
    const STEPS: u64 = 3000;
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("steps.mcap");
    let mut bytes = fs::read(killed(folder.path(), &streams::clean(3))).unwrap();
    // Each message lacks ten bytes before it, and a record without a body follows.
    for n in 0..STEPS {
        let raw = RawBytes {
            stream_offset: 10_000 + n * 11,
            data: vec![b'x'],
        };
        let header = [
            &Topic::RawRx.channel_id().to_le_bytes()[..],
            &(n as u32).to_le_bytes(),
            &(u64::MAX - STEPS + n).to_le_bytes(),
            &(u64::MAX - STEPS + n).to_le_bytes(),
        ];
        let message = [header.concat(), raw.encode_to_vec()].concat();
        for (opcode, body) in [(op::MESSAGE, &message[..]), (op::SCHEMA, &[])] {
            bytes.push(opcode);
            bytes.extend((body.len() as u64).to_le_bytes());
            bytes.extend(body);
        }
    }
    fs::write(&path, bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert_eq!(
        (recovery.rx_missing.len(), recovery.damage.len()),
        (1000, 1000)
    );
    assert_eq!(recovery.unlisted, 2 * STEPS - 2000);
    assert_eq!(recovery.rx_bytes, 240 + STEPS);
    assert_eq!(recovery.rx_bytes_missing, 10_000 - 240 + (STEPS - 1) * 10);
    let mut text = Vec::new();
    recovery.write_text(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.contains("lost or skipped: 4000 more parts"),
        "{}",
        text.len()
    );
    assert!(text.lines().count() < 2010, "{}", text.lines().count());
}

/// Another program's file may have the name of an interrupted recording.
#[test]
fn files_of_others_with_such_names_are_left_alone() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("notes.mcap");
    let foreign = b"Tuesday: it rained.\n";
    fs::write(&path, foreign).unwrap();
    assert!(find_interrupted(folder.path()).is_empty());
    assert_eq!(set_aside(&path).unwrap(), None);
    let error = recover(&path).unwrap_err();
    assert!(matches!(error, CaptureError::NothingLeft(_)), "{error}");
    assert_eq!(fs::read(&path).unwrap(), foreign);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// A flipped bit costs a recovered recording no more than a recording in progress.
#[test]
fn a_flipped_bit_of_a_recovered_recording_costs_little() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 8);
    let path = killed(folder.path(), &stream);
    recover(&path).unwrap();
    let good = fs::read(&path).unwrap();
    for (start, length) in chunks(&path) {
        let mut bad = good.clone();
        bad[start + length / 2] ^= 1;
        fs::write(&path, bad).unwrap();
        let recovery = recover(&path).unwrap();
        assert_honest(&recovery, &stream, "recovered");
        let lost = stream.len() as u64 - recovery.rx_bytes;
        assert!(
            lost * 4 < stream.len() as u64,
            "{lost} of {} bytes",
            stream.len()
        );
    }
}

/// A recovery that was interrupted at any point can be repeated with the same result.
#[test]
fn recovery_can_be_interrupted_anywhere() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(60, 6);
    let path = killed(folder.path(), &stream);
    let unfinished = fs::read(&path).unwrap();
    recover(&path).unwrap();
    let done = fs::read(&path).unwrap();
    let finishing = folder.path().join("killed.mcap.finishing");
    for written in [0, done.len() / 2, done.len()] {
        fs::write(&finishing, &done[..written]).unwrap();
        fs::write(&path, &unfinished).unwrap();
        recover(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), done, "{written} bytes");
        let files = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(files, 1, "{written} bytes");
    }
}

#[test]
fn a_recording_under_way_is_left_alone() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("live.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    feed(&mut recorder, &streams::clean(10));
    assert!(find_interrupted(folder.path()).is_empty());
    let error = recover(&path).unwrap_err();
    assert!(matches!(error, CaptureError::UnderWay(_)), "{error}");
    let error = set_aside(&path).unwrap_err();
    assert!(matches!(error, CaptureError::InUse(_)), "{error}");
    recorder.finish().unwrap();
    assert_eq!(recover(&path).unwrap().outcome, Outcome::Whole);
}

#[test]
fn an_interrupted_recording_makes_room_for_one_of_its_name() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(30);
    let path = killed(folder.path(), &stream);
    let aside = set_aside(&path).unwrap().unwrap();
    assert_eq!(aside, folder.path().join("killed.interrupted.mcap"));
    let recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    recorder.finish().unwrap();
    assert_eq!(recover(&aside).unwrap().outcome, Outcome::Recovered);
    assert_eq!(concatenated(&aside), stream);
    assert_eq!(set_aside(&path).unwrap(), None);
}

/// Each event of the station is in the result once, even with times out of order and repeated texts.
#[test]
fn each_event_is_saved_once() {
    let folder = TempDir::new().unwrap();
    let live = folder.path().join("live.mcap");
    let mut recorder = Recorder::start(&live, Existing::Refuse, &session()).unwrap();
    let mut now = Duration::ZERO;
    for (n, line) in (0_u32..).zip(streams::clean(90).chunks(80)) {
        now += Duration::from_millis(333);
        recorder.handle_rx(now, wall(now), line);
        let said = StationEvent::notice(
            NoticeCode::Other,
            Level::Info,
            if n % 3 == 0 { "the same" } else { "another" },
        );
        // Read by another thread a moment earlier.
        recorder.handle_event(now, wall(now) - Duration::from_millis(5), &said);
    }
    wait_until_written(&recorder);
    let unfinished = fs::read(&live).unwrap();
    recorder.finish().unwrap();
    let whole = messages(&live);
    assert!(whole["/log"].len() > 90, "it said something");
    for tenths in 6..=10 {
        let path = folder.path().join(format!("{tenths}.mcap"));
        fs::write(&path, &unfinished[..unfinished.len() * tenths / 10]).unwrap();
        recover(&path).unwrap();
        let logs = &messages(&path)["/log"];
        assert!(whole["/log"].starts_with(logs), "{tenths} tenths");
        assert_eq!(tenths == 10, logs.len() == whole["/log"].len());
    }
    // Rewriting a finished recording duplicates no event.
    let mut bad = fs::read(&live).unwrap();
    let end = bad.len() - 20;
    bad[end] ^= 1;
    fs::write(&live, bad).unwrap();
    assert_eq!(recover(&live).unwrap().outcome, Outcome::Recovered);
    assert!(messages(&live) == whole);
}

/// Unreadable files are refused with an error, and no result is written.
#[test]
fn other_files_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    assert!(matches!(recover(&path), Err(CaptureError::Open { .. })));
    for content in [&b""[..], b"text", &[0; 4096], &[6; 4096]] {
        fs::write(&path, content).unwrap();
        let error = recover(&path).unwrap_err();
        assert!(matches!(error, CaptureError::NothingLeft(_)), "{error}");
        assert_eq!(fs::read(&path).unwrap(), content);
    }
}
