//! Pulled cables, killed stations, and several users of one radio.
#![cfg(unix)]

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::os::unix::net::UnixStream;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, scratch};
use crate::pty::OnTerminal;
use serde_json::Value;

/// A route that takes seconds to transfer.
fn long_route(folder: &Path) -> String {
    let mut text = String::new();
    for n in 0..100 {
        writeln!(text, "{},{}", n, -n).unwrap();
    }
    let path = folder.join("long.txt");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

fn path_in(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

/// A headless station that shares its link.
fn station(link: &str, socket: &str, more: &[&str]) -> Telling {
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

fn is_stage(stage: &str) -> impl Fn(&Value) -> bool {
    let stage = stage.to_owned();
    move |value| value["status"] == stage.as_str()
}

/// A robot whose pseudo-terminal keeps its name over a restart.
struct Plug {
    link: String,
    eeprom: String,
}

impl Plug {
    fn new(folder: &Path) -> Self {
        Self {
            link: path_in(folder, "radio"),
            eeprom: path_in(folder, "eeprom"),
        }
    }

    fn plug(&self) -> Sim {
        Sim::start(&["--pty", &self.link, "--eeprom", &self.eeprom])
    }
}

/// Pulls the cable during a transfer; the station reports it, reconnects and delivers.
fn pull_at(name: &str, point: &str) {
    let folder = scratch(name);
    let plug = Plug::new(&folder);
    let route = long_route(&folder);
    let socket = path_in(&folder, "s");
    let sim = plug.plug();
    let arguments = ["watch", &plug.link, "--share", &socket];
    let mut watch = OnTerminal::start(GROUNDWAVE, &arguments, 140, 40);
    watch.wait_for("the robot", |text| text.contains("newest <1 s"));
    let mut sender = Telling::start(&["send", "--via", &socket, "route", &route, "--json"]);
    sender.wait_for(point, |value| match point {
        // The last blocks and the order that activates them are being sent.
        "nearly all" => value["acknowledged"].as_i64().is_some_and(|n| n > 60),
        _ => value["status"] == point,
    });
    drop(sim);
    watch.wait_for("the loss", |text| text.contains("LINK LOST"));
    let _sim = plug.plug();
    watch.wait_for("the return", |text| {
        text.contains("newest <1 s") && text.contains("LINK LOST over")
    });
    // The alarm stays until the operator acknowledges it.
    watch.type_keys("A");
    watch.wait_for("no alarm", |text| !text.contains("LINK LOST"));
    expect(0, &["send", "--via", &socket, "route", &route]);
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
    assert!(!Path::new(&socket).exists(), "it goes with the station");
}

#[test]
fn cable_pulled_while_the_session_is_opened() {
    pull_at("pull-opening", "queued");
}

#[test]
fn cable_pulled_during_a_transfer() {
    pull_at("pull-transfer", "progress");
}

#[test]
fn cable_pulled_before_the_confirmation() {
    pull_at("pull-confirm", "nearly all");
}

#[test]
fn killed_station_can_be_replaced_during_a_transfer() {
    let folder = scratch("killed");
    let route = long_route(&folder);
    let sim = Sim::start(&[]);
    let mut sender = Telling::start(&["send", &sim.path, "route", &route, "--json"]);
    sender.wait_for("progress", is_stage("progress"));
    drop(sender);
    let (out, _) = expect(0, &["send", &sim.path, "route", &route]);
    assert!(out.contains("confirmed"), "{out}");
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
        assert!(by.starts_with("pid ") && by.ends_with(&socket), "{by}");
    }
    let sent: Vec<i64> = station
        .said
        .iter()
        .filter(|value| value["event"] == "command" && value["status"] != "queued")
        .map(|value| value["id"].as_i64().unwrap())
        .collect();
    assert!(sent.is_sorted(), "the second waits for the first: {sent:?}");
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
        err.contains("refused `mode forage`: it has no sensor for the dock's beacon"),
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

/// Two clients that send STOP at once share one frame.
#[test]
fn joined_stop_is_not_reported_as_unsent() {
    let folder = scratch("two-stops");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&["--channel", "out=0s..10000s"]);
    let arguments = ["watch", &sim.path, "--headless", "--share", &socket];
    let mut station = Telling::start(&arguments);
    station.wait_for("that it shares", |value| {
        value["text"]
            .as_str()
            .is_some_and(|text| text.starts_with("shared on "))
    });
    let mut first = Telling::start(&["send", "--via", &socket, "stop", "--json"]);
    first.wait_for("a frame of it", is_stage("sent"));
    let arguments = ["send", "--via", &socket, "stop", "--timeout", "10ms"];
    let (_, err) = expect(3, &arguments);
    assert!(err.contains("may or may not"), "{err}");
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
    // The first line may be partial; the second is whole.
    let _ = lines.next();
    let line = lines.next().unwrap().unwrap();
    assert_eq!(line.trim_end_matches('\r').len(), 78, "{line}");
}

/// The program with a folder of its own for sockets and tokens.
fn program_in(folder: &Path, arguments: &[&str]) -> Command {
    let mut program = Command::new(GROUNDWAVE);
    program.args(arguments).env("XDG_RUNTIME_DIR", folder);
    program
}

/// A station that shares on a port of its own choice, and its address.
fn station_on_a_port(link: &str, folder: &Path) -> (Telling, String) {
    let watch = ["watch", link, "--headless", "--share", "0"];
    let mut station = Telling::spawn(program_in(folder, &watch));
    let told = station.wait_for("where", |value| value["code"] == "shared");
    let address = told["text"].as_str().unwrap().strip_prefix("shared on ");
    (station, address.unwrap().to_owned())
}

fn last_line(reading: &mut impl Read) -> Value {
    let mut answer = String::new();
    reading.read_to_string(&mut answer).unwrap();
    serde_json::from_str(answer.lines().last().unwrap()).unwrap()
}

#[test]
fn garbage_closes_only_its_own_connection() {
    let folder = scratch("garbage");
    let socket = path_in(&folder, "s");
    let sim = Sim::start(&[]);
    let mut station = station(&sim.path, &socket, &[]);
    let mut browser = UnixStream::connect(&socket).unwrap();
    browser.write_all(b"GET / HTTP/1.1\r\n\r\n").unwrap();
    let last = last_line(&mut browser);
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
        let last = last_line(&mut stranger);
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
    // With the token first, `nc` reads the raw bytes.
    let mut reader = TcpStream::connect(&address).unwrap();
    reader.write_all(token.as_bytes()).unwrap();
    reader.shutdown(Shutdown::Write).unwrap();
    let mut lines = BufReader::new(reader).lines();
    let _ = lines.next();
    assert!(lines.any(|line| line.unwrap().trim_end().len() == 78));
}

/// Connections of strangers do not use up those of the owner.
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

/// Keeps opening connections from three threads while `act` runs; each thread holds its last 50.
fn with_crowd<T>(connect: impl Fn() -> Option<T> + Sync, act: impl FnOnce()) {
    let is_over = AtomicBool::new(false);
    let crowd = || {
        let mut held = VecDeque::new();
        while !is_over.load(Ordering::Relaxed) {
            held.extend(connect());
            if held.len() > 50 {
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

/// A TCP bridge to a serial port that sends the bytes of the test.
struct Bridge {
    listener: std::net::TcpListener,
    link: String,
}

impl Bridge {
    fn new() -> Self {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let link = format!("tcp:{}", listener.local_addr().unwrap());
        Self { listener, link }
    }

    fn accept(&self) -> TcpStream {
        self.listener.accept().unwrap().0
    }
}

#[test]
fn closed_bridge_is_reconnected() {
    let bridge = Bridge::new();
    let mut watch = Telling::start(&["watch", &bridge.link, "--headless"]);
    drop(bridge.accept());
    let is_link = |state: &'static str| move |value: &Value| value["state"] == state;
    watch.wait_for("the loss", is_link("lost"));
    let _again = bridge.accept();
    watch.wait_for_new("the return", is_link("open"));
}

#[test]
fn bytes_without_a_line_are_classified() {
    let bridge = Bridge::new();
    let mut watch = Telling::start(&["watch", &bridge.link, "--headless"]);
    let mut stream = bridge.accept();
    let is_heard = |what: &'static str| move |value: &Value| value["code"] == what;
    watch.wait_for("nothing", is_heard("nothing"));
    // Sampled four times too fast, each bit becomes four: 2400 baud received at 9600.
    stream
        .write_all(&[0x00, 0xF0, 0x0F, 0xF8, 0x80, 0x07].repeat(100))
        .unwrap();
    watch.wait_for("the wrong rate", is_heard("slower-rate"));
    watch.wait_for_new("the hint", |value| {
        let text = value["text"].as_str().unwrap_or_default();
        value["level"] == "warning" && text.contains("serial server's baud rate")
    });
    let capture = Path::new(env!("CARGO_MANIFEST_DIR")).join("captures/house-clean.txt");
    stream
        .write_all(&fs::read(capture).unwrap()[..800])
        .unwrap();
    watch.wait_for("lines", is_heard("lines"));
}

/// Half duplex is detected by the robot's lines, or set by option or configuration.
#[test]
fn half_duplex_radio_is_detected_or_configured() {
    let folder = scratch("half-duplex");
    let config = path_in(&folder, "config.toml");
    fs::write(&config, "[link]\nradio = \"half\"\n").unwrap();
    let sim = Sim::start(&["--radio", "half"]);
    expect(0, &["send", &sim.path, "mode", "reactive"]);
    expect(0, &["send", &sim.path, "--radio", "half", "mode", "prowl"]);
    expect(
        0,
        &["send", &sim.path, "--config", &config, "mode", "reactive"],
    );
    expect(0, &["send", &sim.path, "stop"]);
}

#[test]
fn buffered_modem_delivers_with_its_preset() {
    let sim = Sim::start(&["--radio", "xbee"]);
    let route = long_route(&scratch("xbee"));
    expect(0, &["send", &sim.path, "--radio", "xbee", "route", &route]);
}

#[test]
fn receive_only_radio_never_sends() {
    let sim = Sim::start(&[]);
    let (_, err) = expect(6, &["send", &sim.path, "--radio", "receive-only", "stop"]);
    assert!(err.contains("receive-only"), "{err}");
}

#[test]
fn wrong_configuration_is_reported() {
    let folder = scratch("configuration");
    let config = path_in(&folder, "config.toml");
    fs::write(&config, "[link]\nradoi = \"half\"\n").unwrap();
    let (_, err) = expect(2, &["send", "--config", &config, "sim", "dock"]);
    assert!(err.contains("radoi") && err.contains(&config), "{err}");
    let missing = path_in(&folder, "missing.toml");
    let (_, err) = expect(2, &["send", "--config", &missing, "sim", "dock"]);
    assert!(err.contains("missing.toml"), "{err}");
}

#[test]
fn stop_works_with_a_wrong_configuration() {
    let folder = scratch("stop-configuration");
    let config = path_in(&folder, "config.toml");
    let sim = Sim::start(&[]);
    let text = format!(
        "[dashboard]\ntheme = \"drak\"\n[link.marvin]\nport = \"{}\"\n",
        sim.path
    );
    fs::write(&config, text).unwrap();
    expect(2, &["send", "--config", &config, "marvin", "dock"]);
    let (out, err) = expect(0, &["send", "--config", &config, "marvin", "stop"]);
    assert!(out.contains("stop: confirmed"), "{out}");
    assert!(
        err.contains("drak") && err.contains("Trying to stop anyway"),
        "{err}"
    );
    // The settings beside a mistake are used.
    let text = format!(
        "[link.marvin]\nport = \"{}\"\n[keys]\nstop = 5 5\n",
        sim.path
    );
    fs::write(&config, text).unwrap();
    let (out, err) = expect(0, &["send", "--config", &config, "marvin", "stop"]);
    assert!(out.contains("stop: confirmed"), "{out}");
    assert!(err.contains(":4:"), "{err}");
}

/// Sixteen programs that said hello and nothing more locked STOP out.
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
        while !line.starts_with("{\"groundwave\"") {
            line.clear();
            client.read_line(&mut line).unwrap();
        }
        idle.push(client);
    }
    expect(0, &["send", "--via", &socket, "stop"]);
    assert_eq!(last_line(&mut idle[0])["code"], "gave-way");
}

/// Readers do not use up the connections for commands.
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
