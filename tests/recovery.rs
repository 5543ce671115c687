//! Recordings that were killed, cut, damaged or left in the middle: what was received is saved, and what is
//! lost is named.

use crate::streams;
use std::fs;
use std::time::Duration;

use crate::recordings::{
    chunks, concatenated, feed, finished, killed, messages, received, session, settle, wall,
};
use crate::streams::Dice;
use groundwave::capture::messages::StationEvent;
use groundwave::capture::recover::{
    Outcome, Paths, Recovery, find_interrupted, recover, set_aside,
};
use groundwave::capture::{CaptureError, Existing, Recorder};
use groundwave::event::{Level, NoticeCode};
use tempfile::TempDir;

/// Every piece is what was received there, in order, and each step is named.
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
    let paths = killed(folder.path(), &stream);
    assert_eq!(
        find_interrupted(folder.path()),
        std::slice::from_ref(&paths.target)
    );
    let recovery = recover(&paths.partial).unwrap();
    assert_eq!(recovery.outcome, Outcome::Recovered);
    assert_eq!(recovery.rx_bytes, stream.len() as u64);
    assert_honest(&recovery, &stream, "killed");
    assert!(!paths.are_interrupted());
    // The same as if it had been finished, but for the note about it.
    let whole = finished(folder.path(), &stream);
    assert_eq!(messages(&paths.target), messages(&whole));
    let again = recover(&paths.target).unwrap();
    assert_eq!(again.outcome, Outcome::Whole);
    assert_eq!(again.rx_bytes, stream.len() as u64);
    assert!(find_interrupted(folder.path()).is_empty());
}

/// The end of either file is wherever the disk had got to.
#[test]
fn a_cut_anywhere_costs_what_was_behind_both_cuts() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 2);
    let paths = killed(folder.path(), &stream);
    let partial = fs::read(&paths.partial).unwrap();
    let journal = fs::read(&paths.journal).unwrap();
    let mut dice = Dice(1);
    for round in 0..250 {
        let copy = Paths::of(&folder.path().join(format!("cut-{round}.mcap")));
        let partial_bytes = dice.roll(partial.len() + 1);
        let journal_bytes = if round % 2 == 0 {
            dice.roll(journal.len() + 1)
        } else {
            journal.len()
        };
        fs::write(&copy.partial, &partial[..partial_bytes]).unwrap();
        fs::write(&copy.journal, &journal[..journal_bytes]).unwrap();
        let what = format!("{partial_bytes} and {journal_bytes} bytes");
        let recovery = recover(&copy.target).unwrap();
        let have = concatenated(&copy.target);
        assert!(stream.starts_with(&have), "{what}");
        if journal_bytes == journal.len() {
            assert_eq!(have, stream, "{what}");
            assert_eq!(recovery.outcome, Outcome::Recovered, "{what}");
        }
        assert_eq!(recovery.rx_bytes, have.len() as u64, "{what}");
        assert_eq!(
            recover(&copy.target).unwrap().outcome,
            Outcome::Whole,
            "{what}"
        );
        fs::remove_file(&copy.target).unwrap();
    }
}

/// A recording from elsewhere has no journal: what was flushed is all there is.
#[test]
fn a_cut_without_a_journal_keeps_every_whole_chunk() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 3);
    let paths = killed(folder.path(), &stream);
    let partial = fs::read(&paths.partial).unwrap();
    let mut dice = Dice(2);
    let mut longest = 0;
    for round in 0..250 {
        let copy = Paths::of(&folder.path().join(format!("cut-{round}.mcap")));
        let bytes = dice.roll(partial.len() + 1);
        fs::write(&copy.partial, &partial[..bytes]).unwrap();
        match recover(&copy.target) {
            Ok(_) => {
                let have = concatenated(&copy.target);
                assert!(stream.starts_with(&have), "{bytes} bytes");
                longest = longest.max(have.len());
            }
            Err(error) => {
                assert!(matches!(error, CaptureError::NothingLeft(_)), "{error}");
                assert!(copy.partial.exists(), "what cannot be saved is left alone");
            }
        }
    }
    assert!(
        longest * 10 > stream.len() * 5,
        "{longest} of {}",
        stream.len()
    );
}

