//! Fuzzing of input: route and parameter files, configurations, commands, the shared socket and its clients, the welcome and answers of
//! a station, lines of any robot and their profiles, worlds, captures and their labels. The tests of keys and scripts are beside their code.
//! `docs/fuzzing.md` describes longer runs.

use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use groundwave::capture::cut::{Window, cut_mcap};
use groundwave::capture::diagnosis::Diagnosis;
use groundwave::capture::index::{self, SeekableReader, SeekableText};
use groundwave::capture::runs::Label;
use groundwave::capture::text::TextReader;
use groundwave::capture::verify::verify_mcap;
use groundwave::capture::{Capture, Piece};
use groundwave::commands::config;
use groundwave::event::CommandId;
use groundwave::io::share_client::{Halves, ShareClient};
use groundwave::parameter_file::ParameterFile;
use groundwave::request::Request;
use groundwave::route;
use groundwave::share::{
    ANNOUNCEMENT, Address, Answers, Broker, CallId, Calls, ClientId, ClientLine, Heard, Lines,
    Output, StationLine, StatusJson, ToClient, ToStation, is_announced,
};
use groundwave_lines::{FIELDS_MAX, Recognizer, runs};
use sr04_sim::World;

const ITERATIONS: usize = 1000;

const WORLD: &str = include_str!("../firmware/sim/worlds/corridor.toml");

/// A route that is written and read again is equal; an invalid one gets an error with the file's name.
#[test]
fn fuzz_route() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            match route::parse("r.txt", &text) {
                Ok(waypoints) => {
                    assert!((1..=groundwave_protocol::WAYPOINTS_MAX).contains(&waypoints.len()));
                    let again = route::parse("r.txt", &route::format(&waypoints));
                    assert_eq!(again, Ok(waypoints));
                }
                Err(error) => assert!(error.to_string().starts_with("r.txt:"), "{error}"),
            }
        });
}

/// A configuration is read, with all values in range, or gets an error.
#[test]
fn fuzz_configuration() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(
            |bytes: &[u8]| match config::parse(&String::from_utf8_lossy(bytes)) {
                Ok(config) => assert_eq!(
                    config.link.latency_ms.is_some(),
                    config.link.latency().is_some()
                ),
                Err(mistakes) => {
                    assert!(!mistakes.is_empty());
                    assert!(mistakes.iter().all(|mistake| !mistake.message.is_empty()));
                }
            },
        );
}

/// A command that is written and read again is equal.
#[test]
fn fuzz_command() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let text = String::from_utf8_lossy(bytes);
            let words: Vec<&str> = text.split_whitespace().collect();
            if let Ok(request) = Request::from_words(&words) {
                let said = request.to_string();
                let again: Vec<&str> = said.split_whitespace().collect();
                assert_eq!(Request::from_words(&again), Ok(request), "{said}");
            }
        });
}

/// Arbitrary bytes of a client: lines do not depend on the chunks, none is longer than allowed, and a parsed line is
/// equal after writing and reading.
#[test]
fn fuzz_socket() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let whole = lines(bytes, bytes.len().max(1));
            assert_eq!(whole, lines(bytes, 1));
            assert_eq!(whole, lines(bytes, 7));
            for line in whole.into_iter().flatten() {
                if let Ok(read) = ClientLine::parse(&line) {
                    let written = read.to_line();
                    let written = written.strip_suffix(b"\n").expect("a line ends");
                    assert_eq!(ClientLine::parse(written), Ok(read));
                }
            }
        });
}

/// A station may answer anything: an answer that is written and read again is equal, and so is a known status in it.
#[test]
fn fuzz_answer() {
    const ANSWER: &str = r#"{"id":1,"status":"refused","code":"bad-value","text":"no","frames":2,"heard":{"bytes":9,"lines":1}}"#;
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            for line in [bytes.to_vec(), edited(ANSWER, bytes)] {
                let Some(answer) = StationLine::parse(&line) else {
                    continue;
                };
                let written = answer.to_line();
                assert_eq!(StationLine::parse(&written).as_ref(), Some(&answer));
                if let StationLine::Status { status, .. } = &answer
                    && let Some(known) = status.status()
                {
                    assert_eq!(StatusJson::from(&known).status(), Some(known));
                }
            }
        });
}

