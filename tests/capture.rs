//! Captures from end to end: both forms hold exactly the received bytes.

use crate::streams;
use std::fs::{self, File};
use std::io::{Cursor, Read};
use std::path::Path;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use groundwave::capture::convert::convert_raw;
use groundwave::capture::decode::{DecodeError, Format, decode};
use groundwave::capture::info::Info;
use groundwave::capture::runs::folder::Run;
use groundwave::capture::source::Form;
use groundwave::capture::verify::verify_mcap;
use groundwave::capture::{Capture, CaptureError, Existing, RawWriter, Recorder, Session};
use groundwave_protocol::decoder::{Decoder, Received};
use proptest::prelude::*;
use tempfile::TempDir;

const START_S: u64 = 1_741_944_413;

fn wall(now: Duration) -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(START_S) + now
}

fn session() -> Session {
    Session {
        link: "/dev/ttyUSB0".into(),
        start: wall(Duration::ZERO),
        notes: [("seed".to_owned(), "42".to_owned())].into(),
        configuration: "[link]\nbaud = 2400\n".into(),
    }
}

/// Feeds a stream as the station does, at 240 bytes per second, in reads of `sizes` in turn.
fn feed(stream: &[u8], sizes: &[usize], raw: &RawWriter, recorder: &mut Recorder) -> Duration {
    let mut sizes = sizes.iter().cycle();
    let mut rest = stream;
    let mut now = Duration::ZERO;
    let mut decoder = Decoder::default();
    while !rest.is_empty() {
        let (read, after) = rest.split_at((*sizes.next().unwrap()).min(rest.len()));
        rest = after;
        now = Duration::from_secs(stream.len() as u64 - rest.len() as u64) / 240;
        raw.write(read);
        recorder.handle_rx(now, wall(now), read);
        for received in decoder.lines(read) {
            if let Received::Line(line, _) = received {
                recorder.handle_line(&line);
            }
        }
    }
    now
}

fn record(folder: &Path, stream: &[u8], sizes: &[usize]) {
    let raw = RawWriter::create(folder.join("a.txt"), Existing::Refuse).unwrap();
    let mut recorder =
        Recorder::start(folder.join("a.mcap"), Existing::Refuse, &session()).unwrap();
    let now = feed(stream, sizes, &raw, &mut recorder);
    recorder.handle_tx(now, wall(now), b"\nsent\n");
    recorder.finish().unwrap();
}

#[cfg(target_os = "linux")]
fn raw_problem(raw: &RawWriter) -> String {
    let deadline = Instant::now() + Duration::from_mins(1);
    loop {
        assert!(Instant::now() < deadline, "no problem");
        match raw.problem() {
            Some(problem) => break problem,
            None => std::thread::yield_now(),
        }
    }
}

fn wait_for_disk(recorder: &Recorder) {
    let deadline = Instant::now() + Duration::from_mins(1);
    while !recorder.is_synced() {
        assert!(Instant::now() < deadline, "the disk does not have it");
        std::thread::yield_now();
    }
}

/// All readable bytes, and the error if some are missing.
fn read_back(path: &Path) -> (Vec<u8>, Option<CaptureError>) {
    let mut capture = Capture::open(path).unwrap();
    let mut content = Vec::new();
    loop {
        match capture.next_chunk() {
            Ok(Some(chunk)) => content.extend(chunk.bytes),
            Ok(None) => break (content, None),
            Err(error) => break (content, Some(error)),
        }
    }
}

/// Checks that all readable bytes equal those of `stream` at their offset; returns whether all were read.
fn is_read_at_its_place(path: &Path, stream: &[u8]) -> (bool, Option<CaptureError>) {
    let mut capture = Capture::open(path).unwrap();
    let mut read = 0;
    loop {
        match capture.next_chunk() {
            Ok(Some(chunk)) => {
                let bytes = chunk.bytes.to_vec();
                let place = read + capture.missing_bytes() as usize;
                assert_eq!(stream.get(place..place + bytes.len()), Some(&bytes[..]));
                read += bytes.len();
            }
            Ok(None) => break (read == stream.len(), None),
            Err(error) => {
                // The error is returned once, at the end.
                assert!(matches!(capture.next_chunk(), Ok(None)), "{error}");
                break (read == stream.len(), Some(error));
            }
        }
    }
}

fn content(path: &Path) -> Vec<u8> {
    let (content, error) = read_back(path);
    assert!(error.is_none(), "{error:?}");
    content
}

fn decoded(path: &Path, format: Format) -> String {
    let mut output = Vec::new();
    decode(&mut Capture::open(path).unwrap(), &[], format, &mut output).unwrap();
    String::from_utf8(output).unwrap()
}

