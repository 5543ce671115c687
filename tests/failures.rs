//! Failures outside the program: full disks, closed streams, unusual files.
#![cfg(target_os = "linux")]

use std::fs;
use std::process::{Command, Output};

use crate::programs::{GROUNDWAVE, Sim, expect, scratch};

const CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

/// Runs a shell line in which `$G` is the program.
fn shell(line: &str) -> Output {
    Command::new("sh")
        .args(["-c", line])
        .env("G", GROUNDWAVE)
        .env("CAPTURE", CAPTURE)
        .output()
        .unwrap()
}

fn code(line: &str) -> (Option<i32>, String) {
    let output = shell(line);
    let both = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(both).unwrap())
}

/// A limit of 8 kB on files simulates a full disk.
#[test]
fn a_full_disk_is_not_a_success() {
    let folder = scratch("full");
    for (n, verb) in ["record - -o", "watch - --headless --tee"]
        .iter()
        .enumerate()
    {
        let raw = folder.join(format!("{n}.txt"));
        let line = format!("ulimit -f 16; $G {verb} {} < $CAPTURE", raw.display());
        let (code, told) = code(&line);
        assert_eq!(code, Some(1), "{verb}: {told}");
        assert!(
            told.contains("stopped") && !told.contains("recorded"),
            "{told}"
        );
        assert_eq!(fs::read(&raw).unwrap(), fs::read(CAPTURE).unwrap()[..8192]);
    }
    let (code, told) = code("$G record - -o /dev/full --force < $CAPTURE");
    assert_eq!(code, Some(1), "{told}");
    assert!(told.contains("make room"), "{told}");
}

/// The disk for the simulator's outputs is full: the robot continues, and the exit code reports the error.
#[test]
fn a_simulation_with_an_incomplete_file_is_not_a_success() {
    for output in ["trace", "wav"] {
        let line = format!("$G sim --duration 11s --time-factor 100 --{output} /dev/full --force");
        let (code, told) = code(&line);
        assert_eq!(code, Some(1), "{told}");
        assert!(
            told.contains("/dev/full is incomplete: the disk is full; free some space"),
            "{told}"
        );
        assert!(told.contains("ran to its end"), "{told}");
    }
}

#[test]
fn too_few_open_files_are_reported() {
    let folder = scratch("open-files");
    let made = folder.join("made.mcap").display().to_string();
    for verb in [
        "info $CAPTURE".to_owned(),
        format!("export --to mcap $CAPTURE -o {made}"),
        format!("record sim --duration 1s -o {made}"),
        "sim --duration 1s".to_owned(),
        "send sim stop".to_owned(),
        "ports".to_owned(),
    ] {
        for limit in [8, 12, 20] {
            let (code, told) = code(&format!("ulimit -n {limit}; $G {verb}"));
            assert_eq!(code, Some(1), "{verb}, {limit}: {told}");
            assert!(
                told.contains("raise their limit with `ulimit -n`"),
                "{told}"
            );
            assert!(
                !told.contains("panicked") && !told.contains("os error"),
                "{told}"
            );
        }
    }
    let (shared, told) = code("ulimit -n 64; $G watch sim --headless --share 127.0.0.1:0");
    assert_eq!(shared, Some(1), "{told}");
    assert!(told.contains("`ulimit -n`"), "{told}");
    // A limit that the program may raise.
    let (raised, told) = code("ulimit -Sn 8; $G sim --duration 1s --time-factor 100");
    assert_eq!(raised, Some(0), "{told}");
}

#[test]
fn a_headless_watch_reports_a_failed_recording_at_once() {
    let sim = Sim::start(&[]);
    let line = format!(
        "timeout 20 $G watch {} --headless --tee /dev/full --force | grep -m 1 notice",
        sim.path
    );
    let (code, told) = code(&line);
    assert_eq!(code, Some(0));
    assert!(
        told.contains("\"alarm\"") && told.contains("make room"),
        "{told}"
    );
}