/// A world is read, or refused with the place of the mistake; a world that is read can be drawn.
#[test]
fn fuzz_world() {
    bolero::check!()
        .with_iterations(ITERATIONS / 10)
        .for_each(|bytes: &[u8]| {
            for text in [bytes.to_vec(), edited(WORLD, bytes)] {
                let text = String::from_utf8_lossy(&text);
                match World::parse("w.toml", &text) {
                    Ok(world) => {
                        assert!((0.0..=1.0).contains(&world.reach()), "{text}");
                        assert!(!world.picture().is_empty(), "{text}");
                        assert!(world.svg().contains("</svg>"), "{text}");
                    }
                    Err(error) => assert!(error.to_string().starts_with("w.toml:"), "{error}"),
                }
            }
        });
}

/// The lines of any robot do not depend on how their bytes are split, and use bounded memory.
#[test]
fn fuzz_own_lines() {
    const LINES: &str = "temp:21.5,volt:11.9\r\n>x:3:1.5\u{a7}m\n\n\nt,x\n1,2\n{\"a\":{\"b\":[1,2]}}\n$GPGGA,1,2*76\r\nready\n";
    let read = |bytes: &[u8], chunk: usize| {
        let mut own = Recognizer::default();
        let chunks = bytes.chunks(chunk).flat_map(runs);
        let lines: Vec<_> = chunks.filter_map(|run| own.take(run, false)).collect();
        assert!(own.fields().count() <= FIELDS_MAX);
        lines
    };
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            for bytes in [bytes.to_vec(), edited(LINES, bytes)] {
                let whole = read(&bytes, bytes.len().max(1));
                // A number that is none differs from itself.
                assert_eq!(format!("{whole:?}"), format!("{:?}", read(&bytes, 1)));
                assert_eq!(format!("{whole:?}"), format!("{:?}", read(&bytes, 7)));
            }
        });
}

/// A profile in a configuration, with any pattern, is refused or reads any lines, however their bytes are split, in bounded memory.
#[test]
fn fuzz_profile() {
    const PROFILE: &str = "[robot.r.lines]\nform = \"regex\"\nchecksum = \"none\"\nfields = [{ name = \"t\", unit = \"C\", scale = 0.1, offset = -1, role = \"speed\", limits = { low = 1, high = 9 } }]\n";
    const PATTERN: &str = r"^T(?<t>-?[0-9.]+);(?i:\p{L}{1,9}|(a*|b?)*){1,9}(?<n>\d+)?$";
    const LINES: &str = "T21.5;aabA7\r\nT-1;\u{e9}\n\nT;;T9\n";
    let read = |own: &Recognizer, bytes: &[u8], chunk: usize| {
        let mut own = own.clone();
        let chunks = bytes.chunks(chunk).flat_map(runs);
        let lines: Vec<_> = chunks.filter_map(|run| own.take(run, false)).collect();
        assert!(own.fields().count() <= FIELDS_MAX);
        // A number that is none differs from itself.
        format!("{lines:?}")
    };
    bolero::check!()
        .with_iterations(ITERATIONS / 10)
        .for_each(|bytes: &[u8]| {
            let (of_profile, of_pattern) = bytes.split_at(bytes.len() / 2);
            let pattern = edited(PATTERN, of_pattern);
            let pattern = toml::Value::String(String::from_utf8_lossy(&pattern).into_owned());
            let pattern = format!("{PROFILE}pattern = {pattern}\n");
            let changed = edited(&pattern, of_profile);
            for text in [pattern.as_bytes(), &changed] {
                match config::parse(&String::from_utf8_lossy(text)) {
                    Ok(config) => {
                        let profiles = config.robots.values();
                        for profile in profiles.filter_map(|robot| robot.lines.as_ref()) {
                            let own = Recognizer::new(profile).unwrap();
                            for bytes in [bytes.to_vec(), edited(LINES, bytes)] {
                                let whole = read(&own, &bytes, bytes.len().max(1));
                                assert_eq!(whole, read(&own, &bytes, 1));
                                assert_eq!(whole, read(&own, &bytes, 7));
                            }
                        }
                    }
                    Err(mistakes) => {
                        assert!(mistakes.iter().all(|mistake| !mistake.message.is_empty()));
                    }
                }
            }
        });
}

