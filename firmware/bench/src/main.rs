//! Runs the robot's program on emulated chips and compares the results with the host's, byte for byte.
//!
//! `cargo xtask emulator` and `cargo xtask microbit` build the chips' programs and run this one.

mod board;
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

use board::Programs;
use chip::Figures;
use recorder::Recording;
use scenario::Scenario;

/// Maximum number of cycles of a tick, including the other calls until the next one.
const TICK_CYCLES_MAX: u64 = 400_000;

/// Minimum RAM that the stack has never reached, bytes.
const SPARE_BYTES_MIN: usize = 1024;

/// Time for which both directions of the board's radio are busy.
const SATURATED_S: u64 = 60;

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
    /// Run the whole board of an Arduino Mega in a simulated house
    Board(Board),
    /// Repeat recorded runs on an emulated micro:bit
    Microbit {
        #[command(flatten)]
        replay: Replay,
    },
}

#[derive(Debug, Args)]
struct Board {
    /// Board's program with every sensor
    #[arg(value_name = "ELF")]
    program: PathBuf,
    /// Emulator's program
    #[arg(long, value_name = "FILE")]
    emulator: PathBuf,
    /// Board's program without sensors
    #[arg(long, value_name = "ELF")]
    bare: PathBuf,
    /// Board's program with a display and a half-duplex radio
    #[arg(long, value_name = "ELF")]
    half: PathBuf,
    /// Address of the function that a panic calls, hexadecimal
    #[arg(long, value_name = "ADDRESS", value_parser = |text: &str| u32::from_str_radix(text, 16))]
    panic_at: u32,
    /// Ground station's program
    #[arg(long, value_name = "FILE")]
    groundwave: PathBuf,
    /// Virtual duration of the drive in the house, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 300)]
    seconds: u64,
    /// Seed of the worlds
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Number of seeds
    #[arg(long, value_name = "N", default_value_t = 1)]
    seeds: u64,
    /// Only the check of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Write the board's bytes to the radio while it drives in the house
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
}

#[derive(Debug, Args)]
struct Replay {
    /// Chip's program
    #[arg(value_name = "ELF")]
    program: PathBuf,
    /// Virtual duration of each run, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 180)]
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
    match Arguments::parse().chip {
        Chip::Mega { emulator, replay } => repeat(&replay, |recording| {
            chip::mega(&emulator, &replay.program, recording)
        }),
        Chip::Microbit { replay } => repeat(&replay, |recording| {
            chip::microbit(&replay.program, recording)
        }),
        Chip::Board(options) => run_board(options),
    }
}

/// Records runs on the host and repeats them on a chip.
fn repeat(
    replay: &Replay,
    on_chip: impl Fn(&Recording) -> Result<Figures, String> + Sync,
) -> ExitCode {
    let scenarios = Scenario::all();
    let runs: Vec<(&str, &Scenario)> = scenarios
        .iter()
        .filter(|run| is_wanted(&replay.only, run.name))
        .map(|run| (run.name, run))
        .collect();
    run_all(replay.seed, replay.seeds, &runs, |scenario, seed| {
        let recording = scenario.record(seed, replay.seconds * 1000)?;
        save(replay.save.as_deref(), on_chip(&recording)?)
    })
}

/// A check of the board with a seed.
type Check<'a> = &'a (dyn Fn(u64) -> Result<Figures, String> + Sync);

/// Runs the checks of the whole board.
fn run_board(options: Board) -> ExitCode {
    let programs = Programs {
        emulator: options.emulator,
        full: options.program,
        bare: options.bare,
        half: options.half,
        panic_at: options.panic_at,
        groundwave: options.groundwave,
    };
    let checks: [(&str, Check); 9] = [
        ("station", &|seed| board::station(&programs, seed)),
        ("lockstep", &|seed| {
            let figures = board::lockstep(&programs, seed, options.seconds)?;
            save(options.save.as_deref(), figures)
        }),
        ("saturated", &|seed| {
            board::saturated(&programs, seed, SATURATED_S)
        }),
        ("resets", &|seed| board::resets(&programs, seed)),
        ("power-lost", &|seed| board::power_lost(&programs, seed)),
        ("half-duplex", &|seed| board::half_duplex(&programs, seed)),
        ("by-hand", &|seed| board::by_hand(&programs, seed)),
        ("display", &|seed| board::display(&programs, seed)),
        ("bare", &|seed| board::bare(&programs, seed)),
    ];
    let wanted: Vec<(&str, Check)> = checks
        .into_iter()
        .filter(|(name, _)| is_wanted(&options.only, name))
        .collect();
    run_all(options.seed, options.seeds, &wanted, |check, seed| {
        check(seed)
    })
}

fn is_wanted(only: &[String], name: &str) -> bool {
    only.is_empty() || only.iter().any(|wanted| wanted == name)
}

/// Runs each with each seed on all cores and prints its figures.
fn run_all<T: Copy + Sync>(
    seed: u64,
    seeds: u64,
    runs: &[(&str, T)],
    run: impl Fn(T, u64) -> Result<Figures, String> + Sync,
) -> ExitCode {
    println!(
        "{:16} {:>8} {:>8} {:>8} {:>11} {:>11} {:>5} {:>8} {:>8}",
        "run", "seed", "calls", "bytes", "mean tick", "worst tick", "late", "stack B", "spare B"
    );
    let seeds = seed..seed.saturating_add(seeds);
    let runs: Vec<(u64, &str, T)> = seeds
        .flat_map(|seed| runs.iter().map(move |&(name, what)| (seed, name, what)))
        .collect();
    let next = AtomicUsize::new(0);
    let failures = AtomicUsize::new(0);
    let worker = || {
        while let Some(&(seed, name, what)) = runs.get(next.fetch_add(1, Ordering::Relaxed)) {
            if !report(name, seed, run(what, seed)) {
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
