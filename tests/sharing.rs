//! Several programs on one radio: exit codes, raw bytes, tokens, crowds and idle clients.
#![cfg(unix)]

use std::collections::VecDeque;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::programs::{
    GROUNDWAVE, Running, Sim, Telling, expect, groundwave, is_stage, long_route, path_in, scratch,
};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

/// A headless station that shares its link.
pub fn station(link: &str, socket: &str, more: &[&str]) -> Telling {
    let arguments = [&["watch", link, "--headless", "--share", socket], more].concat();
    let mut station = Telling::start(&arguments);
    station.wait_for("that it shares", |value| {
        value["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("shared on "))
    });
    station.wait_for("a line", |value| value["event"] == "line");
    station
}

#[test]
fn killed_share_server_leaves_no_obstacle() {
    let folder = scratch("killed-share");
    let route = long_route(&folder);
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let first = station(&sim.path, &socket, &[]);
    let mut sender = Telling::start(&["send", "--via", &socket, "route", &route, "--json"]);
    sender.wait_for("progress", is_stage("progress"));
    drop(first);
    assert_eq!(sender.process.0.wait().unwrap().code(), Some(3));
    assert!(Path::new(&socket).exists(), "nobody could remove it");
    let _second = station(&sim.path, &socket, &[]);
    expect(0, &["send", "--via", &socket, "route", &route]);
}

#[test]
fn commands_of_two_senders_are_confirmed_one_after_the_other() {
    let folder = scratch("two");
    let route = long_route(&folder);
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let mut senders = [
        Telling::start(&["send", "--via", &socket, "route", &route, "--json"]),
        Telling::start(&["send", "--via", &socket, "mode", "reactive", "--json"]),
    ];
    for sender in &mut senders {
        sender.wait_for("the confirmation", is_stage("confirmed"));
        assert_eq!(sender.process.0.wait().unwrap().code(), Some(0));
    }
    for id in [1, 2] {
        station.wait_for("the confirmation", |value| {
            value["id"] == id && value["status"] == "confirmed"
        });
        let asked = station.wait_for("who asked", |value| {
            value["status"] == "queued" && value["id"] == id
        });
        let by = asked["by"].as_str().unwrap();
        assert!(by.starts_with("pid "), "{by}");
    }
    let sent: Vec<i64> = station
        .said
        .iter()
        .filter(|value| value["event"] == "command" && value["status"] != "queued")
        .map(|value| value["id"].as_i64().unwrap())
        .collect();
    assert!(sent.is_sorted(), "the second waits for the first: {sent:?}");
}

/// A second dashboard knows the commands of the station's operator and its other clients, but each of its own once.
#[test]
fn a_client_is_told_of_the_commands_of_others() {
    let folder = scratch("others");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let mut second = Telling::start(&["watch", "--via", &socket, "--headless"]);
    second.wait_for("a line", |value| value["event"] == "line");
    for (words, command) in [
        (&["mode", "reactive"][..], "mode reactive"),
        (&["stop"], "stop"),
    ] {
        let (said, _) = expect(
            0,
            &[&["send", "--via", &socket][..], words, &["--json"]].concat(),
        );
        let queued = said.lines().filter(|line| line.contains("\"queued\""));
        assert_eq!(queued.count(), 1, "{said}");
        for program in [&mut station, &mut second] {
            let asked = program.wait_for("the command", |value| value["command"] == command);
            assert!(asked["by"].as_str().unwrap().starts_with("pid "), "{asked}");
            program.wait_for("its end", |value| {
                value["id"] == asked["id"] && value["status"] == "confirmed"
            });
        }
    }
}

#[test]
fn stop_overtakes_queued_commands() {
    let folder = scratch("overtake");
    let route = long_route(&folder);
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &[]);
    let mut sender = Telling::start(&["send", "--via", &socket, "route", &route, "--json"]);
    sender.wait_for("progress", is_stage("progress"));
    expect(0, &["send", "--via", &socket, "stop"]);
    let failed = sender.wait_for("its end", is_stage("failed"));
    assert_eq!(failed["code"], "stopped");
    assert_eq!(sender.process.0.wait().unwrap().code(), Some(1));
}

