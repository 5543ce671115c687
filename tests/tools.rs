//! The verbs that work on captures: what they make is what the capture holds, and nothing is lost on the way.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

#[path = "common/programs.rs"]
mod programs;
mod streams;

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use groundwave::capture::convert::convert_raw;
use groundwave::capture::cut::{Window, cut_mcap, cut_raw};
use groundwave::capture::decode::{Format, decode};
use groundwave::capture::index;
use groundwave::capture::info::Info;
use groundwave::capture::journal::JournalWriter;
use groundwave::capture::verify::{Beside, verify_mcap};
use groundwave::capture::when::When;
use groundwave::capture::{Capture, CaptureError};
use programs::{GROUNDWAVE, expect, scratch};
use proptest::prelude::*;

fn converted(raw: &[u8]) -> Vec<u8> {
    let mut mcap = Vec::new();
    convert_raw(raw, Some(1_741_944_413_000_000_000), &mut mcap).unwrap();
    mcap
}

fn open(bytes: &[u8]) -> Capture {
    Capture::read("", Box::new(Cursor::new(bytes.to_vec()))).unwrap()
}

/// The bytes of the radio in a capture, and why that is not all.
fn content(capture: &[u8]) -> (Vec<u8>, Option<CaptureError>) {
    let mut capture = open(capture);
    let mut content = Vec::new();
    loop {
        match capture.next_chunk() {
            Ok(Some(chunk)) => content.extend(chunk.bytes),
            Ok(None) => break (content, None),
            Err(error) => break (content, Some(error)),
        }
    }
}

fn whole(capture: &[u8]) -> Vec<u8> {
    let (content, error) = content(capture);
    assert!(error.is_none(), "{error:?}");
    content
}

fn window(from: Option<Duration>, to: Option<Duration>) -> Window {
    Window {
        from: from.map(When::Since),
        to: to.map(When::Since),
    }
}

/// Cuts at every one of `at`.
fn pieces(capture: &[u8], at: &[Duration]) -> Vec<Vec<u8>> {
    let mut bounds = vec![None];
    bounds.extend(at.iter().copied().map(Some));
    bounds.push(None);
    let is_mcap = capture.starts_with(mcap::MAGIC);
    let cut = |bound: &[Option<Duration>]| {
        let window = window(bound[0], bound[1]);
        let mut piece = Vec::new();
        if is_mcap {
            let part = cut_mcap(capture, window, &mut piece).unwrap();
            assert_eq!(part.problem, None);
        } else {
            cut_raw(capture, window, &mut piece).unwrap();
        }
        piece
    };
    bounds.windows(2).map(cut).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_bytes_come_back_from_an_mcap(bytes in prop::collection::vec(any::<u8>(), 0..3000)) {
        let mcap = converted(&bytes);
        prop_assert_eq!(whole(&mcap), bytes);
    }

    #[test]
    fn what_a_robot_sends_comes_back_from_an_mcap(seed in any::<u64>(), slots in 1_u32..300) {
        let raw = streams::noisy(slots, seed);
        let mcap = converted(&raw);
        let side_car: Box<dyn std::io::Read> = Box::new(Cursor::new(raw.clone()));
        let beside = Beside {
            raw: Some(side_car),
            journal: None,
        };
        let verdict = verify_mcap(&mcap[..], beside).unwrap();
        prop_assert!(verdict.is_good(), "{:?}", verdict.faults);
        prop_assert_eq!(verdict.is_as_side_car, Some(true));
        let (lines, _) = streams::live(&raw);
        prop_assert_eq!(verdict.messages.get("/telemetry").copied().unwrap_or(0), lines.len() as u64);
        // All but the bytes and the word that the recording begins.
        let messages: u64 = verdict.messages.values().sum();
        let told = verdict.messages.get("/raw/rx").copied().unwrap_or(0) + 1;
        prop_assert_eq!((verdict.derived_equal, verdict.derived_unchecked), (messages - told, 0));
        prop_assert_eq!(whole(&mcap), raw);
    }

    #[test]
    fn pieces_make_up_the_whole(
        seed in any::<u64>(),
        mut at_ms in prop::collection::vec(1_u64..40_000, 1..5),
    ) {
        at_ms.sort_unstable();
        at_ms.dedup();
        let at: Vec<Duration> = at_ms.into_iter().map(Duration::from_millis).collect();
        let raw = streams::noisy(100, seed);
        prop_assert_eq!(pieces(&raw, &at).concat(), &raw[..]);

        let mcap = converted(&raw);
        let mut bytes = Vec::new();
        let mut counted = BTreeMap::<String, u64>::new();
        let mut lines = 0;
        for piece in pieces(&mcap, &at) {
            let verdict = verify_mcap(&piece[..], Beside::default()).unwrap();
            prop_assert!(verdict.is_good(), "{:?}", verdict.faults);
            prop_assert!(verdict.derived_equal >= verdict.lines);
            for (topic, count) in verdict.messages {
                *counted.entry(topic).or_default() += count;
            }
            lines += verdict.lines;
            bytes.extend(whole(&piece));
        }
        let verdict = verify_mcap(&mcap[..], Beside::default()).unwrap();
        prop_assert_eq!(bytes, raw);
        prop_assert_eq!(lines, verdict.lines);
        // Where a message with bytes is cut in two there is one more.
        let rx = counted.remove("/raw/rx").unwrap();
        let mut expected = verdict.messages;
        prop_assert!(rx >= expected.remove("/raw/rx").unwrap());
        prop_assert_eq!(counted, expected);
    }
}

