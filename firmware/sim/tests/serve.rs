//! A robot behind real pseudo-terminals and TCP ports. No test sleeps: reads wait with a limit.
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

/// Limit far above the duration of any read.
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

/// Whether the bytes are a part of the robot's output in its first minutes. On a busy machine a late reader misses the
/// beginning.
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
    rustix::fs::open(path.as_ref(), flags, Mode::empty()).expect("the terminal exists")
}

fn wait_readable(terminal: &OwnedFd) {
    let limit = Timespec::try_from(LIMIT).expect("the limit fits");
    let mut poll = [PollFd::new(terminal, PollFlags::IN)];
    let ready = rustix::event::poll(&mut poll, Some(&limit)).expect("polling works");
    assert_eq!(ready, 1, "no data within {LIMIT:?}");
}

fn read_some(terminal: &OwnedFd, count: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while bytes.len() < count {
        wait_readable(terminal);
        let mut chunk = [0; 512];
        let read = rustix::io::read(terminal, &mut chunk).expect("the terminal was readable");
        bytes.extend_from_slice(&chunk[..read]);
    }
    bytes.truncate(count);
    bytes
}

/// An empty folder for one test.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).expect("the folder is created");
    path
}

#[test]
fn terminal_carries_the_simulated_bytes_unchanged() {
    let server = start(pty(None));
    let terminal = open(&server.addresses()[0]);
    assert!(is_part_of(&read_some(&terminal, 1000)));
}

#[test]
fn terminal_passes_bytes_to_the_robot() {
    let server = start(pty(None));
    let terminal = open(&server.addresses()[0]);
    // CR, LF and the interrupt character must pass a raw terminal.
    rustix::io::write(&terminal, b"\r\n\x03garbage").expect("the terminal takes bytes");
    while server.uplink_bytes() < 10 {
        read_some(&terminal, 1);
    }
    assert_eq!(server.uplink_bytes(), 10);
}

#[test]
fn unread_terminal_does_not_block_the_simulation() {
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
fn tcp_clients_all_receive_and_their_input_is_merged() {
    let server = start(tcp());
    let connect = || {
        let client = TcpStream::connect(&server.addresses()[0]).expect("the port listens");
        client
            .set_read_timeout(Some(LIMIT))
            .expect("the time limit is set");
        client
    };
    let (mut one, mut other) = (connect(), connect());
    let mut bytes = [0; 200];
    one.read_exact(&mut bytes).expect("bytes arrive");
    other.read_exact(&mut bytes).expect("bytes arrive");
    one.write_all(b"abc").expect("the client sends");
    other.write_all(b"de").expect("the client sends");
    while server.uplink_bytes() < 5 {
        one.read_exact(&mut bytes[..1]).expect("bytes arrive");
    }
    drop(one);
    other
        .read_exact(&mut bytes)
        .expect("the other client still receives");
}

#[test]
fn copy_endpoint_ignores_input() {
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
    rustix::io::write(&copy, b"not for you").expect("the terminal takes bytes");
    assert!(is_part_of(&read_some(&terminal, 1000)));
    assert!(is_part_of(&read_some(&copy, 1000)));
    assert_eq!(server.uplink_bytes(), 0);
}

#[test]
fn link_exists_while_the_robot_is_served() {
    let link = folder("link").join("robot");
    let server = start(pty(Some(&link)));
    assert_eq!(
        fs::read_link(&link).expect("the path is a link"),
        Path::new(&server.addresses()[0])
    );
    read_some(&open(&link), 10);
    drop(server);
    assert!(fs::read_link(&link).is_err());
    assert_eq!(
        fs::read_dir(link.parent().expect("the link has a parent"))
            .expect("the folder is readable")
            .count(),
        0
    );
}

#[test]
fn only_the_link_of_a_stopped_robot_is_replaced() {
    let folder = folder("stale");
    let refuse = |link: &Path| match serve(config(), &options(pty(Some(link)))) {
        Err(ServeError::Link { problem, .. }) => problem,
        other => panic!("{other:?}"),
    };
    let stale = folder.join("stale");
    std::os::unix::fs::symlink("/dev/pts/999999", &stale).expect("the link is made");
    let server = start(pty(Some(&stale)));
    assert_eq!(
        fs::read_link(&stale).expect("the path is a link"),
        Path::new(&server.addresses()[0])
    );
    assert!(refuse(&stale).contains("another simulated robot"));
    read_some(&open(&stale), 10);

    let file = folder.join("file");
    fs::write(&file, "precious").expect("the file is written");
    assert!(refuse(&file).contains("already exists"));
    assert_eq!(
        fs::read_to_string(&file).expect("the file still exists"),
        "precious"
    );

    let foreign = folder.join("foreign");
    std::os::unix::fs::symlink(&file, &foreign).expect("the link is made");
    assert!(refuse(&foreign).contains("it is a link to"));
}

#[test]
fn boot_counter_survives_a_restart() {
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
        fs::read_to_string(&path).expect("the file exists"),
        "boots=3\n"
    );
    fs::write(&path, "seven").expect("the file is written");
    let error = serve(config(), &options).expect_err("the counter is invalid");
    assert!(
        error
            .to_string()
            .contains("delete the file to start from 1"),
        "{error}"
    );
}

#[test]
fn kept_parameters_survive_a_restart() {
    let path = folder("parameters").join("eeprom");
    fs::write(&path, "boots=3\ntop-speed=8\n").expect("the file is written");
    let options = ServeOptions {
        eeprom: Some(path.clone()),
        ..options(tcp())
    };
    drop(serve(config(), &options).expect("the endpoint opens"));
    let kept = fs::read_to_string(&path).expect("the file exists");
    assert_eq!(kept, "boots=4\ntop-speed=8\n");
    fs::write(&path, "boots=3\ntop-speed=99\n").expect("the file is written");
    let error = serve(config(), &options).expect_err("the value is out of range");
    assert!(error.to_string().contains("line 2"), "{error}");
}

#[test]
fn invalid_time_factors_and_used_ports_are_refused() {
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
    let used = Endpoint::Tcp {
        address: server.addresses()[0].clone(),
        copy_only: false,
    };
    let error = serve(config(), &options(used)).expect_err("the port is in use");
    assert!(
        error.to_string().contains("cannot listen on 127.0.0.1:"),
        "{error}"
    );
}

#[test]
fn trace_file_has_one_row_per_tick() {
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
    let text = fs::read_to_string(&path).expect("the trace exists");
    fs::remove_file(&path).expect("the trace is removed");
    assert_eq!(text.lines().count(), 1 + 200, "a header and ten seconds");
    let nowhere = ServeOptions {
        trace: Some("/no/such/folder/trace.csv".into()),
        ..options
    };
    let error = serve(config(), &nowhere).expect_err("the folder does not exist");
    assert!(error.to_string().contains("/no/such/folder"), "{error}");
}

#[test]
fn unwritable_sound_file_is_refused_before_the_start() {
    let options = ServeOptions {
        wav: Some("/no/such/folder/sound.wav".into()),
        ..options(tcp())
    };
    let error = serve(config(), &options).expect_err("the folder does not exist");
    assert!(matches!(error, ServeError::Recording { .. }));
    let message = "cannot write the sound to /no/such/folder/sound.wav";
    assert!(error.to_string().contains(message), "{error}");
}
