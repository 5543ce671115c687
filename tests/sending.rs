//! `send` in scripts: dry runs, commands from a file or a pipe, and the line at fault.
#![cfg(unix)]

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, groundwave, path_in, scratch};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::{Key, Message, Order, Slots};
use groundwave_protocol::digest::digest;
use groundwave_protocol::status_codes::Mode;
use serde_json::Value;

/// The key of the frames that `--dry-run` prints.
const KEY: Key = Key::session(7, 1, 1, 677);

fn frame(message: &Message) -> String {
    String::from_utf8(message.encode(KEY).as_bytes().to_vec()).unwrap()
}

fn command(sequence: u8, order: Order) -> String {
    let command = groundwave_protocol::command::Command { sequence, order };
    frame(&Message::Command(command))
}

fn json_lines(text: &str) -> Vec<Value> {
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap())
        .collect()
}

fn script(name: &str, text: &str) -> PathBuf {
    let path = scratch(name).join("evening.txt");
    fs::write(&path, text).unwrap();
    path
}

fn with_input(arguments: &[&str], input: &str) -> Output {
    let mut child = Command::new(GROUNDWAVE)
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    stdin.write_all(input.as_bytes()).unwrap();
    drop(stdin);
    child.wait_with_output().unwrap()
}

/// The frame of the test vector with this name.
fn vector(about: &str) -> String {
    let vectors = concat!(
        include_str!("../protocol/vectors/frames.jsonl"),
        include_str!("../protocol/vectors/frames-3.jsonl"),
    );
    let found = json_lines(vectors)
        .into_iter()
        .find(|vector| vector["about"] == about);
    found.unwrap()["frame"].as_str().unwrap().to_owned()
}

#[test]
fn dry_run_prints_frames_without_opening_a_link() {
    // Opening this link would give exit code 4.
    let (out, err) = expect(
        0,
        &[
            "send",
            "/dev/nowhere",
            "--dry-run",
            "--json",
            "mode",
            "prowl",
        ],
    );
    assert_eq!(err, "");
    let [told] = &json_lines(&out)[..] else {
        panic!("{out}");
    };
    assert_eq!(told["command"], "mode prowl");
    assert_eq!(
        told["opening"],
        vector("open with an era, the first session after a boot")
    );
    assert_eq!(
        told["frames"],
        serde_json::json!([command(1, Order::Mode(Mode::Prowl))])
    );
    assert_eq!(told["bytes"], 23);
    assert_eq!(told["at_least_s"], 0.213);
    let at_300 = [
        "send",
        "--dry-run",
        "--baud",
        "300",
        "--json",
        "mode",
        "prowl",
    ];
    let (out, _) = expect(0, &at_300);
    assert_eq!(json_lines(&out)[0]["at_least_s"], 1.7);
    let (out, _) = expect(0, &["send", "--dry-run", "stop"]);
    let stop = vector("STOP with a receipt").replace('\n', "\\n");
    assert!(out.contains(&format!("10 bytes  {stop}\n")), "{out}");
    assert!(
        out.contains("stop: 10 bytes, at least 0.10 s") && out.contains("Nothing was sent."),
        "{out}"
    );
}

#[test]
fn dry_run_of_a_route_matches_the_encoders() {
    let route = scratch("dry-route").join("route.txt");
    let waypoints: Vec<Waypoint> = (0..37).map(|n| Waypoint { x_in: n, y_in: -n }).collect();
    let rows: Vec<String> = waypoints
        .iter()
        .map(|waypoint| format!("{},{}", waypoint.x_in, waypoint.y_in))
        .collect();
    let text = rows.join("\n");
    fs::write(&route, text).unwrap();
    let arguments = ["send", "--dry-run", "--json", "--go", "route"];
    let (out, _) = expect(0, &[&arguments[..], &[route.to_str().unwrap()]].concat());
    let [list, go] = &json_lines(&out)[..] else {
        panic!("{out}");
    };
    let slots = |block, range: std::ops::Range<usize>| {
        frame(&Message::Waypoints(Slots::new(1, block, &waypoints[range])))
    };
    let activate = Order::Activate {
        tag: 1,
        count: 37,
        digest: digest(waypoints.iter()),
    };
    let expected = [
        slots(0, 0..16),
        slots(4, 16..32),
        slots(8, 32..37),
        command(1, activate),
    ];
    assert_eq!(list["frames"], serde_json::json!(expected));
    let bytes: usize = expected.iter().map(String::len).sum();
    assert_eq!(list["bytes"], bytes + 13, "a request for a session too");
    assert_eq!(go["opening"], Value::Null);
    assert_eq!(
        go["frames"],
        serde_json::json!([command(2, Order::Mode(Mode::Prowl))])
    );
}

