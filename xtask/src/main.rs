//! Checks for developers and CI: `cargo xtask check` needs only Rust, `cargo xtask ci` adds the microcontroller
//! and the judges (other people's programs), `cargo xtask nightly` tests many other seeds. `cargo xtask STEP` runs one step.

mod avr;
mod chips;
mod cross;
mod debian;
mod dist;
mod licences;
mod mega;
mod mutants;
mod nightly;
mod publish;
mod wiring;

use std::env;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

use serde_json::Value;

/// Name and function of a step; the function returns an error message.
type Step = (&'static str, fn() -> Result<(), String>);

/// Options of every build: one set of features, so that dependencies are built once.
const EVERYTHING: &[&str] = if cfg!(windows) {
    &[
        "--workspace",
        "--exclude",
        BENCH,
        "--all-features",
        "--locked",
    ]
} else {
    &["--workspace", "--all-features", "--locked"]
};

/// Runs chips' programs in emulators; needs pseudo-terminals.
const BENCH: &str = "sr04-bench";

const CHECK: &[Step] = &[
    ("format", || cargo(&["fmt", "--all", "--check"])),
    ("clippy", clippy),
    ("test", test),
    ("doc", doc),
    ("licences", licences::check),
];

const OUTSIDE: &[Step] = &[
    ("avr", avr::check),
    ("emulator", chips::emulator),
    ("board", chips::board),
    ("microbit", chips::microbit),
    ("pico", chips::pico),
    ("c", || {
        run(Command::new("python3").arg("protocol/c/test/check.py"))
    }),
    ("reference", || {
        run(Command::new("python3").arg("protocol/reference/check.py"))
    }),
    ("judges", || judge("tests/judges/run.sh")),
    ("live", || judge("tests/judges/live/run.sh")),
];

const NIGHTLY: &[Step] = &[
    ("seeds", nightly::seeds),
    ("fuzz", nightly::fuzz),
    ("mutants", mutants::check),
    ("trials", nightly::trials),
    ("chips", chips::night),
    ("hex", mega::hex),
    ("linux", cross::linux),
    ("windows", cross::windows),
    ("macos", cross::macos),
    ("packages", dist::check),
    ("published", publish::check),
];

fn main() -> ExitCode {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if env::var_os(debian::AS_RUSTC).is_some() {
        return debian::rustc(&arguments);
    }
    let all = [CHECK, OUTSIDE, NIGHTLY].concat();
    let steps: Vec<Step> = match arguments.first().map(String::as_str) {
        Some("flash") => return ended(mega::flash(&arguments[1..]), "flash"),
        Some("wiring") => return ended(wiring::write(), "wiring"),
        Some("dist") => return ended(dist::make(), "dist"),
        Some("acceptance") => return ended(acceptance(&arguments[1..]), "acceptance"),
        Some("check") => CHECK.to_vec(),
        Some("ci") => [CHECK, OUTSIDE].concat(),
        Some("nightly") => NIGHTLY.to_vec(),
        name => all
            .iter()
            .copied()
            .filter(|(step, _)| Some(*step) == name)
            .collect(),
    };
    if steps.is_empty() {
        let names: Vec<&str> = all.iter().map(|(name, _)| *name).collect();
        eprintln!(
            "usage: cargo xtask check | ci | nightly | acceptance [OPTIONS] | dist | flash mega2560 PORT | wiring | {}",
            names.join(" | ")
        );
        return ExitCode::from(2);
    }
    run_steps(&steps)
}

/// Runs the steps in order up to the first failure; prints the duration of each and writes the table to
/// `target/steps.md`.
fn run_steps(steps: &[Step]) -> ExitCode {
    let began = Instant::now();
    let mut table = "| step | s |\n|---|---|\n".to_owned();
    let mut outcome = ExitCode::SUCCESS;
    for (name, step) in steps {
        println!("== {name}");
        let step_began = Instant::now();
        let result = step();
        let seconds = step_began.elapsed().as_secs();
        // Writing to a string cannot fail.
        let _ = writeln!(table, "| {name} | {seconds} |");
        if result.is_err() {
            outcome = ended(result, name);
            break;
        }
    }
    let _ = writeln!(table, "| in all | {} |", began.elapsed().as_secs());
    println!("{table}");
    if let Err(error) = fs::write(root().join("target/steps.md"), &table) {
        eprintln!("xtask: cannot write target/steps.md: {error}");
    }
    outcome
}

fn ended(result: Result<(), String>, step: &str) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {step}: {error}");
            ExitCode::FAILURE
        }
    }
}

fn clippy() -> Result<(), String> {
    let arguments = [
        &["clippy", "--all-targets"],
        EVERYTHING,
        &["--", "-D", "warnings"],
    ];
    cargo(&arguments.concat())
}

fn doc() -> Result<(), String> {
    run(Command::new(cargo_path())
        .args(["doc", "--no-deps"])
        .args(EVERYTHING)
        .env("RUSTDOCFLAGS", "-D warnings"))
}

/// Runs a judge (other people's program) for ten minutes at most (a minute is usual).
fn judge(script: &str) -> Result<(), String> {
    let program = build("groundwave")?;
    run(Command::new("timeout")
        .args(["--verbose", "--kill-after=10", "600", "bash", script])
        .env("GROUNDWAVE", program))
}

/// Runs the trials of the robot; `--help` describes the options.
fn acceptance(arguments: &[String]) -> Result<(), String> {
    run(Command::new(build("sr04-trials")?).args(arguments))
}

/// Builds a program and a test: without a test, the dependencies would have fewer features than in the step `test`, and
/// cargo would compile most of them and the station again.
fn build(program: &str) -> Result<PathBuf, String> {
    cargo(&[&["build", "--bin", program, "--test", "system"], EVERYTHING].concat())?;
    Ok(root().join("target/debug").join(program))
}

/// Runs the tests, more of them at once than there are cores: many wait for a pseudo-terminal or a process.
fn test() -> Result<(), String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut command = Command::new(cargo_path());
    command.arg("test").args(EVERYTHING);
    if env::var_os("RUST_TEST_THREADS").is_none() {
        command.env("RUST_TEST_THREADS", (2 * cores).to_string());
    }
    run(&mut command)
}

fn cargo(arguments: &[&str]) -> Result<(), String> {
    run(Command::new(cargo_path()).args(arguments))
}

fn cargo_path() -> String {
    env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned())
}

/// Runs a command, by default in the workspace's root.
fn run(command: &mut Command) -> Result<(), String> {
    if command.get_current_dir().is_none() {
        command.current_dir(root());
    }
    let status = command
        .status()
        .map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{command:?} ended with {status}"))
    }
}

/// Standard output of a command.
fn capture(command: &mut Command) -> Result<String, String> {
    if command.get_current_dir().is_none() {
        command.current_dir(root());
    }
    let output = command
        .output()
        .map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr);
        return Err(format!(
            "{command:?} ended with {}: {errors}",
            output.status
        ));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// What cargo knows of the workspace's packages.
fn metadata(options: &[&str]) -> Result<Value, String> {
    let text = capture(
        Command::new(cargo_path())
            .args(["metadata", "--format-version", "1", "--locked"])
            .args(options),
    )?;
    serde_json::from_str(&text).map_err(|error| format!("cannot read cargo metadata: {error}"))
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .map_or_else(PathBuf::new, Path::to_path_buf)
}