#[test]
fn a_piece_holds_what_was_received_in_its_time() {
    let raw = streams::clean(300);
    let mcap = converted(&raw);
    let [_, piece, _] = &pieces(&mcap, &[Duration::from_secs(10), Duration::from_secs(20)])[..]
    else {
        panic!();
    };
    let length = whole(piece).len();
    assert!((2320..=2480).contains(&length), "{length} bytes in 10 s");
    let start = UNIX_SECONDS + 10;
    let by_the_clock = Window {
        from: Some(When::Wall(start * 1_000_000_000)),
        to: Some(When::Wall((start + 10) * 1_000_000_000)),
    };
    let mut same = Vec::new();
    // The capture begins with its first bytes, a line after the clock was looked at.
    cut_mcap(&mcap[..], by_the_clock, &mut same).unwrap();
    let same = whole(&same).len();
    assert!(same.abs_diff(length) <= 80, "{same} and {length} bytes");
}

const UNIX_SECONDS: u64 = 1_741_944_413;

/// A capture of several chunks with one of them spoilt.
fn spoilt(mcap: &[u8], chunk: usize) -> Vec<u8> {
    let mut spoilt = mcap.to_vec();
    let summary = mcap::Summary::read(mcap).unwrap().unwrap();
    assert!(summary.chunk_indexes.len() >= 3);
    let index = &summary.chunk_indexes[chunk];
    spoilt[(index.chunk_start_offset + index.chunk_length / 2) as usize] ^= 0x10;
    spoilt
}

#[test]
fn after_a_damaged_chunk_reading_goes_on() {
    let raw = streams::clean(8000);
    let mcap = converted(&raw);
    let spoilt = spoilt(&mcap, 1);
    let (left, error) = content(&spoilt);
    let error = error.unwrap().to_string();
    assert!(
        error.contains("chunk") && error.contains("everything else"),
        "{error}"
    );
    assert!(left.len() > raw.len() / 3 && left.len() < raw.len());
    let same = raw.iter().zip(&left).take_while(|(a, b)| a == b).count();
    assert!(same < left.len());
    assert!(
        raw.ends_with(&left[same..]),
        "what follows the chunk is there"
    );

    let verdict = verify_mcap(&spoilt[..], Beside::default()).unwrap();
    assert!(!verdict.is_good());
    assert_eq!(verdict.bytes, left.len() as u64);
    assert_eq!(verdict.missing_bytes, (raw.len() - left.len()) as u64);
    // Beside the line that was cut in two at either end everything still agrees.
    assert!(verdict.derived_equal + 2 >= verdict.lines);
    assert!(verdict.faults[0].contains("chunk"), "{:?}", verdict.faults);
}

