//! Acceptance trials of the SR04: tests every claim about the robot in fixed worlds.
//!
//! `cargo xtask acceptance` runs them; README.md describes the options.

mod arena;
mod calibration;
mod claim;
mod claims;
mod parallel;
mod run;
mod seeds;
mod statistics;
mod table;

use std::cell::Cell;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use clap::Parser;

use claim::{Experiment, Reading, Trial};
use seeds::{Purpose, Seed};
use table::Row;

/// Tries every claim about the robot and prints a table.
#[derive(Debug, Parser)]
#[command(name = "cargo xtask acceptance")]
struct Arguments {
    /// Run fewer trials, as CI does
    #[arg(long)]
    short: bool,
    /// Run only the experiment of this name; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
    /// Number of trials of each experiment
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..10_000))]
    seeds: Option<u64>,
    /// Share of the trials of each experiment to run, in percent
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=100))]
    percent: u64,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=256))]
    threads: Option<u64>,
    /// Use tuning seeds instead of reported ones
    #[arg(long)]
    tuning: bool,
    /// Run one trial by its number and print its readings
    #[arg(long, value_name = "N", requires = "only")]
    trial: Option<usize>,
    /// Write every tick of that trial to a CSV file
    #[arg(long, value_name = "FILE", requires = "trial")]
    trace: Option<PathBuf>,
    /// Print the readings of each trial
    #[arg(long)]
    readings: bool,
    /// Fail if this file does not contain the printed table
    #[arg(long, value_name = "FILE")]
    check: Option<PathBuf>,
}

fn main() -> ExitCode {
    match accept(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("acceptance: {problem}");
            ExitCode::FAILURE
        }
    }
}

fn accept(arguments: &Arguments) -> Result<(), String> {
    let experiments = chosen(&arguments.only)?;
    if let Some(index) = arguments.trial {
        for experiment in experiments {
            let readings = one(experiment, index, arguments);
            println!("{} trial {index}: {readings:?}", experiment.name);
        }
        return Ok(());
    }
    let rows: Vec<Row> = experiments
        .into_iter()
        .flat_map(|experiment| all(experiment, arguments))
        .collect();
    let table = table::markdown(&rows);
    print!("{table}");
    if let Some(path) = &arguments.check {
        let text = fs::read_to_string(path)
            .map_err(|error| format!("cannot read {}: {error}", path.display()))?;
        if !text.contains(&table) {
            return Err(format!(
                "{} does not contain this table: after an intended change of the robot, copy the table there",
                path.display()
            ));
        }
    }
    let missed: Vec<&str> = rows
        .iter()
        .filter(|row| row.is_alarming())
        .map(Row::says)
        .collect();
    if missed.is_empty() {
        Ok(())
    } else {
        Err(format!(
            "missed with the whole interval:\n  {}",
            missed.join("\n  ")
        ))
    }
}

fn chosen(only: &[String]) -> Result<Vec<&'static Experiment>, String> {
    let all = claims::all();
    let names = || all.iter().map(|experiment| experiment.name);
    if let Some(unknown) = only
        .iter()
        .find(|name| !names().any(|known| known == *name))
    {
        let known: Vec<&str> = names().collect();
        return Err(format!(
            "unknown experiment `{unknown}`: use one of {}",
            known.join(", ")
        ));
    }
    Ok(all
        .into_iter()
        .filter(|experiment| only.is_empty() || only.iter().any(|name| name == experiment.name))
        .collect())
}

fn one(experiment: &Experiment, index: usize, arguments: &Arguments) -> Vec<Option<Reading>> {
    let purpose = if arguments.tuning {
        Purpose::Tuning
    } else {
        Purpose::Report
    };
    let readings = (experiment.run)(&Trial {
        index,
        seed: Seed::nth(purpose, index),
        trace: arguments.trace.clone(),
        traced: Cell::new(0),
    });
    assert_eq!(
        readings.len(),
        experiment.claims.len(),
        "{} must give a reading for each of its claims",
        experiment.name
    );
    readings
}

/// Rows of one experiment.
fn all(experiment: &'static Experiment, arguments: &Arguments) -> Vec<Row> {
    let [short, long] = experiment.trials;
    let usual = if arguments.short { short } else { long };
    let usual = (usual * arguments.percent as usize).div_ceil(100);
    let trials = arguments.seeds.map_or(usual, |seeds| seeds as usize);
    if trials == 0 {
        return Vec::new();
    }
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments
        .threads
        .map_or_else(cores, |threads| threads as usize);
    let begun = Instant::now();
    let trials = parallel::map(trials, threads, |index| one(experiment, index, arguments));
    eprintln!(
        "{}: {:.1} s",
        experiment.name,
        begun.elapsed().as_secs_f64()
    );
    if arguments.readings {
        for (index, readings) in trials.iter().enumerate() {
            eprintln!("  {index}: {readings:?}");
        }
    }
    experiment
        .claims
        .iter()
        .enumerate()
        .map(|(place, claim)| {
            let readings: Vec<Reading> = trials
                .iter()
                .filter_map(|readings| readings.get(place).copied().flatten())
                .collect();
            Row::new(claim, &readings)
        })
        .collect()
}
