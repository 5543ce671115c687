//! Hostile text and files: no text controls the terminal or forges a line, no file blocks a command.
#![cfg(unix)]

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::os::unix::ffi::OsStrExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::SystemTime;

use groundwave::capture::runs::Label;
use groundwave::capture::runs::label::file_of;
use groundwave::capture::{Session, SessionWriter};
use groundwave::safe_text::is_control;
use serde_json::Value;

use crate::programs::{GROUNDWAVE, scratch};

/// A new title, a cleared screen by C0 and C1, a changed direction, and a separate line.
const HOSTILE: &str =
    "\u{1b}]0;x\u{7}\u{1b}[2J\u{9b}2J\r\u{7f}\u{202e}\u{2066}\u{61c}\u{200f}\u{2028}\nFORGED";

const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/demo-commands.mcap");
const CLEAN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");

/// The world of a straight corridor, the smallest built-in world.
const WORLD: &str = include_str!("../firmware/sim/worlds/corridor.toml");

fn run_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(GROUNDWAVE)
        .args(arguments)
        .current_dir(folder)
        .env("XDG_CONFIG_HOME", folder)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// Checks that the output of a command is safe text and, with `--json`, valid JSON; returns the output.
fn safe(folder: &Path, arguments: &[&str]) -> String {
    let Output { stdout, stderr, .. } = run_in(folder, arguments);
    let [out, err] = [stdout, stderr].map(|text| String::from_utf8(text).unwrap());
    let text = format!("{out}{err}");
    let is_forbidden = |c| is_control(c) && !matches!(c, '\n' | '\t');
    assert!(!text.contains(is_forbidden), "{arguments:?}: {text:?}");
    let is_forged = text
        .lines()
        .any(|line| line.trim_start().starts_with("FORGED"));
    assert!(!is_forged, "{arguments:?}: {text}");
    if arguments.contains(&"--json") {
        for line in out.lines() {
            assert!(
                serde_json::from_str::<Value>(line).is_ok(),
                "{arguments:?}: {line}"
            );
        }
    }
    text
}

/// A recording whose metadata, name and label are hostile.
fn recording(folder: &Path) -> String {
    let name = format!("a{HOSTILE}.mcap");
    let session = Session {
        link: HOSTILE.into(),
        start: SystemTime::UNIX_EPOCH,
        notes: [(HOSTILE.to_owned(), HOSTILE.to_owned())].into(),
        configuration: HOSTILE.into(),
    };
    let file = fs::File::create(folder.join(&name)).unwrap();
    let mut writer = SessionWriter::new(file, &session).unwrap();
    writer
        .handle_rx(1, &fs::read(CLEAN).unwrap()[..4000])
        .unwrap();
    writer.finish().unwrap();
    let mut label = Label {
        name: Some(HOSTILE.into()),
        void: Some(HOSTILE.into()),
        ..Label::default()
    };
    label.remark(Some(1.0), HOSTILE);
    label.keep(&folder.join(&name)).unwrap();
    name
}

