//! The robot of `protocol/c/examples/Host` as a process in lockstep with the test, alone or behind the simulated radio.

use std::cell::{Cell, RefCell};
use std::collections::HashMap;
use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::Duplex;
use sr04_sim::{ChannelSpec, Radio, SimulationConfig};

use super::{Patch, Robot};

/// Number of byte times per second.
pub const BYTES_PER_S: u32 = 240;

/// Number of boots at the start, chosen so that their era is not 0.
pub const BOOTS: u8 = 9;

/// Waypoints of the robot behind a radio: as many as the simulated robot has.
const WAYPOINTS: u16 = 300;

/// The question for the state.
const STATE: &[u8] = b"?\n";

/// A running robot.
pub struct CRobot {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    byte_times: u32,
}

/// The state of the robot's program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CState {
    pub mode: u8,
    pub active_count: u16,
    pub active_digest: u32,
    pub position_in: (i32, i32),
    pub odometer_resets: u16,
}

impl CRobot {
    /// The library at a level, changed by the patches, and a robot that has just booted. `waypoints` is its capacity.
    pub fn start(level: u8, patience_bytes: u8, waypoints: u16, patches: &[Patch]) -> Self {
        let mut process = Command::new(compiled(level, waypoints, patches))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the robot starts");
        let mut robot = Self {
            questions: process.stdin.take().expect("standard input is a pipe"),
            answers: BufReader::new(process.stdout.take().expect("standard output is a pipe")),
            process,
            byte_times: 0,
        };
        robot.boot(BOOTS, patience_bytes);
        robot
    }

    pub fn boot(&mut self, boots: u8, patience_bytes: u8) {
        self.ask(&[b'B', boots, patience_bytes]);
    }

    /// Advances by a byte time, with or without a byte from the ground; returns the byte that the robot sends.
    pub fn exchange(&mut self, heard: Option<u8>) -> Option<u8> {
        let heard: Vec<u8> = heard.into_iter().collect();
        self.pass(&heard, 1).pop().flatten()
    }

    /// Bytes from the ground, then byte times; returns the bytes that the robot sends in them.
    pub fn pass(&mut self, heard: &[u8], byte_times: u32) -> Vec<Option<u8>> {
        let mut question = passing(heard, byte_times);
        question.push(b'\n');
        self.ask(&question);
        self.sent_in(byte_times)
    }

    /// Bytes from the ground, then a byte time; returns the byte that the robot sends in it, and its state after it. One question:
    /// each costs two changes of the running process.
    fn pass_one(&mut self, heard: &[u8]) -> (Option<u8>, CState) {
        let mut question = passing(heard, 1);
        question.extend(STATE);
        self.ask(&question);
        let byte = self.sent_in(1).pop().flatten();
        (byte, self.read_state())
    }

    fn sent_in(&mut self, byte_times: u32) -> Vec<Option<u8>> {
        self.byte_times += byte_times;
        let mut answer = vec![0; 2 * byte_times as usize];
        let read = self.answers.read_exact(&mut answer);
        read.expect("the robot's program runs");
        answer
            .chunks(2)
            .map(|it| (it[0] == b'+').then_some(it[1]))
            .collect()
    }

    pub fn now(&self) -> Duration {
        Duration::from_secs(1) * self.byte_times / BYTES_PER_S
    }

    pub fn state(&mut self) -> CState {
        self.ask(STATE);
        self.read_state()
    }

    fn read_state(&mut self) -> CState {
        let words = self.words();
        let number = |n: usize| words[n].parse::<i64>().expect("a number");
        CState {
            mode: words[0].as_bytes()[0],
            active_count: number(3) as u16,
            active_digest: number(4) as u32,
            position_in: (number(6) as i32, number(7) as i32),
            odometer_resets: number(8) as u16,
        }
    }

    /// The active list.
    pub fn list(&mut self) -> Vec<Waypoint> {
        self.ask(b"W\n");
        let words = self.words();
        let number = |word: &String| word.parse().expect("a number");
        let points = words.chunks(2).map(|pair| Waypoint {
            x_in: number(&pair[0]),
            y_in: number(&pair[1]),
        });
        points.collect()
    }

    fn words(&mut self) -> Vec<String> {
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        line.split_whitespace().map(str::to_owned).collect()
    }

    fn ask(&mut self, question: &[u8]) {
        let asked = self.questions.write_all(question);
        asked.expect("the robot's program runs");
    }
}

fn passing(heard: &[u8], byte_times: u32) -> Vec<u8> {
    let mut question: Vec<u8> = heard.iter().flat_map(|&byte| [b'+', byte]).collect();
    question.extend((0..byte_times).map(|_| b'-'));
    question
}