#[test]
fn command_outlives_its_client() {
    let folder = scratch("vanish");
    let route = long_route(&folder);
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let mut sender = Telling::start(&["send", "--via", &socket, "route", &route, "--json"]);
    sender.wait_for("progress", is_stage("progress"));
    drop(sender);
    station.wait_for("the confirmation", is_stage("confirmed"));
}

#[test]
fn exit_codes_over_a_shared_link_are_those_of_an_own_link() {
    let folder = scratch("codes");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&["--seed", "5"]);
    let station = station(&sim.path, &socket, &[]);
    let (out, _) = expect(0, &["send", "--via", &socket, "mode", "reactive"]);
    assert!(out.starts_with("mode reactive: confirmed after"), "{out}");
    let (_, err) = expect(5, &["send", "--via", &socket, "dock"]);
    assert!(
        err.contains("refused `mode dock`: it has no dock sensor"),
        "{err}"
    );
    expect(2, &["send", "--via", &socket, "fly"]);
    let (_, err) = expect(4, &["send", &sim.path, "stop"]);
    assert!(err.contains("busy") && err.contains("--via"), "{err}");
    drop(sim);
    let arguments = ["send", "--via", &socket, "mode", "prowl", "--timeout", "1s"];
    let (_, err) = expect(3, &arguments);
    assert!(err.contains("not confirmed within 1.0 s"), "{err}");
    drop(station);
    let (_, err) = expect(4, &["send", "--via", &socket, "stop"]);
    assert!(err.contains("cannot reach a station at"), "{err}");
}

/// An answer to an alarm is known to the station and to every program on its link, with the begin of the alarm; only the station runs the hook.
#[test]
fn an_alarm_is_answered_for_all_programs_on_the_link() {
    let folder = scratch("answers");
    let (socket, told) = (path_in(&folder, "s"), folder.join("told.json"));
    let config = folder.join("config.toml");
    let text = format!(
        "[limits]\nbattery_low_dv = 250\nbattery_for_s = 0\n[alarms]\nrun = \"cat >> {}\"\n",
        told.display()
    );
    fs::write(&config, text).unwrap();
    let config = config.to_str().unwrap();
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &["--config", config]);
    let mut second = Telling::start(&["watch", "--via", &socket, "--headless", "--config", config]);
    let begins = |value: &Value| value["code"] == "battery_low" && value["status"] == "begun";
    let begun = [&mut station, &mut second].map(|it| it.wait_for("the alarm", begins));
    let mut client = UnixStream::connect(&socket).unwrap();
    client
        .write_all(b"{\"groundwave\":1}\n{\"alarm\":\"battery_low\",\"answer\":\"acknowledged\"}\n")
        .unwrap();
    for (it, begun) in [&mut station, &mut second].into_iter().zip(begun) {
        let answered = it.wait_for("the answer", |value| value["status"] == "acknowledged");
        assert_eq!(answered["code"], "battery_low");
        assert_eq!(answered["begin_s"], begun["begin_s"]);
        assert!(
            answered["by"].as_str().unwrap().starts_with("pid "),
            "{answered}"
        );
    }
    client
        .write_all(b"{\"alarm\":\"battery_low\",\"answer\":{\"shelved_s\":600}}\n")
        .unwrap();
    station.wait_for("the shelving", |value| value["status"] == "shelved");
    let mut third = Telling::start(&["watch", "--via", &socket, "--headless", "--config", config]);
    let mut shelvings = 0;
    third.wait_for("a line", |value| {
        shelvings += u32::from(value["status"] == "shelved");
        value["event"] == "line"
    });
    assert_eq!(shelvings, 1, "told once to a program that comes later");
    for it in [station, second] {
        let mut process = it.process;
        kill_process(Pid::from_child(&process.0), Signal::TERM).unwrap();
        assert!(process.0.wait().unwrap().success());
    }
    let told = fs::read_to_string(&told).unwrap();
    let statuses = told
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).unwrap());
    let statuses: Vec<_> = statuses.map(|event| event["status"].clone()).collect();
    assert_eq!(
        statuses,
        ["begun", "acknowledged", "shelved"],
        "by the station alone"
    );
}

