//! Link statistics of a handmade recording, of a station in the simulated world, and of the program.
#![cfg(unix)]

use std::fs;
use std::process::Command;
use std::time::Duration;

use crate::common::CoSimulation;
use crate::programs::{GROUNDWAVE, scratch};
use crate::recordings::{session, wall};
use groundwave::capture::info::Info;
use groundwave::capture::messages::RawBytes;
use groundwave::capture::runs::Label;
use groundwave::capture::session_writer::{CHUNK_BYTES, TopicWriter};
use groundwave::capture::topics::{Topic, TopicMessage};
use groundwave::capture::{Capture, Existing, Recorder};
use groundwave::event::{CommandStatus, Event};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave::statistics::Resync;
use groundwave_protocol::arq::Config;
use groundwave_protocol::command::{Command as Sequenced, Key, Message, Order};
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{AbilitiesLine, Ack, Body, Line, TextLine};
use mcap::records::Metadata;
use prost::Message as _;
use serde_json::Value;

fn line(sequence: u8) -> [u8; 80] {
    let line = Line {
        sequence,
        body: Body::Text(TextLine::new("a line")),
        ack: Ack::default(),
    };
    line.encode()
}

/// Ten seconds with 15 lines at the beginning and 15 at the end, one of them damaged; one command sent twice, and 4
/// bytes of knocks.
#[test]
fn a_handmade_recording_has_the_figures_computed_by_hand() {
    let mut mcap = TopicWriter::new(Vec::new(), CHUNK_BYTES).unwrap();
    let mut offsets = [0, 0];
    let mut write = |topic, at_s: u64, data: Vec<u8>| {
        let offset = &mut offsets[usize::from(topic == Topic::RawTx)];
        let stream_offset = *offset;
        *offset += data.len() as u64;
        let bytes = RawBytes {
            stream_offset,
            data,
        };
        let at_ns = at_s * 1_000_000_000;
        mcap.write(&TopicMessage {
            topic,
            log_time_ns: at_ns,
            publish_time_ns: at_ns,
            data: &bytes.encode_to_vec(),
        })
        .unwrap();
    };
    let lines = |range: std::ops::Range<u8>| -> Vec<u8> { range.flat_map(line).collect() };
    write(Topic::RawRx, 100, lines(0..15));
    let order = Order::Mode(Mode::Prowl);
    let frame = Message::Command(Sequenced { sequence: 1, order }).encode(Key::session(7, 1, 1, 1));
    write(Topic::RawTx, 101, frame.as_bytes().to_vec());
    write(Topic::RawTx, 103, frame.as_bytes().to_vec());
    write(Topic::RawTx, 104, b"\n\n\n\n".to_vec());
    let mut damaged = lines(15..30);
    damaged[3 * 80 + 20] ^= 4;
    write(Topic::RawRx, 110, damaged);
    let about = [
        ("link", "tcp:robot:4000"),
        ("start", "2025-03-14T09:26:53Z"),
        ("software", "groundwave"),
        ("software_version", "0.2.0"),
    ];
    let about = about.map(|(what, words)| (what.to_owned(), words.to_owned()));
    let session = Metadata {
        name: "session".to_owned(),
        metadata: about.into(),
    };
    mcap.write_metadata(&session).unwrap();
    let path = scratch("by-hand").join("by-hand.mcap");
    fs::write(&path, mcap.finish().unwrap()).unwrap();

    let info = Info::read(&mut Capture::open(&path).unwrap());
    assert_eq!(
        (
            info.lines.of("T"),
            info.loss.lines_lost,
            info.damaged.kinds()
        ),
        (29, 0, [1, 0, 0])
    );
    let resync = Resync {
        count: 1,
        last_bytes: 80,
        mean_bytes: 80.0,
        worst_bytes: 80,
    };
    assert_eq!(info.resync, Some(resync));
    // 1200 bytes in the 10 s after the first 1200, which came before the clock began; twice 10 bytes and 4.
    assert_eq!(info.airtime_down_pct, Some(50.0));
    let sent = info.sent.unwrap();
    assert_eq!((sent.bytes, sent.frames, sent.frames_again), (24, 2, 1));
    assert!(
        (sent.airtime_up_pct.unwrap() - 1.0).abs() < 1e-9,
        "{sent:?}"
    );
    let label = Label {
        name: Some("by hand".to_owned()),
        void: Some("the pencil broke".to_owned()),
        ..Label::default()
    };
    let info = info.with_label(label);
    let json = serde_json::to_value(&info).unwrap();
    for (fact, words) in [
        ("name", "by hand"),
        ("void", "the pencil broke"),
        ("start", "2025-03-14T09:26:53Z"),
        ("link", "tcp:robot:4000"),
        ("software", "groundwave 0.2.0"),
    ] {
        assert_eq!(json[fact], words, "{fact}");
    }
    let mut text = Vec::new();
    info.write_text(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    for fact in [
        "resync     1 time, 80 bytes on average, 80 at worst",
        "airtime    50.0 % down, 1.0 % up",
        "run        by hand",
        "VOID       the pencil broke",
        "made       2025-03-14T09:26:53Z",
        "link       tcp:robot:4000",
        "software   groundwave 0.2.0",
        "lines      29 intact: 29 long (A 0, B 0, C 0, T 29), 0 short (K)",
        "sent       24 bytes, 2 frames, 1 of them again",
    ] {
        assert!(text.contains(fact), "no `{fact}` in\n{text}");
    }
}

/// A run appended to another: no line counts as lost between them.
#[test]
fn appended_runs_are_restarts_and_not_losses() {
    let run = fs::read("captures/house-clean.txt").unwrap();
    let whole = run.len() - run.len() % 80;
    let runs = run[..whole].repeat(3);
    let info =
        Info::read(&mut Capture::read("runs", Box::new(std::io::Cursor::new(runs))).unwrap());
    assert_eq!((info.restarts, info.loss.lines_lost), (2, 0), "{info:?}");
}

#[test]
fn a_station_measures_what_it_does() {
    let mut co = CoSimulation::new("open-room", 3, "");
    co.run(2);
    for mode in [Mode::Reactive, Mode::Prowl, Mode::Reactive] {
        let end = co.deliver(Request::Mode(mode));
        assert!(
            matches!(end, CommandStatus::Confirmed { .. }),
            "{}",
            co.context()
        );
    }
    let seen = co.station.statistics(co.now());
    let confirmation = seen.confirmation.unwrap();
    assert_eq!(confirmation.count, 3);
    assert!(
        confirmation.worst_s >= confirmation.mean_s && confirmation.mean_s > 0.1,
        "{seen:?}"
    );
    // At least a session request and three commands.
    assert_eq!(seen.frames - seen.frames_again, 4, "{seen:?}");
    assert_eq!((seen.loss.lines_lost, seen.resync), (0, None));
    assert!(seen.airtime_down_pct.unwrap() > 90.0, "{seen:?}");
    // Every byte sent, over the time since the first of them, which the first command began.
    let up_pct = seen.airtime_up_pct.unwrap();
    assert!(up_pct > 0.0 && up_pct < 100.0, "{seen:?}");
    co.run(5);
    let told: Vec<_> = co
        .events
        .iter()
        .filter(|(_, event)| matches!(event, Event::Statistics(_)))
        .map(|(at, _)| *at)
        .collect();
    assert!(told.len() > 5, "{told:?}");
    assert!(
        told.windows(2)
            .all(|pair| pair[1] >= pair[0] + Duration::from_secs(1)),
        "{told:?}"
    );
}

#[test]
fn a_bad_channel_shows_in_every_figure() {
    let mut co = CoSimulation::new("open-room", 4, "ber=1e-3");
    co.run(60);
    let route = (0..40).map(|n| groundwave_protocol::Waypoint { x_in: n, y_in: n });
    co.deliver(Request::Route(route.collect()));
    let seen = co.station.statistics(co.now());
    assert!(
        seen.damaged.kinds()[0] > 10 && seen.damaged.types().count() > 2 && seen.frames_again > 0,
        "{}: {seen:?}",
        co.context()
    );
    let resync = seen.resync.unwrap();
    assert!(
        resync.mean_bytes > 20.0 && resync.worst_bytes >= 80,
        "{resync:?}"
    );
}

/// Damaged lines are not lost: they are counted by kind and type. A radio that damages every line B loses nothing.
#[test]
fn a_bad_line_b_among_good_lines_a_is_damaged_and_not_lost() {
    let run = fs::read("captures/house-clean.txt").unwrap();
    let mut lines: Vec<Vec<u8>> = run.chunks_exact(80).map(<[u8]>::to_vec).collect();
    let mut count = 0;
    for line in lines.iter_mut().filter(|line| line[0] == b'B') {
        line[40] ^= 1;
        count += 1;
    }
    assert!(count > 20);
    let path = scratch("bad-status").join("run.txt");
    fs::write(&path, lines.concat()).unwrap();
    let info = serde_json::to_value(Info::read(&mut Capture::open(&path).unwrap())).unwrap();
    assert_eq!(
        (&info["lines_lost"], &info["loss_pct"]),
        (&0.into(), &0.0.into())
    );
    assert_eq!(info["damaged"]["checksum"], count, "{info}");
    assert_eq!(info["damaged"]["B"], count, "{info}");
}

/// The airtime in a recording is a share of the port's rate, too.
#[test]
fn airtime_of_a_recording_is_of_its_rate() {
    for (baud, expected_pct) in [(1200, 50.0), (9600, 6.25), (115_200, 0.520_8)] {
        let path = scratch("airtime").join("run.mcap");
        let mut session = session();
        session
            .notes
            .insert("baud".into(), f64::from(baud).to_string());
        let mut recorder = Recorder::start(&path, Existing::Refuse, &session).unwrap();
        for n in 0..100_u8 {
            let now = Duration::from_millis(u64::from(n) * 4000 / 3);
            recorder.handle_rx(now, wall(now), &line(n));
        }
        recorder.finish().unwrap();
        let info = Info::read(&mut Capture::open(&path).unwrap());
        let pct = info.airtime_down_pct.unwrap();
        assert!(
            (pct - expected_pct).abs() < 0.01 * expected_pct,
            "{baud}: {pct}"
        );
    }
}

/// A robot's line I that shows 9600 baud.
fn fast_abilities(sequence: u8) -> [u8; 80] {
    let line = Line {
        sequence,
        body: Body::Abilities(AbilitiesLine {
            rate_bytes_per_s: 960,
            ..AbilitiesLine::FULL
        }),
        ack: Ack::default(),
    };
    line.encode()
}

/// Behind a network the port's rate is unknown, and the airtime follows the robot's own rate; with a port's rate, the lower one.
#[test]
fn airtime_without_a_ports_rate_is_of_the_robots_rate() {
    for (baud, expected_pct) in [(None, 25.0), (Some(2400), 100.0), (Some(19_200), 25.0)] {
        let path = scratch("airtime-of-the-robot").join("run.mcap");
        let mut session = session();
        let notes = baud.map(|baud: u32| ("baud".into(), baud.to_string()));
        session.notes.extend(notes);
        let mut recorder = Recorder::start(&path, Existing::Refuse, &session).unwrap();
        let mut station = Station::new(Config::new(1), false);
        if let Some(baud) = baud {
            station.set_baud(baud);
        }
        for n in 0..90_u8 {
            let now = Duration::from_millis(u64::from(n) * 1000 / 3);
            let bytes = if n % 15 == 0 {
                fast_abilities(n)
            } else {
                line(n)
            };
            station.handle_bytes(now, &bytes);
            recorder.handle_rx(now, wall(now), &bytes);
        }
        recorder.finish().unwrap();
        let info = Info::read(&mut Capture::open(&path).unwrap());
        let events = std::iter::from_fn(|| station.poll_event());
        let live = events.filter_map(|event| match event {
            Event::Statistics(seen) => seen.airtime_down_pct,
            _ => None,
        });
        for pct in [info.airtime_down_pct.unwrap(), live.last().unwrap()] {
            assert!((pct - expected_pct).abs() < 2.0, "{baud:?}: {pct}");
        }
    }
}

#[test]
fn headless_reports_the_figures_at_its_end() {
    let shell =
        format!("cat captures/house-noisy.txt | {GROUNDWAVE} watch - --headless | tail -n 2");
    let output = Command::new("sh")
        .args(["-c", &shell])
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let told: Vec<Value> = text
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    assert_eq!(told[0]["event"], "statistics", "{text}");
    let info = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/captures/house-noisy.info.json"
    );
    let info: Value = serde_json::from_str(&fs::read_to_string(info).unwrap()).unwrap();
    for figure in [
        "lines_lost",
        "lines_lost_max",
        "loss_pct",
        "damaged",
        "resync",
    ] {
        assert_eq!(told[0][figure], info[figure], "{figure}: {text}");
    }
    assert_eq!(told[1]["state"], "ended", "{text}");
}

#[test]
fn an_impossible_clock_gives_no_airtime() {
    // 100 lines in 10 s, as from a simulator that runs three times as fast.
    let mut mcap = TopicWriter::new(Vec::new(), CHUNK_BYTES).unwrap();
    for n in 0..100_u8 {
        let at_ns = u64::from(n) * 100_000_000;
        let bytes = RawBytes {
            stream_offset: u64::from(n) * 80,
            data: line(n).to_vec(),
        };
        mcap.write(&TopicMessage {
            topic: Topic::RawRx,
            log_time_ns: at_ns,
            publish_time_ns: at_ns,
            data: &bytes.encode_to_vec(),
        })
        .unwrap();
    }
    let path = scratch("too-fast").join("too-fast.mcap");
    fs::write(&path, mcap.finish().unwrap()).unwrap();
    let info = Info::read(&mut Capture::open(&path).unwrap());
    assert_eq!(info.airtime_down_pct, None);
    assert_eq!(info.sent.unwrap().airtime_up_pct, None);
    let mut text = Vec::new();
    info.write_text(&mut text).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(
        text.contains("100 intact") && !text.contains("airtime"),
        "{text}"
    );
}
