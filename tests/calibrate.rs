//! `groundwave calibrate` with a simulated robot in another process.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::programs::{GROUNDWAVE, Running, Sim, Telling, expect, scratch};

/// Maximum wait for a silent station.
const PATIENCE: Duration = Duration::from_secs(12);

/// Time factor; a square of 40 in takes a minute of simulated time.
const TIME_FACTOR: &str = "16";

/// A robot in a hall with room for its squares, and its EEPROM file.
fn robot_in_a_hall(folder: &Path) -> (Sim, PathBuf) {
    let hall = folder.join("hall.toml");
    let floor = format!("#{}#\n", ".".repeat(60)).repeat(30);
    let wall = format!("{}\n", "#".repeat(62));
    let start = format!("#{}^{}#\n", ".".repeat(30), ".".repeat(29));
    let plan = format!("{wall}{floor}{start}{floor}{wall}");
    let world = format!("name = \"hall\"\ncell_in = 12\nplan = '''\n{plan}'''\n");
    fs::write(&hall, world).unwrap();
    let eeprom = folder.join("eeprom");
    let robot = Sim::start(&[
        "--world",
        hall.to_str().unwrap(),
        "--listen",
        "127.0.0.1:0",
        "--time-factor",
        TIME_FACTOR,
        "--eeprom",
        eeprom.to_str().unwrap(),
    ]);
    (robot, eeprom)
}

/// Runs the calibration and answers its questions; returns its output.
fn calibrate(way: &[&str]) -> String {
    let child = Command::new(GROUNDWAVE)
        .arg("calibrate")
        .args(way)
        .args(["--side", "40", "--once", "--save"])
        .stdin(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut child = Running(child);
    let mut answers = child.0.stdin.take().unwrap();
    let told = BufReader::new(child.0.stderr.take().unwrap());
    // The first answer is not a measurement, so the question is repeated.
    let mut measured = ["a bit to the left", "3.0 -2.0", "-3.0 -2.0"].into_iter();
    let mut said = String::new();
    for line in told.lines() {
        let line = line.unwrap();
        if line.starts_with("Measure its position") || line.ends_with("Again:") {
            let answer = measured.next().expect("it asks three times");
            writeln!(answers, "{answer}").unwrap();
        }
        said += &(line + "\n");
    }
    assert!(child.0.wait().unwrap().success(), "{said}");
    said
}

#[test]
fn calibration_is_sent_and_saved() {
    let folder = scratch("calibrate");
    let (robot, eeprom) = robot_in_a_hall(&folder);
    // Another parameter is changed but not saved.
    expect(0, &["param", &robot.path, "set", "top-speed", "8"]);
    let said = calibrate(&[&robot.path]);
    for words in [
        "a track of 10000",
        "`a bit to the left` is not two numbers",
        "Error before: 3.",
        "Saved permanently.",
        "Not saved, as before: top-speed 8.",
    ] {
        assert!(said.contains(words), "`{words}` is not in:\n{said}");
    }
    // Both squares ended behind and outside the mark: every corner turned too little, as with a wider track.
    let kept = fs::read_to_string(&eeprom).unwrap();
    let track = kept.lines().find_map(|line| line.strip_prefix("track="));
    let track: i32 = track
        .unwrap_or_else(|| panic!("no track in:\n{kept}"))
        .parse()
        .unwrap();
    assert!(
        said.contains(&format!("Measured: a track of {track} ")),
        "{said}"
    );
    assert!(track > 10_000, "{said}");
    let (out, _) = expect(0, &["param", &robot.path, "list"]);
    for (name, value, kept) in [
        ("square", 157, 157),
        ("top-speed", 8, 12),
        ("track", track, track),
    ] {
        let row = out
            .lines()
            .find(|line| line.starts_with(&format!("{name} ")));
        let row: Vec<&str> = row.unwrap().split_whitespace().collect();
        let wanted = [name, &value.to_string(), "saved", &kept.to_string()];
        assert_eq!(row[..4], wanted, "{out}");
    }
    robot.end();
}

#[test]
fn calibration_works_over_a_shared_link() {
    let folder = scratch("calibrate-via");
    let (robot, eeprom) = robot_in_a_hall(&folder);
    let socket = folder.join("s");
    let socket = socket.to_str().unwrap();
    let mut station = Telling::start(&["watch", &robot.path, "--headless", "--share", socket]);
    station.wait_for("a line", |value| value["event"] == "line");
    let said = calibrate(&["--via", socket]);
    assert!(said.contains("Saved permanently."), "{said}");
    let kept = fs::read_to_string(&eeprom).unwrap();
    assert!(
        kept.contains("track=1") && !kept.contains("square=-"),
        "{kept}"
    );
    robot.end();
}

/// The station may wait for the robot for minutes; Ctrl-C ends at once.
#[test]
fn interrupted_calibration_over_a_shared_link_ends_at_once() {
    let folder = scratch("calibrate-given-up");
    let robot = Sim::start(&["--channel", "out=0s..10000s"]);
    let socket = folder.join("s");
    let socket = socket.to_str().unwrap();
    let mut station = Telling::start(&["watch", &robot.path, "--headless", "--share", socket]);
    station.wait_for("that it shares", |value| {
        value["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("shared on "))
    });
    let child = Command::new(GROUNDWAVE)
        .args(["calibrate", "--via", socket, "--timeout", "10m"])
        .stdin(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let mut child = Running(child);
    station.wait_for("that it asks", |value| {
        value["event"] == "command" && value["status"] == "queued"
    });
    let pid = child.0.id().to_string();
    let interrupted = Command::new("kill").args(["-INT", &pid]).status();
    assert!(interrupted.unwrap().success());
    let deadline = Instant::now() + PATIENCE;
    while child.0.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "it goes on");
        thread::yield_now();
    }
}

#[test]
fn receive_only_link_cannot_calibrate() {
    let (_, told) = expect(6, &["calibrate", "-"]);
    assert!(told.contains("receive-only"), "{told}");
}
