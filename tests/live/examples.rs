//! Every example in the documents works: indented command lines are run in order, with a simulated robot, a sample
//! recording and a separate folder; commands in sentences are only parsed.

use std::fs;
use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

use clap::Parser as _;
use clap::error::ErrorKind;
use groundwave::commands::cli::Cli;

use crate::programs::{GROUNDWAVE, Running, Sim, expect, scratch};
use crate::pty::{OnTerminal, PATIENCE};

const CAPTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/captures/house-clean.txt");
const WORLD: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/firmware/sim/worlds/living-room.toml"
);

#[test]
fn examples_of_the_readme_work() {
    assert!(try_all(include_str!("../../README.md")) > 30);
}

#[test]
fn examples_of_the_guide_work() {
    assert!(try_all(include_str!("../../docs/guide.md")) > 20);
}

#[test]
fn examples_of_the_other_documents_work() {
    for text in [
        include_str!("../../docs/opening-captures.md"),
        include_str!("../../docs/your-robot.md"),
        include_str!("../../firmware/sim/worlds/README.md"),
        include_str!("../../captures/README.md"),
    ] {
        try_all(text);
    }
}

/// The sketch in the document is the one that `protocol/c/test/check.py` compiles.
#[test]
fn the_sketch_of_your_robot_is_the_librarys() {
    let page = include_str!("../../docs/your-robot.md");
    let sketch = include_str!("../../protocol/c/examples/OwnLines/OwnLines.ino");
    let (_, code) = sketch.split_once("*/\n").unwrap();
    assert!(page.contains(&format!("```cpp\n{code}```")));
}

/// The way in which an example is tested.
enum Trial {
    /// The command must succeed.
    Run,
    /// The command must show a dashboard.
    Dashboard,
    /// The command serves a robot until the test ends it.
    Serve,
    /// The command needs a person or takes minutes, so its words are only parsed.
    Parse,
    /// A command of another program, which may not be installed or may not end.
    Foreign,
}

/// The way in which a command line is tested; an unexpected line fails the test.
fn trial(line: &str) -> Trial {
    let mut words = line.split_whitespace();
    match (words.next().unwrap(), words.next()) {
        ("groundwave", Some("watch")) if line.contains("--foxglove") => Trial::Parse,
        // Maps need captures of ten minutes and more.
        ("groundwave", Some("calibrate" | "map")) => Trial::Parse,
        ("groundwave", Some("demo" | "watch" | "replay")) | ("cargo", Some("run")) => {
            Trial::Dashboard
        }
        ("groundwave", Some("sim")) => Trial::Serve,
        (
            "groundwave",
            None
            | Some(
                "ports" | "send" | "param" | "record" | "info" | "recover" | "export" | "cut"
                | "verify" | "check" | "runs" | "label" | "compare" | "songs" | "config" | "world",
            ),
        )
        | ("LC_ALL=C" | "mkdir", _) => Trial::Run,
        ("cargo", Some("test" | "install"))
        | ("apt" | "cat" | "pip" | "rerun" | "socat" | "stty" | "tar", _) => Trial::Foreign,
        _ => panic!("no trial for this example: {line}"),
    }
}

/// Tests all examples in a document; returns the number of its command lines.
fn try_all(text: &str) -> usize {
    for command in within_sentences(text) {
        assert_parses(&command);
    }
    let mut desk = Desk::new();
    let lines = indented(text);
    let mut count = 0;
    let mut rest = &lines[..];
    while let Some(line) = rest.first() {
        let is_part_of_file: fn(&str) -> bool = match line.as_str() {
            "# run.txt" => |line| !line.is_empty(),
            line if line.starts_with('[') => {
                |line| line.starts_with('[') || line.contains(" = ") || line.is_empty()
            }
            _ => |_| false,
        };
        let length = rest.iter().take_while(|line| is_part_of_file(line)).count();
        if length > 0 {
            let (file, after) = rest.split_at(length);
            desk.write(&file.join("\n"));
            rest = after;
            continue;
        }
        rest = &rest[1..];
        if !line.is_empty() {
            desk.try_line(line);
            count += 1;
        }
    }
    count
}

