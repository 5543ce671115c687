//! Several robots on one channel: each is named, the other's lines are kept apart, and one that vanished is replaced.
#![cfg(unix)]

use std::fs;
use std::time::Duration;

use crate::outages::{object, sample};
use crate::programs::{expect, scratch};
use groundwave::event::{Event, Notice, NoticeCode};
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{Body, Detail};
use serde_json::Value;
use sr04_sim::{Simulation, SimulationConfig, World};

/// A line as robot 7 would send it, which was switched on earlier.
fn of_robot_7(line: &[u8]) -> Vec<u8> {
    let mut decoder = Decoder::default();
    let Some(Received::Line(mut line, _)) = decoder.lines(line).next() else {
        panic!("an intact line");
    };
    line.ack.detail = Detail::Idle {
        owner: 0,
        robot_id: 7,
    };
    match &mut line.body {
        Body::Counters(counters) => {
            counters.robot_id = 7;
            counters.uptime_s += 5000;
        }
        Body::Status(status) => status.robot_id = 7,
        _ => {}
    }
    line.encode().to_vec()
}

/// The clocks of two robots in one text are not compared.
#[test]
fn text_of_one_robot_after_another_lasts_as_long_as_its_lines() {
    let first: Vec<Vec<u8>> = sample().into_iter().take(100).collect();
    let second = sample().into_iter().take(300);
    let second = second.map(|line| of_robot_7(&line));
    let text: Vec<u8> = first.iter().cloned().chain(second).flatten().collect();
    let folder = scratch("one-after-another");
    let path = folder.join("both.txt");
    fs::write(&path, text).unwrap();
    let (info, _) = expect(0, &["info", path.to_str().unwrap(), "--json"]);
    let info = object(&info, "lines_lost");
    let duration_s = info["duration_s"].as_f64().unwrap();
    assert!((duration_s - 133.3).abs() < 1.0, "{duration_s}");
    assert!(info["robot_clock_s"].as_u64().unwrap() < 140, "{info}");
    // The first robot is silent until the other one is followed.
    let outages = info["outages"].as_array().unwrap();
    assert_eq!(
        (outages.len(), &outages[0]["begin_s"]),
        (1, &33.333_333_333.into())
    );
    fs::remove_dir_all(folder).unwrap();
}

/// Text without timestamps in which one robot is heard no more and another one goes on: nothing shows how many lines of the first are lost.
#[test]
fn a_robot_that_vanishes_from_text_without_timestamps_leaves_its_loss_open() {
    let first: Vec<Vec<u8>> = sample().into_iter().take(100).collect();
    let second = sample().into_iter().take(150);
    let second = second.map(|line| of_robot_7(&line));
    let text: Vec<u8> = first.iter().cloned().chain(second).flatten().collect();
    let folder = scratch("vanished");
    let path = folder.join("both.txt");
    fs::write(&path, text).unwrap();
    for verb in ["info", "verify"] {
        let (figures, _) = expect(0, &[verb, path.to_str().unwrap(), "--json"]);
        let figures = object(&figures, "lines_lost");
        for lost in [&figures, &figures["outages"][0]] {
            let interval = (&lost["lines_lost"], &lost["lines_lost_max"]);
            assert_eq!(interval, (&0.into(), &Value::Null), "{verb} {figures}");
        }
        assert_eq!(figures["outages"].as_array().unwrap().len(), 1, "{verb}");
    }
    let (runs, _) = expect(0, &["runs", path.to_str().unwrap()]);
    assert!(runs.contains(" >=0.0% "), "{runs}");
    fs::remove_dir_all(folder).unwrap();
}

