//! The real ground station at the emulated board, over a pseudo-terminal.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader};
use std::iter;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::Body;
use sr04_sim::serve::{Port, Pty};
use sr04_sim::{ChannelSpec, Modem, Radio};

use super::checks::Programs;
use super::house::House;
use crate::chip::Figures;

/// How much faster than life the robot is, so that a route takes seconds.
const TIMES_LIFE: u32 = 8;

/// Time between two looks at the terminal.
const REST: Duration = Duration::from_millis(2);

/// Uplink bytes taken ahead of their byte time.
const AHEAD: usize = 64;

/// Time in which the board tells its state.
const LAST_LINES_MS: u64 = 3000;

/// Lines among which `watch` must print the wanted one.
const WATCHED_LINES: usize = 100;

/// Pseudo-terminals that are open while the board's is opened.
const LOW_NUMBERS: usize = 64;

/// Points of the route.
const POINTS: i32 = 20;

/// A board behind a pseudo-terminal.
struct Served {
    path: String,
    /// Each message takes the power away for a moment.
    power: Sender<()>,
    thread: JoinHandle<Result<House, String>>,
}

impl Served {
    fn start(
        programs: &Programs,
        program: &Path,
        channel: &ChannelSpec,
        seed: u64,
    ) -> Result<Self, String> {
        // Numbers are reused from the lowest, and a foreign station whose pseudo-terminal has gone opens its number again:
        // it would take the board's between two commands.
        let open = || Pty::open(None, false).map_err(|error| error.to_string());
        let low = (0..LOW_NUMBERS)
            .map(|_| open())
            .collect::<Result<Vec<_>, _>>()?;
        let (pty, path) = open()?;
        drop(low);
        let house = House::new("open-room", seed, &programs.emulator, program)?;
        let radio = Radio::new(channel, seed);
        let (power, lost) = mpsc::channel();
        let thread = std::thread::spawn(move || serve(house, radio, pty, &lost));
        Ok(Self {
            path,
            power,
            thread,
        })
    }

    fn lose_power(&self) -> Result<(), String> {
        self.power
            .send(())
            .map_err(|_| "the board has stopped".to_owned())
    }

    /// Takes the board from the terminal, once it has told what the last command did.
    fn end(self) -> Result<House, String> {
        drop(self.power);
        let mut house = self
            .thread
            .join()
            .map_err(|_| "the board's thread panicked".to_owned())??;
        house.run_ms(LAST_LINES_MS)?;
        Ok(house)
    }
}

/// Runs the board until the other end of `lost` is dropped.
fn serve(
    mut house: House,
    mut radio: Radio,
    mut pty: Pty,
    lost: &Receiver<()>,
) -> Result<House, String> {
    let begun = Instant::now();
    let mut behind = Duration::ZERO;
    let mut told = VecDeque::new();
    loop {
        match lost.recv_timeout(REST) {
            Ok(()) => house.emulator.lose_power()?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return Ok(house),
        }
        let target = begun.elapsed().saturating_sub(behind) * TIMES_LIFE;
        let mut sent = Vec::new();
        while Duration::from_millis(house.now_ms) < target {
            if radio.uplink_pending() < AHEAD {
                let mut read = Vec::new();
                pty.read(&mut read);
                radio.transmit(&read);
            }
            let now_ms = house.now_ms;
            let received: Vec<u8> = iter::from_fn(|| radio.poll_uplink(now_ms)).collect();
            told.extend(house.step(&received)?);
            radio.step(house.now_ms, || told.pop_front());
            sent.extend(iter::from_fn(|| radio.poll_downlink(house.now_ms)));
            // A machine that is too slow lets the robot live more slowly.
            if sent.len() >= AHEAD {
                break;
            }
        }
        behind = behind.max(begun.elapsed().saturating_sub(
            Duration::from_millis(house.now_ms) / TIMES_LIFE + Duration::from_millis(200),
        ));
        pty.write(&sent, Instant::now());
    }
}

/// Runs a command of the ground station; returns what it prints.
fn groundwave(programs: &Programs, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(&programs.groundwave)
        .args(arguments)
        .output()
        .map_err(|error| format!("cannot start {}: {error}", programs.groundwave.display()))?;
    let printed = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    if output.status.success() {
        Ok(printed)
    } else {
        Err(format!(
            "groundwave {arguments:?}: {}: {printed}",
            output.status
        ))
    }
}

