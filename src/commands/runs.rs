//! `runs`: lists captures with their labels and figures.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::cli::Runs;
use super::{Exit, Fault, out, say, say_fault};
use crate::capture::CaptureError;
use crate::capture::name::utc;
use crate::capture::runs::folder::{self, Run, RunError};
use crate::capture::track::Track;
use crate::figures::{Figures, HEADING};
use crate::hint;

pub(super) fn run(options: &Runs) -> Result<(), Fault> {
    let mut fault: Option<Fault> = None;
    let mut out = out();
    let mut runs = Vec::new();
    let mut undated = 0;
    let mut interrupted = Vec::new();
    for path in &options.paths {
        let captures = captures(path).unwrap_or_else(|found| {
            note(&mut fault, Some(found));
            Vec::new()
        });
        for capture in captures {
            let run = match read_run(&capture) {
                Ok(run) => run,
                Err(found) => {
                    note(&mut fault, Some(found));
                    continue;
                }
            };
            let is_empty = run.course.points().is_empty();
            match run.problem {
                Some(unfinished @ CaptureError::Unfinished { .. }) => interrupted.push(unfinished),
                Some(problem) => {
                    note(&mut fault, Some(problem.into()));
                    if is_empty {
                        continue;
                    }
                }
                None => {}
            }
            match is_within(options, run.figures.start.as_deref()) {
                Some(true) => runs.push(run.figures),
                Some(false) => {}
                None => undated += 1,
            }
        }
    }
    folder::sort(&mut runs);
    for (row, run) in runs.iter().enumerate() {
        if let Err(error) = write(&mut out, run, options.json, row == 0) {
            return Fault::output(&error);
        }
    }
    if undated > 0 {
        let plural = if undated == 1 { "" } else { "s" };
        say(format_args!(
            "left out {undated} capture{plural} without a date"
        ));
    }
    for recording in &interrupted {
        if options.json {
            say(format_args!("groundwave: {recording}"));
        } else if let Err(error) = writeln!(out, "{recording}") {
            return Fault::output(&error);
        }
    }
    if runs.is_empty() && fault.is_none() {
        say(if options.since.is_some() || options.until.is_some() {
            "no finished captures here from that time"
        } else {
            "no finished captures here; `groundwave demo --record` makes one"
        });
    }
    fault.map_or(Ok(()), Err)
}

/// Whether a run started within the wanted time; `None` if its start is needed and unknown.
fn is_within(options: &Runs, start: Option<&str>) -> Option<bool> {
    // Dates in one format sort as text.
    let since = options.since.map(|since| utc(since.start));
    let until = options.until.map(|until| utc(until.end));
    if since.is_none() && until.is_none() {
        return Some(true);
    }
    let start = start?;
    let is_late_enough = since.is_none_or(|since| start >= since.as_str());
    Some(is_late_enough && until.is_none_or(|until| start < until.as_str()))
}

/// Prints the earlier fault and keeps the new one for the caller.
fn note(fault: &mut Option<Fault>, found: Option<Fault>) {
    if let Some(found) = found
        && let Some(earlier) = fault.replace(found)
    {
        say_fault(&earlier);
    }
}

/// Reads a run.
pub(super) fn read_run(path: &Path) -> Result<Run, Fault> {
    Run::read(path).map_err(fault)
}

/// Reads a run and its track.
pub(super) fn read_run_with_track(path: &Path) -> Result<(Run, Track), Fault> {
    Run::read_with_track(path).map_err(fault)
}

fn fault(error: RunError) -> Fault {
    match error {
        RunError::Label(error) => Fault::new(Exit::Usage, error),
        RunError::Capture(error) => Fault::from(error),
    }
}

/// The file itself, or the captures in a folder, sorted by name.
fn captures(path: &Path) -> Result<Vec<PathBuf>, Fault> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let unreadable = |error: io::Error| {
        Fault::new(
            Exit::Usage,
            format!(
                "cannot read {}: {}",
                path.display(),
                hint::of_reading(&error)
            ),
        )
    };
    folder::captures(path).map_err(unreadable)
}

fn write(out: &mut impl Write, run: &Figures, json: bool, first: bool) -> io::Result<()> {
    if json {
        serde_json::to_writer(&mut *out, run)?;
        return writeln!(out);
    }
    if first {
        writeln!(out, "{HEADING}")?;
    }
    writeln!(out, "{run}")
}