#[test]
fn the_list_of_topics_may_be_damaged() {
    let raw = streams::clean(8000);
    let spoilt = spoilt(&converted(&raw), 0);
    let (left, error) = content(&spoilt);
    assert!(error.is_some());
    assert_eq!(left, raw);
}

#[test]
fn the_length_of_a_record_may_be_wrong() {
    let raw = streams::clean(8000);
    let mcap = converted(&raw);
    let summary = mcap::Summary::read(&mcap[..]).unwrap().unwrap();
    for bit in [0, 9, 20, 33, 63] {
        let mut spoilt = mcap.clone();
        let length = summary.chunk_indexes[1].chunk_start_offset as usize + 1;
        spoilt[length + bit / 8] ^= 1 << (bit % 8);
        let (left, error) = content(&spoilt);
        assert!(error.is_some(), "bit {bit}");
        let last = &left[left.len() - 1000..];
        assert!(raw.ends_with(last), "bit {bit}: the rest is lost");
    }
}

/// The messages of one topic.
fn messages<'a>(mcap: &'a [u8], topic: &str) -> Vec<mcap::Message<'a>> {
    let stream = mcap::MessageStream::new(mcap).unwrap();
    stream
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == topic)
        .collect()
}

/// A message that says something else than the bytes.
#[test]
fn what_does_not_follow_from_the_bytes_is_found_on_every_topic() {
    let mcap = converted(&streams::clean(300));
    let topics = [
        "/telemetry",
        "/uplink",
        "/tf",
        "/pose",
        "/path",
        "/sonar",
        "/markers",
        "/log",
    ];
    for wrong in topics {
        let mut spoilt = Vec::new();
        let mut writer = mcap::WriteOptions::new()
            .library(concat!(
                "groundwave ",
                env!("CARGO_PKG_VERSION"),
                ", fixed topics"
            ))
            .create(Cursor::new(&mut spoilt))
            .unwrap();
        let mut count = 0;
        for message in mcap::MessageStream::new(&mcap).unwrap() {
            let mut message = message.unwrap();
            if message.channel.topic == wrong {
                count += 1;
                // Not the first of `/log`, which is the station's.
                if count == 2 {
                    let mut data = message.data.into_owned();
                    *data.last_mut().unwrap() ^= 1;
                    message.data = data.into();
                }
            }
            writer.write(&message).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        assert!(count >= 2, "{wrong}");
        let verdict = verify_mcap(&spoilt[..], Beside::default()).unwrap();
        let is_found = |fault: &String| {
            fault.starts_with(wrong) && fault.ends_with("is not what /raw/rx decodes to")
        };
        assert!(
            verdict.faults.iter().any(is_found),
            "{wrong}: {:?}",
            verdict.faults
        );
    }
}

#[test]
fn a_journal_beside_a_recording_is_compared_with_it() {
    let folder = scratch("verify-journal");
    let file = |name: &str| folder.join(name).display().to_string();
    let raw = streams::clean(300);
    fs::write(folder.join("a.mcap"), converted(&raw)).unwrap();
    for (spoilt, code) in [(None, 0), (Some(4000), 1)] {
        let journal = folder.join("a.mcap.journal");
        let mut writer = JournalWriter::create(&journal).unwrap();
        writer.session(0, b"{}");
        let mut bytes = raw.clone();
        if let Some(place) = spoilt {
            bytes[place] ^= 1;
        }
        for read in bytes.chunks(37) {
            writer.rx(0, read);
        }
        drop(writer);
        let (out, _) = expect(code, &["verify", &file("a.mcap")]);
        let says = match spoilt {
            None => "side-car   holds the same bytes",
            Some(_) => "the journal differs from byte 4000 on",
        };
        assert!(out.contains(says), "{out}");
        fs::remove_file(journal).unwrap();
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn telemetry_that_is_not_what_was_received_is_found() {
    let raw = streams::clean(60);
    let other = streams::noisy(60, 5);
    let mut mcap = Vec::new();
    let good = converted(&raw);
    let lies = converted(&other);
    // The telemetry of one capture and the bytes of another.
    let mut writer = mcap::Writer::new(Cursor::new(&mut mcap)).unwrap();
    for message in messages(&good, "/raw/rx") {
        writer.write(&message).unwrap();
    }
    for message in messages(&lies, "/telemetry") {
        writer.write(&message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    let verdict = verify_mcap(&mcap[..], Beside::default()).unwrap();
    let found = verdict
        .faults
        .iter()
        .any(|f| f.contains("is not what /raw/rx decodes to"));
    assert!(found, "{:?}", verdict.faults);
}

#[test]
fn tables_say_what_the_lines_say() {
    let folder = scratch("tables");
    let raw = folder.join("a.txt");
    fs::write(&raw, streams::noisy(300, 7)).unwrap();
    let name = raw.to_str().unwrap();
    expect(0, &["export", name, "--to", "csv"]);
    expect(0, &["export", name, "--to", "jsonl"]);
    let csv = fs::read_to_string(folder.join("a.csv")).unwrap();
    let jsonl = fs::read_to_string(folder.join("a.jsonl")).unwrap();
    let mut rows = csv.lines().map(cells);
    let header = rows.next().unwrap();
    let mut count = 0;
    for (row, line) in rows.zip(jsonl.lines()) {
        let object: serde_json::Map<_, _> = serde_json::from_str(line).unwrap();
        assert_eq!(row.len(), header.len());
        for (name, cell) in header.iter().zip(&row) {
            let said = object.get(name).map_or(String::new(), |value| match value {
                serde_json::Value::String(text) => text.clone(),
                serde_json::Value::Number(number) => number.to_string(),
                other => panic!("{other}"),
            });
            let same_number = said.parse::<f64>().ok() == cell.parse::<f64>().ok();
            assert!(
                said == *cell || (same_number && !cell.is_empty()),
                "{name}: {said}, {cell}"
            );
        }
        count += 1;
    }
    assert!(count > 200);
    let mut direct = Vec::new();
    decode(&mut Capture::open(&raw).unwrap(), Format::Csv, &mut direct).unwrap();
    assert_eq!(csv.as_bytes(), direct);
}

/// A row of a table, as RFC 4180 has it.
fn cells(row: &str) -> Vec<String> {
    let mut cells = vec![String::new()];
    let mut quoted = false;
    let mut letters = row.chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if quoted && letters.peek() == Some(&'"') => {
                cells.last_mut().unwrap().push('"');
                letters.next();
            }
            '"' => quoted = !quoted,
            ',' if !quoted => cells.push(String::new()),
            letter => cells.last_mut().unwrap().push(letter),
        }
    }
    cells
}

#[test]
fn the_picture_shows_what_happened() {
    let folder = scratch("pictures");
    let capture = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-noisy.txt");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    expect(0, &["export", capture, "--to", "svg", "-o", &file("a.svg")]);
    expect(0, &["export", capture, "--to", "png", "-o", &file("a.png")]);
    let svg = fs::read_to_string(file("a.svg")).unwrap();
    insta::assert_snapshot!("house_noisy_svg", svg);
    for word in [
        "start",
        "end",
        "bump (",
        "sonar",
        "prowl",
        "lines lost",
        "60 in = 5 ft",
        "house-noisy",
    ] {
        assert!(svg.contains(word), "no {word}");
    }
    // Every bump is a cross of two strokes, and one more stands in the legend.
    let crosses = |svg: &str| {
        let strokes = svg.lines().filter(|line| {
            line.contains("stroke=\"#000000\" stroke-width=\"2\"")
                && line
                    .split("points=\"")
                    .nth(1)
                    .unwrap()
                    .split('"')
                    .next()
                    .unwrap()
                    .split(' ')
                    .count()
                    == 2
        });
        strokes.count() / 2
    };
    let bumps = svg
        .split("bump (")
        .nth(1)
        .unwrap()
        .split(')')
        .next()
        .unwrap();
    // What the robot counted may differ from what its lines show.
    let shown = bumps.split(", ").last().unwrap();
    let shown = shown.trim_end_matches(" shown");
    assert_eq!(crosses(&svg), shown.parse::<usize>().unwrap() + 1);

    let png = tiny_skia::Pixmap::load_png(file("a.png")).unwrap();
    assert_eq!((png.width(), png.height()), (1280, 960));
    let has = |red, green, blue| {
        let pixels = png.pixels().iter();
        pixels
            .filter(|p| (p.red(), p.green(), p.blue()) == (red, green, blue))
            .count()
    };
    assert!(has(0x56, 0xb4, 0xe9) > 200, "no sonar");
    assert!(has(0xd5, 0x5e, 0x00) > 100, "no bumpers");
    assert!(has(0, 0, 0) > 500, "no words");
    assert!(has(0xff, 0xff, 0xff) > 1_000_000, "no paper");
}

#[test]
fn a_capture_without_a_position_makes_no_picture() {
    let folder = scratch("no-picture");
    let file = folder.join("a.txt");
    fs::write(&file, "nothing of a robot\n").unwrap();
    let (_, err) = expect(2, &["export", file.to_str().unwrap(), "--to", "png"]);
    assert!(err.contains("nothing to draw"), "{err}");
    assert_eq!(fs::read_dir(folder).unwrap().count(), 1);
}

#[test]
fn exit_codes_say_how_good_a_capture_is() {
    let folder = scratch("exit-codes");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let raw = streams::clean(8000);
    fs::write(file("good.txt"), &raw).unwrap();
    expect(0, &["convert", &file("good.txt")]);
    let good = fs::read(file("good.mcap")).unwrap();
    fs::write(file("spoilt.mcap"), spoilt(&good, 1)).unwrap();
    fs::write(file("half.mcap"), &good[..good.len() / 2]).unwrap();
    fs::write(file("other.txt"), &raw[..raw.len() - 1]).unwrap();
    fs::write(file("nonsense.txt"), "no robot\n").unwrap();
    expect(0, &["verify", &file("good.mcap"), &file("good.txt")]);
    for (bad, word) in [("spoilt.mcap", "chunk"), ("half.mcap", "interrupted")] {
        let (out, err) = expect(1, &["verify", &file(bad)]);
        assert!(out.contains("NOT GOOD") && out.contains(word), "{out}{err}");
        let (_, err) = expect(1, &["info", &file(bad)]);
        assert!(!err.is_empty());
    }
    let (out, _) = expect(
        1,
        &["verify", &file("good.mcap"), "--raw", &file("other.txt")],
    );
    assert!(out.contains("the raw file"), "{out}");
    expect(2, &["verify", &file("nonsense.txt")]);
    expect(2, &["verify", &file("absent.mcap")]);
    let (out, _) = expect(
        1,
        &["verify", "--json", &file("good.mcap"), &file("half.mcap")],
    );
    let good: Vec<bool> = out
        .lines()
        .map(|line| {
            serde_json::from_str::<serde_json::Value>(line).unwrap()["good"]
                .as_bool()
                .unwrap()
        })
        .collect();
    assert_eq!(good, [true, false]);
    expect(2, &["cut", &file("good.txt")]);
    expect(
        2,
        &["cut", &file("good.txt"), "--from", "2m", "--to", "1:30"],
    );
    let (_, err) = expect(
        2,
        &["cut", &file("good.txt"), "--from", "2025-03-14T09:26:53Z"],
    );
    assert!(err.contains("says the day"), "{err}");
    expect(2, &["cut", &file("good.txt"), "--from", "soon"]);
}

#[test]
fn nothing_is_overwritten_and_nothing_is_left_behind() {
    let folder = scratch("overwrite");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(30)).unwrap();
    fs::write(file("a.mcap"), "precious").unwrap();
    let (_, err) = expect(2, &["convert", &file("a.txt")]);
    assert!(err.contains("--force"), "{err}");
    assert_eq!(fs::read(file("a.mcap")).unwrap(), b"precious");
    expect(0, &["convert", &file("a.txt"), "--force"]);
    expect(0, &["verify", &file("a.mcap")]);
    let (from, to) = (file("a.txt"), file("b.txt"));
    expect(0, &["cut", &from, "--to", "5", "-o", &to]);
    let length = fs::metadata(&to).unwrap().len();
    assert!((1121..=1200).contains(&length), "{length} bytes in 5 s");
    let (_, err) = expect(1, &["convert", &file("a.txt"), "-o", &file("none/a.mcap")]);
    assert!(err.contains("make the directory"), "{err}");
    let (_, err) = expect(2, &["convert", &file("a.txt"), &file("a.mcap"), "-o", "x"]);
    assert!(err.contains("--output-dir"), "{err}");
    let mut left: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["a.mcap", "a.txt", "b.txt"]);
}

#[test]
fn many_files_are_worked_on_at_once_and_told_in_order() {
    let folder = scratch("many");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for number in 0..12_u32 {
        // The first are the longest: they are done last.
        let raw = streams::noisy(600 - number * 40, number.into());
        fs::write(file(&format!("run-{number:02}.txt")), raw).unwrap();
    }
    let (out, _) = expect(0, &["info", "--json", &file("run-*.txt")]);
    let bytes: Vec<u64> = out
        .lines()
        .map(|line| {
            serde_json::from_str::<serde_json::Value>(line).unwrap()["bytes"]
                .as_u64()
                .unwrap()
        })
        .collect();
    assert_eq!(bytes.len(), 12);
    assert!(bytes.is_sorted_by(|a, b| a > b), "{bytes:?}");
    expect(
        0,
        &["convert", &file("run-*.txt"), "--output-dir", &file("made")],
    );
    let (out, _) = expect(0, &["verify", &file("made/*.mcap")]);
    let named: Vec<&str> = out
        .lines()
        .filter(|line| line.ends_with(": good"))
        .collect();
    assert_eq!(named.len(), 12);
    assert!(named.is_sorted());
    expect(
        0,
        &[
            "convert",
            &file("made/*.mcap"),
            "--output-dir",
            &file("again"),
        ],
    );
    for number in 0..12 {
        let name = format!("run-{number:02}.txt");
        let again = fs::read(file(&format!("again/{name}"))).unwrap();
        assert_eq!(again, fs::read(file(&name)).unwrap());
    }
    let (_, err) = expect(2, &["info", &file("absent-*.txt")]);
    assert!(err.contains("no file matches"), "{err}");
    // Of one bad file the others are told all the same.
    fs::write(file("run-05.txt"), "spoilt\n").unwrap();
    let (out, err) = expect(2, &["info", "--json", &file("run-*.txt")]);
    assert_eq!(out.lines().count(), 11);
    assert!(err.contains("run-05.txt"), "{err}");
    // A folder can hold a file that is called like a pattern.
    fs::write(file("[a].txt"), streams::clean(20)).unwrap();
    expect(0, &["info", &file("[a].txt")]);
}

/// Runs with `input` on standard input.
fn pipe(arguments: &[&str], input: &[u8]) -> Vec<u8> {
    let mut child = Command::new(GROUNDWAVE)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut to = child.stdin.take().unwrap();
    let input = input.to_vec();
    let writer = std::thread::spawn(move || to.write_all(&input));
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap().unwrap();
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {err}");
    assert_eq!(err, "", "{arguments:?} is not quiet in a pipe");
    output.stdout
}

#[test]
fn verbs_work_in_pipes() {
    let raw = streams::noisy(400, 9);
    let mcap = pipe(&["convert", "-"], &raw);
    assert_eq!(pipe(&["convert", "-", "-o", "-"], &mcap), raw);
    let head = pipe(&["cut", "-", "--to", "30"], &mcap);
    let tail = pipe(&["cut", "-", "--from", "30"], &mcap);
    let both = [whole(&head), whole(&tail)].concat();
    assert_eq!(both, raw);
    let verdict = String::from_utf8(pipe(&["verify", "-"], &mcap)).unwrap();
    assert!(verdict.starts_with("-: good"), "{verdict}");
    let csv = pipe(&["export", "-", "--to", "csv"], &mcap);
    assert!(csv.starts_with(b"at_s,"));
    assert!(pipe(&["export", "-", "--to", "png"], &raw).starts_with(b"\x89PNG"));
    let info: Received = serde_json::from_slice(&pipe(&["info", "--json", "-"], &mcap)).unwrap();
    assert_eq!(info.bytes, raw.len() as u64);
    assert_eq!(info.bytes, Info::read(&mut open(&raw)).bytes);
}

#[derive(serde::Deserialize)]
struct Received {
    bytes: u64,
}

#[cfg(unix)]
#[test]
fn a_reader_that_goes_away_is_no_error() {
    let folder = scratch("broken-pipe");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(8000).repeat(3)).unwrap();
    expect(0, &["convert", &file("a.txt")]);
    for words in [
        &["convert", "a.txt", "-o", "-"][..],
        &["convert", "a.mcap", "-o", "-"],
        &["cut", "a.mcap", "--from", "1", "-o", "-"],
        &["cut", "a.txt", "--from", "1", "-o", "-"],
        &["export", "a.txt", "--to", "csv", "-o", "-"],
        &["decode", "a.txt", "--to", "jsonl"],
    ] {
        let mut child = Command::new(GROUNDWAVE)
            .args(words)
            .current_dir(&folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(0), "{words:?}: {err}");
        assert!(!err.contains("groundwave:"), "{words:?}: {err}");
    }
}

