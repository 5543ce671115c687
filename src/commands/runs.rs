//! `runs`: captures with their labels and figures.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::cli::Runs;
use super::{Exit, Fault, say};
use crate::capture::recover::{Interrupted, find_interrupted};
use crate::capture::runs::folder::{self, Run, RunError};
use crate::hint;
use crate::run::{Figures, HEADING};

pub(super) fn run(options: &Runs) -> Result<(), Fault> {
    let mut fault: Option<Fault> = None;
    let mut out = io::stdout().lock();
    let mut shown = 0;
    let mut interrupted = Vec::new();
    for path in &options.paths {
        if path.is_dir() {
            let found = find_interrupted(path).into_iter();
            interrupted.extend(
                found.filter_map(|file| {
                    Interrupted::find(file.strip_prefix(".").unwrap_or(&file), 0)
                }),
            );
        }
        let captures = captures(path).unwrap_or_else(|found| {
            note(&mut fault, Some(found));
            Vec::new()
        });
        for capture in captures {
            match read(&capture) {
                Ok((figures, problem)) => {
                    if let Err(error) = write(&mut out, &figures, options.json, shown == 0) {
                        return Fault::output(&error);
                    }
                    shown += 1;
                    note(&mut fault, problem);
                }
                Err(found) => note(&mut fault, Some(found)),
            }
        }
    }
    for recording in &interrupted {
        if options.json {
            say(format_args!("groundwave: {recording}"));
        } else if let Err(error) = writeln!(out, "{recording}") {
            return Fault::output(&error);
        }
    }
    if shown == 0 && interrupted.is_empty() && fault.is_none() {
        say("no finished captures here; `groundwave demo --record` makes one");
    }
    fault.map_or(Ok(()), Err)
}

/// Prints the earlier fault and keeps the new one for the caller.
fn note(fault: &mut Option<Fault>, found: Option<Fault>) {
    if let Some(found) = found
        && let Some(earlier) = fault.replace(found)
    {
        say(format_args!("groundwave: {earlier}"));
    }
}

/// Reads the figures of a run, and the fault if they are incomplete.
fn read(path: &Path) -> Result<(Figures, Option<Fault>), Fault> {
    let run = read_run(path)?;
    let problem = run.problem.map(Fault::from);
    match problem {
        Some(problem) if run.course.points().is_empty() => Err(problem),
        problem => Ok((run.figures, problem)),
    }
}

/// Reads a run.
pub(super) fn read_run(path: &Path) -> Result<Run, Fault> {
    Run::read(path).map_err(|error| match error {
        RunError::Label(error) => Fault::new(Exit::Usage, error),
        RunError::Capture(error) => Fault::from(error),
    })
}

/// The file itself, or the captures in a folder, by name.
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