/// A line that may be another robot's counts as the followed one's at the end: text, recording and its messages agree.
#[test]
fn a_recording_that_ends_with_an_undecided_line_is_good() {
    let folder = scratch("undecided");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (text, mcap) = (path("a.txt"), path("a.mcap"));
    let mut lines = sample();
    lines.truncate(20);
    let mut decoder = Decoder::default();
    let Some(Received::Line(mut line, _)) = decoder.lines(&lines[10]).next() else {
        panic!("an intact line");
    };
    line.ack.boot = 5;
    line.ack.detail = Detail::Era { era: 5 };
    lines.push(line.encode().to_vec());
    fs::write(&text, lines.concat()).unwrap();
    expect(0, &["export", &text, "--to", "mcap", "-o", &mcap]);
    for capture in [&text, &mcap] {
        let (said, _) = expect(0, &["verify", capture]);
        assert!(said.contains("lines      21 intact, 0 damaged"), "{said}");
        let (rows, _) = expect(0, &["export", capture, "--to", "jsonl", "-o", "-"]);
        let rows = rows.lines().filter(|it| it.contains("\"line_type\":"));
        assert_eq!(rows.count(), 21);
    }
    let (said, _) = expect(0, &["verify", &mcap, "--json"]);
    let messages = &object(&said, "messages")["messages"];
    assert_eq!(messages["/telemetry"], 21, "{said}");
    fs::remove_dir_all(folder).unwrap();
}

/// A station and the summary of the bytes that it received.
fn heard_by_a_station(name: &str, lines: &[(u64, Vec<u8>)]) -> (Vec<Notice>, String, Value) {
    let mut station = Station::new(Config::new(1), false);
    let (mut notices, mut text) = (Vec::new(), Vec::new());
    for (at_ms, line) in lines {
        station.handle_bytes(Duration::from_millis(*at_ms), line);
        let (minute, ms) = (at_ms / 60_000, at_ms % 60_000);
        let time = format!(
            "2026-03-14T09:{minute:02}:{:02}.{:03}Z ",
            ms / 1000,
            ms % 1000
        );
        text.extend_from_slice(time.as_bytes());
        text.extend_from_slice(line);
        while let Some(event) = station.poll_event() {
            if let Event::Notice(notice) = event {
                notices.push(notice);
            }
        }
    }
    let folder = scratch(name);
    let path = folder.join("a.txt");
    fs::write(&path, text).unwrap();
    let (info, _) = expect(0, &["info", path.to_str().unwrap()]);
    let (json, _) = expect(0, &["info", path.to_str().unwrap(), "--json"]);
    fs::remove_dir_all(folder).unwrap();
    (notices, info, object(&json, "lines_lost"))
}

/// Robot 4 sends, is silent for a time and sends again, while robot 7 sends all the time from 5 s on.
fn silent_while_another_robot_sends(silent: usize) -> Vec<(u64, Vec<u8>)> {
    let all = sample();
    let own = (0..).zip(&all).take(350).filter(|(n, _)| {
        let silence = 100..100 + silent;
        !silence.contains(n)
    });
    let own = own.map(|(n, line)| (n as u64 * 1000 / 3, line.clone()));
    let other = (0..).zip(&all[20..]).take(330);
    let other = other.map(|(n, line)| (5170 + n * 1000 / 3, of_robot_7(line)));
    let mut both: Vec<_> = own.chain(other).collect();
    both.sort();
    both
}

#[test]
fn a_robot_that_is_silent_for_seven_seconds_stays_the_followed_one() {
    let lines = silent_while_another_robot_sends(21);
    let (notices, text, info) = heard_by_a_station("silent-seven-seconds", &lines);
    let notices: Vec<_> = notices.iter().map(|it| it.text.as_str()).collect();
    assert_eq!(
        notices,
        ["robot 7 also sends on this channel; its lines are kept apart, robot 4 is followed"]
    );
    assert_eq!(
        (&info["lines_lost"], &info["lines_lost_max"]),
        (&21.into(), &21.into())
    );
    let outages = info["outages"].as_array().unwrap();
    assert_eq!(outages.len(), 1, "{info}");
    assert_eq!(
        (&outages[0]["code"], &outages[0]["lines_lost"]),
        (&"silent".into(), &21.into())
    );
    assert!(
        text.contains("others     330 lines of robot 7, kept apart"),
        "{text}"
    );
    assert!(!text.contains("followed"), "{text}");
}