impl Drop for CRobot {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Compiles a robot, once in a run of the tests.
fn compiled(level: u8, waypoints: u16, patches: &[Patch]) -> PathBuf {
    static PROGRAMS: Mutex<Option<HashMap<String, PathBuf>>> = Mutex::new(None);
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("{level} {waypoints} {patches:?}");
    let known =
        |programs: &Option<HashMap<String, PathBuf>>| programs.as_ref()?.get(&name).cloned();
    if let Some(program) = known(&PROGRAMS.lock().expect("no compiler has failed")) {
        return program;
    }
    let number = COUNT.fetch_add(1, Ordering::Relaxed);
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("c-robot-{number}"));
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("protocol/c");
    fs::create_dir_all(&folder).expect("the folder of the build can be written");
    let source = library.join("src/groundwave.c");
    let mut text = fs::read_to_string(source).expect("the library is there");
    for (from, to) in patches {
        assert_eq!(
            text.matches(from).count(),
            1,
            "not once in the library: {from}"
        );
        text = text.replace(from, to);
    }
    let changed = folder.join("groundwave.c");
    fs::write(&changed, text).expect("the folder can be written");
    let program = folder.join("robot");
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    // A robot of an earlier run may still be running.
    let _ = fs::remove_file(&program);
    let status = Command::new(&compiler)
        // A patched library is used once, so compiling it takes longer than running it.
        .args([
            "-std=c99",
            if patches.is_empty() { "-O1" } else { "-O0" },
            "-w",
        ])
        .arg(format!("-DGW_LEVEL={level}"))
        .arg(format!("-DGW_WAYPOINTS={waypoints}"))
        .arg("-I")
        .arg(library.join("src"))
        .arg(library.join("test/lockstep.c"))
        .arg(&changed)
        .args(["-lm", "-o"])
        .arg(&program)
        .status()
        .unwrap_or_else(|error| panic!("cannot start {compiler}: {error}"));
    assert!(status.success(), "{compiler} ended with {status}");
    let mut programs = PROGRAMS.lock().expect("no compiler has failed");
    let programs = programs.get_or_insert_default();
    programs.entry(name).or_insert(program).clone()
}

/// The C robot behind the simulated radio.
pub struct CSimulation {
    robot: RefCell<CRobot>,
    radio: Radio,
    now_ms: u64,
    /// Bytes that the robot has received since its latest byte time.
    heard: Vec<u8>,
    boots: u8,
    patience_bytes: u8,
    /// Its state, if that was asked for since the latest byte time.
    state: Cell<Option<CState>>,
}

impl CSimulation {
    /// A robot of a level that has just booted.
    pub fn at_level(level: u8, config: &SimulationConfig) -> Self {
        let patience_bytes = match config.duplex {
            Duplex::Full => 0,
            Duplex::Half { patience_bytes } => patience_bytes,
        };
        let robot = CRobot::start(level, patience_bytes, WAYPOINTS, &[]);
        Self {
            robot: RefCell::new(robot),
            state: Cell::new(None),
            radio: Radio::new(&config.channel, config.seed),
            now_ms: 0,
            heard: Vec::new(),
            boots: BOOTS,
            patience_bytes,
        }
    }

    fn state(&self) -> CState {
        let state = self.state.get();
        let state = state.unwrap_or_else(|| self.robot.borrow_mut().state());
        self.state.set(Some(state));
        state
    }
}

impl Robot for CSimulation {
    const IS_IN_C: bool = true;

    fn start(config: &SimulationConfig) -> Self {
        Self::at_level(5, config)
    }

    fn now_ms(&self) -> u64 {
        self.now_ms
    }

    fn step(&mut self) {
        self.now_ms += 1;
        let (robot, heard, state) = (self.robot.get_mut(), &mut self.heard, &mut self.state);
        self.radio.step(self.now_ms, || {
            let heard = std::mem::take(heard);
            // A test that asked for the state asks again.
            if state.take().is_none() {
                return robot.pass(&heard, 1).pop()?;
            }
            let (byte, after) = robot.pass_one(&heard);
            state.set(Some(after));
            byte
        });
        while let Some(byte) = self.radio.poll_uplink(self.now_ms) {
            self.heard.push(byte);
        }
    }

    fn handle_uplink(&mut self, bytes: &[u8]) {
        self.radio.transmit(bytes);
    }

    fn poll_downlink(&mut self) -> Option<u8> {
        self.radio.poll_downlink(self.now_ms)
    }

    fn uplink_pending(&self) -> usize {
        self.radio.uplink_pending() + self.heard.len()
    }

    fn set_channel(&mut self, channel: &ChannelSpec) {
        self.radio.set(channel);
    }

    fn reboot(&mut self) {
        self.boots += 1;
        self.heard.clear();
        self.robot.get_mut().boot(self.boots, self.patience_bytes);
        self.state.set(None);
    }

    fn mode(&self) -> Mode {
        Mode::from_letter(self.state().mode).expect("a mode's letter")
    }

    fn active_digest(&self) -> u32 {
        self.state().active_digest
    }

    fn active_list(&mut self) -> Vec<Waypoint> {
        self.robot.get_mut().list()
    }

    fn position_in(&self) -> (i32, i32) {
        self.state().position_in
    }

    fn odometer_resets(&self) -> usize {
        usize::from(self.state().odometer_resets)
    }
}