#[test]
fn dry_run_and_send_refuse_the_same_words() {
    for wrong in [
        &["fly"][..],
        &["goto", "1"],
        &["failsafe", "home", "3s"],
        &["stop", "--go"],
        &["route", "/nowhere/route.txt"],
        &[],
    ] {
        let without = groundwave(&[&["send", "/dev/nowhere"], wrong].concat());
        let with = groundwave(&[&["send", "/dev/nowhere", "--dry-run"], wrong].concat());
        assert_eq!(with.status.code(), Some(2), "{wrong:?}");
        assert_eq!(without.status.code(), Some(2), "{wrong:?}");
        assert_eq!(with.stdout, b"", "{wrong:?}");
    }
    let path = script("dry-script", "\u{feff}stop\n# a remark\n\nfly\n");
    let path = path.to_str().unwrap();
    let (_, err) = expect(2, &["send", "--dry-run", "-f", path]);
    assert!(
        err.contains("evening.txt:4: unknown command `fly`"),
        "{err}"
    );
    expect(2, &["send", "tcp:", "--dry-run", "stop"]);
}

#[test]
fn script_lines_take_quoted_names_and_comments() {
    let route = scratch("quoted-route").join("a #1 b.csv");
    fs::write(&route, "12,8\n").unwrap();
    let route = route.to_str().unwrap();
    let lines = format!("route \"{route}\" # the cat's\nstop # it's\n");
    let path = script("quoted-script", &lines);
    let path = path.to_str().unwrap();
    expect(0, &["send", "--dry-run", "-f", path]);
    let path = script("quoted-script", "route 'a b\n");
    let (_, err) = expect(2, &["send", "--dry-run", "-f", path.to_str().unwrap()]);
    assert!(err.contains(":1: a quote is not closed"), "{err}");
}

#[test]
fn failed_script_names_the_line_and_the_commands_not_sent() {
    let sim = Sim::start(&["--seed", "5"]);
    let path = script(
        "script-fails",
        "# sit still\nmode reactive\n\ndock # refused\nmode prowl\ngoto 3 4\n",
    );
    let path = path.to_str().unwrap();
    let (out, err) = expect(5, &["send", &sim.path, "-f", path, "--go"]);
    assert!(
        out.starts_with("mode reactive: confirmed") && out.lines().count() == 1,
        "{out}"
    );
    assert!(
        err.contains("evening.txt:4: the robot refused `mode dock`")
            && err.contains("the 3 commands after it were not sent"),
        "{err}"
    );
    let (out, _) = expect(5, &["send", &sim.path, "-f", path, "--go", "--json"]);
    let steps: Vec<(String, u64, String)> = json_lines(&out)
        .iter()
        .map(|step| {
            (
                step["command"].as_str().unwrap().to_owned(),
                step["line"].as_u64().unwrap(),
                step["status"].as_str().unwrap().to_owned(),
            )
        })
        .collect();
    let ends: Vec<_> = steps.iter().filter(|step| step.2 != "sent").collect();
    let expected = [
        ("mode reactive", 2, "queued"),
        ("mode reactive", 2, "confirmed"),
        ("mode dock", 4, "queued"),
        ("mode dock", 4, "refused"),
    ];
    assert_eq!(
        ends,
        expected
            .map(|(c, n, s)| (c.to_owned(), n, s.to_owned()))
            .iter()
            .collect::<Vec<_>>()
    );
    // Whether `dock` is sent depends on whether the robot's abilities (line I) come before it.
    assert!(
        steps.contains(&("mode reactive".to_owned(), 2, "sent".to_owned())),
        "{out}"
    );
}