/// Records without their times, which only MCAP has.
fn timeless(table: &str) -> Vec<&str> {
    table
        .lines()
        // The times of outages are in their records.
        .filter(|line| !line.contains("outage"))
        .map(|line| line.split_once(',').unwrap().1)
        .collect()
}

#[test]
fn received_bytes_are_read_back() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(600, 1);
    record(folder.path(), &stream, &[1, 80, 33, 240]);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    assert_eq!(fs::read(folder.path().join("a.txt")).unwrap(), stream);
    assert_eq!(content(&folder.path().join("a.txt")), stream);
    assert_eq!(content(&folder.path().join("a.mcap")), stream);
    assert_eq!(
        Capture::open(folder.path().join("a.mcap")).unwrap().form(),
        Form::Mcap
    );
}

#[test]
fn both_forms_decode_to_what_was_seen_live() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(600, 2);
    record(folder.path(), &stream, &[80]);
    let (lines, counters) = streams::live(&stream);
    assert!(counters.crc_rejected > 0 && counters.lines_lost > 0 && counters.noise_bytes > 0);
    for form in ["a.txt", "a.mcap"] {
        let mut capture = Capture::open(folder.path().join(form)).unwrap();
        let mut decoder = Decoder::default();
        let mut read_back = Vec::new();
        capture
            .for_each_line(&mut decoder, |_, received| {
                read_back.push(*received);
                Ok::<_, CaptureError>(())
            })
            .unwrap();
        assert_eq!(read_back, lines);
        assert_eq!(*decoder.counters(), counters);
    }
    for format in [Format::Jsonl, Format::Csv] {
        let raw = decoded(&folder.path().join("a.txt"), format);
        let mcap = decoded(&folder.path().join("a.mcap"), format);
        assert_eq!(timeless(&raw), timeless(&mcap));
        let header = usize::from(format == Format::Csv);
        assert_eq!(timeless(&raw).len(), lines.len() + header);
    }
}

#[test]
fn every_type_of_line_as_json_and_as_csv() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.txt");
    let mut stream = b"noise before the first line\n".to_vec();
    stream.extend(streams::clean(18));
    fs::write(&path, stream).unwrap();
    insta::assert_snapshot!("decoded_jsonl", decoded(&path, Format::Jsonl));
    insta::assert_snapshot!("decoded_csv", decoded(&path, Format::Csv));
    for line in decoded(&path, Format::Jsonl).lines() {
        serde_json::from_str::<serde_json::Value>(line).unwrap();
    }
}

/// The partial line received when the plug is pulled is not noise.
#[test]
fn half_a_line_at_the_end_is_not_noise() {
    let stream = streams::clean(18);
    for (cut, unfinished) in [(0, 0), (1, 79), (79, 1), (80, 0)] {
        let whole = stream[..stream.len() - cut].to_vec();
        let info = Info::read(&mut Capture::read("", Box::new(Cursor::new(whole))).unwrap());
        assert_eq!(info.unfinished_bytes, unfinished, "{cut} bytes short");
        let mut text = Vec::new();
        info.write_text(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(
            text.contains("received, 0 noise"),
            "{cut} bytes short: {text}"
        );
    }
}

#[test]
fn info_reports_the_events() {
    let folder = TempDir::new().unwrap();
    let stream = streams::noisy(900, 4);
    record(folder.path(), &stream, &[80]);
    let info = |name| Info::read(&mut Capture::open(folder.path().join(name)).unwrap());
    let (raw, mcap) = (info("a.txt"), info("a.mcap"));
    let mut text = Vec::new();
    raw.write_text(&mut text).unwrap();
    insta::assert_snapshot!("info_text", String::from_utf8(text).unwrap());
    insta::assert_snapshot!("info_json", serde_json::to_string_pretty(&mcap).unwrap());
    assert_eq!(raw.lines, mcap.lines);
    assert_eq!(raw.damaged, mcap.damaged);
    assert_eq!(raw.holders, mcap.holders);

    // 3.5 inches per slot without loss: the distance is exact.
    let stream = streams::clean(900);
    let info = Info::read(&mut Capture::read("", Box::new(Cursor::new(stream))).unwrap());
    assert!(
        (info.distance_in - 3.5 * 898.0).abs() < 0.1,
        "{}",
        info.distance_in
    );
    assert_eq!((info.loss.lines_lost, info.bumps), (0, 14));
    let share = |i: usize| (info.holders[i].holder, info.holders[i].share_pct.round());
    assert_eq!(
        [share(0), share(1), share(2)],
        [("prowl", 60.0), ("sonar", 30.0), ("bumpers", 10.0)]
    );
}

#[test]
fn nothing_is_overwritten_unless_asked() {
    let folder = TempDir::new().unwrap();
    let (raw, mcap) = (folder.path().join("a.txt"), folder.path().join("a.mcap"));
    fs::write(&raw, "precious").unwrap();
    fs::write(&mcap, "precious").unwrap();

    let refused = RawWriter::create(&raw, Existing::Refuse).unwrap_err();
    assert!(matches!(refused, CaptureError::Exists { .. }));
    assert!(refused.to_string().contains("--append"), "{refused}");
    let refused = Recorder::start(&mcap, Existing::Refuse, &session())
        .err()
        .unwrap();
    assert!(matches!(refused, CaptureError::Exists { .. }));
    assert!(refused.to_string().contains("--force"), "{refused}");
    let refused = Recorder::start(&mcap, Existing::Append, &session())
        .err()
        .unwrap();
    assert!(matches!(refused, CaptureError::CannotAppend(_)));
    assert_eq!(fs::read(&mcap).unwrap(), b"precious");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);

    let appended = RawWriter::create(&raw, Existing::Append).unwrap();
    appended.write(b" and more");
    appended.finish().unwrap();
    assert_eq!(fs::read(&raw).unwrap(), b"precious and more");
    let replaced = RawWriter::create(&raw, Existing::Overwrite).unwrap();
    replaced.write(b"new");
    replaced.finish().unwrap();
    assert_eq!(fs::read(&raw).unwrap(), b"new");
    let replaced = Recorder::start(&mcap, Existing::Overwrite, &session()).unwrap();
    replaced.finish().unwrap();
    assert_eq!(content(&mcap), b"");
}

