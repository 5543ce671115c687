//! Outages and other robots: the same figures wherever they are told.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use crate::pty::OnTerminal;
use crate::recordings::messages;
use groundwave::capture::messages::OutageMessage;
use groundwave::event::{Event, NoticeCode};
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use prost::Message as _;
use serde_json::Value;
use sr04_sim::{Simulation, SimulationConfig, World};

/// The lines of a sample, three a second.
fn sample() -> Vec<Vec<u8>> {
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");
    let bytes = fs::read(sample).unwrap();
    bytes.chunks_exact(80).map(<[u8]>::to_vec).collect()
}

/// The first object that a JSON output has with a key.
fn object(output: &str, key: &str) -> Value {
    let values = serde_json::Deserializer::from_str(output).into_iter::<Value>();
    let found = values
        .map(Result::unwrap)
        .flat_map(|value| match value {
            Value::Array(values) => values,
            value => vec![value],
        })
        .find(|value| value.get(key).is_some());
    found.unwrap_or_else(|| panic!("no `{key}` in {output}"))
}

/// Whole hundreds are not in the sequence of the lines: 200 of 359 are lost.
#[test]
fn an_outage_has_the_same_figures_everywhere() {
    let folder = scratch("outage");
    let at = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (text, recording) = (at("a.txt"), at("a.mcap"));
    let received = sample().into_iter().enumerate();
    let received = received.filter(|(n, _)| !(100..300).contains(n));
    let stamped = received.flat_map(|(n, line)| {
        let stamp = format!("{}.{:03} ", n / 3, n % 3 * 333);
        [stamp.into_bytes(), line].concat()
    });
    fs::write(&text, stamped.collect::<Vec<u8>>()).unwrap();
    expect(0, &["export", &text, "--to", "mcap", "-o", &recording]);
    let json = |arguments: &[&str]| object(&expect(0, arguments).0, "lines_lost");
    let headless = Command::new(GROUNDWAVE)
        .args(["watch", "-", "--headless"])
        .stdin(fs::File::open(&text).unwrap())
        .stderr(Stdio::null())
        .output()
        .unwrap();
    let headless = String::from_utf8(headless.stdout).unwrap();
    let mut statistics = headless.lines().map(|line| object(line, "event"));
    let statistics = statistics.rfind(|value| value["event"] == "statistics");
    let info = json(&["info", &recording, "--json"]);
    for (place, figures) in [
        ("info", &info),
        ("info of the text", &json(&["info", &text, "--json"])),
        ("verify", &json(&["verify", &recording, "--json"])),
        ("runs", &json(&["runs", &recording, "--json"])),
        ("headless", &statistics.unwrap()),
    ] {
        let lost = (&figures["lines_lost"], &figures["lines_lost_max"]);
        assert_eq!(lost, (&200.into(), &200.into()), "{place}");
        for share in ["loss_pct", "loss_max_pct"] {
            let pct = figures[share].as_f64().unwrap();
            assert!((pct - 20_000.0 / 359.0).abs() < 1e-9, "{place}: {pct}");
        }
    }
    assert_eq!(info["gaps"], 1);
    let outage = &info["outages"][0];
    assert_eq!(outage["code"], "silent");
    assert_eq!(
        (&outage["begin_s"], &outage["end_s"]),
        (&33.0.into(), &100.0.into())
    );
    let (table, _) = expect(0, &["export", &recording, "--to", "jsonl", "-o", "-"]);
    let row = table.lines().map(|line| object(line, "at_s"));
    let row = row
        .into_iter()
        .find(|row| row["event"] == "outage")
        .unwrap();
    let (csv, _) = expect(0, &["export", &recording, "--to", "csv", "-o", "-"]);
    assert!(csv.contains(",silent,,33.0,100.0,200,200"), "{csv}");
    for key in ["code", "begin_s", "end_s", "lines_lost", "lines_lost_max"] {
        assert_eq!(row[key], outage[key], "{key}");
    }
    let recorded = &messages(Path::new(&recording))["/outages"];
    let recorded = OutageMessage::decode(&recorded[0][..]).unwrap();
    assert_eq!((recorded.lines_lost, recorded.lines_lost_max), (200, 200));
    assert_eq!(recorded.begin_ns, 33_000_000_000);
    let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", &recording], 160, 50);
    replay.wait_for("the beginning", |text| text.contains("REPLAY"));
    replay.type_keys("G");
    replay.wait_for("the loss and the outage", |text| {
        text.contains("loss 55.7 %") && text.contains("silent 67.0 s from 33.0 s: 200 lines lost")
    });
    replay.type_keys("q");
    assert_eq!(replay.wait(), 0);
    fs::remove_dir_all(folder).unwrap();
}

/// Another robot is named within five seconds; its lines are kept apart and make no loss.
#[test]
fn two_robots_on_one_channel() {
    let world = World::built_in("open-room").unwrap();
    let mut config = SimulationConfig::new(world, 1);
    config.robot_id = 7;
    let mut other = Simulation::new(&config);
    let mut station = Station::new(Config::new(1), false);
    let mut named_at = None;
    let (mut both, mut theirs) = (Vec::new(), Vec::new());
    for (n, line) in (0..).zip(sample()) {
        let at = Duration::from_millis(n * 333);
        other.run_for_ms(334);
        while let Some(byte) = other.poll_downlink() {
            theirs.push(byte);
        }
        // The robots send in turn, a line at a time.
        let whole = theirs.len() - theirs.len() % line.len();
        for bytes in [&line, &theirs.drain(..whole).collect()] {
            station.handle_bytes(at, bytes);
            both.extend_from_slice(bytes);
        }
        while let Some(event) = station.poll_event() {
            if let Event::Notice(notice) = event
                && notice.code == NoticeCode::OtherRobot
            {
                named_at.get_or_insert((at, notice.text));
            }
        }
    }
    let (at, text) = named_at.unwrap();
    assert!(at <= Duration::from_secs(5), "{at:?}");
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
    fs::remove_dir_all(folder).unwrap();
}

/// A suspended laptop: the outage has its own cause. Another station is the clock.
#[test]
fn a_suspended_station_tells_its_outage() {
    let sim = Sim::start(&[]);
    let mut watch = Telling::start(&["watch", &sim.path, "--headless"]);
    let mut clock = Telling::start(&["watch", "sim", "--headless"]);
    let is_line = |value: &Value| value["event"] == "line";
    watch.wait_for("a line", is_line);
    let pid = watch.process.0.id().to_string();
    let signal = |name: &str| {
        Command::new("kill")
            .args([name, pid.as_str()])
            .status()
            .unwrap()
    };
    assert!(signal("-STOP").success());
    let began_s = clock.wait_for_new("a line", is_line)["at_s"]
        .as_f64()
        .unwrap();
    clock.wait_for_new("seven seconds", |value| {
        value["at_s"]
            .as_f64()
            .is_some_and(|at_s| at_s > began_s + 7.0)
    });
    assert!(signal("-CONT").success());
    let suspended = watch.wait_for("the suspension", |value| value["event"] == "suspended");
    assert!(
        suspended["duration_s"].as_f64().unwrap() > 5.0,
        "{suspended}"
    );
    let outage = watch.wait_for("the outage", |value| {
        value["event"] == "outage" && !value["end_s"].is_null()
    });
    assert_eq!(outage["code"], "suspended", "{outage}");
    sim.end();
}