#[test]
fn a_flipped_bit_of_a_finished_recording_is_found_and_costs_little() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 4);
    let good = fs::read(finished(folder.path(), &stream)).unwrap();
    let mut dice = Dice(3);
    let mut kept = 0;
    for round in 0..250 {
        let path = folder.path().join(format!("flipped-{round}.mcap"));
        let (byte, bit) = (dice.roll(good.len()), dice.roll(8));
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
fn a_flipped_bit_in_the_journal_or_the_unfinished_file_costs_nothing() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 5);
    let paths = killed(folder.path(), &stream);
    let partial = fs::read(&paths.partial).unwrap();
    let journal = fs::read(&paths.journal).unwrap();
    let mut dice = Dice(4);
    for round in 0..250 {
        let copy = Paths::of(&folder.path().join(format!("flipped-{round}.mcap")));
        let (mut partial, mut journal) = (partial.clone(), journal.clone());
        let file = if round % 2 == 0 {
            &mut partial
        } else {
            &mut journal
        };
        let (byte, bit) = (dice.roll(file.len()), dice.roll(8));
        file[byte] ^= 1 << bit;
        fs::write(&copy.partial, &partial).unwrap();
        fs::write(&copy.journal, &journal).unwrap();
        let what = format!("round {round}: bit {bit} of byte {byte}");
        let recovery = recover(&copy.target).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_honest(&recovery, &stream, &what);
        if round % 2 == 0 {
            assert_eq!(recovery.rx_bytes, stream.len() as u64, "{what}");
        }
        fs::remove_file(&copy.target).unwrap();
    }
}

/// Both files are damaged, and each has what the other lacks: nothing is lost, unless it is lost in both,
/// and the rest is as if nothing had happened.
#[test]
fn what_either_file_has_is_saved() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(400, 7);
    let paths = killed(folder.path(), &stream);
    let whole = messages(&finished(folder.path(), &stream));
    let partial = fs::read(&paths.partial).unwrap();
    let journal = fs::read(&paths.journal).unwrap();
    let chunks = chunks(&paths.partial);
    assert!(chunks.len() > 5, "{} chunks", chunks.len());
    let mut dice = Dice(5);
    let mut complete = 0;
    for round in 0..120 {
        let copy = Paths::of(&folder.path().join(format!("both-{round}.mcap")));
        let (mut partial, mut journal) = (partial.clone(), journal.clone());
        for _ in 0..=round % 2 {
            let (start, length) = chunks[dice.roll(chunks.len())];
            partial[start + length / 2] ^= 4;
        }
        for _ in 0..=round % 3 {
            let byte = dice.roll(journal.len());
            journal[byte] ^= 1 << dice.roll(8);
        }
        fs::write(&copy.partial, &partial).unwrap();
        fs::write(&copy.journal, &journal).unwrap();
        let recovery = recover(&copy.target).unwrap();
        let what = format!("round {round}: {recovery:?}");
        assert_honest(&recovery, &stream, &what);
        let lost = stream.len() as u64 - recovery.rx_bytes;
        assert!(lost <= 33 * (round as u64 % 3 + 1), "{what}");
        let have = messages(&copy.target);
        if lost == 0 {
            complete += 1;
            let lines = (have["/telemetry"].len(), whole["/telemetry"].len());
            assert!(lines.0 + 3 >= lines.1, "{lines:?} {what}");
        }
        let uplinks = (have["/uplink"].len(), whole["/uplink"].len());
        assert!(
            uplinks.0 <= uplinks.1 && uplinks.0 + 3 >= uplinks.1,
            "{uplinks:?} {what}"
        );
        let kept = recovery.journal_kept.unwrap();
        assert_eq!(fs::read(kept).unwrap(), journal, "{what}");
    }
    assert!(complete > 60, "{complete} of 120 are complete");
}

/// A name is no proof that a file is ours.
#[test]
fn files_of_others_with_such_names_are_left_alone() {
    let folder = TempDir::new().unwrap();
    let paths = Paths::of(&folder.path().join("notes.mcap"));
    for foreign in [&paths.journal, &paths.partial] {
        fs::write(foreign, "Tuesday: it rained.\n").unwrap();
        for error in [
            recover(&paths.target).unwrap_err(),
            set_aside(&paths.target).unwrap_err(),
        ] {
            let error = error.to_string();
            assert!(error.contains(foreign.to_str().unwrap()), "{error}");
            assert!(error.contains("left alone"), "{error}");
        }
        assert_eq!(fs::read(foreign).unwrap(), b"Tuesday: it rained.\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        fs::remove_file(foreign).unwrap();
    }
}

/// A recovered recording is not more at risk than one under way was.
#[test]
fn a_flipped_bit_of_a_recovered_recording_costs_little() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(120, 8);
    let paths = killed(folder.path(), &stream);
    recover(&paths.target).unwrap();
    let good = fs::read(&paths.target).unwrap();
    for (start, length) in chunks(&paths.target) {
        let mut bad = good.clone();
        bad[start + length / 2] ^= 1;
        fs::write(&paths.target, bad).unwrap();
        let recovery = recover(&paths.target).unwrap();
        assert_honest(&recovery, &stream, "recovered");
        let lost = stream.len() as u64 - recovery.rx_bytes;
        assert!(
            lost * 4 < stream.len() as u64,
            "{lost} of {} bytes",
            stream.len()
        );
    }
}

