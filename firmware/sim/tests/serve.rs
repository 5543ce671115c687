//! A robot behind real pseudo-terminals and TCP ports. Nothing sleeps: reads wait with a limit.
#![cfg(unix)]

use std::fs;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec};
use rustix::fs::{Mode, OFlags};
use sr04_sim::serve::{Endpoint, ServeError, ServeOptions, Server, serve};
use sr04_sim::{Simulation, SimulationConfig, World};

/// Far longer than anything here takes.
const LIMIT: Duration = Duration::from_secs(20);

fn config() -> SimulationConfig {
    SimulationConfig::new(World::default(), 5)
}

fn pty(link: Option<&Path>) -> Endpoint {
    Endpoint::Pty {
        link: link.map(Path::to_owned),
        copy_only: false,
    }
}

fn tcp() -> Endpoint {
    Endpoint::Tcp {
        address: "127.0.0.1:0".to_owned(),
        copy_only: false,
    }
}

fn options(endpoint: Endpoint) -> ServeOptions {
    ServeOptions {
        endpoints: vec![endpoint],
        time_factor: 10.0,
        ..ServeOptions::default()
    }
}

fn start(endpoint: Endpoint) -> Server {
    serve(config(), &options(endpoint)).expect("the endpoint opens")
}

/// Whether these bytes are a piece of what the robot sends in its first minutes. A reader that a
/// busy machine holds up at first misses the beginning.
fn is_part_of(received: &[u8]) -> bool {
    let mut simulation = Simulation::new(&config());
    let mut sent = Vec::new();
    for _ in 0..300 {
        simulation.run_for_ms(1000);
        sent.extend(std::iter::from_fn(|| simulation.poll_downlink()));
    }
    sent.windows(received.len())
        .any(|window| window == received)
}

fn open(path: impl AsRef<Path>) -> OwnedFd {
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK;
    rustix::fs::open(path.as_ref(), flags, Mode::empty()).expect("the terminal is there")
}

fn wait_readable(terminal: &OwnedFd) {
    let limit = Timespec::try_from(LIMIT).expect("it fits");
    let mut poll = [PollFd::new(terminal, PollFlags::IN)];
    let ready = rustix::event::poll(&mut poll, Some(&limit)).expect("polling works");
    assert_eq!(ready, 1, "nothing came within {LIMIT:?}");
}

fn read_some(terminal: &OwnedFd, count: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while bytes.len() < count {
        wait_readable(terminal);
        let mut chunk = [0; 512];
        let read = rustix::io::read(terminal, &mut chunk).expect("it was readable");
        bytes.extend_from_slice(&chunk[..read]);
    }
    bytes.truncate(count);
    bytes
}

/// An empty folder of this test's own.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("the folder can be made");
    path
}

#[test]
fn a_terminal_carries_the_simulated_bytes_unchanged() {
    let server = start(pty(None));
    let terminal = open(&server.addresses()[0]);
    assert!(is_part_of(&read_some(&terminal, 1000)));
}

#[test]
fn a_terminal_takes_bytes_for_the_robot() {
    let server = start(pty(None));
    let terminal = open(&server.addresses()[0]);
    // CR, LF and the interrupt character must pass a raw terminal.
    rustix::io::write(&terminal, b"\r\n\x03garbage").expect("it takes bytes");
    while server.uplink_bytes() < 10 {
        read_some(&terminal, 1);
    }
    assert_eq!(server.uplink_bytes(), 10);
}

#[test]
fn nobody_reading_stops_nothing() {
    let options = ServeOptions {
        duration: Some(Duration::from_secs(110)),
        time_factor: 1000.0,
        ..options(pty(None))
    };
    let server = serve(config(), &options).expect("the endpoint opens");
    // Far more bytes than any queue holds.
    let terminal = open(&server.addresses()[0]);
    server.wait();
    drop(terminal);
}

#[test]
fn tcp_clients_all_receive_and_are_merged() {
    let server = start(tcp());
    let connect = || {
        let client = TcpStream::connect(&server.addresses()[0]).expect("it listens");
        client
            .set_read_timeout(Some(LIMIT))
            .expect("a limit can be set");
        client
    };
    let (mut one, mut other) = (connect(), connect());
    let mut bytes = [0; 200];
    one.read_exact(&mut bytes).expect("bytes come");
    other.read_exact(&mut bytes).expect("bytes come");
    one.write_all(b"abc").expect("it takes bytes");
    other.write_all(b"de").expect("it takes bytes");
    while server.uplink_bytes() < 5 {
        one.read_exact(&mut bytes[..1]).expect("bytes come");
    }
    drop(one);
    other
        .read_exact(&mut bytes)
        .expect("one client less is no end");
}

#[test]
fn a_copy_ignores_what_it_is_told() {
    let copy = Endpoint::Pty {
        link: None,
        copy_only: true,
    };
    let options = ServeOptions {
        endpoints: vec![pty(None), copy],
        ..options(tcp())
    };
    let server = serve(config(), &options).expect("the endpoints open");
    let terminal = open(&server.addresses()[0]);
    let copy = open(&server.addresses()[1]);
    rustix::io::write(&copy, b"not for you").expect("it takes bytes");
    assert!(is_part_of(&read_some(&terminal, 1000)));
    assert!(is_part_of(&read_some(&copy, 1000)));
    assert_eq!(server.uplink_bytes(), 0);
}

