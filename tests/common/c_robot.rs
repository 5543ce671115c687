//! The robot of `protocol/c/examples/Host` as a process in lockstep with the test: each exchange takes a byte time.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

/// Number of byte times per second.
pub const BYTES_PER_S: u32 = 240;

use super::Patch;

/// Number of boots at the start, chosen so that their era is not 0.
pub const BOOTS: u8 = 9;

/// A running robot.
pub struct CRobot {
    process: Child,
    questions: ChildStdin,
    answers: BufReader<ChildStdout>,
    folder: PathBuf,
    byte_times: u32,
}

/// The state of the robot's program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CState {
    pub mode: u8,
    pub active_count: u16,
    pub active_digest: u32,
}

impl CRobot {
    /// The library at a level, changed by the patches, and a robot that has just booted.
    pub fn start(level: u8, patience_bytes: u8, patches: &[Patch]) -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("c-robot-{}-{number}", std::process::id()));
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
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
        let status = Command::new(&compiler)
            .args([
                "-std=c99",
                "-O1",
                "-w",
                &format!("-DGW_LEVEL={level}"),
                "-I",
            ])
            .arg(library.join("src"))
            .arg(library.join("test/lockstep.c"))
            .arg(&changed)
            .args(["-lm", "-o"])
            .arg(folder.join("robot"))
            .status()
            .unwrap_or_else(|error| panic!("cannot start {compiler}: {error}"));
        assert!(status.success(), "{compiler} ended with {status}");
        let mut process = Command::new(folder.join("robot"))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .expect("the robot starts");
        let mut robot = Self {
            questions: process.stdin.take().expect("standard input is a pipe"),
            answers: BufReader::new(process.stdout.take().expect("standard output is a pipe")),
            process,
            folder,
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
        match heard {
            Some(byte) => self.ask(&[b'+', byte]),
            None => self.ask(b"-"),
        }
        self.byte_times += 1;
        let mut answer = [0; 2];
        let read = self.answers.read_exact(&mut answer);
        read.expect("the robot's program runs");
        (answer[0] == b'+').then_some(answer[1])
    }

    pub fn now(&self) -> Duration {
        Duration::from_secs(1) * self.byte_times / BYTES_PER_S
    }

    pub fn state(&mut self) -> CState {
        self.ask(b"?");
        let mut line = String::new();
        self.answers.read_line(&mut line).expect("an answer");
        let words: Vec<&str> = line.split_whitespace().collect();
        CState {
            mode: words[0].as_bytes()[0],
            active_count: words[3].parse().expect("a number"),
            active_digest: words[4].parse().expect("a number"),
        }
    }

    fn ask(&mut self, question: &[u8]) {
        let asked = self.questions.write_all(question);
        asked.expect("the robot's program runs");
    }
}

impl Drop for CRobot {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = fs::remove_dir_all(&self.folder);
    }
}
