//! Full disks, and interrupted recordings found at the start.
#![cfg(unix)]

use std::fs;
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant, SystemTime};

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use crate::pty::OnTerminal;
use groundwave::capture::interrupted::find_interrupted;
use groundwave::capture::recover::{Outcome, recover};
use groundwave::capture::{Existing, RawWriter, Recorder, Session};

/// A limit on the size of files simulates a full disk without privileges.
#[test]
fn a_full_disk_is_reported_and_the_robot_is_still_watched() {
    let folder = scratch("full");
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "50"]);
    let path = folder.join("run.mcap");
    let script = "ulimit -f 100; exec \"$0\" \"$@\"";
    let mut watch = Telling::start_as(
        "sh",
        &[
            "-c",
            script,
            GROUNDWAVE,
            "watch",
            &sim.path,
            "--headless",
            "--no-uplink",
            "--record",
            path.to_str().unwrap(),
        ],
    );
    let told = watch.wait_for("that the disk is full", |value| {
        value["event"] == "notice" && value["level"] == "alarm"
    });
    let text = told["text"].as_str().unwrap();
    assert!(text.contains("run.mcap"), "{text}");
    assert!(text.contains("everything before is kept"), "{text}");
    let hint = format!("`groundwave recover {}`", path.display());
    assert!(text.contains(&hint), "{text}");
    watch.wait_for_new("another line", |value| value["event"] == "line");
    drop(watch);
    let recovery = recover(&path).unwrap();
    assert!(recovery.rx_bytes > 5000, "{recovery:?}");
    assert!(path.exists() && find_interrupted(&folder).is_empty());
}

#[test]
fn a_disk_too_full_to_begin_keeps_nothing_and_claims_nothing() {
    let folder = scratch("too-full");
    let script = "cd \"$0\"; ulimit -f 8; exec \"$@\"";
    let output = Command::new("sh")
        .args(["-c", script])
        .arg(&folder)
        .args([
            GROUNDWAVE,
            "record",
            "sim",
            "-o",
            "run.mcap",
            "--duration",
            "1s",
        ])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(
        err.contains("cannot create run.mcap") && !err.contains("kept"),
        "{err}"
    );
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn after_a_full_disk_one_key_records_on() {
    let folder = scratch("full-dashboard");
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "50"]);
    let script = "cd \"$0\"; ulimit -f 60; exec \"$@\"";
    let folder = folder.to_str().unwrap();
    let arguments = [
        "-c", script, folder, GROUNDWAVE, "watch", &sim.path, "--record", "run.mcap",
    ];
    let mut watch = OnTerminal::start("sh", &arguments, 120, 40);
    watch.wait_for("that the disk is full", |text| {
        text.contains("RECORDING FAILED")
    });
    watch.type_keys("R");
    watch.wait_for("the next recording", |text| text.contains("groundwave-2"));
    watch.type_keys("q");
    watch.wait();
}

/// Replay copies standard input to a temporary file.
#[test]
fn a_temporary_folder_that_does_not_exist_is_named() {
    let script = "TMPDIR=/nonexistent exec \"$0\" replay - < captures/house-clean.txt";
    let mut replay = OnTerminal::start("sh", &["-c", script, GROUNDWAVE], 120, 40);
    assert_eq!(replay.wait(), 1);
    let text = replay.text();
    assert!(text.contains("in /nonexistent: not found"), "{text}");
    assert!(text.contains("set TMPDIR"), "{text}");
}

#[test]
fn an_interrupted_recording_is_recovered_when_the_next_begins() {
    let folder = scratch("next");
    let path = folder.join("run.mcap");
    let name = path.to_str().unwrap();
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "50"]);
    let arguments = [
        "watch",
        &sim.path,
        "--headless",
        "--no-uplink",
        "--record",
        name,
    ];
    let mut killed = Telling::start(&arguments);
    for _ in 0..20 {
        killed.wait_for_new("a line", |value| value["event"] == "line");
    }
    drop(killed);
    assert_eq!(find_interrupted(&folder), [path.as_path()]);
    // The name is used again: both recordings are kept.
    let (_, err) = expect(0, &["record", &sim.path, "-o", name, "--duration", "1s"]);
    assert!(err.contains("recovered"), "{err}");
    assert!(err.contains("run.interrupted.mcap"), "{err}");
    for name in ["run.mcap", "run.interrupted.mcap"] {
        assert_eq!(recover(&folder.join(name)).unwrap().outcome, Outcome::Whole);
    }
    let (_, err) = expect(2, &["record", &sim.path, "-o", name, "--duration", "1s"]);
    assert!(err.contains("exists") && err.contains("--force"), "{err}");
}

