//! Commands on captures as processes: several files, pipes, and results that are either whole or absent.

use crate::streams;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;
use std::process::{Command, Stdio};

use crate::programs::{GROUNDWAVE, expect, scratch};
use groundwave::capture::Capture;
use groundwave::capture::info::Info;

fn open(bytes: &[u8]) -> Capture {
    Capture::read("", Box::new(Cursor::new(bytes.to_vec()))).unwrap()
}

/// The received bytes in a capture.
fn whole(capture: &[u8]) -> Vec<u8> {
    let mut capture = open(capture);
    let mut whole = Vec::new();
    while let Some(chunk) = capture.next_chunk().unwrap() {
        whole.extend(chunk.bytes);
    }
    whole
}

#[test]
fn existing_files_are_kept_and_no_temporary_file_remains() {
    let folder = scratch("overwrite");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(30)).unwrap();
    fs::write(file("a.mcap"), "precious").unwrap();
    let (_, err) = expect(2, &["export", "--to", "mcap", &file("a.txt")]);
    assert!(err.contains("--force"), "{err}");
    assert_eq!(fs::read(file("a.mcap")).unwrap(), b"precious");
    expect(0, &["export", "--to", "mcap", &file("a.txt"), "--force"]);
    expect(0, &["verify", &file("a.mcap")]);
    let (from, to) = (file("a.txt"), file("b.txt"));
    expect(0, &["cut", &from, "--to", "5", "-o", &to]);
    let length = fs::metadata(&to).unwrap().len();
    assert!((1121..=1200).contains(&length), "{length} bytes in 5 s");
    let (_, err) = expect(
        1,
        &[
            "export",
            "--to",
            "mcap",
            &file("a.txt"),
            "-o",
            &file("none/a.mcap"),
        ],
    );
    assert!(err.contains("create the folder"), "{err}");
    let (_, err) = expect(
        2,
        &[
            "export",
            "--to",
            "mcap",
            &file("a.txt"),
            &file("a.mcap"),
            "-o",
            "x",
        ],
    );
    assert!(err.contains("--output-dir"), "{err}");
    let mut left: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    left.sort();
    assert_eq!(left, ["a.mcap", "a.txt", "b.txt"]);
}

#[test]
fn results_of_several_files_are_in_order() {
    let folder = scratch("many");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    for number in 0..12_u32 {
        // The first files are the longest and are done last.
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
        &[
            "export",
            "--to",
            "mcap",
            &file("run-*.txt"),
            "--output-dir",
            &file("made"),
        ],
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
            "export",
            "--to",
            "raw",
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
    // A bad file does not prevent the results of the others.
    fs::write(file("run-05.txt"), "spoilt\n").unwrap();
    let (out, err) = expect(2, &["info", "--json", &file("run-*.txt")]);
    assert_eq!(out.lines().count(), 11);
    assert!(err.contains("run-05.txt"), "{err}");
    // A file name may look like a pattern.
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
fn commands_work_in_pipes() {
    let raw = streams::noisy(400, 9);
    let mcap = pipe(&["export", "--to", "mcap", "-"], &raw);
    assert_eq!(pipe(&["export", "--to", "raw", "-", "-o", "-"], &mcap), raw);
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
fn closed_pipe_is_not_an_error() {
    let folder = scratch("broken-pipe");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(8000).repeat(3)).unwrap();
    expect(0, &["export", "--to", "mcap", &file("a.txt")]);
    for words in [
        &["export", "--to", "mcap", "a.txt", "-o", "-"][..],
        &["export", "--to", "raw", "a.mcap", "-o", "-"],
        &["cut", "a.mcap", "--from", "1", "-o", "-"],
        &["cut", "a.txt", "--from", "1", "-o", "-"],
        &["export", "a.txt", "--to", "csv", "-o", "-"],
        &["export", "-o", "-", "a.txt", "--to", "jsonl"],
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
fn text_output_names_the_file() {
    let folder = scratch("names");
    let path = folder.join("a.txt");
    fs::write(&path, streams::clean(30)).unwrap();
    let (out, _) = expect(0, &["verify", path.to_str().unwrap()]);
    let name = Path::new(out.lines().next().unwrap().trim_end_matches(": good"));
    assert_eq!(name, path);
}

#[test]
fn part_outside_the_capture_is_an_error_without_output() {
    let folder = scratch("outside");
    let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    fs::write(file("a.txt"), streams::clean(570)).unwrap();
    expect(0, &["export", "--to", "mcap", &file("a.txt")]);
    let made = file("part");
    let (raw, mcap) = (file("a.txt"), file("a.mcap"));
    for (name, window) in [
        (&raw, ["--from", "5h"].as_slice()),
        (&raw, &["--from", "0", "--to", "1ms"]),
        (&mcap, &["--from", "5h"]),
    ] {
        let (_, err) = expect(2, &[&["cut", name, "-o", &made], window].concat());
        assert!(err.contains("is 3:"), "{err}");
        assert!(err.contains("nothing recorded between"), "{err}");
        assert!(!Path::new(&made).exists());
    }
    let wall = ["cut", &file("a.mcap"), "--from", "2099-01-01T00:00:00Z"];
    let (_, err) = expect(2, &wall);
    assert!(err.contains("nothing recorded between"), "{err}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 2);
}

#[test]
fn recording_to_dash_is_refused() {
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
        assert!(err.contains("watch LINK --headless"), "{err}");
    }
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 0);
}