#[test]
fn the_text_for_people_names_the_file() {
    let folder = scratch("names");
    let path = folder.join("a.txt");
    fs::write(&path, streams::clean(30)).unwrap();
    let (out, _) = expect(0, &["verify", path.to_str().unwrap()]);
    let name = Path::new(out.lines().next().unwrap().trim_end_matches(": good"));
    assert_eq!(name, path);
}

#[test]
fn a_part_outside_of_the_capture_is_an_error_and_makes_no_file() {
    let folder = scratch("outside");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(570)).unwrap();
    expect(0, &["convert", &file("a.txt")]);
    let made = file("part");
    let (raw, mcap) = (file("a.txt"), file("a.mcap"));
    for (name, window) in [
        (&raw, ["--from", "5h"].as_slice()),
        (&raw, &["--from", "0", "--to", "1ms"]),
        (&mcap, &["--from", "5h"]),
    ] {
        let (_, err) = expect(2, &[&["cut", name, "-o", &made], window].concat());
        assert!(err.contains("is 3:"), "{err}");
        assert!(err.contains("nothing of it lies there"), "{err}");
        assert!(!Path::new(&made).exists());
    }
    let wall = ["cut", &file("a.mcap"), "--from", "2099-01-01T00:00:00Z"];
    let (_, err) = expect(2, &wall);
    assert!(err.contains("nothing of it lies there"), "{err}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
}