#[test]
fn a_recording_in_use_is_left_alone_and_so_is_what_replaces_its_content() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    let recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    let second = Recorder::start(&path, Existing::Refuse, &session())
        .err()
        .unwrap();
    assert!(matches!(second, CaptureError::InUse(_)), "{second}");
    fs::write(&path, "precious").unwrap();
    let error = recorder.finish().unwrap_err();
    assert!(matches!(error, CaptureError::NothingLeft(_)), "{error}");
    assert_eq!(fs::read(&path).unwrap(), b"precious");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_killed_recording_holds_everything_that_was_read() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(90);
    let raw = RawWriter::create(folder.path().join("a.txt"), Existing::Refuse).unwrap();
    let mut recorder =
        Recorder::start(folder.path().join("a.mcap"), Existing::Refuse, &session()).unwrap();
    let now = feed(&stream, &[80], &raw, &mut recorder);
    // A power cut takes the last 10 s at most.
    recorder.handle_timeout(now + Duration::from_secs(8));
    wait_for_disk(&recorder);
    // The file after a kill at this moment, and in the middle of the next write.
    let mut killed = fs::read(folder.path().join("a.mcap")).unwrap();
    for torn in [0, 5, 400] {
        killed.extend(&[6; 400][..torn]);
        let copy = folder.path().join("killed.mcap");
        fs::write(&copy, &killed).unwrap();
        let (content, error) = read_back(&copy);
        assert_eq!(content, stream, "{torn} bytes of the next write");
        let error = error.expect("an unfinished recording passed for a whole one");
        assert!(
            torn > 0 || matches!(error, CaptureError::Unfinished { .. }),
            "{error}"
        );
    }
    drop(recorder);
    assert_eq!(content(&folder.path().join("a.mcap")), stream);
}

#[test]
fn a_bump_is_on_the_disk_at_once() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(21);
    let raw = RawWriter::create(folder.path().join("a.txt"), Existing::Refuse).unwrap();
    let mut recorder =
        Recorder::start(folder.path().join("a.mcap"), Existing::Refuse, &session()).unwrap();
    feed(&stream, &[80], &raw, &mut recorder);
    // The last of these lines is a bump.
    wait_for_disk(&recorder);
}

#[test]
fn damage_is_named_and_never_read_as_good() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    record(folder.path(), &stream, &[80]);
    let good = fs::read(folder.path().join("a.mcap")).unwrap();
    let copy = folder.path().join("damaged.mcap");
    let mut rng = streams::Rng(7);
    for _ in 0..250 {
        let (byte, bit) = (8 + rng.below(good.len() - 8), rng.below(8));
        let mut bad = good.clone();
        bad[byte] ^= 1 << bit;
        fs::write(&copy, &bad).unwrap();
        let (is_whole, error) = is_read_at_its_place(&copy, &stream);
        assert!(error.is_some() || is_whole, "bit {bit} of byte {byte}");
    }
    for length in (8..good.len()).step_by(good.len() / 250) {
        fs::write(&copy, &good[..length]).unwrap();
        let (content, error) = read_back(&copy);
        let error = error.expect("a part passed for the whole");
        assert!(
            matches!(error, CaptureError::Unfinished { .. }),
            "{length}: {error}"
        );
        assert!(stream.starts_with(&content), "{length} bytes");
    }
}

