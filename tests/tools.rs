//! The verbs that convert captures lose nothing.

use crate::streams;
use std::collections::BTreeMap;
use std::fs;
use std::io::Cursor;
use std::time::Duration;

use crate::programs::{expect, scratch};
use groundwave::capture::convert::convert_raw;
use groundwave::capture::cut::{Window, cut_mcap, cut_raw};
use groundwave::capture::decode::{Format, decode};
use groundwave::capture::verify::{Comparison, RawCopy, verify_mcap};
use groundwave::capture::when::When;
use groundwave::capture::{Capture, CaptureError};
use proptest::prelude::*;

fn converted(raw: &[u8]) -> Vec<u8> {
    let mut mcap = Vec::new();
    convert_raw(raw, Some(1_741_944_413_000_000_000), &mut mcap).unwrap();
    mcap
}

fn open(bytes: &[u8]) -> Capture {
    Capture::read("", Box::new(Cursor::new(bytes.to_vec()))).unwrap()
}

/// The radio's bytes in a capture, and the error if some are missing.
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

/// Cuts a capture at each of `at`.
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
    fn telemetry_comes_back_from_an_mcap(seed in any::<u64>(), slots in 1_u32..300) {
        let raw = streams::noisy(slots, seed);
        let mcap = converted(&raw);
        let text = RawCopy { source: Box::new(Cursor::new(raw.clone())), is_named: true };
        let verdict = verify_mcap(&mcap[..], Some(text)).unwrap();
        prop_assert!(verdict.is_good(), "{:?}", verdict.faults);
        prop_assert_eq!(verdict.raw_file, Some(Comparison::Same));
        let (lines, _) = streams::live(&raw);
        prop_assert_eq!(verdict.messages.get("/telemetry").copied().unwrap_or(0), lines.len() as u64);
        // All messages except the bytes and the notice of the beginning.
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
            let verdict = verify_mcap(&piece[..], None).unwrap();
            prop_assert!(verdict.is_good(), "{:?}", verdict.faults);
            prop_assert!(verdict.derived_equal >= verdict.lines);
            for (topic, count) in verdict.messages {
                *counted.entry(topic).or_default() += count;
            }
            lines += verdict.lines;
            bytes.extend(whole(&piece));
        }
        let verdict = verify_mcap(&mcap[..], None).unwrap();
        prop_assert_eq!(bytes, raw);
        prop_assert_eq!(lines, verdict.lines);
        // A message of bytes that is cut in two counts twice.
        let rx = counted.remove("/raw/rx").unwrap();
        let mut expected = verdict.messages;
        prop_assert!(rx >= expected.remove("/raw/rx").unwrap());
        // A piece whose first line changes the markers has one message for both, and does not know that the target before it ended.
        *counted.entry("/markers".into()).or_default() += at.len() as u64;
        // Each piece repeats the state that its reader needs first.
        for topic in ["/log", "/markers", "/path", "/uplink"] {
            let (pieces, whole) = (counted.remove(topic), expected.remove(topic));
            prop_assert!(pieces >= whole, "{}: {:?} {:?}", topic, pieces, whole);
        }
        // An outage in which the recording is cut may be too short in both pieces.
        let [pieces, whole] = [&mut counted, &mut expected].map(|it| it.remove("/outages").unwrap_or(0));
        prop_assert!(pieces.abs_diff(whole) <= at.len() as u64, "{} {}", pieces, whole);
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
    // The capture begins with its first bytes, a line after the session's start time.
    cut_mcap(&mcap[..], by_the_clock, &mut same).unwrap();
    let same = whole(&same).len();
    assert!(same.abs_diff(length) <= 80, "{same} and {length} bytes");
}

const UNIX_SECONDS: u64 = 1_741_944_413;

