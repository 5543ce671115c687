//! Time until the robot has confirmed a command: the real station, the robot's real program and a radio that flips
//! bits, in virtual time, compared with the lower bound and with MAVLink's mission protocol over the same radio. Prints
//! Markdown.
//!
//!     cargo bench --bench delivery                                 everything
//!     cargo bench --bench delivery -- full 100 3e-3 --seeds 50     one cell
//!     cargo bench --bench delivery -- half 100 mavlink             a row, with MAVLink beside it
//!     cargo bench --bench delivery -- commands                     one section: lists commands stop cold
//!
//! Arguments select `full` or `half`, a number of waypoints (10, 100, 300), a bit error rate (0, 1e-4, 1e-3, 3e-3 or
//! any other) or `burst`. The same seeds give the same figures on every machine.

#[path = "../../tests/common/mod.rs"]
mod common;
mod mavlink;
mod ours;
mod report;
mod selection;

use report::Times;
use selection::{Duplex, Section, Selection};

fn main() {
    let selection = match Selection::from_words(std::env::args().skip(1)) {
        Ok(selection) => selection,
        Err(problem) => {
            eprintln!("{problem}");
            std::process::exit(2);
        }
    };
    for section in &selection.sections {
        match section {
            Section::Lists => lists(&selection),
            Section::Commands => commands(&selection),
            Section::Stop => stop(&selection),
            Section::Cold => cold(&selection),
        }
        println!();
    }
}

/// Time until a list is confirmed, seconds: mean and 95th percentile.
fn lists(selection: &Selection) {
    println!(
        "Lists, {} seeds a cell: mean (95 % within), seconds",
        selection.seeds
    );
    println!();
    report::header(&[&["", "waypoints"], &selection.channel_names()[..]].concat());
    for count in &selection.counts {
        let bounds = selection
            .channels
            .iter()
            .map(|c| format!("{:.2}", report::bound_s(c, *count)));
        report::row(
            ["lower bound".to_owned(), count.to_string()]
                .into_iter()
                .chain(bounds),
        );
        for &duplex in &selection.duplexes {
            let cells = selection.channels.iter().map(|channel| {
                let times = common::on_all_cores(0..selection.seeds, |seed| {
                    ours::list_s(duplex, channel, seed, *count)
                });
                Times::of(times).to_string()
            });
            report::row(
                [duplex.to_string(), count.to_string()]
                    .into_iter()
                    .chain(cells),
            );
        }
        if selection.mavlink {
            for duplex in &selection.duplexes {
                mavlink_row(selection, *duplex, *count);
            }
        }
    }
}

fn mavlink_row(selection: &Selection, duplex: Duplex, count: usize) {
    // On a half-duplex radio, a vehicle that sends telemetry all the time cannot receive.
    let telemetry = match duplex {
        Duplex::Full => &[true, false][..],
        Duplex::Half => &[false],
    };
    for telemetry in telemetry {
        let cells = selection.channels.iter().map(|channel| {
            let spec = duplex.over(channel);
            let times = common::on_all_cores(0..selection.seeds, |seed| {
                mavlink::upload_s(&spec, seed, count, *telemetry)
            });
            Times::of(times).to_string()
        });
        let silent = if *telemetry { "" } else { ", no telemetry" };
        let name = format!("MAVLink, {duplex}{silent}");
        report::row([name, count.to_string()].into_iter().chain(cells));
    }
}

/// Time until a single command is confirmed, seconds.
fn commands(selection: &Selection) {
    println!(
        "One command, session open, {} seeds a cell: seconds",
        selection.seeds
    );
    println!();
    report::header(&["", "bit error rate", "mean", "95 % within", "slowest"]);
    for &duplex in &selection.duplexes {
        for channel in ["", "ber=1e-3"] {
            let times = common::on_all_cores(0..selection.seeds, |seed| {
                ours::command_s(duplex, channel, seed)
            });
            report::row(Times::of(times).columns(&duplex.to_string(), channel));
        }
    }
}

/// The same for a station that has received nothing and has no session.
fn cold(selection: &Selection) {
    println!(
        "Cold: a station that has heard nothing, no session, {} seeds a cell: seconds",
        selection.seeds
    );
    println!();
    report::header(&["", "bit error rate", "mean", "95 % within", "slowest"]);
    for &duplex in &selection.duplexes {
        for count in [None, Some(100)] {
            for channel in ["", "ber=1e-3"] {
                let times = common::on_all_cores(0..selection.seeds, |seed| {
                    ours::cold_s(duplex, channel, seed, count)
                });
                let what = count.map_or("one command".to_owned(), |n| format!("{n} waypoints"));
                let name = format!("{duplex}, {what}");
                report::row(Times::of(times).columns(&name, channel));
            }
        }
    }
}

/// Time from the key until the motors are off and the wheels stand still.
fn stop(selection: &Selection) {
    const PHASES_MS: u64 = 2000;
    println!(
        "STOP in mid-transfer on a clean link, key pressed at each of {PHASES_MS} ms: milliseconds"
    );
    println!();
    report::header(&["", "what", "mean", "slowest"]);
    for &duplex in &selection.duplexes {
        let stops = common::on_all_cores(0..PHASES_MS, |phase| ours::stop_ms(duplex, phase));
        for (index, (what, _)) in ours::STOP_EFFECTS.iter().enumerate() {
            let all: Vec<u64> = stops.iter().map(|(_, times)| times[index]).collect();
            let mean_ms = all.iter().sum::<u64>() / PHASES_MS;
            let slowest_ms = all.iter().max().copied().unwrap_or_default();
            report::row([
                duplex.to_string(),
                (*what).to_owned(),
                mean_ms.to_string(),
                slowest_ms.to_string(),
            ]);
        }
    }
    println!();
    println!(
        "STOP on any channel, {} seeds a row: seconds",
        selection.seeds
    );
    println!();
    report::header(&["", "bit error rate", "mean", "95 % within", "slowest"]);
    for &duplex in &selection.duplexes {
        for channel in ["", "ber=1e-3", "ber=3e-3"] {
            let stops = common::on_all_cores(0..selection.seeds, |seed| {
                ours::stop_s(duplex, channel, seed)
            });
            let effect = stops.iter().map(|(seed, (effect, _))| (*seed, *effect));
            let confirmation = stops
                .iter()
                .map(|(seed, (_, confirmation))| (*seed, *confirmation));
            let (effect, confirmation) = (
                Times::of(effect.collect()),
                Times::of(confirmation.collect()),
            );
            report::row(effect.columns(&format!("{duplex}, robot in mode stop"), channel));
            report::row(confirmation.columns(&format!("{duplex}, confirmed"), channel));
        }
    }
}
