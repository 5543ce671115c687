//! Hostile captures: every command that reads captures ends within limits of memory and CPU time, with its own exit code.
#![cfg(target_os = "linux")]

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use groundwave::capture::messages::{FloorMessage, RawBytes, StationEvent, StationEventKind};
use groundwave::capture::topics::Topic;
use groundwave::event::{LinkEvent, Moment};
use mcap::MAGIC;
use mcap::records::op;
use prost::Message as _;

use crate::common::{Rng, is_nightly, on_all_cores, seeds};
use crate::programs::{GROUNDWAVE, scratch};
use crate::pty::OnTerminal;

/// Memory that a command may allocate, KiB: 64 MiB of data and some stacks.
const MEMORY_KIB: u32 = 72 << 10;

/// CPU time that a command may take, s. The value is only a bound: a loop over a claimed length takes hours.
const CPU_S: u32 = 60;

/// Sets the limits, then becomes the program; `exec` keeps the process id.
const LIMITED: &str = r#"ulimit -S -d "$1" && ulimit -S -t "$2" && shift 2 && exec "$@""#;

/// Arguments of `sh` that run the program within the limits.
fn limited(arguments: &[&str]) -> Vec<String> {
    let (memory, cpu) = (MEMORY_KIB.to_string(), CPU_S.to_string());
    let shell = ["-c", LIMITED, "sh", &memory, &cpu, GROUNDWAVE];
    shell.iter().chain(arguments).map(|&it| it.into()).collect()
}

fn run(arguments: &[&str]) -> Output {
    Command::new("sh")
        .args(limited(arguments))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .output()
        .unwrap()
}

/// Checks every command that reads captures, with a capture alone in its folder.
fn assert_bounded(capture: &Path, what: &str) {
    let folder = capture.parent().unwrap();
    let (capture, folder) = (capture.to_str().unwrap(), folder.to_str().unwrap());
    let made = format!("{folder}/made");
    let both = format!("{made}/both.png");
    for arguments in [
        &["info", capture][..],
        &["verify", capture],
        &[
            "export",
            "--to",
            "jsonl",
            "-o",
            "/dev/null",
            "--force",
            capture,
        ],
        &[
            "export",
            "--to",
            "svg",
            capture,
            "-o",
            "/dev/null",
            "--force",
        ],
        &[
            "cut",
            "--from",
            "0:01",
            capture,
            "--output-dir",
            &made,
            "--force",
        ],
        &[
            "export",
            "--to",
            "mcap",
            "--anyway",
            capture,
            "--output-dir",
            &made,
            "--force",
        ],
        &[
            "export",
            "--to",
            "map",
            capture,
            "--output-dir",
            &made,
            "--force",
        ],
        &["map", capture, capture, "-o", &both, "--force"],
        &["songs", capture],
        &["runs", folder],
        &["label", capture, "--note", "x", "--at", "1"],
        &["compare", capture, capture],
        // Last: it may replace the capture.
        &["recover", capture],
    ] {
        let output = run(arguments);
        let told = String::from_utf8_lossy(&output.stderr);
        let code = output.status.code();
        let is_bounded = matches!(code, Some(0..=2)) && !told.contains("panicked");
        assert!(
            is_bounded,
            "{what}: {arguments:?}: {}\n{told}",
            output.status
        );
    }
}