/// The first bytes of a link show early whether a station shares it. A client becomes one by a welcome alone, whatever comes before
/// it, and loses no byte after it.
#[test]
fn fuzz_welcome() {
    const LINES: &str = "{\"groundwave\":1}\n{\"groundwave\":1,\"link\":\"sim\",\"can_send\":true}\n{\"rx\":\"A\"}\n{\"code\":\"full\",\"error\":\"too many\"}\n";
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            for bytes in [bytes.to_vec(), edited(LINES, bytes)] {
                let known = (0..=bytes.len()).find_map(|count| is_announced(&bytes[..count]));
                assert_eq!(known, is_announced(&bytes));
                assert!(known.is_some() || bytes.len() < ANNOUNCEMENT.len());
                for chunk in [1, 7, bytes.len().max(1)] {
                    let reading = Chunked(Cursor::new(bytes.clone()), chunk);
                    let halves = Halves {
                        reading: Box::new(reading),
                        writing: Box::new(io::sink()),
                        token: None,
                    };
                    let address = Address::Tcp("here:1".to_owned());
                    let deadline = Instant::now() + Duration::from_mins(1);
                    let greeted = ShareClient::greet(address, halves, true, deadline);
                    let first = first_answer(&bytes);
                    match greeted {
                        Ok((client, welcome)) => {
                            let (rest, line) = first.expect("a welcome");
                            assert_eq!(line, StationLine::Welcome(welcome));
                            let (mut halves, mut unread) = client.into_halves();
                            halves.reading.read_to_end(&mut unread).unwrap();
                            assert_eq!(unread, rest);
                        }
                        Err(error) => {
                            assert!(!matches!(first, Some((_, StationLine::Welcome(_)))));
                            let error = error.to_string();
                            assert!(error.contains("here:1"), "{error}");
                        }
                    }
                }
            }
        });
}

/// The first welcome or error of a station among its bytes, and the bytes after it.
fn first_answer(mut bytes: &[u8]) -> Option<(&[u8], StationLine)> {
    let mut lines = Lines::default();
    while !bytes.is_empty() {
        let (taken, line) = lines.take(bytes);
        bytes = &bytes[taken..];
        let line = line.ok().flatten();
        if let Some(line @ (StationLine::Welcome(_) | StationLine::Error { .. })) =
            line.and_then(|line| StationLine::parse(&line))
        {
            return Some((bytes, line));
        }
    }
    None
}

/// A reader that returns at most this number of bytes per call.
struct Chunked(Cursor<Vec<u8>>, usize);

impl Read for Chunked {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = buffer.len().min(self.1);
        self.0.read(&mut buffer[..count])
    }
}

/// The mistakes found in any lines do not depend on how their bytes are split.
#[test]
fn fuzz_check() {
    let lines = include_bytes!("../captures/house-clean.txt");
    let found = |bytes: &[u8], chunk: usize| {
        let mut diagnosis = Diagnosis::default();
        bytes.chunks(chunk).for_each(|bytes| diagnosis.take(bytes));
        (
            diagnosis.findings(),
            diagnosis.level(),
            *diagnosis.counters(),
        )
    };
    bolero::check!()
        .with_iterations(ITERATIONS / 10)
        .for_each(|bytes: &[u8]| {
            let text = String::from_utf8_lossy(&lines[..1600]);
            for bytes in [bytes.to_vec(), edited(&text, bytes)] {
                let whole = found(&bytes, bytes.len().max(1));
                assert_eq!(whole, found(&bytes, 1));
                assert_eq!(whole, found(&bytes, 7));
            }
        });
}