#[test]
fn a_capture_goes_down_a_pipe_or_nowhere_without_a_complaint() {
    let folder = scratch("fifo");
    let fifo = folder.join("fifo");
    let line = format!(
        "mkfifo {fifo}; cat {fifo} > {fifo}.out & $G record - -o {fifo} --force < $CAPTURE; code=$?; wait; exit $code",
        fifo = fifo.display()
    );
    let (code_of_fifo, told) = code(&line);
    assert_eq!(code_of_fifo, Some(0), "{told}");
    assert_eq!(
        fs::read(folder.join("fifo.out")).unwrap(),
        fs::read(CAPTURE).unwrap()
    );
    let (code, told) = code("$G record - -o /dev/null --force < $CAPTURE");
    assert_eq!(code, Some(0), "{told}");
    assert!(told.contains("28799 bytes written"), "{told}");
}

#[test]
fn a_refused_start_leaves_nothing_behind_and_destroys_nothing() {
    let folder = scratch("refused");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (tee, old, same) = (path("new.txt"), path("old.mcap"), path("same"));
    fs::write(&old, "precious").unwrap();
    let watch = |arguments: &[&str]| {
        let arguments = [&["watch", "sim", "--headless"], arguments].concat();
        expect(2, &arguments).1
    };
    watch(&["--tee", &tee, "--record", &old]);
    let told = watch(&["--tee", &same, "--record", &same]);
    assert!(told.contains("different names"), "{told}");
    watch(&["--tee", &old, "--record", &path("new.mcap")]);
    expect(
        1,
        &[
            "watch",
            "sim",
            "--headless",
            "--force",
            "--tee",
            &old,
            "--record",
            "/nowhere/a.mcap",
        ],
    );
    assert_eq!(fs::read(&old).unwrap(), b"precious");
    let left: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left, ["old.mcap"]);
}

#[test]
fn a_closed_or_full_standard_error_keeps_the_exit_code() {
    for (line, wanted) in [
        ("$G send /nope stop 2>/dev/full", 4),
        ("$G send /nope stop 2>&-", 4),
        ("$G record - -o /dev/null --force < $CAPTURE 2>/dev/full", 0),
        ("$G sim --duration 1s --time-factor 100 2>/dev/full", 0),
        ("$G info /nope /nope 2>/dev/full", 2),
    ] {
        let (code, told) = code(line);
        assert_eq!(code, Some(wanted), "{line}: {told}");
    }
}

/// A refusal keeps its exit code when the reader of standard error has ended.
#[test]
fn a_reader_of_standard_error_that_goes_away_keeps_the_exit_code() {
    let folder = scratch("closed-pipe");
    let code_file = folder.join("code");
    let line = format!(
        "{{ $G send sim dock 2>&1; echo $? > {}; }} | true",
        code_file.display()
    );
    shell(&line);
    assert_eq!(fs::read_to_string(code_file).unwrap().trim(), "5");
}

#[test]
fn bad_input_is_called_bad_input() {
    let folder = scratch("bad");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (prose, cut) = (path("prose.txt"), path("cut.mcap"));
    fs::write(&prose, "nothing a robot would say\n".repeat(40)).unwrap();
    let whole = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/demo-commands.mcap");
    let whole = fs::read(whole).unwrap();
    fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    for arguments in [
        &["export", "-o", "-", &prose, "--to", "csv"][..],
        &["export", "-o", "-", &prose, "--to", "jsonl"],
        &["info", &prose],
        &["info", "/tmp"],
        &["export", "-o", "-", "/tmp", "--to", "csv"],
        &["sim", "--time-factor", "0"],
        &["sim", "--time-factor", "nan"],
        &["sim", "--time-factor", "1e9"],
        &["sim", "--listen", "nonsense"],
        &["sim", "--eeprom", &prose],
        &["sim", "--pty", &prose],
    ] {
        expect(2, arguments);
    }
    // An interrupted recording is read as far as possible, with a warning.
    for arguments in [
        &["info", &cut][..],
        &["export", "-o", "-", &cut, "--to", "csv"],
    ] {
        let (out, err) = expect(1, arguments);
        assert!(out.lines().count() > 5 && err.contains("cut.mcap"), "{err}");
    }
}

#[test]
fn unsent_command_is_not_called_doubtful() {
    let sim = Sim::start(&["--channel", "out=0s..10000s"]);
    let (_, err) = expect(
        3,
        &["send", &sim.path, "mode", "prowl", "--timeout", "10ms"],
    );
    assert!(
        err.contains("within 10 ms") && err.contains("It was not sent."),
        "{err}"
    );
    let (_, err) = expect(3, &["send", &sim.path, "stop", "--timeout", "10ms"]);
    assert!(err.contains("may or may not"), "{err}");
}
