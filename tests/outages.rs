//! Outages: the same figures wherever they are reported.
#![cfg(unix)]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use crate::pty::OnTerminal;
use crate::recordings::{START_S, messages, session, wall};
use groundwave::capture::messages::OutageMessage;
use groundwave::capture::session::ending;
use groundwave::capture::{Existing, Recorder};
use groundwave::event::{Event, Level, LinkEvent, Mark, Notice, NoticeCode};
use groundwave::recorded::to_recorded;
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use groundwave_protocol::telemetry::{Ack, Body, CountersLine, Line, StateLine};
use prost::Message as _;
use serde_json::Value;

/// The lines of a sample capture, three per second.
pub fn sample() -> Vec<Vec<u8>> {
    let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");
    let bytes = fs::read(sample).unwrap();
    bytes.chunks_exact(80).map(<[u8]>::to_vec).collect()
}

/// The first object with a key in a JSON output.
pub fn object(output: &str, key: &str) -> Value {
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

/// The sequence numbers do not count whole hundreds of lost lines: 200 of 359 are lost.
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
    let outages = headless.lines().map(|line| object(line, "event"));
    let mut outages = outages.filter(|value| value["event"] == "outage");
    // The text arrives at once, so only its sequence and the robot's clock show the gap.
    assert_eq!(outages.next_back().unwrap()["lines_lost"], 200);
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
    let worst = &json(&["verify", &recording, "--json"])["worst_gap"];
    assert_eq!(
        (&worst["lines"], &worst["until_s"]),
        (&200.into(), &100.0.into())
    );
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
    assert_eq!(
        (recorded.lines_lost, recorded.lines_lost_max),
        (200, Some(200))
    );
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

/// The lines that a robot sends in five minutes, three per second, each with the robot's time in seconds.
pub struct Robot {
    pub boots: u16,
    pub booted_s: f64,
    pub sent: u64,
}

impl Robot {
    pub fn line(&mut self, at_s: f64) -> [u8; 80] {
        let body = if self.sent.is_multiple_of(12) {
            Body::Counters(CountersLine {
                robot_id: 4,
                uptime_s: (at_s - self.booted_s) as u32,
                boots: self.boots,
                ..CountersLine::default()
            })
        } else {
            Body::State(StateLine {
                x_tenths_in: (at_s * 10.0) as i32,
                ..StateLine::BLANK
            })
        };
        let sequence = (self.sent % 100) as u8;
        self.sent += 1;
        let boot = (self.boots % 8) as u8;
        let ack = Ack {
            boot,
            ..Ack::default()
        };
        let line = Line {
            sequence,
            body,
            ack,
        };
        line.encode()
    }
}

/// The events and bytes of a session: 55 s of silence, 165 lines; unplugged for 5 s, 15 lines; suspended for 10 s, 30 lines; and
/// a robot that restarts.
fn eventful() -> Vec<(Duration, Result<[u8; 80], Event>)> {
    let mut robot = Robot {
        boots: 4,
        booted_s: 0.0,
        sent: 0,
    };
    let mut session = Vec::new();
    for n in 0..900_u32 {
        let at = Duration::from_millis(u64::from(n) * 1000 / 3);
        let s = f64::from(n) / 3.0;
        let open = LinkEvent::Opened {
            name: "radio".to_owned(),
            can_send: false,
        };
        let lost = LinkEvent::Lost {
            reason: "unplugged".to_owned(),
        };
        let event = match n {
            0 | 465 => Some(Event::Link(open)),
            450 => Some(Event::Link(lost)),
            630 => Some(Event::Suspended(Duration::from_secs(10))),
            _ => None,
        };
        session.extend(event.map(|event| (at, Err(event))));
        if n == 750 {
            robot = Robot {
                boots: 5,
                booted_s: s,
                sent: 0,
            };
        }
        let line = robot.line(s);
        let is_lost = [180..345, 450..465, 600..630]
            .iter()
            .any(|it| it.contains(&n));
        if !is_lost {
            session.push((at, Ok(line)));
        }
    }
    session
}

/// Records the session; returns the outages that a station reports meanwhile, and its figures at the end.
fn record_eventful(path: &Path) -> [Value; 2] {
    let mut recorder = Recorder::start(path, Existing::Refuse, &session()).unwrap();
    let mut station = Station::new(Config::new(1), false);
    let (mut live, mut end) = (Vec::new(), Duration::ZERO);
    for (now, what) in eventful() {
        end = now;
        match what {
            Ok(line) => {
                recorder.handle_rx(now, wall(now), &line);
                station.handle_bytes(now, &line);
            }
            Err(event) => {
                recorder.handle_event(now, wall(now), &to_recorded(now, &event).unwrap());
                match event {
                    Event::Link(link) => station.handle_link(now, link),
                    Event::Suspended(duration) => station.handle_suspension(now, duration),
                    _ => {}
                }
            }
        }
        let outages = std::iter::from_fn(|| station.poll_event()).filter_map(|event| match event {
            Event::Outage(outage) if outage.end.is_some() => Some(outage),
            _ => None,
        });
        live.extend(outages);
    }
    recorder.finish().unwrap();
    // Headless output prints both as they are.
    let statistics = station.statistics(end);
    [
        serde_json::to_value(live).unwrap(),
        serde_json::to_value(statistics).unwrap(),
    ]
}

/// A robot that falls silent, or whose link is lost, until the end of the recording: the outage lasts in every verb.
#[test]
fn an_outage_until_the_end_of_a_recording_is_listed() {
    let folder = scratch("silent-until-the-end");
    let lost = Event::Link(LinkEvent::Lost {
        reason: "unplugged".to_owned(),
    });
    let notice = Notice::new(NoticeCode::NotPrinted, Level::Warning, "late".to_owned());
    for (code, event, at_s) in [
        ("silent", Event::Notice(notice), 80),
        ("unplugged", lost, 62),
    ] {
        let path = folder.join(format!("{code}.mcap"));
        let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
        let lines = eventful()
            .into_iter()
            .filter_map(|(at, what)| Some((at, what.ok()?)));
        for (now, line) in lines.take_while(|(at, _)| *at < Duration::from_mins(1)) {
            recorder.handle_rx(now, wall(now), &line);
        }
        let now = Duration::from_secs(at_s);
        recorder.handle_event(now, wall(now), &to_recorded(now, &event).unwrap());
        recorder.finish().unwrap();
        lasts_until_the_end(&path, code, at_s - 60);
    }
    fs::remove_dir_all(folder).unwrap();
}

/// Nothing is recorded in the silence but the end of the recording.
#[test]
fn a_silence_until_a_recording_was_ended_is_listed() {
    let folder = scratch("silent-when-ended");
    let path = folder.join("a.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    for (now, what) in eventful().into_iter().take(100) {
        if let Ok(line) = what {
            recorder.handle_rx(now, wall(now), &line);
        }
    }
    let now = Duration::from_secs(36);
    recorder.handle_event(now, wall(now), &ending());
    recorder.finish().unwrap();
    lasts_until_the_end(&path, "silent", 3);
    fs::remove_dir_all(folder).unwrap();
}

/// An outage whose number of lost lines no line C shows before the recording ends in a silence.
#[test]
fn a_recording_that_ends_soon_after_an_outage_is_good() {
    let folder = scratch("silent-soon");
    let path = folder.join("a.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    let lines = sample();
    for n in (0..24).chain(33..36) {
        assert!(n < 33 || lines[n][0] != b'C');
        let now = Duration::from_millis(n as u64 * 333);
        recorder.handle_rx(now, wall(now), &lines[n]);
    }
    let now = Duration::from_secs(22);
    recorder.handle_event(now, wall(now), &ending());
    recorder.finish().unwrap();
    assert_eq!(messages(&path)["/outages"].len(), 2);
    let (out, _) = expect(0, &["verify", path.to_str().unwrap()]);
    assert!(out.contains("good"), "{out}");
    fs::remove_dir_all(folder).unwrap();
}

/// Every verb lists the outage of a recording, which has not ended.
fn lasts_until_the_end(path: &Path, code: &str, silence_s: u64) {
    let path = path.to_str().unwrap();
    let info = object(&expect(0, &["info", path, "--json"]).0, "lines_lost");
    // None is lost before, and what the robot sent since then is not known.
    let lost = ["lines_lost", "lines_lost_max"].map(|key| info[key].as_u64().unwrap());
    let sent = 3 * silence_s;
    assert!((sent..=sent * 5 / 4 + 5).contains(&lost[1]), "{lost:?}");
    for verb in ["info", "verify"] {
        let figures = object(&expect(0, &[verb, path, "--json"]).0, "lines_lost");
        let outages = figures["outages"].as_array().unwrap();
        assert_eq!(outages.len(), 1, "{verb}: {outages:?}");
        assert_eq!(outages[0]["code"], code, "{verb}");
        assert!(outages[0]["end_s"].is_null(), "{verb}: {outages:?}");
        let runs = object(&expect(0, &["runs", path, "--json"]).0, "lines_lost");
        for key in ["lines_lost", "lines_lost_max"] {
            for (place, found) in [("all", &figures), ("outage", &outages[0]), ("runs", &runs)] {
                assert_eq!(found[key], info[key], "{verb}, {place}: {key}");
            }
        }
    }
    let recorded = &messages(Path::new(path))["/outages"];
    let recorded = OutageMessage::decode(&recorded.last().unwrap()[..]).unwrap();
    assert_eq!((&recorded.code[..], recorded.end_ns), (code, None));
    assert_eq!(recorded.lines_lost_max, Some(lost[1]));
    let exported = |to: &str| expect(0, &["export", path, "--to", to, "-o", "-"]).0;
    let (rows, csv) = (exported("jsonl"), exported("csv"));
    let rows = rows
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    let rows: Vec<_> = rows.filter(|row| row["event"] == "outage").collect();
    assert_eq!(rows.len(), 1, "{rows:?}");
    assert_eq!(
        (&rows[0]["code"], &rows[0]["end_s"]),
        (&code.into(), &Value::Null)
    );
    assert!(csv.contains(&format!(",{code},,")), "{csv}");
    assert!(exported("svg").contains("outage (1)"), "the picture");
}

/// One recording with every kind of outage: the same loss and the same outages wherever they are reported.
#[test]
fn a_session_has_the_same_loss_and_outages_everywhere() {
    const LOST: u64 = 165 + 15 + 30;
    let folder = scratch("eventful");
    let recording = folder.join("a.mcap");
    let [live, statistics] = record_eventful(&recording);
    let recording = recording.to_str().unwrap();
    let json = |verb: &str| object(&expect(0, &[verb, recording, "--json"]).0, "lines_lost");
    let (info, verify) = (json("info"), json("verify"));
    let outages = info["outages"].as_array().unwrap();
    let told = outages.iter().map(|outage| {
        let end_s = outage["end_s"].as_f64().unwrap().round() as u64;
        let lost = outage["lines_lost"].as_u64().unwrap();
        (outage["code"].as_str().unwrap(), end_s, lost)
    });
    assert_eq!(
        told.collect::<Vec<_>>(),
        [
            ("silent", 115, 165),
            ("unplugged", 155, 15),
            ("suspended", 210, 30),
            ("rebooted", 250, 0)
        ]
    );
    assert_eq!(live, info["outages"]);
    assert_eq!(verify["outages"], info["outages"]);
    assert_eq!(verify["gaps"], info["gaps"]);
    let runs = json("runs");
    for (place, figures) in [
        ("info", &info),
        ("verify", &verify),
        ("runs", &runs),
        ("live", &statistics),
    ] {
        for key in ["lines_lost", "lines_lost_max"] {
            assert_eq!(figures[key], LOST, "{place}");
        }
        let pct = figures["loss_pct"].as_f64().unwrap();
        let expected = 100.0 * LOST as f64 / 900.0;
        assert!((pct - expected).abs() < 1e-9, "{place}: {pct}");
    }
    are_exported(outages, recording);
    let svg = folder.join("a.svg");
    let to_svg = ["--to", "svg", "-o", svg.to_str().unwrap()];
    expect(0, &[&["export", recording][..], &to_svg].concat());
    let svg = fs::read_to_string(svg).unwrap();
    let gaps = format!("lost or damaged ({} gaps)", info["gaps"]);
    for words in ["outage (4)", "4 outages, the longest: silent 55.3 s", &gaps] {
        assert!(svg.contains(words), "no {words}");
    }
    let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", recording], 160, 60);
    replay.wait_for("the beginning", |text| text.contains("REPLAY"));
    replay.type_keys("G");
    replay.wait_for("the loss and the outages", |text| {
        let shown = [
            "loss 23.3 %",
            "silent 55.3 s from 59.7 s: 165 lines lost",
            "unplugged 5.0 s from 150.0 s: 15 lines lost",
            "suspended 10.3 s from 199.7 s: 30 lines lost",
            "rebooted 0.3 s from 249.7 s",
        ];
        shown.iter().all(|words| text.contains(words))
    });
    replay.type_keys("q");
    assert_eq!(replay.wait(), 0);
    fs::remove_dir_all(folder).unwrap();
}

/// CSV, JSON and the recording's own messages have these outages.
fn are_exported(outages: &[Value], recording: &str) {
    const KEYS: [&str; 5] = ["code", "begin_s", "end_s", "lines_lost", "lines_lost_max"];
    let exported = |to: &str| expect(0, &["export", recording, "--to", to, "-o", "-"]).0;
    let (rows, csv) = (exported("jsonl"), exported("csv"));
    let rows = rows
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    let rows: Vec<_> = rows.filter(|row| row["event"] == "outage").collect();
    let recorded = &messages(Path::new(recording))["/outages"];
    let recorded = recorded
        .iter()
        .map(|message| OutageMessage::decode(&message[..]).unwrap());
    let recorded: Vec<_> = recorded.filter(|it| it.end_ns.is_some()).collect();
    assert_eq!((rows.len(), recorded.len()), (outages.len(), outages.len()));
    let seconds = |ns: u64| (ns - START_S * 1_000_000_000) as f64 / 1e9;
    for ((outage, row), message) in outages.iter().zip(rows).zip(recorded) {
        assert_eq!(KEYS.map(|key| &row[key]), KEYS.map(|key| &outage[key]));
        let [code, begin_s, end_s, lost, lost_max] = KEYS.map(|key| outage[key].clone());
        let code = code.as_str().unwrap();
        let row = format!(",{code},,{begin_s},{end_s},{lost},{lost_max}");
        assert!(csv.contains(&row), "no {row} in {csv}");
        assert_eq!(message.code, code);
        let (begin, end) = (seconds(message.begin_ns), seconds(message.end_ns.unwrap()));
        assert!((begin - begin_s.as_f64().unwrap()).abs() < 1e-6, "{begin}");
        assert!((end - end_s.as_f64().unwrap()).abs() < 1e-6, "{end}");
        assert_eq!(
            (message.lines_lost.into(), message.lines_lost_max.into()),
            (lost, lost_max)
        );
    }
}

/// Every third line B is damaged: none is lost, and each is a gap.
#[test]
fn damaged_lines_are_not_lost_and_are_gaps() {
    let folder = scratch("damaged-b");
    let path = folder.join("a.txt");
    let mut lines = sample();
    let of_b = lines.iter_mut().filter(|line| line[0] == b'B').step_by(3);
    let mut damaged = 0;
    for line in of_b {
        line[20] = b'~';
        damaged += 1;
    }
    fs::write(&path, lines.concat()).unwrap();
    let path = path.to_str().unwrap();
    let info = object(&expect(0, &["info", path, "--json"]).0, "lines_lost");
    assert_eq!(
        (&info["lines_lost"], &info["damaged"]["B"]),
        (&0.into(), &damaged.into())
    );
    let verify = object(&expect(0, &["verify", path, "--json"]).0, "lines_lost");
    assert_eq!(
        (&info["gaps"], &verify["gaps"]),
        (&damaged.into(), &damaged.into())
    );
    let row = format!("{damaged} checksum, 0 shape, 0 field: B {damaged}\n");
    for verb in ["info", "verify"] {
        let (text, _) = expect(0, &[verb, path]);
        assert!(text.contains(&row), "{verb}: {text}");
    }
    let picture = expect(0, &["export", path, "--to", "svg", "-o", "-"]).0;
    assert!(picture.contains(&format!("lost or damaged ({damaged} gaps)")));
    fs::remove_dir_all(folder).unwrap();
}

/// The operator's marks are in tables with the moments that they mark, and in pictures unless they were removed.
#[test]
fn marks_are_exported() {
    let folder = scratch("marks-exported");
    let path = folder.join("a.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    for (now, what) in eventful().into_iter().take(60) {
        if let Ok(line) = what {
            recorder.handle_rx(now, wall(now), &line);
        }
    }
    for (at_s, ago_s, is_set) in [(21, 5, true), (22, 1, true), (23, 2, false)] {
        let now = Duration::from_secs(at_s);
        let ago = Duration::from_secs(ago_s);
        let mark = Event::Mark(Mark { ago, is_set });
        recorder.handle_event(now, wall(now), &to_recorded(now, &mark).unwrap());
    }
    recorder.finish().unwrap();
    let exported = |to: &str| {
        let arguments = ["export", path.to_str().unwrap(), "--to", to, "-o", "-"];
        expect(0, &arguments).0
    };
    let rows = exported("jsonl");
    let rows = rows
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap())
        .filter(|row| row["event"] == "mark");
    let rows = rows.map(|row| (row["status"].clone(), row["begin_s"].as_f64().unwrap()));
    assert_eq!(
        rows.collect::<Vec<_>>(),
        [
            ("set".into(), 16.0),
            ("set".into(), 21.0),
            ("cleared".into(), 21.0)
        ]
    );
    let csv = exported("csv");
    let marks: Vec<_> = csv.lines().filter(|row| row.contains(",mark,")).collect();
    assert_eq!(marks.len(), 3, "{csv}");
    assert!(
        marks[0].contains(",set,") && marks[0].contains(",16.0,"),
        "{marks:?}"
    );
    let picture = exported("svg");
    assert!(picture.contains("mark at 16 s") && !picture.contains("mark at 21 s"));
    fs::remove_dir_all(folder).unwrap();
}

/// A suspended laptop: the outage has its own cause. Another station serves as the clock.
#[test]
fn a_suspended_station_reports_its_outage() {
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
