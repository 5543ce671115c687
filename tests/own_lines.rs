//! Robots with their own line formats, on real links.
#![cfg(unix)]

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use groundwave::capture::own_lines::Values;
use groundwave::event::{CommandStatus, Event, Failure};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::arq::Config;
use portable_pty::{MasterPty, PtySize, native_pty_system};

use prost::Message as _;

use crate::programs::{GROUNDWAVE, Running, expect, path_in, scratch};
use crate::pty::OnTerminal;

/// A robot on a pseudo-terminal that prints lines until it is dropped.
struct Robot {
    path: String,
    is_over: Arc<AtomicBool>,
    _master: Box<dyn MasterPty + Send>,
}

impl Robot {
    fn printing(line: impl Fn(u32) -> String + Send + 'static) -> Self {
        let pair = native_pty_system()
            .openpty(PtySize::default())
            .expect("a pseudo-terminal");
        let path = pair.master.tty_name().unwrap().display().to_string();
        let mut port = pair.master.take_writer().unwrap();
        let is_over = Arc::new(AtomicBool::new(false));
        let ended = Arc::clone(&is_over);
        thread::spawn(move || {
            // The open end keeps the device alive while no program reads it.
            let _slave = pair.slave;
            for n in 0.. {
                if ended.load(Ordering::Relaxed) || port.write_all(line(n).as_bytes()).is_err() {
                    return;
                }
                thread::sleep(Duration::from_millis(50));
            }
        });
        Self {
            path,
            is_over,
            _master: pair.master,
        }
    }
}

impl Drop for Robot {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

#[test]
fn values_are_shown_without_a_configuration() {
    let robot = Robot::printing(|n| format!("temp:{}.5,volt:11.9\n", n % 3 + 20));
    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &robot.path], 120, 40);
    watch.wait_for("the values", |text| {
        text.contains("F9 fields") && text.contains("volt             11.9")
    });
    watch.wait_for("another value", |text| {
        text.contains("temp             22.5")
    });
    assert!(
        !watch.text().contains("who holds the motors"),
        "{}",
        watch.text()
    );
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}

/// A robot on a TCP port that prints its position and answers each command with `OK` and the command, except `X`.
fn answering_robot() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    thread::spawn(move || {
        for connection in listener.incoming() {
            let mut port = connection.unwrap();
            let mut answers = port.try_clone().unwrap();
            let commands = BufReader::new(port.try_clone().unwrap()).lines();
            thread::spawn(move || {
                for command in commands
                    .map_while(Result::ok)
                    .filter(|command| command != "X")
                {
                    let _ = writeln!(answers, "OK {command}");
                }
            });
            thread::spawn(move || {
                while writeln!(port, "12.7,25.4,11500").is_ok() {
                    thread::sleep(Duration::from_millis(50));
                }
            });
        }
    });
    format!("tcp:{address}")
}

#[test]
fn command_strings_are_echoed_and_never_confirmed() {
    let folder = scratch("own-commands");
    let config = folder.join("config.toml");
    let text = format!(
        r#"
        [robot.rover]
        link = "{}"
        [robot.rover.lines]
        form = "csv"
        fields = [
          {{ name = "x", unit = "cm", role = "x" }},
          {{ name = "y", unit = "cm", role = "y" }},
          {{ name = "batt", unit = "mV", role = "battery" }},
        ]
        [robot.rover.commands]
        stop = {{ send = "S\n", reply = "OK S" }}
        goto = {{ send = "G {{x}} {{y}}\n", reply = "OK G" }}
        beep = {{ send = "X\n", reply = "OK" }}
        "#,
        answering_robot()
    );
    fs::write(&config, text).unwrap();
    let config = config.to_str().unwrap();
    let (out, _) = expect(0, &["--config", config, "send", "rover", "goto", "48", "0"]);
    assert!(out.starts_with("goto 48 0: echoed after"), "{out}");
    let (out, _) = expect(0, &["--config", config, "send", "rover", "stop", "--json"]);
    assert!(
        out.contains("\"status\":\"echoed\"") && !out.contains("confirmed"),
        "{out}"
    );
    let (_, err) = expect(1, &["--config", config, "send", "rover", "scan"]);
    assert!(err.contains("no such command string"), "{err}");
    expect(
        3,
        &[
            "--config",
            config,
            "send",
            "rover",
            "beep",
            "--timeout",
            "1s",
        ],
    );
    let arguments = ["--config", config, "watch", "rover"];
    let mut watch = OnTerminal::start(GROUNDWAVE, &arguments, 120, 40);
    watch.wait_for("the map", |text| {
        text.contains("map: x +5 y +10 in") && text.contains("11.5 V")
    });
    watch.type_keys(":goto 1 2\r");
    watch.wait_for("its echo", |text| text.contains("goto 1 2: echoed in"));
    watch.type_keys(" ");
    watch.wait_for("the echo of STOP", |text| text.contains("stop: echoed"));
    assert!(!watch.text().contains("confirmed"), "{}", watch.text());
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}