/// A capture of several chunks, one of them damaged.
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

    let verdict = verify_mcap(&spoilt[..], None).unwrap();
    assert!(!verdict.is_good());
    assert_eq!(verdict.bytes, left.len() as u64);
    assert_eq!(verdict.missing_bytes, (raw.len() - left.len()) as u64);
    // All messages agree except for the line that was cut in two at either end.
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
fn damage_behind_a_chunk_costs_nothing_of_it() {
    let raw = streams::clean(8000);
    let mcap = converted(&raw);
    let summary = mcap::Summary::read(&mcap[..]).unwrap().unwrap();
    let chunk = &summary.chunk_indexes[1];
    let behind = (chunk.chunk_start_offset + chunk.chunk_length) as usize;
    // Operation code and length of the record there.
    for bit in 0..9 * 8 {
        let mut spoilt = mcap.clone();
        spoilt[behind + bit / 8] ^= 1 << (bit % 8);
        let (left, error) = content(&spoilt);
        assert!(error.is_some(), "bit {bit}");
        assert_eq!(left.len(), raw.len(), "bit {bit}");
    }
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

#[test]
fn tables_contain_the_values_of_the_lines() {
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
    decode(
        &mut Capture::open(&raw).unwrap(),
        &[],
        Format::Csv,
        &mut direct,
    )
    .unwrap();
    assert_eq!(csv.as_bytes(), direct);
}

/// Notes of the label are records at their moments; those about the whole run come first.
#[test]
fn tables_carry_the_notes_of_the_label() {
    let folder = scratch("noted");
    let raw = folder.join("evening.txt");
    fs::write(&raw, streams::lines(60)).unwrap();
    let name = raw.to_str().unwrap();
    for (note, at) in [("lamp, \"left\"", "0:05"), ("late", "0:19")] {
        expect(0, &["label", name, "--note", note, "--at", at]);
    }
    expect(0, &["label", name, "--note", "new wheels"]);
    let (jsonl, _) = expect(0, &["export", name, "--to", "jsonl", "-o", "-"]);
    let object = |line| serde_json::from_str::<serde_json::Value>(line).unwrap();
    let records: Vec<_> = jsonl.lines().map(object).collect();
    let places = ["new wheels", "lamp, \"left\"", "late"].map(|text| {
        let is_it = |it: &serde_json::Value| it["event"] == "note" && it["note"] == text;
        records.iter().position(is_it).unwrap()
    });
    assert_eq!(places[0], 0);
    let at_s = |index: usize| records[index]["at_s"].as_f64().unwrap();
    for (place, noted_s) in [(places[1], 5.0), (places[2], 19.0)] {
        assert!(at_s(place - 1) < noted_s && at_s(place + 1) >= noted_s);
    }
    let (csv, _) = expect(0, &["export", name, "--to", "csv", "-o", "-"]);
    let row = csv.lines().find(|row| row.starts_with("5.000,,")).unwrap();
    let header = cells(csv.lines().next().unwrap());
    let note = header.iter().position(|name| name == "note").unwrap();
    assert_eq!(cells(row)[note], "lamp, \"left\"");
}

/// The cells of a CSV row by RFC 4180.
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
        "lost or damaged (",
        "x, feet",
        "house-noisy",
    ] {
        assert!(svg.contains(&format!("aria-label=\"{word}")), "no {word}");
    }
    // Every bump and every outage is a sign of two strokes, and the legend has another one of each.
    let is_sign = |line: &&str| {
        let count = |letter| line.matches(letter).count();
        line.contains("stroke=\"#000000\" stroke-width=\"2\"") && (count('M'), count('L')) == (2, 2)
    };
    let signs = svg.lines().filter(is_sign).count();
    let (_, outages) = svg.split_once("aria-label=\"outage (").unwrap();
    let (outages, _) = outages.split_once(')').unwrap();
    let outages: usize = outages.parse().unwrap();
    let (_, bumps) = svg.split_once("aria-label=\"bump (").unwrap();
    let (bumps, _) = bumps.split_once(')').unwrap();
    // The robot's count may differ from the bumps in its lines.
    let shown = bumps.split(", ").last().unwrap();
    let shown = shown.trim_end_matches(" shown");
    let bumps: usize = shown.parse().unwrap();
    assert_eq!(signs, bumps + 1 + outages + 1);

    let png = tiny_skia::Pixmap::load_png(file("a.png")).unwrap();
    assert_eq!(size(&svg), (png.width() / 2, png.height() / 2));
    assert!(png.width() > png.height(), "the path is wider than high");
    let has = |red, green, blue| {
        let pixels = png.pixels().iter();
        pixels
            .filter(|p| (p.red(), p.green(), p.blue()) == (red, green, blue))
            .count()
    };
    assert!(has(0x56, 0xb4, 0xe9) > 200, "no sonar");
    assert!(has(0xd5, 0x5e, 0x00) > 100, "no bumpers");
    assert!(has(0, 0, 0) > 500, "no marks");
    assert!(has(0x1f, 0x24, 0x30) > 500, "no words");
    assert!(has(0xff, 0xff, 0xff) > 1_000_000, "no paper");
}

