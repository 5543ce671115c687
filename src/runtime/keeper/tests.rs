use super::*;
use crate::capture::{Capture, Piece};
#[cfg(target_os = "linux")]
use crate::capture::{Existing, Rotation, Session};
use crate::event::NoticeCode;
use std::fs;

/// A recording manager whose first recording goes into `folder`.
fn keeper(folder: &Path, started: Instant) -> Keeper {
    let options = KeepOptions {
        mcap: Some(folder.join("first/a.mcap")),
        ..KeepOptions::default()
    };
    fs::create_dir(folder.join("first")).unwrap();
    let keeper = Keeper::open(&options, started).unwrap();
    // No thread may look for interrupted recordings while the folder is removed.
    wait_until("the folder was searched", || !keeper.is_busy());
    keeper
}

/// Waits for another thread.
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + Duration::from_mins(1);
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}: never");
        thread::yield_now();
    }
}

fn wait_for_notice(keeper: &Keeper, words: &str) {
    let mut said = Vec::new();
    wait_until(words, || {
        said.extend(keeper.poll_notice());
        said.iter().any(|(_, text)| text.contains(words))
    });
}

fn received(path: &Path) -> String {
    let mut capture = Capture::open(path).unwrap();
    let mut received = Vec::new();
    while let Some(chunk) = capture.next_chunk().unwrap() {
        received.extend(chunk.bytes);
    }
    String::from_utf8(received).unwrap()
}

/// Removes the folder of a current recording, and makes the recorder check its file.
fn fail(keeper: &Keeper, folder: &Path, at: Instant) {
    fs::remove_dir_all(folder.join("first")).unwrap();
    let mut sink = keeper.sink();
    sink(at, b"one\n");
    sink(at + Duration::from_secs(20), b"two\n");
    wait_until("it has failed", || {
        keeper.status().problem.is_some() && keeper.lock().recorder.as_ref().unwrap().has_failed()
    });
}

#[test]
fn bytes_after_a_failure_are_in_the_next_recording() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let keeper = keeper(folder.path(), started);
    fail(&keeper, folder.path(), started);
    keeper.sink()(started + Duration::from_secs(21), b"three\n");
    keeper.toggle_as(folder.path().join("b.mcap"));
    wait_for_notice(&keeper, "recording to");
    keeper.sink()(started + Duration::from_secs(22), b"four\n");
    keeper.finish().unwrap();
    let all = "one\ntwo\nthree\nfour\n";
    assert_eq!(received(&folder.path().join("b.mcap")), all);
}

/// A failed attempt keeps the history, and a reported failure is not reported again.
#[test]
fn another_attempt_loses_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let keeper = keeper(folder.path(), started);
    fail(&keeper, folder.path(), started);
    keeper.toggle_as(folder.path().join("nowhere/b.mcap"));
    wait_until("it has been tried", || !keeper.lock().is_beginning);
    let (level, text) = keeper.poll_notice().unwrap();
    assert_eq!(level, Level::Alarm);
    assert!(text.contains("create the folder first"), "{text}");
    assert_eq!(keeper.poll_notice(), None);
    keeper.toggle_as(folder.path().join("c.mcap"));
    wait_for_notice(&keeper, "recording to");
    keeper.finish().unwrap();
    assert_eq!(received(&folder.path().join("c.mcap")), "one\ntwo\n");
}

/// A failed recording is recovered even if the next one has another folder.
#[test]
fn a_recording_that_failed_is_recovered_when_the_next_begins() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let keeper = keeper(folder.path(), started);
    let moved = folder.path().join("first/moved.mcap");
    let mut sink = keeper.sink();
    sink(started, b"one\n");
    fs::rename(folder.path().join("first/a.mcap"), &moved).unwrap();
    sink(started + Duration::from_secs(20), b"two\n");
    wait_until("it has failed", || {
        keeper.lock().recorder.as_ref().unwrap().has_failed()
    });
    keeper.toggle_as(folder.path().join("b.mcap"));
    wait_for_notice(&keeper, "recording to");
    keeper.finish().unwrap();
    assert_eq!(received(&moved), "one\ntwo\n");
}

/// A finished recording's observations are not in the next one.
#[test]
fn a_finished_recording_is_not_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let keeper = keeper(folder.path(), started);
    let mut sink = keeper.sink();
    sink(started, b"one\n");
    keeper.toggle();
    sink(started + Duration::from_secs(1), b"two\n");
    wait_for_notice(&keeper, "recorded");
    keeper.toggle_as(folder.path().join("b.mcap"));
    wait_for_notice(&keeper, "recording to");
    keeper.finish().unwrap();
    assert_eq!(received(&folder.path().join("first/a.mcap")), "one\n");
    assert_eq!(received(&folder.path().join("b.mcap")), "two\n");
}