/// A robot that vanished for more than a minute has lost an unknown number of lines.
#[test]
fn the_robot_that_replaces_a_silent_one_is_reported() {
    let lines = silent_while_another_robot_sends(300);
    let (notices, text, info) = heard_by_a_station("silent-a-minute", &lines);
    let change = "robot 7 is followed now; robot 4 was not heard for a minute";
    // Robot 7 never shows an era, which is told as a mistake.
    let codes = notices.iter().map(|it| it.code);
    let codes: Vec<_> = codes
        .filter(|code| *code != NoticeCode::RobotMistake)
        .collect();
    assert_eq!(codes, [NoticeCode::OtherRobot, NoticeCode::RobotReplaced]);
    assert_eq!(notices[1].text, change);
    assert!(text.contains(&format!("followed   {change}")), "{text}");
    assert_eq!(
        (&info["followed_robot"], &info["replaced_robot"]),
        (&7.into(), &4.into())
    );
    assert_eq!(info["lines_lost"], 0);
    let most = info["lines_lost_max"].as_u64().unwrap();
    assert!((175..210).contains(&most), "{info}");
    let outage = &info["outages"][0];
    assert_eq!(
        (&outage["code"], &outage["lines_lost_max"]),
        (&"silent".into(), &most.into())
    );
}

/// Another robot is named within five seconds; its lines are counted separately and do not count as loss.
#[test]
fn two_robots_on_one_channel() {
    // The number of lines after which the other robot begins; the sample's lines in turn show its id or an era.
    for begin in [0, 10, 11, 12] {
        two_robots(begin);
    }
}

fn two_robots(begin: u64) {
    let world = World::built_in("open-room").unwrap();
    let mut config = SimulationConfig::new(world, 1);
    config.robot_id = 7;
    let mut other = Simulation::new(&config);
    // Robots that boot at the same time number their lines alike: one that shows no id could be either's.
    other.run_for_ms(20_000);
    while other.poll_downlink().is_some() {}
    while other.poll_downlink() != Some(b'\n') {
        other.run_for_ms(1);
    }
    let mut station = Station::new(Config::new(1), false);
    let mut named_at = None;
    let (mut both, mut theirs) = (Vec::new(), Vec::new());
    for (n, line) in (0..).zip(sample()) {
        let at = Duration::from_millis(n * 333);
        other.run_for_ms(334);
        while let Some(byte) = other.poll_downlink() {
            theirs.push(byte);
        }
        if n < begin {
            theirs.drain(..theirs.len() / line.len() * line.len());
        }
        // The robots send in turn, a line at a time.
        let whole = theirs.len() - theirs.len() % line.len();
        for bytes in [&line, &theirs.drain(..whole).collect()] {
            station.handle_bytes(at, bytes);
            both.extend_from_slice(bytes);
        }
        while let Some(event) = station.poll_event() {
            if let Event::Notice(notice) = event {
                assert_ne!(notice.code, NoticeCode::RobotMistake, "{}", notice.text);
                if notice.code == NoticeCode::OtherRobot {
                    named_at.get_or_insert((at, notice.text));
                }
            }
        }
    }
    let (at, text) = named_at.unwrap();
    let begin_at = Duration::from_millis(begin * 333);
    assert!(at <= begin_at + Duration::from_secs(5), "{at:?}");
    assert!(text.contains("robot 7"), "{text}");
    let folder = scratch("two-robots");
    let path = folder.join("both.txt");
    fs::write(&path, both).unwrap();
    let (info, _) = expect(0, &["info", path.to_str().unwrap(), "--json"]);
    let info = object(&info, "other_robot");
    assert_eq!(
        (&info["other_robot"], &info["lines_lost"]),
        (&7.into(), &0.into())
    );
    assert!(info["other_lines"].as_u64().unwrap() > 300, "{info}");
    let lines = info["lines"].as_object().unwrap().values();
    let own: u64 = lines.map(|lines| lines.as_u64().unwrap()).sum();
    assert_eq!(own, sample().len() as u64, "begin {begin}");
    let (exported, _) = expect(
        0,
        &["export", path.to_str().unwrap(), "--to", "jsonl", "-o", "-"],
    );
    let exported = exported.lines().filter(|it| it.contains("\"line_type\":"));
    assert_eq!(exported.count() as u64, own, "begin {begin}");
    fs::remove_dir_all(folder).unwrap();
}