/// The lines of indented blocks, without indentation; an empty one after each block.
fn indented(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut is_fenced = false;
    for line in text.lines() {
        is_fenced ^= line.starts_with("```");
        match line.strip_prefix("    ") {
            Some(code) if !is_fenced => lines.push(code.trim().to_owned()),
            _ if lines.last().is_some_and(|last: &String| !last.is_empty()) => {
                lines.push(String::new());
            }
            _ => {}
        }
    }
    lines
}

/// The commands between backticks.
fn within_sentences(text: &str) -> Vec<String> {
    let outside_blocks = text
        .lines()
        .filter(|line| !line.starts_with("    ") && !line.starts_with("```"));
    let text = outside_blocks.collect::<Vec<_>>().join(" ");
    let commands = text.split('`').skip(1).step_by(2);
    commands
        .filter(|code| code.starts_with("groundwave "))
        .map(|code| code.split_whitespace().collect::<Vec<_>>().join(" "))
        .collect()
}

/// Checks verbs, options and values; a sentence may omit arguments.
fn assert_parses(command: &str) {
    let parsed = Cli::try_parse_from(command.split_whitespace());
    let kind = parsed.map_err(|error| error.kind());
    assert!(
        matches!(
            kind,
            Ok(_) | Err(ErrorKind::DisplayHelp | ErrorKind::MissingRequiredArgument)
        ),
        "{command}: {kind:?}"
    );
}

/// A folder with the files that the examples name, and the programs that continue in the background.
struct Desk {
    folder: PathBuf,
    configuration: String,
    robots: Vec<Sim>,
    stations: Vec<Running>,
    dashboards: Vec<OnTerminal>,
}

impl Desk {
    fn new() -> Self {
        static NUMBER: AtomicU32 = AtomicU32::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let folder = scratch(&format!("examples-{number}"));
        let file = |name: &str| folder.join(name).to_str().unwrap().to_owned();
        fs::copy(CAPTURE, file("file")).unwrap();
        fs::copy(WORLD, file("my-flat.toml")).unwrap();
        for name in ["evening.mcap", "run-1.mcap", "run-2.mcap"] {
            expect(
                0,
                &["export", CAPTURE, "--to", "mcap", "-q", "-o", &file(name)],
            );
        }
        for name in ["square.txt", "course.csv"] {
            fs::write(file(name), "24,0\n24,24\n0,24\n0,0\n").unwrap();
        }
        fs::write(file("run.txt"), "mode prowl\nstop\n").unwrap();
        fs::create_dir(file("run")).unwrap();
        fs::set_permissions(file("run"), fs::Permissions::from_mode(0o700)).unwrap();
        Self {
            folder,
            configuration:
                "[robot.marvin]\nlink = \"shed\"\n[link.shed]\nport = \"usb:0403:6001\"\n"
                    .to_owned(),
            robots: Vec::new(),
            stations: Vec::new(),
            dashboards: Vec::new(),
        }
    }

    /// Writes a script or a configuration to the file that the examples name.
    fn write(&mut self, text: &str) {
        if text.starts_with('[') {
            text.clone_into(&mut self.configuration);
            let path = self.folder.join("example.toml");
            fs::write(&path, text).unwrap();
            expect(0, &["config", "check", path.to_str().unwrap()]);
        } else {
            fs::write(self.folder.join("run.txt"), text).unwrap();
        }
    }