#[test]
fn receive_only_station_refuses_commands() {
    let folder = scratch("listens");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &["--no-uplink"]);
    let (_, err) = expect(6, &["send", "--via", &socket, "stop"]);
    assert!(err.contains("the link is receive-only"), "{err}");
}

#[test]
fn shared_link_passes_raw_bytes() {
    let folder = scratch("raw");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &[]);
    let mut second = Telling::start(&["watch", &format!("unix:{socket}"), "--headless"]);
    second.wait_for("a line", |value| value["event"] == "line");
    let mut lines = BufReader::new(UnixStream::connect(&socket).unwrap()).lines();
    let announced = lines.next().unwrap().unwrap();
    assert_eq!(announced, r#"{"groundwave":1}"#);
    // The first line of the robot may be partial, and short lines acknowledge commands.
    assert!(lines.any(|line| line.unwrap().trim_end().len() == 78));
}

/// The program with a separate folder for sockets and tokens.
pub fn program_in(folder: &Path, arguments: &[&str]) -> Command {
    let mut program = Command::new(GROUNDWAVE);
    program.args(arguments).env("XDG_RUNTIME_DIR", folder);
    program
}

/// A station that shares on a free port, and its address.
pub fn station_on_a_port(link: &str, folder: &Path) -> (Telling, String) {
    station_at("0", link, folder)
}

fn station_at(share: &str, link: &str, folder: &Path) -> (Telling, String) {
    let watch = ["watch", link, "--headless", "--share", share];
    let mut station = Telling::spawn(program_in(folder, &watch));
    let told = station.wait_for("where", |value| value["code"] == "shared");
    let address = told["text"].as_str().unwrap().strip_prefix("shared on ");
    (station, address.unwrap().to_owned())
}

/// The error with which a connection ends; a part of a robot's line may be before it.
fn last_error(reading: &mut impl Read) -> Value {
    let mut answer = String::new();
    reading.read_to_string(&mut answer).unwrap();
    let begin = answer.rfind("{\"code\"").expect(&answer);
    serde_json::from_str(answer[begin..].trim_end()).expect(&answer)
}

#[test]
fn garbage_closes_only_its_own_connection() {
    let folder = scratch("garbage");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let mut browser = UnixStream::connect(&socket).unwrap();
    browser.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
    let last = last_error(&mut browser);
    assert_eq!(last["code"], "not-understood");
    assert!(
        last["error"].as_str().unwrap().contains("not understood"),
        "{last}"
    );
    let mut flood = UnixStream::connect(&socket).unwrap();
    // The client may be cut off before it has sent everything.
    let _ = flood.write_all(&vec![b'x'; 1 << 20]);
    station.wait_for("that the flood was closed", |value| {
        value["level"] == "warning"
    });
    expect(0, &["send", "--via", &socket, "mode", "reactive"]);
}

/// Every user of a machine can connect to its ports; only the owner can read the token.
#[test]
fn a_port_is_for_its_owner_alone() {
    let folder = scratch("port");
    let sim = Sim::start(&[]);
    let (_station, address) = station_on_a_port(&sim.path, &folder);
    let hello = "{\"groundwave\":1}\n{\"id\":1,\"do\":\"stop\"}\n";
    for first in [
        "",
        "\n",
        "GET / HTTP/1.1\n",
        &"0".repeat(64),
        &"x".repeat(999),
    ] {
        let mut stranger = TcpStream::connect(&address).unwrap();
        // It may be closed before it has said all of it.
        let _ = stranger.write_all(format!("{first}\n{hello}").as_bytes());
        let last = last_error(&mut stranger);
        assert_eq!(last["code"], "token", "{first}: {last}");
        let error = last["error"].as_str().unwrap();
        assert!(error.contains("GROUNDWAVE_TOKEN"), "{error}");
    }
    let send = |token: Option<&str>| {
        let mut send = program_in(&folder, &["send", "--via", &address, "stop"]);
        if let Some(token) = token {
            send.env("GROUNDWAVE_TOKEN", token);
        }
        send.output().unwrap()
    };
    let refused = send(Some("wrong"));
    let err = String::from_utf8(refused.stderr).unwrap();
    assert_eq!(refused.status.code(), Some(4), "{err}");
    assert!(err.contains("GROUNDWAVE_TOKEN"), "{err}");
    // By its file, and by what the refusal says.
    assert_eq!(send(None).status.code(), Some(0));
    let path = err.split_once(" find it in ").unwrap().1;
    let token = fs::read_to_string(path.split_once(';').unwrap().0).unwrap();
    assert_eq!(send(Some(&token)).status.code(), Some(0));
    // It is the only station there, and is found without its address.
    let mut found = program_in(&folder, &["send", "--via", "stop"]);
    assert_eq!(found.output().unwrap().status.code(), Some(0));
    // With the token first, `nc` reads the raw bytes.
    let mut reader = TcpStream::connect(&address).unwrap();
    reader.write_all(token.as_bytes()).unwrap();
    reader.shutdown(Shutdown::Write).unwrap();
    let mut lines = BufReader::new(reader).lines();
    assert!(lines.any(|line| line.unwrap().trim_end().len() == 78));
}