/// A set of parameters is read, or refused with file and line.
#[test]
fn fuzz_parameter_file() {
    const FILE: &str = "# calm\ntop-speed = 8\nprowl-speed = 6 # in/s\n";
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            for bytes in [bytes.to_vec(), edited(FILE, bytes)] {
                let text = String::from_utf8_lossy(&bytes);
                match ParameterFile::parse("p.txt", &text) {
                    Ok(file) => assert!(!file.entries().is_empty()),
                    Err(error) => assert!(error.to_string().starts_with("p.txt:"), "{error}"),
                }
            }
        });
}

/// Clients may send any lines in any order: no more commands than they sent reach the station, and each client that is closed is
/// not received again. A call of a live tool starts or gets an answer.
#[test]
fn fuzz_clients() {
    const LINES: [&[u8]; 6] = [
        br#"{"groundwave":1,"pid":7,"raw":true}"#,
        br#"{"id":1,"do":"stop"}"#,
        br#"{"id":2,"do":"route 1,2 3,4","timeout_s":1}"#,
        br#"{"cancel":2}"#,
        br#"{"drive":[3,-3]}"#,
        br#"{"do":"mode prowl"}"#,
    ];
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let mut broker = Broker::new("link".to_owned(), true);
            let answers = Answers::default();
            let mut closed = Vec::new();
            let (mut given, mut now) = (0, Duration::ZERO);
            for step in bytes.chunks(3) {
                let client = ClientId(u64::from(step[0] % 20));
                let choice = usize::from(*step.get(1).unwrap_or(&0));
                now += Duration::from_millis(u64::from(*step.get(2).unwrap_or(&0)) * 10);
                let line = LINES.get(choice % 8).copied().unwrap_or(step);
                match choice % 16 {
                    15 => broker.handle_connected(client, "pid 1".to_owned()),
                    14 => broker.handle_gone(client),
                    13 => broker.handle_timeout(now, Heard::default()),
                    _ => {
                        let line = edited(
                            &String::from_utf8_lossy(line),
                            &bytes[..bytes.len().min(choice % 9)],
                        );
                        if let Some(asked) = broker.handle_line(now, client, Ok(&line), &answers) {
                            assert!(!closed.contains(&client), "{client:?}");
                            given += 1;
                            broker.handle_started(now, CommandId(given), &asked, Heard::default());
                        }
                    }
                }
                while let Some(output) = broker.poll_output() {
                    match output {
                        Output::Client(client, ToClient::Close) => closed.push(client),
                        Output::Station(ToStation::GiveUp(id, _)) => {
                            assert!((1..=given).contains(&id.0));
                        }
                        Output::Client(client, ToClient::Converse { .. }) => {
                            assert!(!closed.contains(&client));
                        }
                        _ => {}
                    }
                }
                if choice % 16 == 15 {
                    closed.retain(|it| *it != client);
                }
            }
            let mut calls = Calls::default();
            calls.handle_call(now, CallId(1), bytes);
            assert!(calls.poll_output().is_some());
        });
}

/// A sample with edits by these bytes: random bytes alone are hardly ever TOML or JSON.
fn edited(sample: &str, bytes: &[u8]) -> Vec<u8> {
    let mut text = sample.as_bytes().to_vec();
    for edit in bytes.chunks_exact(4) {
        let at = usize::from(u16::from_le_bytes([edit[0], edit[1]])) % text.len().max(1);
        match edit[2] % 4 {
            0 => text.insert(at, edit[3]),
            1 => drop(text.drain(at..(at + usize::from(edit[3] % 8)).min(text.len()))),
            2 => text.extend_from_within(at..(at + usize::from(edit[3])).min(text.len())),
            _ => {
                if let Some(byte) = text.get_mut(at) {
                    *byte = edit[3];
                }
            }
        }
    }
    text
}