#[test]
fn script_is_read_from_standard_input() {
    let sim = Sim::start(&["--seed", "6"]);
    let arguments = ["send", &sim.path, "-f", "-", "--go", "--json"];
    let output = with_input(&arguments, "mode reactive\ngoto 12 -5\n");
    let out = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(0), "{out}");
    let confirmed: Vec<String> = json_lines(&out)
        .iter()
        .filter(|step| step["status"] == "confirmed")
        .map(|step| format!("{} {}", step["line"], step["command"].as_str().unwrap()))
        .collect();
    assert_eq!(
        confirmed,
        ["1 mode reactive", "2 goto 12 -5", "2 mode prowl"]
    );
    let output = with_input(&["send", &sim.path, "-f", "-"], "dock\nstop\n");
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(5), "{err}");
    assert!(
        err.contains("standard input:1: ") && err.contains("`stop` was not sent"),
        "{err}"
    );
    // Standard input cannot be both the script and a route.
    let output = with_input(&["send", "--dry-run", "-f", "-"], "route -\n1,2\n");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn timeout_is_reported_in_json() {
    let sim = Sim::start(&["--channel", "out=0s..10000s"]);
    let path = script("script-late", "\nmode prowl\nstop\n");
    let path = path.to_str().unwrap();
    let arguments = ["send", &sim.path, "-f", path, "--json", "--timeout", "1s"];
    let (out, err) = expect(3, &arguments);
    let last = json_lines(&out).pop().unwrap();
    assert_eq!(
        (&last["status"], &last["code"], &last["line"]),
        (&"failed".into(), &"timed-out".into(), &2.into())
    );
    assert!(
        err.contains("evening.txt:2: `mode prowl` was not confirmed")
            && err.contains("`stop` was not sent"),
        "{err}"
    );
}

#[test]
fn script_over_a_shared_link_stops_at_the_first_failure() {
    let folder = scratch("via-script");
    let socket = folder.join("x.sock");
    let socket = socket.to_str().unwrap();
    let sim = Sim::start(&["--seed", "7"]);
    let mut station = Telling::start(&["watch", &sim.path, "--headless", "--share", socket]);
    station.wait_for("a line of the robot", |said| said["event"] == "line");
    let path = script("via-evening", "mode reactive\ndock\nmode prowl\n");
    let arguments = [
        "send",
        "--via",
        socket,
        "-f",
        path.to_str().unwrap(),
        "--json",
    ];
    let (out, err) = expect(5, &arguments);
    let last = json_lines(&out).pop().unwrap();
    assert_eq!(
        (&last["status"], &last["command"], &last["line"]),
        (&"refused".into(), &"mode dock".into(), &2.into())
    );
    assert!(
        err.contains("evening.txt:2: ") && err.contains("`mode prowl` was not sent"),
        "{err}"
    );
}

/// A script waits for a drive to end and checks the result, over its own link and through a station that shares its link.
#[test]
fn scripts_wait_and_check() {
    let folder = scratch("waits");
    let script = path_in(&folder, "run.txt");
    fs::write(
        &script,
        "wait until mode prowl within 1m\ngoto 0 24\nmode prowl\nwait until driven within 5m\nmode passive\n\
         wait until stopped within 1m\nexpect mode passive\nwait 10ms\nexpect battery < 3\nstop\n",
    )
    .unwrap();
    let socket = path_in(&folder, "s");
    let robot = || {
        Sim::start(&[
            "--listen",
            "127.0.0.1:0",
            "--time-factor",
            "20",
            "--world",
            "open-room",
        ])
    };
    let (own, shared) = (robot(), robot());
    let mut station = Telling::start(&["watch", &shared.path, "--headless", "--share", &socket]);
    station.wait_for("a line", |value| value["event"] == "line");
    for link in [&[&*own.path][..], &["--via", &socket]] {
        let arguments = [&["send"], link, &["-f", &script]].concat();
        let (out, err) = expect(3, &arguments);
        assert!(out.contains("wait until driven within 5m: after"), "{out}");
        assert!(
            err.contains(":9: `expect battery < 3`: battery_v 1"),
            "{err}"
        );
        assert!(err.contains("`stop` was not sent"), "{err}");
    }
}
