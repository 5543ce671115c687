//! Error messages of all commands: what failed, why, what to do, and the exit code.
#![cfg(unix)]

use std::fs;
use std::process::{Command, Stdio};

use crate::programs::{GROUNDWAVE, scratch};

const CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/demo-commands.mcap");
const NO_FILE: &str = "file not found; check the path";
const IS_FOLDER: &str = "it is a folder; name a file in it";
const NO_LINE: &str = "no line found in 6 bytes; the file is not a capture";

/// Exit code, arguments, and a part of the message.
#[rustfmt::skip]
const CASES: &[(i32, &[&str], &str)] = &[
    (2, &["info", "gone"], NO_FILE),
    (2, &["info", "."], IS_FOLDER),
    (2, &["info", "a.txt"], NO_LINE),
    (2, &["info", "empty.txt"], "in 0 bytes; the file is not a capture"),
    (2, &["info", "no*such.mcap"], "no file matches"),
    (2, &["export", "-o", "-", "gone", "--to", "csv"], NO_FILE),
    (2, &["export", "-o", "-", "a.txt", "--to", "jsonl"], NO_LINE),
    (2, &["export", "-o", "-", "a.txt", "--to", "xml"], "possible values: csv, jsonl"),
    (2, &["export", "--to", "mcap", "gone"], NO_FILE),
    (1, &["export", "--to", "raw", CAPTURE, "--output-dir", "a.txt"], "a file with that name exists; choose another"),
    (2, &["export", "--to", "raw", CAPTURE, "-o", "."], "is a folder; name a file in it"),
    (2, &["export", "--to", "mcap", CAPTURE, "--start", "noon"], "is not a time; try 90s"),
    (2, &["export", "--to", "mcap", CAPTURE, "-o", "-"], "is MCAP already; `groundwave cut` makes a part of it"),
    (2, &["export", "--to", "csv", CAPTURE, "--anyway"], "--start and --anyway are for --to mcap"),
    (2, &["verify", "gone"], NO_FILE),
    (2, &["verify", CAPTURE, "--raw", "gone"], NO_FILE),
    (2, &["songs", "."], IS_FOLDER),
    (2, &["map", "gone", "-o", "a.yaml"], NO_FILE),
    (2, &["map", CAPTURE, "-o", "a.pgm"], "a map is a YAML file and an image beside it"),
    (2, &["export", "a.txt", "--to", "svg"], "there is nothing to draw"),
    (2, &["cut", CAPTURE, "--from", "x"], "is not a time; try 90s"),
    (2, &["cut", CAPTURE, "--from", "2m", "--to", "1m"], "--from must be before --to"),
    (1, &["cut", CAPTURE, "--from", "1s", "-o", "gone/a.mcap"], "create the folder first"),
    (2, &["replay", CAPTURE, "--speed", "fast"], "`fast` is not a number; write 10 or 0.5"),
    (2, &["replay", CAPTURE], "needs a terminal"),
    (2, &["demo"], "use `groundwave sim` instead"),
    (2, &["watch", "sim"], "use `groundwave watch --headless` instead"),
    (2, &["recover", "gone"], NO_FILE),
    (1, &["recover", "a.txt"], "no part of a Groundwave recording"),
    (2, &["label", "gone"], NO_FILE),
    (2, &["label", "."], IS_FOLDER),
    (2, &["compare", CAPTURE, "gone"], NO_FILE),
    (2, &["runs", "gone"], NO_FILE),
    (4, &["send", "trillian", "stop"], "[robot.trillian]"),
    (4, &["watch", "trillian", "--headless"], "`groundwave ports` lists the devices"),
    (4, &["send", "/dev/gone", "stop"], "`groundwave ports` lists what is plugged in"),
    (4, &["send", "./", "stop"], "it is not a serial device"),
    (4, &["record", "a.txt"], "a capture is shown with `groundwave replay"),
    (4, &["send", "tcp:127.0.0.1:1", "stop"], "Is the serial server running"),
    (2, &["send", "tcp:localhost", "stop"], "try tcp:localhost:4000"),
    (4, &["send", "usb:1:2", "stop"], "`groundwave ports` lists those that are"),
    (4, &["send", "--via", "./gone", "stop"], "Start one that shares its link"),
    (6, &["send", "-", "stop"], "--via ADDR"),
    (6, &["send", "sim", "--no-uplink", "stop"], "--via ADDR"),
    (2, &["send", "sim", "route", "gone"], NO_FILE),
    (2, &["send", "sim", "route", "bad.csv"], "bad.csv:2:1: `3;4` is not two numbers with a comma"),
    (2, &["send", "sim", "-f", "gone"], NO_FILE),
    (2, &["send", "sim", "-f", "."], IS_FOLDER),
    (2, &["send", "sim", "goto", "1", "x"], "whole number of inches from"),
    (2, &["send", "sim", "enable", "sonr"], "did you mean `sonar`?"),
    (2, &["param", "sim", "set", "top-sped", "8"], "did you mean `top-speed`?"),
    (2, &["param", "sim", "get", "top-sped"], "write `'=top-sped'`"),
    (2, &["send", "sim", "route", "a", "b.csv"], "quote a name with spaces"),
    (2, &["send", "sim", "--timeout", "soon", "stop"], "is not a duration; write 30s"),
    (2, &["send", "sim", "--baud", "fast", "stop"], "`fast` is not a baud rate; write a number such as 2400"),
    (2, &["calibrate", "sim", "--side", "10"], "10 is not in 40..=400"),
    (2, &["record", "sim", "--duration", "0"], "is not a duration; write 30s"),
    (1, &["record", "sim", "-o", "gone/a.mcap", "--duration", "1s"], "create the folder first"),
    (2, &["record", "sim", "-o", "a.txt", "--duration", "1s"], "give --force to replace it"),
    (2, &["record", "sim", "-o", ".", "--duration", "1s"], "name a file in it"),
    (1, &["watch", "sim", "--headless", "--share", "gone/a.mcap"], "make the folder first"),
    (2, &["watch", "sim", "--headless", "--share", "99999"], "neither a port (4001)"),
    (2, &["watch", "sim", "--headless", "--share", "host"], "nor a Unix socket (station.sock"),
    (2, &["watch", "sim", "--headless", "--rotate", "5x"], "a size such as 64MB"),
    (2, &["sim", "--world", "huose"], "a built-in world (house"),
    (2, &["sim", "--channel", "ber=2"], "like ber=1e-3"),
    (2, &["sim", "--listen", "127.0.0.1:99999"], "choose another address"),
    (2, &["sim", "--time-factor", "0"], "choose one from 0.01"),
    (2, &["sim", "--time-factor", "1e-308"], "choose one from 0.01"),
    (2, &["sim", "--time-factor", "nan"], "choose one from 0.01"),
    (2, &["sim", "--seed", "-1"], "write a whole number such as 7"),
    (2, &["world", "house", "--svg", "."], "is a folder; name a file in it"),
    (2, &["--config", "gone", "ports"], "makes a file to start from"),
    (2, &["config", "check", "gone"], "makes a file to start from"),
    (2, &["completions", "tcsh"], "possible values: bash"),
    (1, &["man", "a.txt"], "a file has the name of the folder"),
    (2, &["wach", "sim"], "a similar subcommand exists: 'watch'"),
    (2, &["watch", "sim", "--duration", "5s"], "--duration is an option of `record`"),
    (2, &["export", CAPTURE, "--from", "1m"], "--from is an option of `cut`"),
    (2, &["watch", "sim", "--headles"], "a similar argument exists: '--headless'"),
];

#[test]
fn errors_have_a_hint_and_the_right_exit_code() {
    let folder = scratch("hints");
    for (name, text) in [
        ("a.txt", "hello\n"),
        ("empty.txt", ""),
        ("bad.csv", "1,2\n3;4\n"),
    ] {
        fs::write(folder.join(name), text).unwrap();
    }
    for (code, words, told) in CASES {
        let output = Command::new(GROUNDWAVE)
            .args(*words)
            .current_dir(&folder)
            .stdin(Stdio::null())
            .output()
            .unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(!said.contains("os error"), "{said}");
        assert_eq!(output.status.code(), Some(*code), "{words:?}: {said}");
        assert!(said.contains(told), "{words:?}: {said}");
        let lines: Vec<&str> = said.lines().collect();
        let is_said_twice = lines.windows(2).any(|pair| pair[0] == pair[1]);
        assert!(!is_said_twice, "{words:?}: {said}");
    }
}