#[test]
fn another_mcap_is_not_taken_for_ours() {
    let mut foreign = Cursor::new(Vec::new());
    let mut writer = mcap::Writer::new(&mut foreign).unwrap();
    writer.finish().unwrap();
    drop(writer);
    let path = Path::new("foreign.mcap");
    let mut capture = Capture::read(path, Box::new(Cursor::new(foreign.into_inner()))).unwrap();
    let error = capture.next_chunk().unwrap_err();
    assert!(matches!(error, CaptureError::NoRawBytes(_)), "{error}");
}

#[test]
fn a_clock_set_back_leaves_the_times_in_order() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    for second in [100, 130, 50, 131] {
        let now = Duration::from_secs(second);
        recorder.handle_rx(now, wall(now), b"a damaged line\n");
    }
    recorder.finish().unwrap();
    let mut capture = Capture::open(&path).unwrap();
    let mut at_s = Vec::new();
    while let Some(chunk) = capture.next_chunk().unwrap() {
        at_s.push(chunk.at.as_secs());
    }
    // The recording begins at 0; when the clock is set back, time stands still.
    assert_eq!(at_s, [100, 130, 130, 131]);
}

/// A writer that accepts a few bytes and then fails.
struct Closing(usize);

impl std::io::Write for Closing {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0 = self
            .0
            .checked_sub(bytes.len())
            .ok_or(std::io::ErrorKind::BrokenPipe)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_broken_pipe_has_its_own_error() {
    let stream = streams::clean(30);
    let mut capture = Capture::read("stream", Box::new(Cursor::new(stream))).unwrap();
    match decode(&mut capture, &[], Format::Jsonl, &mut Closing(1500)) {
        Err(DecodeError::Output(error)) => {
            assert_eq!(error.kind(), std::io::ErrorKind::BrokenPipe);
        }
        other => panic!("{other:?}"),
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_remembered_to_the_end() {
    let raw = RawWriter::create("/dev/full", Existing::Overwrite).unwrap();
    raw.write(b"bytes");
    let problem = raw_problem(&raw);
    assert!(
        problem.contains("nothing was written; make room"),
        "{problem}"
    );
    raw.write(b"more");
    assert_eq!(raw.problem(), Some(problem.clone()));
    assert_eq!(raw.bytes(), 0);
    assert_eq!(raw.finish().unwrap_err().to_string(), problem);

    let folder = TempDir::new().unwrap();
    let path = folder.path().join("a.mcap");
    std::os::unix::fs::symlink("/dev/full", &path).unwrap();
    let error = Recorder::start(&path, Existing::Overwrite, &session())
        .err()
        .unwrap();
    assert!(error.to_string().contains("needs a file"), "{error}");
    assert!(Path::new("/dev/full").exists());
    let error = Recorder::start("/nowhere/a.mcap", Existing::Refuse, &session())
        .err()
        .unwrap();
    assert!(error.to_string().contains("create the folder"), "{error}");
}

/// A reader that returns `sizes` bytes in turn.
struct Reads {
    stream: Cursor<Vec<u8>>,
    sizes: std::iter::Cycle<std::vec::IntoIter<usize>>,
}

impl Read for Reads {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let size = self.sizes.next().unwrap().min(to.len());
        self.stream.read(&mut to[..size])
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_chunking_of_a_stream_changes_nothing(
        seed in any::<u64>(),
        sizes in prop::collection::vec(1_usize..300, 1..20),
    ) {
        let folder = TempDir::new().unwrap();
        let stream = streams::noisy(60, seed);
        record(folder.path(), &stream, &sizes);
        let (raw, mcap) = (folder.path().join("a.txt"), folder.path().join("a.mcap"));
        prop_assert_eq!(content(&raw), &stream[..]);
        prop_assert_eq!(content(&mcap), &stream[..]);
        let whole = decoded(&raw, Format::Jsonl);
        let recorded = decoded(&mcap, Format::Jsonl);
        prop_assert_eq!(timeless(&recorded), timeless(&whole));

        let source = Reads { stream: Cursor::new(stream), sizes: sizes.into_iter().cycle() };
        let mut piped = Vec::new();
        decode(&mut Capture::read("-", Box::new(source)).unwrap(), &[], Format::Jsonl, &mut piped).unwrap();
        prop_assert_eq!(String::from_utf8(piped).unwrap(), whole);
    }
}

/// Needs Python with `tests/judges/requirements.txt`; `JUDGE_PYTHON` names it.
#[test]
#[ignore = "needs Python packages; CI installs them"]
fn tools_that_others_wrote_agree() {
    let folder = TempDir::new().unwrap();
    let file = |name| folder.path().join(name);
    let stream = streams::noisy(3000, 3);
    record(folder.path(), &stream, &[80, 33, 1]);
    fs::write(file("a.jsonl"), decoded(&file("a.mcap"), Format::Jsonl)).unwrap();
    let python = std::env::var_os("JUDGE_PYTHON").unwrap_or("python3".into());
    let output = std::process::Command::new(python)
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/tests/judges/judge_mcap.py"
        ))
        .arg(file("a.mcap"))
        .arg("--raw")
        .arg(file("a.txt"))
        .arg("--jsonl")
        .arg(file("a.jsonl"))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    let complained = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}{complained}");
    println!("{said}");
}