/// A station that only records sends the same command strings for others; what answers them is text, and a limit of a field raises an alarm.
#[test]
fn a_recording_station_sends_command_strings() {
    let folder = scratch("own-station");
    let (config, socket, mcap) = (
        path_in(&folder, "config.toml"),
        path_in(&folder, "s"),
        path_in(&folder, "run.mcap"),
    );
    let text = format!(
        r#"
        [robot.rover]
        link = "{}"
        [robot.rover.lines]
        form = "csv"
        fields = [{{ name = "a" }}, {{ name = "b" }}, {{ name = "batt", limits = {{ low = 12000 }} }}]
        [robot.rover.commands]
        stop = {{ send = "S,0,0\n", reply = "OK S" }}
        goto = {{ send = "1,{{x}},{{y}}\n", reply = "OK" }}
        "#,
        answering_robot()
    );
    fs::write(&config, text).unwrap();
    let mut station = Running(
        Command::new(GROUNDWAVE)
            .args(["--config", &config, "record", "rover", "-o", &mcap])
            .args(["--share", &socket])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap(),
    );
    let said = BufReader::new(station.0.stderr.take().unwrap()).lines();
    let mut said = said.map_while(Result::ok);
    assert!(said.any(|line| line.contains("shared on")));
    let send = |words: &[&str], code| {
        let arguments = [&["--config", &config, "send", "--via", &socket], words].concat();
        expect(code, &arguments)
    };
    assert!(send(&["stop"], 0).0.starts_with("stop: echoed"));
    assert!(
        send(&["goto", "5", "6"], 0)
            .0
            .starts_with("goto 5 6: echoed")
    );
    let (_, err) = send(&["fly"], 2);
    assert!(err.contains("the robot's commands are goto, stop"), "{err}");
    let pid = station.0.id().to_string();
    let interrupted = Command::new("kill").args(["-INT", &pid]).status();
    assert!(interrupted.unwrap().success());
    assert!(said.any(|line| line.contains("own lines")));
    assert!(station.0.wait().unwrap().success());
    let (out, _) = expect(0, &["export", &mcap, "--to", "csv", "-o", "-"]);
    assert!(
        out.contains("\"OK S,0,0\"") && out.contains("\"OK 1,5,6\""),
        "{out}"
    );
    let begun = out.lines().find(|line| line.contains("alarm,,begun"));
    assert!(begun.unwrap().contains(",batt_below_12000,"), "{out}");
    assert!(begun.unwrap().contains(",alarm,12000.0,"), "{out}");
}

/// Raw bytes become a recording with named numbers, and every verb shows the numbers.
#[test]
fn values_are_recorded_exported_and_counted() {
    let folder = scratch("own-captures");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (raw, mcap) = (path("raw.txt"), path("run.mcap"));
    let mut text = String::new();
    for n in 0..50 {
        write!(text, "temp:{}.5,mode:auto\r\n", n % 10).unwrap();
    }
    fs::write(&raw, text + "low battery\r\n").unwrap();
    expect(0, &["export", &raw, "--to", "mcap", "-o", &mcap]);
    for capture in [&mcap, &raw] {
        let (out, _) = expect(0, &["verify", capture]);
        assert!(out.contains(": good\n"), "{out}");
        assert!(
            out.contains("own lines  49 with values, 1 of text, 0 damaged"),
            "{out}"
        );
        assert!(!out.contains("\nlines "), "there is no other line: {out}");
    }
    for capture in [&raw, &mcap] {
        let (out, _) = expect(0, &["info", capture]);
        // The first line may have lost its start.
        assert!(
            out.contains("own lines  49 with values, 1 of text, 0 damaged"),
            "{out}"
        );
        assert!(
            out.contains("field      temp: 49 values, 0.5 to 9.5"),
            "{out}"
        );
        assert!(!out.contains("bumps") && !out.contains("distance"), "{out}");
        let (out, _) = expect(0, &["export", capture, "--to", "jsonl", "-o", "-"]);
        assert_eq!(
            out.lines()
                .filter(|line| line.contains("\"values\":{\"temp\":9.5,\"mode\":\"auto\"}"))
                .count(),
            5,
            "{out}"
        );
        assert!(out.contains("\"own\":\"low battery\""), "{out}");
        let (out, _) = expect(0, &["export", capture, "--to", "csv", "-o", "-"]);
        assert!(out.starts_with("at_s,temp,mode,event,own\n"), "{out}");
        let rows = |end: &str| out.lines().filter(|line| line.ends_with(end)).count();
        assert_eq!(rows(",9.5,auto,,"), 5, "{out}");
        assert_eq!(rows(",,,own,low battery"), 1, "{out}");
    }
    let recording = fs::read(&mcap).unwrap();
    let messages = mcap::MessageStream::new(&recording).unwrap();
    let values: Vec<Values> = messages
        .map(Result::unwrap)
        .filter(|message| message.channel.topic == "/values")
        .map(|message| Values::decode(&message.data[..]).unwrap())
        .collect();
    assert_eq!(values.len(), 49);
    assert_eq!(values[0].numbers["temp"].to_string(), "1.5");
    assert_eq!(values[0].texts["mode"], "auto");
}

