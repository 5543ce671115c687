//! Pulled cables, killed stations, and radios of all kinds.

use std::fs;
use std::io::Write;
use std::net::TcpStream;
use std::path::Path;

use crate::programs::{GROUNDWAVE, Sim, Telling, expect, is_stage, long_route, path_in, scratch};
use crate::pty::OnTerminal;
use serde_json::Value;

/// A robot whose pseudo-terminal keeps its name after a restart.
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

/// Half duplex is detected from the robot's lines, or set by option or configuration.
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