#[test]
fn a_disk_that_is_full_stops_a_recovery_and_changes_nothing() {
    let folder = scratch("room");
    let path = folder.join("run.mcap");
    let name = path.to_str().unwrap();
    record(&path);
    let mut bad = fs::read(&path).unwrap();
    let middle = bad.len() / 2;
    bad[middle] ^= 1;
    fs::write(&path, &bad).unwrap();
    let script = "ulimit -f 4; exec \"$0\" \"$@\"";
    let output = Command::new("sh")
        .args(["-c", script, GROUNDWAVE, "recover", name])
        .output()
        .unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(
        err.contains("run recover again; nothing was changed"),
        "{err}"
    );
    assert!(err.contains("run.mcap failed"), "{err}");
    assert_eq!(fs::read(&path).unwrap(), bad);
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
}

/// All recordings that cannot be recovered are reported in one line, which explains how to stop the reports.
#[test]
fn unrecoverable_file_is_reported_once() {
    let folder = scratch("hopeless");
    for name in ["a.mcap", "b.mcap", "c.mcap"] {
        recorder(&folder.join(name)).abandon();
        // A folder has the name of recovery's output.
        fs::create_dir(folder.join(format!("{name}.finishing"))).unwrap();
    }
    let path = folder.join("run.mcap");
    let output = Command::new(GROUNDWAVE)
        .args(["record", "-", "-o"])
        .arg(&path)
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success(), "{err}");
    let told: Vec<&str> = err
        .lines()
        .filter(|line| line.contains("recover"))
        .collect();
    assert_eq!(told.len(), 1, "{err}");
    assert!(told[0].contains("3 interrupted recordings"), "{err}");
    assert!(
        told[0].contains("a.mcap") && told[0].contains("delete"),
        "{err}"
    );
}

#[test]
fn names_of_unfinished_recordings_are_refused() {
    let folder = scratch("names");
    for name in ["x.damaged", "x.mcap.finishing"] {
        let path = folder.join(name);
        let (_, err) = expect(2, &["record", "-", "-o", path.to_str().unwrap()]);
        assert!(err.contains(name) && err.contains("another name"), "{err}");
        assert!(!path.exists());
    }
}

fn record(path: &Path) {
    let mut child = Command::new(GROUNDWAVE)
        .args(["record", "-", "--quiet", "-o"])
        .arg(path)
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let text = fs::read("captures/house-noisy.txt").unwrap();
    child.stdin.take().unwrap().write_all(&text).unwrap();
    assert!(child.wait().unwrap().success());
}

#[test]
fn recover_reports_its_work_as_text_and_as_json() {
    let folder = scratch("says");
    let path = folder.join("run.mcap");
    record(&path);
    let name = path.to_str().unwrap();
    let (out, _) = expect(0, &["recover", name]);
    assert!(out.contains("is whole"), "{out}");
    let good = fs::read(&path).unwrap();
    let mut bad = good.clone();
    // Chunks come first, and records between them are shorter.
    let place = bad.len() / 8;
    bad[place] ^= 1;
    fs::write(&path, bad).unwrap();
    let (out, err) = expect(1, &["recover", "--json", name]);
    let said: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(said["outcome"], "partly");
    assert_eq!(said["damage"].as_array().unwrap().len(), 1, "{said}");
    assert!(err.contains("a part of it is lost"), "{err}");
    let (_, err) = expect(2, &["recover", "nowhere.mcap"]);
    assert!(err.contains("cannot open nowhere.mcap"), "{err}");
    let (_, err) = expect(0, &["recover", folder.to_str().unwrap()]);
    assert!(err.contains("no interrupted recordings"), "{err}");
}

