//! Robots of lower levels on pseudo-terminals: the refusals that the operator reads. Their program is `protocol/c/examples/Host`.
#![cfg(unix)]

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::programs::{GROUNDWAVE, expect, scratch};
use crate::pty::OnTerminal;

struct Host {
    process: Child,
    path: String,
}

impl Host {
    fn start(level: u8, waypoints: u16) -> Self {
        let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("protocol/c");
        let program = scratch(&format!("host-{level}")).join("host");
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
        let status = Command::new(&compiler)
            .args(["-std=c99", "-O1", "-w"])
            .arg(format!("-DGW_LEVEL={level}"))
            .arg(format!("-DGW_WAYPOINTS={waypoints}"))
            .arg(library.join("examples/Host/host.c"))
            .arg(library.join("src/groundwave.c"))
            .args(["-lm", "-o"])
            .arg(&program)
            .status()
            .unwrap();
        assert!(status.success(), "{compiler} ended with {status}");
        let mut process = Command::new(program)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut path = String::new();
        let output = process.stdout.take().unwrap();
        BufReader::new(output).read_line(&mut path).unwrap();
        Self {
            process,
            path: path.trim().to_owned(),
        }
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

#[test]
fn a_command_beyond_the_level_names_both_levels() {
    let robot = Host::start(2, 8);
    let (_, error) = expect(5, &["send", &robot.path, "param", "save"]);
    let words = "needs level 5, the robot has level 2";
    assert!(error.contains(words), "{error}");
    let (out, _) = expect(5, &["send", "--json", &robot.path, "scan"]);
    for part in ["\"code\":\"beyond-level\"", "\"has\":2,\"needs\":4"] {
        assert!(out.contains(part), "{out}");
    }
    // The first answers of a robot of level 4 arrive before its level.
    let robot = Host::start(4, 8);
    let (_, error) = expect(5, &["send", &robot.path, "param", "save"]);
    let words = "needs level 5, the robot has level 4";
    assert!(error.contains(words), "{error}");
}

#[test]
fn a_list_beyond_the_capacity_names_both_counts() {
    let robot = Host::start(3, 8);
    let route = scratch("host-route").join("long.txt");
    fs::write(&route, "1,10\n".repeat(9)).unwrap();
    let route = route.to_str().unwrap();
    let words = "has 9 waypoints, the robot holds 8";
    let (_, error) = expect(5, &["send", &robot.path, "route", route]);
    assert!(error.contains(words), "{error}");

    let mut watch = OnTerminal::start(GROUNDWAVE, &["watch", &robot.path], 120, 40);
    watch.wait_for("the robot's level", |text| text.contains("level"));
    watch.type_keys(&format!(":route {route}\r"));
    watch.wait_for("the draft", |text| text.contains("9 waypoints, not sent"));
    watch.type_keys("S");
    watch.wait_for("the refusal", |text| text.contains(words));
    watch.type_keys("q");
    assert_eq!(watch.wait(), 0);
}