/// Width and height of an SVG.
fn size(svg: &str) -> (u32, u32) {
    let (_, view) = svg.split_once("viewBox=\"0 0 ").unwrap();
    let (view, _) = view.split_once('"').unwrap();
    let (width, height) = view.split_once(' ').unwrap();
    (width.parse().unwrap(), height.parse().unwrap())
}

/// A picture names the number of gaps that `info` counts, and has a dashed line only if there are gaps.
#[test]
fn pictures_and_info_have_the_same_gaps() {
    for name in [
        "demo-commands.mcap",
        "house-clean.txt",
        "house-noisy.txt",
        "living-room-bursts.txt",
    ] {
        let file = format!("{}/captures/{name}", env!("CARGO_MANIFEST_DIR"));
        let (info, _) = expect(0, &["info", "--json", &file]);
        let info: serde_json::Value = serde_json::from_str(&info).unwrap();
        let gaps = info["gaps"].as_u64().unwrap();
        let (svg, _) = expect(0, &["export", "--to", "svg", &file, "-o", "-"]);
        assert_eq!(gaps > 0, svg.contains("stroke-dasharray"), "{name}");
        let has_bad = info["lines_lost"] != 0 || info["damaged"]["lines"] != 0;
        assert_eq!(gaps > 0, has_bad, "{name}");
        let named = svg.contains(&format!("lost or damaged ({gaps} gap"));
        assert_eq!(gaps > 0, named, "{name}");
    }
}

#[test]
fn a_folder_of_captures_with_names_of_any_alphabet_becomes_pictures() {
    let folder = scratch("many-pictures");
    let out = folder.join("out");
    let one = [streams::clean(1)].concat();
    for (name, bytes) in [("küche.txt", streams::clean(400)), ("台所 2.txt", one)] {
        fs::write(folder.join(name), bytes).unwrap();
    }
    let captures = folder.join("*.txt");
    let [captures, to] = [&captures, &out].map(|path| path.to_str().unwrap());
    expect(0, &["export", captures, "--to", "svg", "--output-dir", to]);
    for name in ["küche", "台所 2"] {
        let svg = fs::read_to_string(out.join(format!("{name}.svg"))).unwrap();
        assert!(svg.contains(&format!("<title>{name}</title>")), "{svg}");
        assert!(!svg.contains("NaN"), "{svg}");
    }
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
fn exit_codes_report_the_state_of_a_capture() {
    let folder = scratch("exit-codes");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let raw = streams::clean(8000);
    fs::write(file("good.txt"), &raw).unwrap();
    expect(0, &["export", "--to", "mcap", &file("good.txt")]);
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
    // Another file of the same name is not compared unless it is named; sessions of one robot begin alike.
    let mut other = raw.clone();
    other[145] ^= 1;
    for text in [&b"2026-11-23 notes on the drive\n"[..], &other] {
        fs::write(file("good.txt"), text).unwrap();
        let (out, _) = expect(0, &["verify", &file("good.mcap")]);
        assert!(out.contains("another capture, not compared"), "{out}");
        expect(
            1,
            &["verify", &file("good.mcap"), "--raw", &file("good.txt")],
        );
    }
    fs::write(file("good.txt"), &raw).unwrap();
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
    assert!(err.contains("have no date"), "{err}");
    expect(2, &["cut", &file("good.txt"), "--from", "soon"]);
}