/// Bytes preceded by their length as 32 bits.
fn sized(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

fn record(opcode: u8, body: &[u8]) -> Vec<u8> {
    claiming(opcode, body.len() as u64, body)
}

/// A record that claims a wrong length.
fn claiming(opcode: u8, length: u64, body: &[u8]) -> Vec<u8> {
    [&[opcode], &length.to_le_bytes()[..], body].concat()
}

fn schema(id: u16, name: &str) -> Vec<u8> {
    let fields = [
        &id.to_le_bytes()[..],
        &sized(name.as_bytes()),
        &sized(b"protobuf"),
        &sized(b""),
    ];
    record(op::SCHEMA, &fields.concat())
}

fn channel(id: u16, schema: u16, topic: &str) -> Vec<u8> {
    let fields = [
        &id.to_le_bytes()[..],
        &schema.to_le_bytes(),
        &sized(topic.as_bytes()),
        &sized(b"protobuf"),
        &sized(b""),
    ];
    record(op::CHANNEL, &fields.concat())
}

fn message(topic: Topic, at_ns: u64, data: &[u8]) -> Vec<u8> {
    let fields = [
        &topic.channel_id().to_le_bytes()[..],
        &0_u32.to_le_bytes(),
        &at_ns.to_le_bytes(),
        &at_ns.to_le_bytes(),
        data,
    ];
    record(op::MESSAGE, &fields.concat())
}

fn received(stream_offset: u64, data: Vec<u8>) -> Vec<u8> {
    let raw = RawBytes {
        stream_offset,
        data,
    };
    message(Topic::RawRx, 1, &raw.encode_to_vec())
}

/// A chunk of these records that claims an unpacked length.
fn chunk(records: &[u8], claimed: u64, crc: u32) -> Vec<u8> {
    let packed = zstd::bulk::compress(records, 3).unwrap();
    let fields = [
        &1_u64.to_le_bytes()[..],
        &1_u64.to_le_bytes(),
        &claimed.to_le_bytes(),
        &crc.to_le_bytes(),
        &sized(b"zstd"),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ];
    record(op::CHUNK, &fields.concat())
}

fn honest_chunk(records: &[u8]) -> Vec<u8> {
    chunk(records, records.len() as u64, 0)
}

/// The beginning of a recording: header, and the topics that are read.
fn beginning() -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(record(
        op::HEADER,
        &[sized(b""), sized(b"groundwave")].concat(),
    ));
    for topic in [Topic::RawRx, Topic::RawTx, Topic::Station] {
        let id = topic.channel_id();
        bytes.extend(schema(id, &topic.schema().name));
        bytes.extend(channel(id, id, topic.name()));
    }
    bytes
}

/// The beginning, then these records.
fn recording(records: &[Vec<u8>]) -> Vec<u8> {
    [beginning(), records.concat()].concat()
}

/// Hostile captures; `factor` multiplies their size.
fn hostile(factor: usize) -> Vec<(&'static str, Vec<u8>)> {
    [claiming_much(factor), repeating_much(factor)].concat()
}

/// Captures that claim large sizes, or unpack to them.
fn claiming_much(factor: usize) -> Vec<(&'static str, Vec<u8>)> {
    let flood = received(0, vec![b'\n'; 1 << 20]);
    let noise = received(0, vec![b'x'; (2 << 20) - 64]);
    let too_long = received(0, vec![b'x'; 6 << 20]);
    let notice = StationEvent::notice(
        groundwave::event::NoticeCode::Radio,
        groundwave::event::Level::Info,
        "x".repeat(6 << 20).as_str(),
    );
    let long = u32::MAX.to_le_bytes();
    vec![
        ("a header's length", claiming_string(op::HEADER, &[])),
        (
            "a table's length",
            claiming_string(op::METADATA, &beginning()),
        ),
        (
            "lengths in a chunk without a checksum",
            recording(&[honest_chunk(
                &[
                    record(op::METADATA, &long),
                    record(op::HEADER, &long),
                    record(op::CHANNEL, &[&[9, 0, 9, 0], &long[..]].concat()),
                    record(op::SCHEMA, &[&[9, 0], &long[..]].concat()),
                    record(op::ATTACHMENT, &[&[0; 16], &long[..]].concat()),
                    claiming(op::MESSAGE, u64::MAX, &[]),
                ]
                .concat(),
            )]),
        ),
        (
            "chunks that claim 4 GB and more",
            recording(&[
                chunk(&flood, 4 << 30, 0),
                chunk(&flood, u64::MAX, 1),
                chunk(&flood, 100 << 20, 0),
                received(0, vec![b'x'; 80]),
            ]),
        ),
        (
            "a flood of line feeds in a chunk",
            recording(&[honest_chunk(&flood)]),
        ),
        ("noise in a chunk", recording(&[honest_chunk(&noise)])),
        (
            "many chunks that unpack to much",
            recording(&vec![honest_chunk(&too_long); 5 * factor]),
        ),
        (
            "an event as long as a book",
            recording(&[honest_chunk(&message(
                Topic::Station,
                1,
                &notice.encode_to_vec(),
            ))]),
        ),
    ]
}

