//! Verbs that read an interrupted recording: each reports that the recording is incomplete and how to finish it.
#![cfg(unix)]

use crate::streams;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::time::{Duration, UNIX_EPOCH};

use crate::programs::{GROUNDWAVE, expect, scratch};
use crate::pty::OnTerminal;
use crate::recordings::wait_until_written;
use groundwave::capture::{Existing, Recorder, Session, index};

/// A recording after a kill.
fn interrupted(folder: &Path, name: &str) {
    let stream = streams::clean(400);
    let session = Session {
        link: "/dev/ttyUSB0".into(),
        start: UNIX_EPOCH,
        notes: BTreeMap::new(),
        configuration: String::new(),
    };
    let live = folder.join("live.mcap");
    let mut recorder = Recorder::start(&live, Existing::Refuse, &session).unwrap();
    let mut now = Duration::ZERO;
    for read in stream.chunks(33) {
        now += Duration::from_millis(137);
        recorder.handle_rx(now, UNIX_EPOCH + now, read);
    }
    wait_until_written(&recorder);
    fs::copy(&live, folder.join(name)).unwrap();
    recorder.discard();
}

const READERS: &[&[&str]] = &[
    &["info"],
    &["export", "-o", "-", "--to", "jsonl"],
    &["export", "--to", "raw", "-o", "-"],
    &["cut", "--from", "0s", "-o", "/dev/null"],
    &["export", "--to", "csv", "-o", "-"],
    &["export", "--to", "svg", "-o", "-"],
    &["songs"],
    &["compare", "captures/house-clean.txt"],
    &["label"],
    &["verify"],
];

#[test]
fn every_reader_names_the_recovery_of_an_interrupted_recording() {
    let folder = scratch("interrupted-readers");
    interrupted(&folder, "r.mcap");
    let file = |name: &str| folder.join(name).display().to_string();
    let remedy = format!("`groundwave recover {}`", file("r.mcap"));
    for verb in READERS.iter().filter(|verb| verb[0] != "label") {
        let (_, err) = expect(1, &[verb, &[&*file("r.mcap")][..]].concat());
        assert!(err.contains(&remedy), "{verb:?}: {err}");
    }
    // The function that `replay` uses.
    assert!(index::open(&folder.join("r.mcap")).is_ok());
    expect(0, &["label", &file("r.mcap"), "--name", "x"]);
    expect(0, &["recover", &file("r.mcap")]);
    for verb in READERS {
        expect(0, &[verb, &[&*file("r.mcap")][..]].concat());
    }
    fs::remove_dir_all(folder).unwrap();
}

/// The readable part is shown; the missing end and its remedy stay in the hint row.
#[test]
fn a_replay_of_an_unfinished_file_keeps_naming_the_recovery() {
    let folder = scratch("interrupted-replay");
    interrupted(&folder, "my r.mcap");
    let file = folder.join("my r.mcap").display().to_string();
    // So fast that the news of every line has been shown before.
    let arguments = ["replay", &file, "--speed", "1000"];
    let mut replay = OnTerminal::start(GROUNDWAVE, &arguments, 80, 24);
    replay.wait_for("the remedy over the robot's lines", |text| {
        text.contains("! this recording was interrupted; `groundwave recover FILE` finishes it")
            && text.contains("session ended")
    });
    // Whole in the log, quoted for a shell and wrapped: the path is as long as the folder of the test makes it.
    let hint = format!(
        "`groundwave recover '{}'`",
        folder.join("my r.mcap").display()
    );
    let dense = |text: &str| text.replace(char::is_whitespace, "");
    replay.resize(200, 40);
    replay.type_keys("\x1b[H\x1b[17~z");
    replay.wait_for("the whole remedy", |text| {
        dense(text).contains(&dense(&hint))
    });
    replay.type_keys("q");
    replay.wait();
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn the_list_of_runs_has_what_was_interrupted() {
    let folder = scratch("interrupted-runs");
    interrupted(&folder, "r.mcap");
    let name = folder.display().to_string();
    let (out, err) = expect(0, &["runs", &name]);
    assert!(
        out.contains("r.mcap") && out.contains("interrupted"),
        "{out}"
    );
    assert!(out.contains("`groundwave recover "), "{out}");
    assert!(!err.contains("capture here"), "{err}");
    let (out, err) = expect(0, &["runs", "--json", &name]);
    assert!(out.contains("r.mcap"), "{out}");
    assert!(err.contains("`groundwave recover "), "{err}");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_recording_under_way_is_not_recovered() {
    let folder = scratch("under-way");
    let session = Session {
        link: "/dev/ttyUSB0".into(),
        start: UNIX_EPOCH,
        notes: BTreeMap::new(),
        configuration: String::new(),
    };
    let path = folder.join("r.mcap");
    let _recorder = Recorder::start(&path, Existing::Refuse, &session).unwrap();
    let file = path.display().to_string();
    let (_, err) = expect(2, &["recover", &file]);
    assert!(err.contains("will not recover"), "{err}");
    assert!(err.contains("end it there first"), "{err}");
    let (_, err) = expect(1, &["info", &file]);
    assert!(err.contains("is being recorded"), "{err}");
    assert!(!err.contains("groundwave recover"), "{err}");
}
