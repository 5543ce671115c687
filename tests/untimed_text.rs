//! Text without timestamps: what it shows of pauses and lost lines.
#![cfg(unix)]

use std::fs;

use serde_json::Value;

use crate::outages::{Robot, object, sample};
use crate::programs::{GROUNDWAVE, expect, scratch};
use crate::pty::OnTerminal;

/// Pauses that a text does not contain show in the robot's clock.
#[test]
fn text_without_its_pauses_says_how_long_the_robots_clock_ran() {
    let lines = sample();
    let text = [&lines[..30], &lines[195..]].concat().concat();
    let folder = scratch("without-pauses");
    let path = folder.join("a.txt");
    fs::write(&path, text).unwrap();
    let (info, _) = expect(0, &["info", path.to_str().unwrap()]);
    for words in [
        "1 min 4.7 s without the pauses, 1 min 56.0 s by the robot's clock",
        "gap at 10.0 s: 165 lines lost",
    ] {
        assert!(info.contains(words), "no {words} in {info}");
    }
    fs::remove_dir_all(folder).unwrap();
}

/// Without times, a text does not show how long a robot was silent before it booted again, and neither does its conversion.
#[test]
fn a_reboot_in_text_without_timestamps_leaves_the_loss_open() {
    let mut text = Vec::new();
    for (boots, lines) in [(4, 0..100), (5, 90..150), (6, 0..60)] {
        let mut robot = Robot {
            boots,
            booted_s: 0.0,
            sent: 0,
        };
        for n in 0..lines.end {
            let line = robot.line(f64::from(n) / 3.0);
            if lines.contains(&n) {
                text.extend(line);
            }
        }
    }
    let folder = scratch("untimed-reboot");
    let [text_path, recording] = ["a.txt", "a.mcap"].map(|name| folder.join(name));
    let [path, recording] = [&text_path, &recording].map(|path| path.to_str().unwrap());
    fs::write(path, &text).unwrap();
    expect(0, &["export", path, "--to", "mcap", "-o", recording]);
    let outages = |verb: &str, path: &str| {
        let figures = object(&expect(0, &[verb, path, "--json"]).0, "lines_lost");
        let told = (&figures["lines_lost"], &figures["lines_lost_max"]);
        assert_eq!(told, (&90.into(), &Value::Null), "{verb} {path}");
        assert_eq!(
            figures.get("airtime_down_pct"),
            Some(&Value::Null).filter(|_| verb == "info")
        );
        figures["outages"].clone()
    };
    let listed = outages("info", path);
    for (outage, lost) in listed.as_array().unwrap().iter().zip([90, 0]) {
        assert_eq!(outage["code"], "rebooted");
        let told = (&outage["lines_lost"], &outage["lines_lost_max"]);
        assert_eq!(told, (&lost.into(), &Value::Null));
    }
    let info = expect(0, &["info", path]).0;
    assert!(info.contains(": an unknown number of lines lost"), "{info}");
    for path in [path, recording] {
        for verb in ["info", "verify"] {
            assert_eq!(outages(verb, path), listed, "{verb} {path}");
        }
        outages("runs", path);
        let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", path], 160, 60);
        replay.wait_for("the beginning", |text| text.contains("REPLAY"));
        replay.type_keys("G");
        replay.wait_for("the loss", |text| text.contains("loss at least 29.0 %"));
        // Soon after the second reboot.
        replay.type_keys("g82%\r");
        replay.wait_for("the latest loss", |text| {
            text.contains("loss at least 0.0 %")
        });
        replay.type_keys("q");
        assert_eq!(replay.wait(), 0);
    }
    fs::remove_dir_all(folder).unwrap();
}

/// A line that is missing before the first or after the last line C could be one of a hundred and one; one between two lines C is one.
#[test]
fn a_gap_in_text_without_timestamps_is_open_until_a_line_c() {
    let lines = &sample()[1..];
    let counters: Vec<usize> = (0..lines.len())
        .filter(|at| lines[*at][0] == b'C')
        .collect();
    let [first, .., before, last] = counters[..] else {
        panic!("{counters:?}");
    };
    let folder = scratch("untimed-gap");
    // The header has a loss as long as the session is not over.
    for (missing, most, keys, header) in [
        (first - 6, Value::Null, "g5%\r", "loss at least "),
        (before + 1, Value::from(1), "G,", "loss 1.7 %"),
        (last + 1, Value::Null, "G,", "loss at least 1.7 %"),
    ] {
        let text = [&lines[..missing], &lines[missing + 1..]].concat().concat();
        let path = folder.join(format!("{missing}.txt"));
        let path = path.to_str().unwrap();
        fs::write(path, text).unwrap();
        for verb in ["info", "verify", "runs"] {
            let figures = object(&expect(0, &[verb, path, "--json"]).0, "lines_lost");
            let told = (&figures["lines_lost"], &figures["lines_lost_max"]);
            assert_eq!(told, (&1.into(), &most), "{verb}, without line {missing}");
        }
        let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", path], 160, 60);
        replay.wait_for("the beginning", |text| text.contains("REPLAY"));
        replay.type_keys(keys);
        replay.wait_for("the loss", |text| text.contains(header));
        replay.type_keys("q");
        assert_eq!(replay.wait(), 0);
    }
    fs::remove_dir_all(folder).unwrap();
}