/// Two stations of one user on the same port of two addresses have a token each.
#[cfg(target_os = "linux")]
#[test]
fn a_port_of_another_address_has_a_token_of_its_own() {
    let folder = scratch("same-port");
    let sims = [Sim::start(&[]), Sim::start(&[])];
    let (_first, address) = station_on_a_port(&sims[0].path, &folder);
    let other = address.replace("127.0.0.1", "127.0.0.2");
    let (second, shared) = station_at(&other, &sims[1].path, &folder);
    assert_eq!(shared, other);
    let stop = |address: &str| {
        let mut send = program_in(&folder, &["send", "--via", address, "stop"]);
        send.output().unwrap().status.code()
    };
    assert_eq!((stop(&address), stop(&other)), (Some(0), Some(0)));
    drop(second);
    assert_eq!(stop(&address), Some(0), "the other one has ended");
}

/// Connections of other users do not use up those of the owner.
#[test]
fn strangers_do_not_keep_the_owner_out() {
    let folder = scratch("strangers");
    let sim = Sim::start(&[]);
    let (_station, address) = station_on_a_port(&sim.path, &folder);
    let strangers: Vec<TcpStream> = (0..40)
        .map(|_| TcpStream::connect(&address).unwrap())
        .collect();
    let stop = ["send", "--via", &address, "stop"];
    let sent = program_in(&folder, &stop).output().unwrap();
    assert_eq!(sent.status.code(), Some(0), "{sent:?}");
    drop(strangers);
}

/// Keeps opening connections from three threads while `act` runs; each thread holds its last 200, more than a station admits.
fn with_crowd<T>(connect: impl Fn() -> Option<T> + Sync, act: impl FnOnce()) {
    let is_over = AtomicBool::new(false);
    let crowd = || {
        let mut held = VecDeque::new();
        while !is_over.load(Ordering::Relaxed) {
            held.extend(connect());
            if held.len() > 200 {
                held.pop_front();
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..3 {
            scope.spawn(crowd);
        }
        let result = catch_unwind(AssertUnwindSafe(act));
        is_over.store(true, Ordering::Relaxed);
        result.unwrap_or_else(|panic| resume_unwind(panic));
    });
}

#[test]
fn a_crowd_does_not_keep_the_owner_out() {
    let folder = scratch("crowds");
    let sim = Sim::start(&[]);
    let (_station, address) = station_on_a_port(&sim.path, &folder);
    let stop = |via: &str| {
        let sent = program_in(&folder, &["send", "--via", via, "stop"]).output();
        let sent = sent.unwrap();
        assert_eq!(sent.status.code(), Some(0), "{sent:?}");
    };
    let stops = |via: &str| (0..2).for_each(|_| stop(via));
    with_crowd(|| TcpStream::connect(&address).ok(), || stops(&address));
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &[]);
    let once = || {
        drop(UnixStream::connect(&socket));
        None::<()>
    };
    with_crowd(once, || stops(&socket));
}

#[test]
fn share_and_via_meet_without_an_address() {
    let folder = scratch("usual");
    let run = |arguments: &[&str]| program_in(&folder, arguments);
    let sim = Sim::start(&[]);
    let watch = ["watch", &sim.path, "--headless", "--share"];
    let mut station = Telling::spawn(run(&watch));
    station.wait_for("a line", |value| value["event"] == "line");
    assert!(folder.join("groundwave/station.sock").exists());
    let sent = run(&["send", "--via", "stop"]).output().unwrap();
    assert_eq!(sent.status.code(), Some(0), "{sent:?}");
    let second = run(&watch).output().unwrap();
    let err = String::from_utf8(second.stderr).unwrap();
    assert!(err.contains("another program"), "{err}");
}