#[test]
fn text_of_a_capture_reaches_the_terminal_without_controls() {
    let folder = scratch("hostile-capture");
    let name = &recording(&folder);
    for arguments in [
        &["info", name][..],
        &["info", "--json", name],
        &["runs"],
        &["runs", "--json"],
        &["label", name],
        &["label", "--json", name],
        &["compare", name, name],
        &["compare", "--json", name, name],
        &["verify", name],
        &["verify", "--json", name],
        &["songs", name],
        &["recover", name],
        &["recover", "--json", name],
        &["cut", name, "--from", "1s"],
        &["export", "--to", "raw", name],
        &["export", "--to", "raw", name],
        &["export", name, "--to", "csv"],
        &[],
    ] {
        let text = safe(&folder, arguments);
        assert!(
            text.contains("FORGED") || arguments.contains(&"songs"),
            "{arguments:?}: {text}"
        );
    }
    fs::write(folder.join(file_of(Path::new(name))), HOSTILE).unwrap();
    safe(&folder, &["label", name]);
    safe(&folder, &["runs"]);
    // An MCAP that is cut off, and text that is not a capture.
    let whole = fs::read(folder.join(name)).unwrap();
    fs::write(folder.join(name), &whole[..whole.len() / 2]).unwrap();
    for verb in ["info", "runs", "verify", "recover", "songs"] {
        safe(&folder, &[verb, name]);
    }
    fs::write(folder.join(name), HOSTILE).unwrap();
    for verb in ["info", "runs", "verify", "recover", "songs", "replay"] {
        safe(&folder, &[verb, name]);
    }
    safe(&folder, &["export", name, "--to", "mcap"]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn no_argument_reaches_the_terminal_as_a_control() {
    let folder = scratch("hostile-argument");
    for arguments in [
        &[HOSTILE][..],
        &["info", HOSTILE],
        &["info", "a", &format!("--{HOSTILE}")],
        &["export", "-o", "-", HOSTILE, "--to", HOSTILE],
        &["export", "-o", "-", HOSTILE, "--to", "csv"],
        &["cut", "a", "--from", HOSTILE],
        &["export", HOSTILE, "--to", "png"],
        &["compare", HOSTILE, HOSTILE],
        &["compare", CLEAN, CLEAN, "--svg", &format!("none/{HOSTILE}")],
        &["label", HOSTILE, "--name", HOSTILE],
        &["record", HOSTILE],
        &["record", "-", "-o", &format!("none/{HOSTILE}.mcap")],
        &["record", "-", "-o", HOSTILE],
        &["watch", HOSTILE, "--headless"],
        &[
            "watch",
            "-",
            "--headless",
            "--tee",
            &format!("none/{HOSTILE}"),
        ],
        &["watch", "-", "--headless", "--rotate", HOSTILE],
        &["send", HOSTILE, "stop"],
        &["send", "sim", HOSTILE],
        &["send", "sim", "route", HOSTILE],
        &["send", "sim", "-f", HOSTILE],
        &["send", "--via", HOSTILE, "stop"],
        &["param", "sim", "get", HOSTILE],
        &["calibrate", HOSTILE],
        &["sim", "--world", HOSTILE],
        &["sim", "--channel", HOSTILE],
        &[
            "sim",
            "--pty",
            HOSTILE,
            "--duration",
            "1s",
            "--time-factor",
            "100",
        ],
        &["sim", "--trace", &format!("none/{HOSTILE}")],
        &["sim", "--eeprom", &format!("none/{HOSTILE}")],
        &["world", HOSTILE],
        &["--config", HOSTILE, "ports"],
        &["--config", HOSTILE, "config", "path"],
        &["config", "check", HOSTILE],
        &["man", &format!("/dev/null/{HOSTILE}")],
        &["completions", HOSTILE],
        &["recover", HOSTILE],
        &["songs", CLEAN, "--wav", &format!("/dev/null/{HOSTILE}")],
    ] {
        safe(&folder, arguments);
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn no_text_file_reaches_the_terminal_as_a_control() {
    let folder = scratch("hostile-text");
    let quoted = HOSTILE.chars().fold(String::new(), |text, c| {
        text + &format!("\\U{:08x}", u32::from(c))
    });
    let quoted = &format!("\"{quoted}\"");
    let write = |text: &str| fs::write(folder.join("a.toml"), text).unwrap();
    let configurations = [
        format!("{quoted} = 1\n{HOSTILE}\n"),
        format!("{quoted} = 1\n"),
        format!("[link.{quoted}]\nport = {quoted}\n"),
        format!("[link.{quoted}]\n{quoted} = 1\nbaud = {quoted}\n"),
        format!("[robot.{quoted}]\nlink = {quoted}\n"),
        format!("[robot.{quoted}]\n"),
        format!("[dashboard]\ntheme = {quoted}\n"),
        format!("[recording]\nrotate = {quoted}\n"),
        format!("[link]\nshare = {quoted}\n"),
        format!("[keys]\n{quoted} = {quoted}\nscan = {quoted}\n"),
        format!("[keys.{quoted}]\nscan = 1\n"),
    ];
    for text in &configurations {
        write(text);
        safe(&folder, &["config", "check", "a.toml"]);
        safe(&folder, &["--config", "a.toml"]);
        safe(&folder, &["--config", "a.toml", "ports"]);
        safe(
            &folder,
            &["--config", "a.toml", "watch", HOSTILE, "--headless"],
        );
        safe(&folder, &["--config", "a.toml", "send", HOSTILE, "stop"]);
    }
    let (_, plan) = WORLD.split_once("cell_in").unwrap();
    for text in [
        &format!("name = {quoted}\nabout = {quoted}\ncell_in{plan}")[..],
        &format!("name = \"a\"\nabout = \"b\"\n{quoted} = 1\ncell_in{plan}"),
        &format!("name = \"a\"\nabout = \"b\"\n# \u{202e}\u{9b}2J\ncell_in{plan}"),
        &HOSTILE.replace('\n', ""),
    ] {
        write(text);
        for option in [None, Some("--check"), Some("--text")] {
            let arguments = ["world", "a.toml"].into_iter().chain(option);
            safe(&folder, &arguments.collect::<Vec<_>>());
        }
        safe(
            &folder,
            &[
                "sim",
                "--world",
                "a.toml",
                "--duration",
                "1s",
                "--time-factor",
                "100",
            ],
        );
    }
    write(HOSTILE);
    safe(&folder, &["send", "sim", "route", "a.toml"]);
    safe(&folder, &["send", "sim", "-f", "a.toml"]);
    write("goto 1 2\n");
    safe(&folder, &["send", "--dry-run", "-f", "a.toml"]);
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn no_answer_of_a_station_reaches_the_terminal_as_a_control() {
    let text = serde_json::to_string(HOSTILE).unwrap();
    let refused = format!(r#"{{"status":"refused","code":"bad-value","text":{text},"#);
    let failed = format!(r#"{{"status":"failed","code":{text},"text":{text},"#);
    let unknown = format!(r#"{{"status":{text},"code":{text},"text":{text},"#);
    let heard = r#""id":1,"heard":{"bytes":9,"lines":1}}"#;
    let folder = scratch("hostile-station");
    for answer in [
        format!("{refused}{heard}"),
        format!("{failed}{heard}"),
        format!("{unknown}{heard}"),
        format!(r#"{{"code":{text},"error":{text}}}"#),
        format!("{{\"lost\":{text}}}\n{refused}{heard}"),
    ] {
        for option in ["--timeout=5s", "--json"] {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            let address = listener.local_addr().unwrap().to_string();
            let answer = answer.clone();
            let text = text.clone();
            let station = thread::spawn(move || {
                let (mut socket, _) = listener.accept().unwrap();
                let mut lines = BufReader::new(socket.try_clone().unwrap()).lines();
                lines.next().unwrap().unwrap();
                writeln!(
                    socket,
                    r#"{{"groundwave":1,"link":{text},"can_send":true}}"#
                )
                .unwrap();
                lines.next().unwrap().unwrap();
                writeln!(socket, "{answer}").unwrap();
                // Until the client has closed the connection.
                let _ = lines.next();
            });
            let said = safe(
                &folder,
                &["send", "--via", &address, option, "mode", "prowl"],
            );
            assert!(said.contains("FORGED"), "{said}");
            station.join().unwrap();
        }
    }
    fs::remove_dir_all(folder).unwrap();
}

fn pipe(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status().unwrap();
    assert!(made.success());
}

/// No program ever writes into these pipes.
#[test]
fn a_named_pipe_stops_no_command() {
    let folder = scratch("pipes");
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    fs::copy(CLEAN, folder.join("a.csv")).unwrap();
    for name in ["x.mcap", "x.txt", "a.txt.run.toml", "x.toml"] {
        pipe(&folder.join(name));
    }
    let label = "cannot read a.txt.run.toml: it is not a regular file";
    let output = run_in(&folder, &["runs"]);
    assert!(String::from_utf8(output.stderr).unwrap().contains(label));
    for (arguments, told) in [
        (&["info", "x.mcap"][..], "it is a named pipe"),
        (&["info", "a.txt"], label),
        (&["label", "a.txt"], label),
        (&["label", "x.mcap"], "it is a named pipe"),
        (&["runs", "x.mcap"], "it is a named pipe"),
        (&["compare", "x.mcap", "a.txt"], "it is a named pipe"),
        (&["verify", "x.mcap"], "it is a named pipe"),
        (&["verify", SAMPLE, "--raw", "x.txt"], "it is a named pipe"),
        (&["recover", "x.mcap"], "it is a named pipe"),
        (&["recover", "."], "no interrupted recordings"),
        (
            &["export", "-o", "-", "x.txt", "--to", "csv"],
            "it is a named pipe",
        ),
        (&["songs", "x.txt"], "it is a named pipe"),
        (&["export", "--to", "mcap", "x.txt"], "it is a named pipe"),
        (&["send", "sim", "route", "x.txt"], "it is a named pipe"),
        (&["--config", "x.toml", "ports"], "it is a named pipe"),
        (&["world", "x.toml"], "it is not a regular file"),
        (
            &["export", "--to", "csv", "a.csv", "-o", "x.txt", "--force"],
            "no program reads this named pipe",
        ),
        (
            &["record", "sim", "-o", "x.txt", "--append"],
            "no program reads this named pipe",
        ),
        (&["sim", "--trace", "x.txt", "--force"], "is a named pipe"),
        (&["sim", "--eeprom", "x.txt"], "is a named pipe"),
    ] {
        let output = run_in(&folder, arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains(told), "{arguments:?}: {err}");
    }
    assert!(run_in(&folder, &[]).status.success());
    // A pipe that is given is read.
    let script = "cat a.txt | \"$0\" info /dev/stdin && cat a.txt | \"$0\" export - --to csv >&2";
    let output = Command::new("sh")
        .args(["-c", script, GROUNDWAVE])
        .current_dir(&folder)
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    fs::remove_dir_all(folder).unwrap();
}

/// A device may send bytes for ever, so no command reads it as a capture.
#[test]
fn a_device_is_not_read_as_a_capture() {
    let folder = scratch("devices");
    for arguments in [
        &["info", "/dev/zero"][..],
        &["verify", "/dev/zero"],
        &["verify", SAMPLE, "--raw", "/dev/zero"],
        &["runs", "/dev/zero"],
        &["compare", CLEAN, "/dev/zero"],
        &["export", "--to", "csv", "-o", "-", "/dev/zero"],
        &["export", "--to", "mcap", "/dev/zero", "-o", "a.mcap"],
        &["export", "--to", "raw", "/dev/zero", "-o", "a.txt"],
        &["cut", "/dev/zero", "--from", "1s", "-o", "a.txt"],
        &["songs", "/dev/zero"],
        &["label", "/dev/zero"],
        &["recover", "/dev/zero"],
    ] {
        let output = run_in(&folder, arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains("it is a device"), "{arguments:?}: {err}");
        assert!(err.contains("groundwave record"), "{arguments:?}: {err}");
        assert!(!output.status.success(), "{arguments:?}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_text_file_has_a_limit() {
    let folder = scratch("long");
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    let long = vec![b' '; 5 << 20];
    for name in ["long", "a.txt.run.toml"] {
        fs::write(folder.join(name), &long).unwrap();
    }
    let toml = "longer than 256 KiB";
    for (arguments, problem) in [
        (&["send", "sim", "route", "long"][..], "longer than 4 MiB"),
        (&["send", "sim", "-f", "long"], "longer than 4 MiB"),
        (&["config", "check", "long"], toml),
        (&["--config", "long", "ports"], toml),
        (&["world", "long"], toml),
        (&["label", "a.txt"], toml),
        (&["info", "a.txt"], toml),
    ] {
        let output = run_in(&folder, arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains(problem), "{arguments:?}: {err}");
        assert!(!output.status.success(), "{arguments:?}: {err}");
    }
    // A label comes with a capture of somebody else's.
    fs::write(folder.join("a.txt.run.toml"), &long[..300 << 10]).unwrap();
    for verb in ["label", "info", "runs"] {
        let output = run_in(&folder, &[verb, "a.txt"]);
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains("longer than 256 KiB"), "{verb}: {err}");
    }
    fs::remove_dir_all(folder).unwrap();
}

/// A mistake in a line of a megabyte is told in a line of a thousand characters.
#[test]
fn a_message_has_a_limit() {
    let folder = scratch("long-messages");
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    fs::write(folder.join("long"), "[".repeat(1 << 20)).unwrap();
    fs::write(folder.join("tables"), "[x]\n".repeat(1 << 17)).unwrap();
    fs::write(folder.join("a.txt.run.toml"), "[".repeat(200 << 10)).unwrap();
    for arguments in [
        &["send", "sim", "route", "long"][..],
        &["send", "sim", "-f", "long"],
        &["send", "--dry-run", "param", "load", "long"],
        &["config", "check", "long"],
        &["config", "check", "tables"],
        &["--config", "long", "ports"],
        &["world", "long"],
        &["label", "a.txt"],
        &["info", "a.txt"],
    ] {
        let output = run_in(&folder, arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        let is_short = err.lines().all(|line| line.chars().count() < 1100);
        assert!(is_short && err.lines().count() < 110, "{arguments:?}");
        assert!(!output.status.success(), "{arguments:?}: {err}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn a_name_that_is_not_utf_8_is_listed() {
    let folder = scratch("names");
    let name = OsStr::from_bytes(b"a\xff.txt");
    if fs::copy(CLEAN, folder.join(name)).is_err() {
        return; // Not every file system has such names.
    }
    for arguments in [
        &["runs"][..],
        &["info", "*.txt"],
        &["info", "../names-*/*.txt"],
    ] {
        let output = run_in(&folder, arguments);
        let out = String::from_utf8(output.stdout).unwrap();
        assert!(out.contains("a\u{fffd}.txt"), "{arguments:?}: {out}");
    }
    fs::remove_dir_all(folder).unwrap();
}

/// Links to the folder above make a folder of endless depth.
#[test]
fn a_pattern_enters_no_linked_folder() {
    let folder = scratch("loops");
    fs::create_dir_all(folder.join("a/b")).unwrap();
    fs::copy(CLEAN, folder.join("a/b/c.txt")).unwrap();
    fs::copy(CLEAN, folder.join("a/d.txt")).unwrap();
    fs::write(folder.join("e.txt.toml"), "").unwrap();
    for link in ["a/up", "a/b/up", "a/b/again"] {
        std::os::unix::fs::symlink("..", folder.join(link)).unwrap();
    }
    std::os::unix::fs::symlink("self", folder.join("self")).unwrap();
    std::os::unix::fs::symlink("a/b", folder.join("named")).unwrap();
    for (pattern, found) in [
        ("**/*.txt", &["a/b/c.txt", "a/d.txt"][..]),
        ("**/**/?.t*t", &["a/b/c.txt", "a/d.txt"]),
        ("./a/[!x].txt", &["./a/d.txt"]),
        ("a/up/a/*.txt", &["a/up/a/d.txt"]),
        ("n*/*.txt", &["named/c.txt"]),
    ] {
        let out = safe(&folder, &["verify", "--json", pattern]);
        let files: Vec<_> = out
            .lines()
            .map(|line| serde_json::from_str::<Value>(line).unwrap()["file"].to_string())
            .collect();
        let found: Vec<_> = found.iter().map(|name| format!("\"{name}\"")).collect();
        assert_eq!(files, found, "{pattern}: {out}");
    }
    for pattern in ["***/x", "a[", "**x"] {
        let output = run_in(&folder, &["info", pattern]);
        assert_eq!(output.status.code(), Some(2), "{pattern}");
    }
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn no_output_is_written_over_a_label() {
    let folder = scratch("labels");
    fs::copy(CLEAN, folder.join("a.txt")).unwrap();
    let label = folder.join("a.txt.run.toml");
    fs::write(&label, "name = \"x\"\n").unwrap();
    for command in [
        "cut a.txt --from 1s -o a.txt.run.toml --force",
        "export a.txt --to svg -o a.txt.run.toml --force",
        "record sim --duration 1s -o b.mcap.run.toml",
        "sim --duration 1s --trace a.txt.run.toml --force",
    ] {
        let arguments: Vec<_> = command.split(' ').collect();
        let output = run_in(&folder, &arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}: {err}");
        assert!(err.contains("choose another name"), "{command}: {err}");
    }
    assert_eq!(fs::read_to_string(&label).unwrap(), "name = \"x\"\n");
    fs::remove_dir_all(folder).unwrap();
}

#[test]
fn no_output_is_written_over_an_input_or_another_output() {
    let folder = scratch("same");
    let at = |name: &str| -> PathBuf { folder.join(name) };
    fs::copy(CLEAN, at("a.txt")).unwrap();
    fs::hard_link(at("a.txt"), at("linked.svg")).unwrap();
    std::os::unix::fs::symlink("a.txt", at("pointing.svg")).unwrap();
    fs::write(at("w.toml"), WORLD).unwrap();
    fs::hard_link(at("w.toml"), at("w.svg")).unwrap();
    fs::write(at("c.toml"), "").unwrap();
    fs::write(at("t.csv"), "").unwrap();
    fs::hard_link(at("t.csv"), at("t.wav")).unwrap();
    let songs = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/demo-commands.mcap");
    fs::create_dir(at("songs")).unwrap();
    fs::copy(songs, at("songs/song-01.wav")).unwrap();
    let before = fs::read(at("a.txt")).unwrap();
    for arguments in [
        &["compare", "a.txt", CLEAN, "--svg", "a.txt", "--force"][..],
        &["compare", CLEAN, "a.txt", "--svg", "linked.svg", "--force"],
        &[
            "compare",
            "a.txt",
            CLEAN,
            "--svg",
            "pointing.svg",
            "--force",
        ],
        &[
            "export",
            "a.txt",
            "--to",
            "svg",
            "-o",
            "linked.svg",
            "--force",
        ],
        &[
            "export",
            "--to",
            "mcap",
            "a.txt",
            "-o",
            "pointing.svg",
            "--force",
        ],
        &[
            "cut",
            "a.txt",
            "--from",
            "1s",
            "-o",
            "linked.svg",
            "--force",
        ],
        &["world", "w.toml", "--svg", "w.toml", "--force"],
        &["world", "w.toml", "--svg", "w.svg", "--force"],
        &["songs", "songs/song-01.wav", "--wav", "songs", "--force"],
        &["sim", "--world", "w.toml", "--trace", "w.svg", "--force"],
        &["sim", "--trace", "x", "--wav", "x"],
        &["sim", "--trace", "x", "--wav", "./x", "--force"],
        &["sim", "--trace", "t.csv", "--wav", "t.wav", "--force"],
        &["sim", "--trace", "x", "--eeprom", "x"],
        &[
            "--config", "c.toml", "record", "sim", "-o", "c.toml", "--force",
        ],
        &[
            "watch",
            "sim",
            "--headless",
            "--tee",
            "t.csv",
            "--record",
            "t.wav",
            "--force",
        ],
    ] {
        let output = run_in(&folder, arguments);
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {err}");
        assert!(
            err.contains("different") || err.contains("choose another name"),
            "{err}"
        );
    }
    let script = "\"$0\" record - -o a.txt --force < a.txt";
    let output = Command::new("sh")
        .args(["-c", script, GROUNDWAVE])
        .current_dir(&folder)
        .output();
    assert_eq!(output.unwrap().status.code(), Some(2));
    assert!(fs::read(at("a.txt")).unwrap() == before);
    assert_eq!(fs::read_to_string(at("w.toml")).unwrap(), WORLD);
    assert!(!at("x").exists());
    fs::remove_dir_all(folder).unwrap();
}