/// Captures that repeat one thing many times.
fn repeating_much(factor: usize) -> Vec<(&'static str, Vec<u8>)> {
    let mib = factor << 18;
    let lines = fs::read("captures/house-clean.txt").unwrap()[..8000].to_vec();
    vec![
        (
            "false chunks in false chunks",
            nested(mib, |left| {
                let fields = [
                    &[0; 16][..],
                    &(left as u64).to_le_bytes(),
                    &1_u32.to_le_bytes(),
                    &sized(b""),
                    &(left as u64 - 40).to_le_bytes(),
                ];
                claiming(op::CHUNK, left as u64, &fields.concat())
            }),
        ),
        (
            "false messages with checksums",
            nested(mib, |left| {
                [
                    record(0xC3, &[1; 4]),
                    claiming(op::MESSAGE, left as u64 - 13, &[2; 22]),
                ]
                .concat()
            }),
        ),
        (
            "attachments in attachments",
            nested(mib, |left| {
                let data = (left as u64 - 16 - 8 - 8 - 4).to_le_bytes();
                let fields = [&[1; 16][..], &sized(b""), &sized(b""), &data];
                let row = message(Topic::RawRx, 1, &[]);
                [row, claiming(op::ATTACHMENT, left as u64, &fields.concat())].concat()
            }),
        ),
        ("many channels", many_channels(5_000 * factor)),
        ("times and offsets of any value", wild_numbers(&lines)),
        (
            "a table of many pairs",
            recording(&[record(
                op::METADATA,
                &[sized(b"session"), sized(&pairs(mib * 2))].concat(),
            )]),
        ),
        (
            "records without a body",
            recording(&vec![record(op::SCHEMA, &[]); 5_000 * factor]),
        ),
        ("floors of as many cells as are read", floors(125 * factor)),
        ("no line", vec![b'x'; 2 * mib]),
        ("only line feeds", vec![b'\n'; mib]),
        (
            "a line, then none",
            [lines.clone(), vec![b'x'; 2 * mib], lines.clone()].concat(),
        ),
        (
            "a time, then none",
            [stamped(&lines), vec![b'x'; 2 * mib]].concat(),
        ),
    ]
}

/// A recording of floors with few runs and many cells.
fn floors(count: usize) -> Vec<u8> {
    let floor = FloorMessage {
        cell_in: 3.0,
        columns: 1,
        runs: vec![4 * 128 + 1; 2048],
        ..FloorMessage::default()
    };
    assert!(floor.cells().is_some());
    let event = StationEvent::from(StationEventKind::Floor(floor)).encode_to_vec();
    let messages = (0..count).map(|at| message(Topic::Station, at as u64, &event));
    recording(&messages.collect::<Vec<_>>())
}

/// A record at the end of a file whose first string claims a length of 4 GB.
fn claiming_string(opcode: u8, before: &[u8]) -> Vec<u8> {
    let body = [&u32::MAX.to_le_bytes()[..], b"text"].concat();
    let before = if before.is_empty() { MAGIC } else { before };
    [before, &record(opcode, &body), &received(0, vec![b'x'; 80])].concat()
}

/// Consecutive heads of records, each of which claims the whole rest of the file.
fn nested(bytes: usize, head: impl Fn(usize) -> Vec<u8>) -> Vec<u8> {
    let mut all = beginning();
    let length = head(bytes).len();
    for number in 1..=bytes / length {
        all.extend(head(bytes - number * length + 100));
    }
    // The last one is whole, too.
    all.extend([0; 200]);
    all
}

/// Channels whose topics are ours and others, and a summary that lists them again and again.
fn many_channels(count: usize) -> Vec<u8> {
    let channels: Vec<_> = (0..count)
        .map(|n| match n % 2 {
            0 => channel(n as u16, 1, Topic::RawRx.name()),
            _ => channel(n as u16, 1, &format!("/topic/{n}")),
        })
        .collect();
    recording(&[channels.concat(), honest_chunk(&channels.concat())])
}

fn pairs(bytes: usize) -> Vec<u8> {
    let pair = |n: u32| [sized(&n.to_le_bytes().map(|byte| byte % 100)), sized(b"")].concat();
    (0..(bytes / 12) as u32).flat_map(pair).collect()
}

/// Intact lines at times that go back and forth, and at offsets up to the largest.
fn wild_numbers(lines: &[u8]) -> Vec<u8> {
    let mut rng = Rng(1);
    let mut any = || match rng.below(4) {
        0 => u64::MAX - rng.below(200),
        1 => rng.below(1 << 40),
        _ => 1_800_000_000_000_000_000 + rng.below(1 << 40),
    };
    let messages = lines.chunks(80).map(|line| {
        let raw = |offset| RawBytes {
            stream_offset: offset,
            data: line.to_vec(),
        };
        let lost = LinkEvent::Lost {
            reason: "it is gone".into(),
        };
        let events = [
            StationEvent::from(&lost),
            StationEvent::suspended(Moment::MAX),
        ];
        let events = events.map(|event| message(Topic::Station, any(), &event.encode_to_vec()));
        [
            message(Topic::RawRx, any(), &raw(any()).encode_to_vec()),
            message(Topic::RawTx, any(), &raw(any()).encode_to_vec()),
            events.concat(),
        ]
        .concat()
    });
    recording(&messages.collect::<Vec<_>>())
}

