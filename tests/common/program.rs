//! The program and a simulated robot, as processes.
#![allow(dead_code, reason = "each test file uses its own part")]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

pub const GROUNDWAVE: &str = env!("CARGO_BIN_EXE_groundwave");

/// A simulated robot in a process of its own.
pub struct Sim {
    child: Child,
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
            child,
            path: path.trim().to_owned(),
        }
    }
}

impl Sim {
    /// Ends it in good order, so that no link is left behind that points to a terminal which somebody
    /// else is given next.
    pub fn end(mut self) {
        let pid = self.child.id().to_string();
        Command::new("kill").arg(&pid).status().unwrap();
        self.child.wait().unwrap();
    }
}

impl Drop for Sim {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

pub fn groundwave(arguments: &[&str]) -> Output {
    Command::new(GROUNDWAVE)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .unwrap()
}

/// Runs to its end; checks the exit code; returns standard output and standard error.
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

pub fn scratch(name: &str) -> PathBuf {
    let folder =
        Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}", std::process::id()));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}
