//! A running recorder: its parts, its history, and a removed folder.

use crate::streams;
use std::fs::{self, File};
use std::path::PathBuf;
use std::time::Duration;

use crate::recordings::{START_S, concatenated, feed, messages, received, session, wall};
use groundwave::capture::recover::{Outcome, recover};
use groundwave::capture::rotation::part_name;
use groundwave::capture::topics::{Origin, Topic};
use groundwave::capture::{Capture, Existing, Recorder, Rotation, Session};
use tempfile::TempDir;

#[test]
fn days_are_recorded_in_parts_that_are_whole_by_themselves() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("long.mcap");
    let rotation: Rotation = "50s".parse().unwrap();
    let mut recorder =
        Recorder::start_rotating(&path, Existing::Refuse, &session(), rotation).unwrap();
    let stream = streams::lines(600);
    feed(&mut recorder, &stream);
    recorder.finish().unwrap();
    let parts: Vec<PathBuf> = ["long.mcap", "long-2.mcap", "long-3.mcap", "long-4.mcap"]
        .iter()
        .map(|name| folder.path().join(name))
        .collect();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), parts.len());
    let mut all = Vec::new();
    for part in &parts {
        assert_eq!(recover(part).unwrap().outcome, Outcome::Whole);
        let pieces = received(part);
        assert_eq!(pieces[0].0, 0, "each part counts from its own beginning");
        all.extend(pieces.into_iter().flat_map(|piece| piece.1));
        let messages = messages(part);
        // The robot acknowledges nothing new, no line is late, and none is of the robot's own form.
        let derived = |topic: &Topic| match topic.origin() {
            Origin::Line | Origin::History => {
                !matches!(topic, Topic::Uplink | Topic::Outages | Topic::Values)
            }
            Origin::Recorded | Origin::Event => false,
        };
        for topic in Topic::ALL.into_iter().filter(derived).map(Topic::name) {
            let part = part.display();
            assert!(messages.contains_key(topic), "{topic} in {part}");
        }
    }
    assert_eq!(all, stream);
}

/// Number of lines in each part of a recording with one line at each of these times, milliseconds.
fn lines_by_part(rotation: &str, times_ms: impl IntoIterator<Item = u64>) -> Vec<usize> {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    let rotation: Rotation = rotation.parse().unwrap();
    let mut recorder =
        Recorder::start_rotating(&path, Existing::Refuse, &session(), rotation).unwrap();
    let line = &streams::clean(1)[..80];
    for time_ms in times_ms {
        let now = Duration::from_millis(time_ms);
        recorder.handle_rx(now, wall(now), line);
    }
    recorder.finish().unwrap();
    let parts = (1..).map(|part| part_name(&path, part));
    parts
        .take_while(|part| part.exists())
        .map(|part| received(&part).len())
        .collect()
}

#[test]
fn a_part_is_as_long_as_asked_however_long_its_file_takes_to_begin() {
    // The third line waits for the disk.
    let times_ms = [0, 500, 1000, 2700, 2800, 3600, 3650];
    assert_eq!(lines_by_part("1s", times_ms), [3, 4]);
}

#[test]
fn a_part_is_as_large_as_asked_however_large_its_beginning_is() {
    let lines = lines_by_part("1kB", 0..100);
    let (_, whole) = lines.split_last().unwrap();
    assert!(whole.iter().all(|lines| *lines > 5), "{lines:?}");
}

#[test]
fn remembered_bytes_come_first_with_their_times() {
    use groundwave::capture::Observation;
    use groundwave::capture::messages::RawBytes;
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("late.mcap");
    let stream = streams::clean(30);
    let session = Session {
        start: wall(Duration::ZERO) - Duration::from_mins(10),
        ..session()
    };
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session).unwrap();
    let remembered = stream[..1600].chunks(80).zip(0..).map(|(line, n)| {
        let raw = RawBytes::unplaced(line);
        let at_ns = (START_S - 600 + n) * 1_000_000_000;
        (at_ns, Observation::Received(raw))
    });
    recorder.handle_backlog(&remembered.collect::<Vec<_>>());
    recorder.handle_rx(Duration::ZERO, wall(Duration::ZERO), &stream[1600..]);
    recorder.finish().unwrap();
    assert_eq!(concatenated(&path), stream);
    let mut capture = Capture::open(&path).unwrap();
    let mut at_s = Vec::new();
    while let Some(chunk) = capture.next_chunk().unwrap() {
        at_s.push(chunk.at.as_secs());
    }
    assert_eq!(at_s[..20], (0..20).collect::<Vec<_>>());
    assert_eq!(at_s[20], 600);
}

/// A removed folder is reported, and the open file stays open.
#[cfg(unix)]
#[test]
fn a_removed_folder_is_reported_at_the_end() {
    let folder = TempDir::new().unwrap();
    let inner = folder.path().join("gone");
    fs::create_dir(&inner).unwrap();
    let path = inner.join("a.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    fs::remove_dir_all(&inner).unwrap();
    feed(&mut recorder, &streams::clean(30));
    let error = recorder.finish().unwrap_err().to_string();
    assert!(error.contains("a.mcap"), "{error}");
    let error = Recorder::start(&path, Existing::Refuse, &session()).err();
    let error = error.unwrap().to_string();
    assert!(error.contains("create the folder first"), "{error}");
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_reported_at_once() {
    use std::os::unix::fs::PermissionsExt;
    let folder = TempDir::new().unwrap();
    let closed = folder.path().join("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    if File::create(closed.join("probe")).is_ok() {
        // The test runs as root, who may write anywhere.
        return;
    }
    let error = Recorder::start(closed.join("a.mcap"), Existing::Refuse, &session()).err();
    let error = error.unwrap().to_string();
    assert!(error.contains("choose a writable folder"), "{error}");
}