#[test]
fn a_link_appears_and_disappears_with_the_robot() {
    let link = folder("link").join("robot");
    let server = start(pty(Some(&link)));
    assert_eq!(
        fs::read_link(&link).expect("it is a link"),
        Path::new(&server.addresses()[0])
    );
    read_some(&open(&link), 10);
    drop(server);
    assert!(fs::read_link(&link).is_err());
    assert_eq!(
        fs::read_dir(link.parent().expect("it has one"))
            .expect("readable")
            .count(),
        0
    );
}

#[test]
fn only_a_dead_robots_link_is_replaced() {
    let folder = folder("stale");
    let refuse = |link: &Path| match serve(config(), &options(pty(Some(link)))) {
        Err(ServeError::Link { problem, .. }) => problem,
        other => panic!("{other:?}"),
    };
    let stale = folder.join("stale");
    std::os::unix::fs::symlink("/dev/pts/999999", &stale).expect("a link can be made");
    let server = start(pty(Some(&stale)));
    assert_eq!(
        fs::read_link(&stale).expect("it is a link"),
        Path::new(&server.addresses()[0])
    );
    assert!(refuse(&stale).contains("another simulated robot"));
    read_some(&open(&stale), 10);

    let file = folder.join("file");
    fs::write(&file, "precious").expect("a file can be written");
    assert!(refuse(&file).contains("a file is there"));
    assert_eq!(
        fs::read_to_string(&file).expect("it is still there"),
        "precious"
    );

    let foreign = folder.join("foreign");
    std::os::unix::fs::symlink(&file, &foreign).expect("a link can be made");
    assert!(refuse(&foreign).contains("it is a link to"));
}

#[test]
fn the_boot_counter_survives() {
    let path = folder("eeprom").join("eeprom");
    let options = ServeOptions {
        eeprom: Some(path.clone()),
        ..options(tcp())
    };
    for boot in 1..=3 {
        let server = serve(config(), &options).expect("the endpoint opens");
        assert_eq!(server.boots(), boot);
    }
    assert_eq!(
        fs::read_to_string(&path).expect("it was written"),
        "boots=3\n"
    );
    fs::write(&path, "seven").expect("a file can be written");
    let error = serve(config(), &options).expect_err("the counter is unreadable");
    assert!(
        error.to_string().contains("remove it to start from 1"),
        "{error}"
    );
}

#[test]
fn parameters_that_were_kept_come_back() {
    let path = folder("parameters").join("eeprom");
    fs::write(&path, "boots=3\ntop-speed=8\n").expect("a file can be written");
    let options = ServeOptions {
        eeprom: Some(path.clone()),
        ..options(tcp())
    };
    drop(serve(config(), &options).expect("the endpoint opens"));
    let kept = fs::read_to_string(&path).expect("it was written");
    assert_eq!(kept, "boots=4\ntop-speed=8\n");
    fs::write(&path, "boots=3\ntop-speed=99\n").expect("a file can be written");
    let error = serve(config(), &options).expect_err("no robot goes that fast");
    assert!(error.to_string().contains("line 2"), "{error}");
}

#[test]
fn senseless_time_and_taken_ports_are_refused() {
    for time_factor in [0.0, -1.0, f64::NAN, 1e9] {
        let options = ServeOptions {
            time_factor,
            ..options(tcp())
        };
        assert!(matches!(
            serve(config(), &options),
            Err(ServeError::TimeFactor(_))
        ));
    }
    let server = start(tcp());
    let taken = Endpoint::Tcp {
        address: server.addresses()[0].clone(),
        copy_only: false,
    };
    let error = serve(config(), &options(taken)).expect_err("the port is taken");
    assert!(
        error.to_string().contains("cannot listen on 127.0.0.1:"),
        "{error}"
    );
}

#[test]
fn the_trace_has_a_row_for_every_tick() {
    let path = std::env::temp_dir().join(format!("groundwave-trace-{}.csv", std::process::id()));
    let options = ServeOptions {
        duration: Some(Duration::from_secs(10)),
        time_factor: 1000.0,
        trace: Some(path.clone()),
        ..options(tcp())
    };
    serve(config(), &options)
        .expect("the endpoint opens")
        .wait();
    let text = fs::read_to_string(&path).expect("it is there");
    fs::remove_file(&path).expect("it can go");
    assert_eq!(text.lines().count(), 1 + 200, "a head and ten seconds");
    let nowhere = ServeOptions {
        trace: Some("/no/such/folder/trace.csv".into()),
        ..options
    };
    let error = serve(config(), &nowhere).expect_err("there is no such folder");
    assert!(error.to_string().contains("/no/such/folder"), "{error}");
}

#[test]
fn a_sound_that_has_no_place_is_refused_before_the_robot_starts() {
    let options = ServeOptions {
        wav: Some("/no/such/folder/sound.wav".into()),
        ..options(tcp())
    };
    let error = serve(config(), &options).expect_err("there is no such folder");
    assert!(matches!(error, ServeError::Recording { .. }));
    let told = "cannot write the sound to /no/such/folder/sound.wav";
    assert!(error.to_string().contains(told), "{error}");
}