/// The time of a note counts as in a replay of the recording.
#[test]
fn a_moment_of_a_recording_counts_from_the_first_that_is_in_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let options = KeepOptions {
        mcap: Some(path.clone()),
        ..KeepOptions::default()
    };
    let started = Instant::now();
    let after = |s| started + Duration::from_secs(s);
    let keeper = Keeper::open(&options, started).unwrap();
    assert_eq!(keeper.moment_of(&path, after(1)), None);
    keeper.sink()(after(2), b"something\r\n");
    let ten = Some(Duration::from_secs(10));
    assert_eq!(keeper.moment_of(&path, after(12)), ten);
    let other = folder.path().join("b.mcap");
    assert_eq!(keeper.moment_of(&other, after(12)), None);
    keeper.finish().unwrap();
}

#[test]
fn two_unnamed_recordings_begin_in_one_second() {
    let folder = tempfile::tempdir().unwrap();
    let options = KeepOptions {
        mcap: Some(folder.path().join("groundwave-20250314T092653Z.mcap")),
        is_unnamed: true,
        ..KeepOptions::default()
    };
    let keepers = [(); 3].map(|()| Keeper::open(&options, Instant::now()).unwrap());
    for keeper in keepers {
        keeper.finish().unwrap();
    }
    let mut names: Vec<String> = fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let name = |number| format!("groundwave-20250314T092653Z{number}.mcap");
    assert_eq!(names, [".2", ".3", ""].map(name));
}

#[test]
fn a_panic_leaves_a_finished_recording() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let options = KeepOptions {
        mcap: Some(path.clone()),
        link: "sim".to_owned(),
        ..KeepOptions::default()
    };
    let keeper = Keeper::open(&options, Instant::now()).unwrap();
    // The link's reader thread keeps the sink.
    let _sink = keeper.sink();
    let panicked = std::panic::catch_unwind(|| {
        let _finish = keeper.finish_on_drop();
        panic!("this is the panic that was asked for");
    });
    assert!(panicked.is_err());
    assert!(path.exists());
}

/// The event loop requests the state while the raw text waits for its reader.
#[cfg(target_os = "linux")]
#[test]
fn a_stalled_raw_text_delays_neither_the_recording_nor_the_event_loop() {
    use std::os::fd::AsRawFd;
    let folder = tempfile::tempdir().unwrap();
    let (reader, pipe) = std::io::pipe().unwrap();
    let options = KeepOptions {
        tee: Some(format!("/proc/self/fd/{}", pipe.as_raw_fd()).into()),
        mcap: Some(folder.path().join("a.mcap")),
        existing: Existing::Append,
        ..KeepOptions::default()
    };
    let started = Instant::now();
    let keeper = Keeper::open(&options, started).unwrap();
    drop(pipe);
    let line = "a line of the robot\n".repeat(10_000);
    keeper.sink()(started, line.as_bytes());
    keeper.sent_sink()(started, b"stop\n");
    assert_eq!(keeper.status().problem, None);
    wait_until("the folder was searched", || !keeper.is_busy());
    drop(reader);
    let error = keeper.finish().unwrap_err().to_string();
    assert!(error.contains("stopped"), "{error}");
    assert_eq!(received(&folder.path().join("a.mcap")), line);
}

/// The sinks and the status, which STOP and drawing need, work while the disk hangs.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_hangs_delays_neither_the_link_nor_the_event_loop() {
    let (reader, pipe) = std::io::pipe().unwrap();
    let session = Session {
        link: "sim".to_owned(),
        start: UNIX_EPOCH,
        notes: [].into(),
        configuration: String::new(),
    };
    let started = Instant::now();
    let keeper = Keeper::open(&KeepOptions::default(), started).unwrap();
    let recorder = Recorder::on(
        fs::File::from(std::os::fd::OwnedFd::from(pipe)),
        Path::new("pipe.mcap"),
        Existing::Refuse,
        &session,
        Rotation::default(),
    );
    keeper.lock().recorder = Some(recorder.unwrap());
    let line = "a line of the robot\n".repeat(200);
    let (mut sink, mut sent) = (keeper.sink(), keeper.sent_sink());
    for second in 0..200 {
        let now = started + Duration::from_secs(second);
        sink(now, line.as_bytes());
        sent(now, b"stop\n");
        assert_eq!(keeper.status().mcap.as_deref(), Some("pipe.mcap"));
    }
    let unwritten = keeper.lock().recorder.as_ref().unwrap().unwritten_bytes();
    assert!(unwritten > 500_000, "the disk has not hung: {unwritten}");
    drop(reader);
    assert!(keeper.finish().is_err());
}

/// A silence at the end lasts until the end of the recording, which the recording has.
#[test]
fn the_end_of_a_recording_is_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let started = Instant::now();
    let keeper = keeper(folder.path(), started);
    keeper.sink()(started, b"one\n");
    keeper.finish().unwrap();
    let mut capture = Capture::open(folder.path().join("first/a.mcap")).unwrap();
    let mut has_ended = false;
    while let Some((_, piece)) = capture.next_piece().unwrap() {
        has_ended |=
            matches!(piece, Piece::Event(event) if event.is_notice(NoticeCode::RecordingEnded));
    }
    assert!(has_ended);
}
