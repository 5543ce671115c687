//! `cargo xtask check`: everything that needs nothing but Rust. `cargo xtask ci`: that, the
//! microcontroller and the outside judges. `cargo xtask acceptance` tries what is claimed of the robot.

mod licences;
mod mutants;

use std::env;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

/// A step's name and what it does; an error says what went wrong.
type Step = (&'static str, fn() -> Result<(), String>);

const CHECK: &[Step] = &[
    ("format", || cargo(&["fmt", "--all", "--check"])),
    ("clippy", || {
        cargo(&[
            "clippy",
            "--workspace",
            "--all-targets",
            "--all-features",
            "--locked",
            "--",
            "-D",
            "warnings",
        ])
    }),
    ("test", || {
        cargo(&["test", "--workspace", "--all-features", "--locked"])
    }),
    ("doc", || {
        run(Command::new(cargo_path())
            .args([
                "doc",
                "--workspace",
                "--all-features",
                "--no-deps",
                "--locked",
            ])
            .env("RUSTDOCFLAGS", "-D warnings"))
    }),
    ("licences", licences::check),
    ("mutants", mutants::check),
    ("acceptance", || acceptance(&["--short".to_owned()])),
];

const OUTSIDE: &[Step] = &[
    ("avr", || {
        run(Command::new("bash").arg("firmware/boards/check-avr.sh"))
    }),
    ("stranger", stranger),
    ("judges", || {
        run(Command::new("bash").arg("tests/judges/run.sh"))
    }),
    ("live", || {
        run(Command::new("bash").arg("tests/judges/live/run.sh"))
    }),
];

fn main() -> ExitCode {
    let wanted = env::args().nth(1);
    if wanted.as_deref() == Some("acceptance") {
        let arguments: Vec<String> = env::args().skip(2).collect();
        return match acceptance(&arguments) {
            Ok(()) => ExitCode::SUCCESS,
            Err(error) => {
                eprintln!("xtask: acceptance: {error}");
                ExitCode::FAILURE
            }
        };
    }
    let steps: Vec<Step> = match wanted.as_deref() {
        Some("check") => CHECK.to_vec(),
        Some("ci") => [CHECK, OUTSIDE].concat(),
        Some(name) => [CHECK, OUTSIDE]
            .concat()
            .into_iter()
            .filter(|(step, _)| *step == name)
            .collect(),
        None => Vec::new(),
    };
    if steps.is_empty() {
        let names: Vec<&str> = [CHECK, OUTSIDE]
            .concat()
            .iter()
            .map(|(name, _)| *name)
            .collect();
        eprintln!("usage: cargo xtask check | ci | {}", names.join(" | "));
        return ExitCode::from(2);
    }
    for (name, step) in steps {
        println!("== {name}");
        let began = Instant::now();
        if let Err(error) = step() {
            eprintln!("xtask: {name}: {error}");
            return ExitCode::FAILURE;
        }
        println!("== {name}: ok, {:.0} s", began.elapsed().as_secs_f32());
    }
    ExitCode::SUCCESS
}

/// Tries what is claimed of the robot; `--help` says how.
fn acceptance(arguments: &[String]) -> Result<(), String> {
    let run = [
        "run",
        "--release",
        "--quiet",
        "--locked",
        "-p",
        "sr04-trials",
        "--",
    ];
    let arguments = run.into_iter().chain(arguments.iter().map(String::as_str));
    cargo(&arguments.collect::<Vec<_>>())
}

/// A decoder written from SPEC.md alone agrees with ours.
fn stranger() -> Result<(), String> {
    run(Command::new("python3").arg("protocol/stranger/check.py"))
}

fn cargo(arguments: &[&str]) -> Result<(), String> {
    run(Command::new(cargo_path()).args(arguments))
}

fn cargo_path() -> String {
    env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned())
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command
        .current_dir(root())
        .status()
        .map_err(|error| format!("cannot start {command:?}: {error}"))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{command:?} ended with {status}"))
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .map_or_else(PathBuf::new, Path::to_path_buf)
}