    fn try_line(&mut self, line: &str) {
        let line = without_comment(line);
        match trial(line) {
            Trial::Foreign => {}
            Trial::Parse => assert_parses(line),
            Trial::Run => {
                let command = self.stand_in(line);
                let output = self.shell(&command).stdin(Stdio::null()).output().unwrap();
                let err = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "{line}\n{command}\n{err}");
            }
            Trial::Serve => {
                let command = format!("exec {}", self.stand_in(line));
                let mut command = self.shell(&command);
                let command = command.stdout(Stdio::piped()).stderr(Stdio::null());
                let mut robot = Running(command.spawn().unwrap());
                let mut path = String::new();
                let mut output = BufReader::new(robot.0.stdout.take().unwrap());
                output.read_line(&mut path).unwrap();
                assert!(
                    path.starts_with("/dev/") || path.starts_with("tcp:"),
                    "{line}: {path}"
                );
            }
            Trial::Dashboard => {
                let line = line.replace("cargo run --release --", "groundwave");
                let command = self.stand_in(&line);
                let script = self.script(&command);
                let mut dashboard = OnTerminal::start("sh", &["-c", &script], 120, 40);
                dashboard.wait_for(&line, |text| text.contains("map"));
                // Later examples use the link that it shares.
                if command.contains("--share") {
                    self.dashboards.push(dashboard);
                }
            }
        }
    }

    fn shell(&self, command: &str) -> Command {
        let mut shell = Command::new("sh");
        shell.args(["-c", &self.script(command)]);
        shell
    }

    /// A script that runs a command in this folder, which is also the home.
    fn script(&self, command: &str) -> String {
        let folder = self.folder.display();
        let programs = Path::new(GROUNDWAVE).parent().unwrap().display();
        format!(
            "cd {folder}; unset XDG_CONFIG_HOME XDG_STATE_HOME; export HOME={folder} XDG_RUNTIME_DIR={folder}/run \
             PATH={programs}:$PATH; {command}"
        )
    }

    /// The command with a simulated robot, a free port and this folder in place of those of the example.
    fn stand_in(&mut self, line: &str) -> String {
        let mut command = line.to_owned();
        for (link, arguments) in [
            ("/dev/ttyUSB0", &[][..]),
            (" PATH", &[]),
            ("tcp:robot.local:4000", &["--listen", "127.0.0.1:0"]),
            ("marvin", &[]),
        ] {
            if !command.split_whitespace().any(|word| word == link.trim()) {
                continue;
            }
            let robot = self.start_robot(arguments);
            if link == "marvin" {
                let folder = self.folder.join(".config/groundwave");
                fs::create_dir_all(&folder).unwrap();
                let text = self.configuration.replace("usb:0403:6001", &robot);
                // The simulated robot does not take turns.
                let text = text.replace("hc-12", "full");
                fs::write(folder.join("config.toml"), text).unwrap();
            } else {
                command = command.replace(link.trim(), &robot);
            }
        }
        let text = self.folder.join("evening.txt");
        if command.starts_with("LC_ALL") && command.contains("evening.txt") {
            fs::copy(CAPTURE, text).unwrap();
        }
        let folder = self.folder.to_str().unwrap().to_owned();
        command = command.replace("/tmp/", &format!("{folder}/"));
        if let Some((_, socket)) = command.split_once("unix:") {
            self.share_at(Path::new(socket.split_whitespace().next().unwrap()));
        }
        if command.starts_with("groundwave record") || command.contains("--tee") {
            // In a separate folder: nothing is overwritten.
            let folder = format!("recorded-{}", self.robots.len());
            fs::create_dir(self.folder.join(&folder)).unwrap();
            command = format!("cd {folder}; {command}");
        }
        command
            .replace("--duration 90m", "--duration 0.3s")
            .replace("--duration 1m", "--duration 1s")
            .replace("127.0.0.1:4000", "127.0.0.1:0")
    }

    fn start_robot(&mut self, arguments: &[&str]) -> String {
        let robot = Sim::start(&[&["--time-factor", "10"], arguments].concat());
        let path = robot.path.clone();
        self.robots.push(robot);
        path
    }

    /// A station that shares its link on a socket, unless an earlier example has started one.
    fn share_at(&mut self, socket: &Path) {
        if socket.exists() {
            return;
        }
        let robot = self.start_robot(&[]);
        let command = format!(
            "exec groundwave watch {robot} --headless --share {}",
            socket.display()
        );
        let station = self.shell(&command).stdout(Stdio::null()).spawn().unwrap();
        self.stations.push(Running(station));
        let deadline = Instant::now() + PATIENCE;
        while !socket.exists() {
            assert!(
                Instant::now() < deadline,
                "no station at {}",
                socket.display()
            );
            std::thread::yield_now();
        }
    }
}

fn without_comment(line: &str) -> &str {
    line.split_once("  #")
        .map_or(line, |(command, _)| command)
        .trim()
}