#[test]
fn nothing_is_recorded_to_a_file_called_dash() {
    let folder = scratch("dash");
    for arguments in [
        ["record", "-", "-o", "-"].as_slice(),
        &["watch", "-", "--headless", "--tee", "-"],
        &["watch", "-", "--headless", "--record=-"],
    ] {
        let output = Command::new(GROUNDWAVE)
            .args(arguments)
            .current_dir(&folder)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {err}");
        assert!(err.contains("watch - --headless"), "{err}");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}

#[test]
fn a_journal_is_not_taken_for_a_raw_capture() {
    let folder = scratch("journal");
    let path = folder.join("a.mcap.journal");
    let mut journal = JournalWriter::create(&path).unwrap();
    journal.session(1, b"{}");
    journal.rx(2, &streams::clean(30));
    assert_eq!(journal.problem(), None);
    drop(journal);
    let name = path.to_str().unwrap();
    for verb in [
        ["info"].as_slice(),
        &["decode", "--to", "csv"],
        &["convert"],
        &["verify"],
        &["songs"],
        &["cut", "--from", "1s"],
        &["export", "--to", "csv"],
    ] {
        let (_, err) = expect(2, &[verb, &[name]].concat());
        let told = "is the journal of a recording: groundwave recover ";
        assert!(err.contains(told), "{verb:?}: {err}");
    }
    // What `replay` opens.
    let error = index::open(&path).err().unwrap();
    assert!(matches!(error, CaptureError::Journal(_)), "{error}");
    expect(0, &["recover", name]);
    expect(0, &["info", folder.join("a.mcap").to_str().unwrap()]);
}
