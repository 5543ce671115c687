//! Processes of the program: robots and stations, and their output.

use std::fmt::Write as _;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::Value;

pub const GROUNDWAVE: &str = env!("CARGO_BIN_EXE_groundwave");

/// Timeout of a test that hangs.
const PATIENCE: Duration = Duration::from_mins(1);

/// A route that takes seconds to transfer.
pub fn long_route(folder: &Path) -> String {
    let mut text = String::new();
    for n in 0..100 {
        writeln!(text, "{},{}", n, -n).unwrap();
    }
    let path = folder.join("long.txt");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

pub fn path_in(folder: &Path, name: &str) -> String {
    folder.join(name).to_str().unwrap().to_owned()
}

/// Whether a command has reached a stage.
pub fn is_stage(stage: &str) -> impl Fn(&Value) -> bool {
    let stage = stage.to_owned();
    move |value| value["status"] == stage.as_str()
}

/// A process that is killed at the end of the test.
pub struct Running(pub Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A simulated robot as a process.
pub struct Sim {
    pub process: Running,
    pub path: String,
}

impl Sim {
    pub fn start(arguments: &[&str]) -> Self {
        let mut child = Command::new(GROUNDWAVE)
            .arg("sim")
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut path = String::new();
        BufReader::new(child.stdout.as_mut().unwrap())
            .read_line(&mut path)
            .unwrap();
        Self {
            process: Running(child),
            path: path.trim().to_owned(),
        }
    }
}

impl Sim {
    /// Ends the process in order, so that no link remains to a pseudo-terminal that another test gets next.
    pub fn end(mut self) {
        let pid = self.process.0.id().to_string();
        Command::new("kill").arg(&pid).status().unwrap();
        self.process.0.wait().unwrap();
    }
}

/// A process that writes JSON lines.
pub struct Telling {
    pub process: Running,
    lines: Receiver<Value>,
    /// The program's output so far.
    pub said: Vec<Value>,
}

impl Telling {
    pub fn start(arguments: &[&str]) -> Self {
        Self::start_as(GROUNDWAVE, arguments)
    }

    /// Starts the program like [`Self::start`], through another program.
    pub fn start_as(program: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new(program);
        command.args(arguments);
        Self::spawn(command)
    }

    pub fn spawn(mut command: Command) -> Self {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let output = BufReader::new(child.stdout.take().unwrap());
        let (sender, lines) = channel();
        std::thread::spawn(move || {
            for line in output.lines().map_while(Result::ok) {
                if sender.send(serde_json::from_str(&line).unwrap()).is_err() {
                    break;
                }
            }
        });
        Self {
            process: Running(child),
            lines,
            said: Vec::new(),
        }
    }

    /// Waits for a line that matches, earlier lines included.
    pub fn wait_for(&mut self, what: &str, mut is_it: impl FnMut(&Value) -> bool) -> Value {
        if let Some(said) = self.said.iter().find(|value| is_it(value)) {
            return said.clone();
        }
        self.wait_for_new(what, is_it)
    }

    /// Waits for a new line that matches.
    pub fn wait_for_new(&mut self, what: &str, mut is_it: impl FnMut(&Value) -> bool) -> Value {
        let deadline = Instant::now() + PATIENCE;
        loop {
            let left = deadline.saturating_duration_since(Instant::now());
            let Ok(value) = self.lines.recv_timeout(left) else {
                let said: Vec<String> = self
                    .said
                    .iter()
                    .filter(|value| value["event"] != "line")
                    .map(Value::to_string)
                    .collect();
                panic!("never said: {what}. It said:\n{}", said.join("\n"));
            };
            self.said.push(value.clone());
            if is_it(&value) {
                return value;
            }
        }
    }
}

pub fn groundwave(arguments: &[&str]) -> Output {
    Command::new(GROUNDWAVE)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// Runs the program to its end and checks the exit code; returns standard output and standard error.
pub fn expect(code: i32, arguments: &[&str]) -> (String, String) {
    let output = groundwave(arguments);
    let out = String::from_utf8(output.stdout).unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        output.status.code(),
        Some(code),
        "{arguments:?}\n{out}\n{err}"
    );
    (out, err)
}

/// An empty folder; its path is short enough for a Unix socket.
pub fn scratch(name: &str) -> PathBuf {
    let folder =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}
