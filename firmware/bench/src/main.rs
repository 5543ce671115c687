//! Runs the robot's program on emulated chips and compares the results with the host's, byte for byte.
//!
//! `cargo xtask emulator` and `cargo xtask microbit` build the chips' programs and run this one.

mod chip;
mod operator;
mod recorder;
mod scenario;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use clap::{Args, Parser, Subcommand};

use chip::Figures;
use scenario::Scenario;

/// Maximum number of cycles of a tick, including the other calls until the next one.
const TICK_CYCLES_MAX: u64 = 400_000;

/// Minimum RAM that the stack has never reached, bytes.
const SPARE_BYTES_MIN: usize = 1024;

/// Compares the robot's program on an emulated chip with the host's
#[derive(Debug, Parser)]
#[command(name = "sr04-bench")]
struct Arguments {
    #[command(subcommand)]
    chip: Chip,
}

#[derive(Debug, Subcommand)]
enum Chip {
    /// Repeat recorded runs on an emulated Arduino Mega
    Mega {
        /// Emulator's program
        #[arg(long, value_name = "FILE")]
        emulator: PathBuf,
        #[command(flatten)]
        replay: Replay,
    },
    /// Repeat recorded runs on an emulated micro:bit
    Microbit {
        #[command(flatten)]
        replay: Replay,
    },
}

#[derive(Debug, Args)]
struct Replay {
    /// Chip's program
    #[arg(value_name = "ELF")]
    program: PathBuf,
    /// Virtual duration of each run, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 600)]
    seconds: u64,
    /// First seed of each run
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of seeds of each run
    #[arg(long, value_name = "N", default_value_t = 1)]
    seeds: u64,
    /// Run only the scenario with this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Write the chip's bytes to the radio
    #[arg(long, value_name = "FILE", requires = "only")]
    save: Option<PathBuf>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let replay = match &arguments.chip {
        Chip::Mega { replay, .. } | Chip::Microbit { replay } => replay,
    };
    let scenarios: Vec<Scenario> = Scenario::all()
        .into_iter()
        .filter(|scenario| {
            replay.only.is_empty() || replay.only.iter().any(|name| name == scenario.name)
        })
        .collect();
    println!(
        "{:16} {:>8} {:>8} {:>8} {:>11} {:>11} {:>5} {:>8} {:>8}",
        "run", "seed", "calls", "bytes", "mean tick", "worst tick", "late", "stack B", "spare B"
    );
    let seeds = replay.seed..replay.seed.saturating_add(replay.seeds);
    let runs: Vec<(u64, &Scenario)> = seeds
        .flat_map(|seed| scenarios.iter().map(move |scenario| (seed, scenario)))
        .collect();
    let next = AtomicUsize::new(0);
    let failures = AtomicUsize::new(0);
    let worker = || {
        while let Some((seed, scenario)) = runs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let recording = scenario.record(*seed, replay.seconds * 1000);
            let outcome = recording.and_then(|recording| match &arguments.chip {
                Chip::Mega { emulator, replay } => {
                    chip::mega(emulator, &replay.program, &recording)
                }
                Chip::Microbit { replay } => chip::microbit(&replay.program, &recording),
            });
            let outcome = outcome.and_then(|figures| save(replay.save.as_deref(), figures));
            if !report(scenario.name, *seed, outcome) {
                failures.fetch_add(1, Ordering::Relaxed);
            }
        }
    };
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(worker);
        }
    });
    if runs.is_empty() || failures.into_inner() > 0 {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    }
}

/// Writes the chip's bytes to the radio.
fn save(path: Option<&Path>, figures: Figures) -> Result<Figures, String> {
    if let Some(path) = path {
        fs::write(path, &figures.downlink)
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(figures)
}

/// Prints the result of a run; returns `false` if it fails.
fn report(name: &str, seed: u64, outcome: Result<Figures, String>) -> bool {
    let figures = match outcome {
        Ok(figures) => figures,
        Err(error) => {
            println!("{name:16} {seed:>8} FAILED: {error}");
            return false;
        }
    };
    println!(
        "{name:16} {seed:>8} {:>8} {:>8} {:>11} {:>11} {:>5} {:>8} {:>8}",
        figures.calls,
        figures.downlink.len(),
        figures.mean_tick_cycles,
        figures.worst_tick_cycles,
        figures.late_ticks,
        figures.stack_bytes,
        figures.spare_bytes
    );
    let limits = [
        (
            figures.worst_tick_cycles > TICK_CYCLES_MAX,
            format!("a tick takes more than {TICK_CYCLES_MAX} cycles"),
        ),
        (figures.late_ticks > 0, "a tick is late".to_owned()),
        (
            figures.spare_bytes < SPARE_BYTES_MIN,
            format!("less than {SPARE_BYTES_MIN} bytes of RAM are spare"),
        ),
    ];
    for (_, problem) in limits.iter().filter(|(is_broken, _)| *is_broken) {
        println!("{name:16} {seed:>8} FAILED: {problem}");
    }
    !limits.iter().any(|(is_broken, _)| *is_broken)
}