/// Whatever a recovery has got done when it is interrupted, another makes the same of it.
#[test]
fn recovery_can_be_interrupted_anywhere() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(60, 6);
    let paths = killed(folder.path(), &stream);
    let (partial, journal) = (&paths.partial, &paths.journal);
    let (partial_bytes, journal_bytes) = (fs::read(partial).unwrap(), fs::read(journal).unwrap());
    recover(&paths.target).unwrap();
    let done = fs::read(&paths.target).unwrap();
    let recovering = folder.path().join("killed.mcap.recovering");
    for state in ["half written", "renamed", "partial gone", "journal only"] {
        fs::remove_file(&paths.target).unwrap();
        match state {
            "half written" => {
                fs::write(&recovering, &done[..done.len() / 2]).unwrap();
                fs::write(partial, &partial_bytes).unwrap();
                fs::write(journal, &journal_bytes).unwrap();
            }
            "renamed" => {
                fs::write(&paths.target, &done).unwrap();
                fs::write(partial, &partial_bytes).unwrap();
                fs::write(journal, &journal_bytes).unwrap();
            }
            "partial gone" => {
                fs::write(&paths.target, &done).unwrap();
                fs::write(journal, &journal_bytes).unwrap();
            }
            _ => fs::write(journal, &journal_bytes).unwrap(),
        }
        recover(&paths.target).unwrap();
        assert_eq!(fs::read(&paths.target).unwrap(), done, "{state}");
        let files = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(files, 1, "{state}");
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
    let paths = killed(folder.path(), &stream);
    let aside = set_aside(&paths.target).unwrap().unwrap();
    assert_eq!(aside, folder.path().join("killed.interrupted.mcap"));
    let recorder = Recorder::start(&paths.target, Existing::Refuse, &session()).unwrap();
    recorder.finish().unwrap();
    assert_eq!(recover(&aside).unwrap().outcome, Outcome::Recovered);
    assert_eq!(concatenated(&aside), stream);
    assert_eq!(set_aside(&paths.target).unwrap(), None);
}

/// Two recordings have a claim to the name: both are kept.
#[test]
fn a_finished_recording_is_not_replaced_by_an_interrupted_one() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(30);
    let paths = killed(folder.path(), &stream);
    let other = streams::clean(12);
    let whole = finished(folder.path(), &other);
    fs::rename(whole, &paths.target).unwrap();
    let recovery = recover(&paths.target).unwrap();
    assert_eq!(recovery.path, folder.path().join("killed.interrupted.mcap"));
    assert_eq!(concatenated(&recovery.path), stream);
    assert_eq!(concatenated(&paths.target), other);
}

/// What the station said stands once in what is recovered, whichever file it is taken from, though its times come
/// out of order and it says the same again and again.
#[test]
fn what_was_said_is_saved_once() {
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
        // Read by another thread, a moment before.
        recorder.handle_event(now, wall(now) - Duration::from_millis(5), &said);
        settle(&recorder);
    }
    let from = Paths::of(&live);
    let (partial, journal) = (
        fs::read(&from.partial).unwrap(),
        fs::read(&from.journal).unwrap(),
    );
    recorder.finish().unwrap();
    let whole = messages(&live);
    assert!(whole["/log"].len() > 90, "it said something");
    for tenths in 0..=10 {
        let to = Paths::of(&folder.path().join(format!("{tenths}.mcap")));
        fs::write(&to.partial, &partial).unwrap();
        fs::write(&to.journal, &journal[..journal.len() * tenths / 10]).unwrap();
        recover(&to.target).unwrap();
        let saved = messages(&to.target);
        let logs = &saved["/log"];
        let first = &whole["/log"][..logs.len()];
        assert!(logs == first, "{tenths} tenths of the journal");
    }
    for tenths in 0..=10 {
        let to = Paths::of(&folder.path().join(format!("cut-{tenths}.mcap")));
        fs::write(&to.partial, &partial[..partial.len() * tenths / 10]).unwrap();
        fs::write(&to.journal, &journal).unwrap();
        recover(&to.target).unwrap();
        assert!(
            messages(&to.target)["/log"] == whole["/log"],
            "{tenths} tenths of the recording"
        );
    }
}

/// What nobody can read any more is named, and nothing is made of it.
#[test]
fn what_is_no_recording_is_refused() {
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