/// The lines found in chunks of `chunk` bytes, up to the first that is too long, after which the client is disconnected.
fn lines(bytes: &[u8], chunk: usize) -> Vec<Option<Vec<u8>>> {
    let mut lines = Lines::default();
    let mut found = Vec::new();
    for mut rest in bytes.chunks(chunk) {
        while !rest.is_empty() {
            let (taken, line) = lines.take(rest);
            rest = &rest[taken..];
            match line {
                Ok(Some(line)) => found.push(Some(line)),
                Ok(None) => {}
                Err(_) => {
                    found.push(None);
                    return found;
                }
            }
        }
    }
    found
}

/// A changed sample recording; the first byte selects the kind of change.
fn recording(bytes: &[u8]) -> Vec<u8> {
    let Some((kind, rest)) = bytes.split_first() else {
        return mcap::MAGIC.to_vec();
    };
    if kind % 4 == 0 {
        return [mcap::MAGIC, rest].concat();
    }
    let mut recording = include_bytes!("../captures/demo-commands.mcap").to_vec();
    for change in rest.as_chunks::<4>().0 {
        let [low, high, length, byte] = *change;
        let at = usize::from(u16::from_le_bytes([low, high])) % recording.len();
        match kind % 4 {
            1 => recording[at] = byte,
            2 => drop(recording.splice(at..at, vec![byte; length.into()])),
            _ => drop(recording.drain(at..(at + usize::from(length)).min(recording.len() - 1))),
        }
    }
    recording
}

/// Reading any recording ends, from its beginning and by its index, with no more parts than the file has bytes; both give the
/// same bytes. Checking and cutting the recording also end.
#[test]
fn fuzz_recording() {
    bolero::check!()
        .with_iterations(ITERATIONS / 10)
        .for_each(|bytes: &[u8]| {
            let bytes = recording(bytes);
            let parts_max = 100 + 100 * bytes.len();
            let mut capture = Capture::read("", Box::new(Cursor::new(bytes.clone()))).unwrap();
            let read = (0..parts_max).position(|_| matches!(capture.next_piece(), Ok(None)));
            assert!(read.is_some());
            if let Ok(mut reader) = index::read(Arc::new(bytes.clone()), Path::new("")) {
                let read = (0..parts_max).position(|_| reader.next_piece().is_none());
                assert!(read.is_some());
            }
            verify_mcap(&bytes[..], None).unwrap();
            cut_mcap(&bytes[..], Window::default(), Vec::new()).unwrap();
        });
}

/// The pieces of any text make up the file, and a seekable reader gives the same bytes of the radio at the same times.
#[test]
fn fuzz_raw_text() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(|bytes: &[u8]| {
            let mut text = TextReader::new(bytes);
            let mut seekable = SeekableText::new(Arc::new(bytes.to_vec())).unwrap();
            let mut stored: Vec<u8> = Vec::new();
            while let Some(piece) = text.next_piece().unwrap() {
                stored.extend(piece.stored);
                assert_eq!(seekable.next_at(), Some(piece.at));
                assert_eq!(seekable.next_piece(), Some(Piece::Received(piece.radio)));
            }
            assert_eq!(seekable.next_piece(), None);
            assert_eq!(stored, bytes);
        });
}

/// A label that is read, written and read again is equal; an unreadable label gets an error message.
#[test]
fn fuzz_label() {
    bolero::check!()
        .with_iterations(ITERATIONS)
        .for_each(
            |bytes: &[u8]| match Label::parse(&String::from_utf8_lossy(bytes)) {
                Ok(label) => {
                    let written = toml::to_string(&label).unwrap();
                    // A number that is none differs from itself.
                    let again = Label::parse(&written).unwrap();
                    assert_eq!(format!("{again:?}"), format!("{label:?}"));
                }
                Err(problem) => assert!(!problem.is_empty()),
            },
        );
}