/// Records into a folder until the folder is removed.
fn removed_recording(name: &str) -> (i32, String) {
    let folder = scratch(&format!("removed-{name}"));
    let mut child = Command::new(GROUNDWAVE)
        .args(["record", "-", "-o"])
        .arg(folder.join(name))
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_mins(1);
    let text = fs::read("captures/house-noisy.txt").unwrap();
    child.stdin.as_mut().unwrap().write_all(&text).unwrap();
    let is_written = || {
        let entries = fs::read_dir(&folder).unwrap();
        let bytes = |entry: fs::DirEntry| entry.metadata().map_or(0, |about| about.len());
        entries
            .map_while(Result::ok)
            .any(|entry| bytes(entry) > 1000)
    };
    while !is_written() && Instant::now() < deadline {
        std::thread::yield_now();
    }
    fs::remove_dir_all(&folder).unwrap();
    drop(child.stdin.take());
    let mut err = String::new();
    let mut said = child.stderr.take().unwrap();
    said.read_to_string(&mut err).unwrap();
    (child.wait().unwrap().code().unwrap(), err)
}

#[test]
fn a_recording_whose_folder_was_removed_has_failed() {
    for name in ["a.txt", "a.mcap"] {
        let (code, err) = removed_recording(name);
        assert_eq!(code, 1, "{name}: {err}");
        assert!(
            err.contains("the file no longer exists; it was removed"),
            "{err}"
        );
        assert!(err.contains("its content is lost"), "{err}");
        assert!(!err.contains("recorded"), "{err}");
    }
}

/// The recorder's problem after its next check.
fn problem(recorder: &Recorder) -> String {
    let deadline = Instant::now() + Duration::from_mins(1);
    while recorder.problem().is_none() && Instant::now() < deadline {
        std::thread::yield_now();
    }
    recorder.problem().unwrap()
}

fn recorder(path: &Path) -> Recorder {
    let session = Session {
        link: "sim".to_owned(),
        start: SystemTime::now(),
        notes: [].into(),
        configuration: String::new(),
    };
    let mut recorder = Recorder::start(path, Existing::Refuse, &session).unwrap();
    recorder.handle_rx(Duration::ZERO, SystemTime::now(), b"noise\n");
    recorder.handle_timeout(Duration::ZERO);
    recorder
}

#[test]
fn removed_files_are_reported_within_seconds() {
    const SOON: Duration = Duration::from_secs(10);
    let folder = scratch("taken");
    let path = |name: &str| folder.join(name);

    let mut removed = recorder(&path("removed.mcap"));
    fs::remove_file(path("removed.mcap")).unwrap();
    removed.handle_timeout(SOON);
    assert!(problem(&removed).contains("its content is lost"));
    assert!(removed.finish().is_err());

    let mut moved = recorder(&path("here.mcap"));
    fs::rename(path("here.mcap"), path("there.mcap")).unwrap();
    moved.handle_timeout(SOON);
    assert!(problem(&moved).contains("moved or renamed"));
    assert!(moved.finish().is_err());
    assert_eq!(recover(&path("there.mcap")).unwrap().rx_bytes, 6);

    let replaced = RawWriter::create(path("a.txt"), Existing::Refuse).unwrap();
    replaced.handle_timeout(Duration::ZERO);
    assert_eq!(replaced.problem(), None);
    fs::rename(path("a.txt"), path("b.txt")).unwrap();
    fs::write(path("a.txt"), "somebody else's").unwrap();
    replaced.handle_timeout(SOON);
    let deadline = Instant::now() + Duration::from_mins(1);
    while replaced.problem().is_none() {
        assert!(Instant::now() < deadline, "no problem");
        std::thread::yield_now();
    }
    assert!(replaced.problem().unwrap().contains("moved or renamed"));
    replaced.write(b"more");
    assert!(replaced.finish().is_err());
    assert_eq!(fs::read(path("b.txt")).unwrap(), b"more");

    // A device has no content to lose.
    let device = RawWriter::create("/dev/null", Existing::Append).unwrap();
    device.handle_timeout(Duration::ZERO);
    device.handle_timeout(SOON);
    assert_eq!(device.problem(), None);
    device.finish().unwrap();
}