/// The lines, each with a timestamp before it.
fn stamped(lines: &[u8]) -> Vec<u8> {
    let lines = lines.split_inclusive(|byte| *byte == b'\n').zip(0..60);
    lines
        .flat_map(|(line, s)| [format!("20:46:{s:02} ").as_bytes(), line].concat())
        .collect()
}

#[test]
fn commands_bear_hostile_captures() {
    let factor = if is_nightly() { 32 } else { 1 };
    let captures = hostile(factor);
    on_all_cores(0..captures.len() as u64, |n| {
        let (what, bytes) = &captures[n as usize];
        let folder = scratch(&format!("hostile-{n}"));
        let extension = if bytes.starts_with(MAGIC) {
            "mcap"
        } else {
            "txt"
        };
        let path = folder.join("it").with_extension(extension);
        fs::write(&path, bytes).unwrap();
        assert_bounded(&path, what);
        fs::remove_dir_all(folder).unwrap();
    });
}

/// A capture with a few random changes: bits flipped, parts cut, inserted and repeated.
fn mutated(seed: u64) -> (&'static str, Vec<u8>) {
    let mut rng = Rng(seed);
    let name = ["demo-commands.mcap", "house-noisy.txt"][rng.below(4).min(1) as usize];
    let mut bytes = fs::read(Path::new("captures").join(name)).unwrap();
    for _ in 0..=rng.below(12) {
        let at = rng.below(bytes.len() as u64) as usize;
        let end = bytes.len().min(at + rng.below(4096) as usize);
        match rng.below(5) {
            0 => drop(bytes.drain(at..end)),
            1 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            2 => drop(bytes.splice(at..at, [0xFF; 8])),
            _ => bytes[at] ^= 1 << rng.below(8),
        }
        if bytes.is_empty() {
            bytes.push(b'\n');
        }
    }
    (name, bytes)
}

#[test]
fn commands_bear_random_damage() {
    on_all_cores(seeds(4), |seed| {
        let (name, bytes) = mutated(seed);
        let folder = scratch(&format!("mutated-{seed}"));
        let path = folder.join(name);
        fs::write(&path, bytes).unwrap();
        assert_bounded(&path, &format!("seed {seed}"));
        fs::remove_dir_all(folder).unwrap();
    });
}

/// Lines with as many fields as are kept; each field has plots in every keyframe of a replay.
fn many_fields() -> Vec<u8> {
    let line = |n: usize| {
        let values = (0..64).map(|field| format!("f{field}:{}", (n * 7 + field * 31) % 1000));
        values.collect::<Vec<_>>().join(",") + "\n"
    };
    // Two seconds each at 2400 baud: nearly three hours, which need more keyframes than a replay keeps.
    (0..5000).flat_map(|n| line(n).into_bytes()).collect()
}

#[test]
fn a_replay_of_many_fields_has_bounded_memory() {
    let folder = scratch("many-fields");
    let path = folder.join("fields.txt");
    fs::write(&path, many_fields()).unwrap();
    let arguments = limited(&["replay", path.to_str().unwrap()]);
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let mut replay = OnTerminal::start("sh", &arguments, 120, 40);
    replay.wait_for("the replay", |text| text.contains("replay of"));
    // That there is no such line is known when all is read.
    replay.type_keys("g#9999999\r");
    replay.wait_for("the end", |text| text.contains("there is no line 9999999"));
    replay.type_keys("q");
    let code = replay.wait();
    assert_eq!(code, 0, "{}", replay.text());
}

/// While keys skip a long part without a line, a replay still reacts to a signal.
#[test]
fn a_replay_without_lines_obeys_keys_and_signals() {
    let folder = scratch("no-lines");
    for (n, (what, bytes)) in hostile(1).into_iter().enumerate() {
        let is_shown = ["flood", "noise", "then none", "unpack to much", "a book"];
        if !is_shown.iter().any(|it| what.contains(it)) {
            continue;
        }
        let path = folder.join(format!("{n}"));
        fs::write(&path, bytes).unwrap();
        let arguments = limited(&["replay", path.to_str().unwrap()]);
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let mut replay = OnTerminal::start("sh", &arguments, 120, 40);
        replay.wait_for("the replay", |text| text.contains("REPLAY"));
        // To the end, which is shown when it has been played to; a line back, and a line on.
        replay.type_keys("G");
        replay.wait_for("the end", |text| text.contains("session ended"));
        replay.type_keys(",.");
        let pid = replay.child.process_id().unwrap().to_string();
        Command::new("kill").arg(&pid).status().unwrap();
        let code = replay.wait();
        assert!(matches!(code, 0 | 1), "{what}: {code}\n{}", replay.text());
    }
}