/// A recording of a robot that sends only text is one; raw text of the same bytes may be any text.
#[test]
fn a_recording_of_text_alone_is_read_back() {
    let folder = scratch("own-text");
    let path = |name: &str| folder.join(name).to_str().unwrap().to_owned();
    let (raw, mcap) = (path("raw.txt"), path("run.mcap"));
    fs::write(&raw, "the motors start\nall is well here\n".repeat(20)).unwrap();
    let recorded = Command::new(GROUNDWAVE)
        .args(["record", "-", "-o", &mcap])
        .stdin(fs::File::open(&raw).unwrap())
        .output()
        .unwrap();
    assert!(recorded.status.success(), "{recorded:?}");
    for verb in ["info", "verify"] {
        let (out, _) = expect(0, &[verb, &mcap]);
        // The first lines may be noise.
        assert!(
            out.contains("own lines  0 with values, 38 of text, 0 damaged"),
            "{out}"
        );
        expect(2, &[verb, &raw]);
    }
    for form in ["jsonl", "csv"] {
        let (out, _) = expect(0, &["export", &mcap, "--to", form, "-o", "-"]);
        let rows = out.lines().filter(|line| line.contains("all is well here"));
        assert_eq!(rows.count(), 19, "{out}");
    }
}

/// The form of the lines is kept in the recording: no configuration is needed to read it.
#[test]
fn a_recording_keeps_the_form_of_the_lines() {
    let folder = scratch("own-form");
    let config = folder.join("config.toml");
    let text = format!(
        "[robot.rover]\nlink = \"{}\"\n[robot.rover.lines]\nform = \"csv\"\nfields = [{{ name = \"x\", unit = \"cm\", role = \"x\" }}, \
         {{ name = \"y\", unit = \"cm\", role = \"y\" }}, {{ name = \"batt\", unit = \"mV\", scale = 2 }}]\n",
        answering_robot()
    );
    fs::write(&config, text).unwrap();
    let mcap = folder.join("run.mcap");
    let (config, mcap) = (config.to_str().unwrap(), mcap.to_str().unwrap());
    expect(
        0,
        &[
            "--config",
            config,
            "record",
            "rover",
            "-o",
            mcap,
            "--duration",
            "2s",
        ],
    );
    expect(0, &["verify", mcap]);
    let (out, _) = expect(0, &["info", mcap]);
    assert!(out.contains("23000 to 23000 mV"), "{out}");
    let (out, _) = expect(0, &["check", mcap]);
    let level = "lines of the robot's own\nLevel 0 is reached. Level 1 needs: line A.\n";
    assert!(out.ends_with(level), "{out}");
    let mut replay = OnTerminal::start(GROUNDWAVE, &["replay", mcap], 120, 40);
    replay.wait_for("the map", |text| {
        text.contains("map: x +5 y +10 in") && text.contains("23000 mV")
    });
    replay.type_keys("q");
    assert_eq!(replay.wait(), 0);
}

/// Only STOP is sent to a robot that may know no frame.
#[test]
fn a_robot_with_lines_of_its_own_alone_is_refused_commands_at_once() {
    let mut station = Station::new(Config::new(1), true);
    let mut now = Duration::ZERO;
    for _ in 0..20 {
        now += Duration::from_millis(100);
        station.handle_bytes(now, b"temp:1.5,volt:2\n");
    }
    let id = station.handle_request(now, Request::Scan, None);
    assert_eq!(station.poll_transmit(now), None);
    let events: Vec<Event> = std::iter::from_fn(|| station.poll_event()).collect();
    let refused = Event::Command {
        id,
        status: CommandStatus::Failed(Failure::NotConfigured),
    };
    assert!(events.contains(&refused), "{events:?}");
    station.handle_request(now, Request::Stop, None);
    assert!(station.poll_transmit(now).is_some());
}