/// Lines that `watch --headless` prints until one is of a type.
fn watch_until(programs: &Programs, link: &str, kind: &str) -> Result<(), String> {
    let mut process = Command::new(&programs.groundwave)
        .args(["watch", "--headless", link])
        .stdout(Stdio::piped())
        .spawn()
        .map_err(|error| format!("cannot start {}: {error}", programs.groundwave.display()))?;
    let lines = process.stdout.take().map(BufReader::new);
    let wanted = format!("\"line_type\":\"{kind}\"");
    let is_seen = lines
        .into_iter()
        .flat_map(BufRead::lines)
        .map_while(Result::ok)
        .take(WATCHED_LINES)
        .any(|line| line.contains(&wanted));
    let _ = process.kill();
    let _ = process.wait();
    if is_seen {
        Ok(())
    } else {
        Err(format!("watch --headless ended without {wanted}"))
    }
}

/// Watches, drives a route to its end, keeps a parameter over a reset, stops.
pub(crate) fn station(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let folder = tempfile::tempdir().map_err(|error| format!("no temporary folder: {error}"))?;
    let (route, script) = (
        folder.path().join("route.csv"),
        folder.path().join("script"),
    );
    let mut points = String::new();
    for n in 0..POINTS {
        let (right, ahead) = [(1, 1), (1, -1), (-1, -1), (-1, 1)][n as usize % 4];
        let reach_in = 8 + n / 2;
        // Writing to a string cannot fail.
        let _ = writeln!(points, "{},{}", right * reach_in, ahead * reach_in);
    }
    let commands = format!(
        "route {}\nmode prowl\nwait until driven within 3m\n",
        route.display()
    );
    fs::write(&route, points)
        .and_then(|()| fs::write(&script, commands))
        .map_err(|error| format!("{}: {error}", folder.path().display()))?;
    let served = Served::start(programs, &programs.full, &ChannelSpec::default(), seed)?;
    let link = served.path.clone();
    let tried = (|| {
        watch_until(programs, &link, "A")?;
        groundwave(programs, &["send", &link, "-f", &script.to_string_lossy()])?;
        groundwave(programs, &["param", &link, "set", "top-speed", "7"])?;
        groundwave(programs, &["param", &link, "save"])?;
        groundwave(programs, &["send", &link, "param", "list"])?;
        served.lose_power()?;
        let told = groundwave(programs, &["param", &link, "get", "top-speed"])?;
        if !told.contains('7') {
            return Err(format!("top-speed after the reset: {told}"));
        }
        groundwave(programs, &["send", &link, "stop"])
    })();
    let house = served.end()?;
    tried?;
    let driven = house
        .bodies(|body| match body {
            Body::Status(status) => Some(status.list.driven),
            _ => None,
        })
        .into_iter()
        .max();
    if driven != Some(POINTS as u16) {
        return Err(format!("{driven:?} points of {POINTS} were driven"));
    }
    stands(&house)?;
    house.finish()
}

/// Commands to a board whose radio takes turns: HC-12 modules.
pub(crate) fn half_duplex(programs: &Programs, seed: u64) -> Result<Figures, String> {
    let modules = ChannelSpec {
        modem: Some(Modem::Hc12),
        ..ChannelSpec::default()
    };
    let served = Served::start(programs, &programs.half, &modules, seed)?;
    let link = served.path.clone();
    let send = |command: &[&str]| {
        groundwave(
            programs,
            &[&["send", &link, "--radio", "hc-12"], command].concat(),
        )
    };
    let tried = send(&["mode", "reactive"]).and_then(|_| send(&["stop"]));
    let house = served.end()?;
    tried?;
    stands(&house)?;
    house.finish()
}

/// Whether the robot has been stopped.
fn stands(house: &House) -> Result<(), String> {
    let modes = house.bodies(|body| match body {
        Body::State(state) => Some(state.mode),
        _ => None,
    });
    if modes.last() != Some(&Mode::Stop) || house.drives {
        return Err(format!("the robot is not stopped: {:?}", modes.last()));
    }
    Ok(())
}