/// 55 s without a line, 165 lines: the sequence shows the loss of 65 of them, the robot's clock the loss of all.
#[test]
fn an_outage_has_the_same_figure_everywhere() {
    let folder = TempDir::new().unwrap();
    let sample = format!("{}/captures/house-clean.txt", env!("CARGO_MANIFEST_DIR"));
    let mut stamped = String::new();
    for (n, line) in fs::read_to_string(sample).unwrap().lines().enumerate() {
        if line.len() == 78 && !(90..255).contains(&n) {
            let at_s = 1_741_944_413.0 + n as f64 / 3.0;
            stamped.extend([format!("{at_s:.3} {line}\r\n")]);
        }
    }
    let text = folder.path().join("a.txt");
    fs::write(&text, stamped).unwrap();
    let mcap = folder.path().join("a.mcap");
    let source = File::open(&text).unwrap();
    convert_raw(source, None, File::create(&mcap).unwrap()).unwrap();
    for path in [&text, &mcap] {
        let info = Info::read(&mut Capture::open(path).unwrap());
        assert_eq!(
            (info.loss.lines_lost, info.loss.lines_lost_max),
            (165, Some(165))
        );
        let mut words = Vec::new();
        info.write_text(&mut words).unwrap();
        let words = String::from_utf8(words).unwrap();
        assert!(
            words.contains("outage     silent 55.3 s from 29.7 s: 165 lines lost"),
            "{words}"
        );
        let run = Run::read(path).unwrap();
        assert_eq!(run.figures.loss, info.loss);
        let json = decoded(path, Format::Jsonl);
        let row = json.lines().find(|line| line.contains("outage")).unwrap();
        let row: serde_json::Value = serde_json::from_str(row).unwrap();
        assert_eq!(
            (&row["code"], &row["lines_lost"]),
            (&"silent".into(), &165.into())
        );
        let csv = decoded(path, Format::Csv);
        let columns = csv.lines().next().unwrap().split(',').count();
        let row = csv.lines().find(|line| line.contains("outage")).unwrap();
        assert_eq!(row.split(',').count(), columns, "{row}");
        assert!(
            row.ends_with(",outage,,,,silent,,29.667,85.0,165,165,,,,,,,,,,,,"),
            "{row}"
        );
    }
    let verdict = verify_mcap(File::open(&mcap).unwrap(), None).unwrap();
    assert!(verdict.is_good(), "{verdict:?}");
    assert_eq!(verdict.loss.lines_lost, 165);
    assert_eq!(verdict.messages.get("/outages"), Some(&1));
}

#[test]
fn tables_hold_commands() {
    let path = format!("{}/captures/demo-commands.mcap", env!("CARGO_MANIFEST_DIR"));
    let json = decoded(Path::new(&path), Format::Jsonl);
    let commands: Vec<serde_json::Value> = json
        .lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .filter(|record: &serde_json::Value| record["event"] == "command")
        .collect();
    assert_eq!(commands[0]["status"], "queued");
    assert!(commands[0]["command"].is_string(), "{commands:?}");
    assert!(
        commands
            .iter()
            .any(|record| record["status"] == "confirmed")
    );
    let csv = decoded(Path::new(&path), Format::Csv);
    let rows = csv.lines().skip(1);
    let count = rows.filter(|row| row.contains(",command,")).count();
    assert_eq!(count, commands.len());
}