#[test]
fn a_recorder_sends_for_its_clients_unless_it_may_not() {
    let folder = scratch("recorder");
    for (option, code) in [("--radio=full", 0), ("--no-uplink", 6)] {
        let sim = Sim::start(&[]);
        let socket = path_in(&folder, option.trim_start_matches('-'));
        let capture = format!("{socket}.mcap");
        let recorder = [
            "record", &sim.path, "-o", &capture, "--share", &socket, option,
        ];
        let mut recorder = Running(Command::new(GROUNDWAVE).args(recorder).spawn().unwrap());
        while !Path::new(&socket).exists() {
            assert_eq!(recorder.0.try_wait().unwrap(), None, "it ended");
            thread::yield_now();
        }
        expect(code, &["send", "--via", &socket, "stop"]);
        kill_process(Pid::from_child(&recorder.0), Signal::TERM).unwrap();
        assert!(recorder.0.wait().unwrap().success());
        expect(0, &["verify", &capture]);
        let exported = groundwave(&["export", &capture, "--to", "jsonl", "-o", "-"]).stdout;
        let out = String::from_utf8(exported).unwrap();
        assert_eq!(out.contains(r#""status":"confirmed""#), code == 0, "{out}");
    }
}

#[test]
fn sharing_with_the_network_needs_its_option() {
    let sim = Sim::start(&[]);
    let open = ["watch", &sim.path, "--headless", "--share", "0.0.0.0:0"];
    let (_, err) = expect(2, &open);
    assert!(err.contains("--share-open-to-network"), "{err}");
}

#[test]
fn stopped_reader_is_disconnected_without_delaying_others() {
    let folder = scratch("stalled");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&["--listen", "127.0.0.1:0", "--time-factor", "300"]);
    let mut station = station(&sim.path, &socket, &[]);
    let _never_reads = UnixStream::connect(&socket).unwrap();
    station.wait_for("that it was cut off", |value| {
        value["text"]
            .as_str()
            .is_some_and(|text| text.contains("stopped reading and was cut off"))
    });
    station.wait_for_new("lines all the same", |value| value["event"] == "line");
}

#[test]
fn replaced_reader_is_reported() {
    let folder = scratch("crowd");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let _readers: Vec<UnixStream> = (0..20)
        .map(|_| UnixStream::connect(&socket).unwrap())
        .collect();
    for _ in 0..4 {
        let warning =
            station.wait_for_new("that one was cut off", |value| value["level"] == "warning");
        let text = warning["text"].as_str().unwrap();
        assert!(text.ends_with("to make room for another program"), "{text}");
    }
}

/// Sixteen programs that connected and then sent nothing must not block STOP.
#[test]
fn idle_clients_do_not_block_stop() {
    let folder = scratch("idle");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let _station = station(&sim.path, &socket, &[]);
    let mut idle: Vec<BufReader<UnixStream>> = Vec::new();
    for _ in 0..16 {
        let mut client = BufReader::new(UnixStream::connect(&socket).unwrap());
        client.get_mut().write_all(b"{\"groundwave\":1}\n").unwrap();
        let mut line = String::new();
        while !line.contains("can_send") {
            line.clear();
            client.read_line(&mut line).unwrap();
        }
        idle.push(client);
    }
    expect(0, &["send", "--via", &socket, "stop"]);
    assert_eq!(last_error(&mut idle[0])["code"], "gave-way");
}

/// Clients that only read do not use up the connections for commands.
#[test]
fn idle_readers_do_not_block_stop() {
    let folder = scratch("readers");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut watch = Telling::start(&["watch", &sim.path, "--headless", "--share", &socket]);
    watch.wait_for("a line", |value| value["event"] == "line");
    let readers: Vec<UnixStream> = (0..20)
        .map(|_| UnixStream::connect(&socket).unwrap())
        .collect();
    expect(0, &["send", "--via", &socket, "stop"]);
    drop(readers);
}
