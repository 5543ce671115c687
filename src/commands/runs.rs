//! `runs`: captures with their labels and figures.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::cli::Runs;
use super::{Exit, Fault, out, say, say_fault};
use crate::capture::CaptureError;
use crate::capture::runs::folder::{self, Run, RunError};
use crate::capture::track::Track;
use crate::figures::{Figures, HEADING};
use crate::hint;

pub(super) fn run(options: &Runs) -> Result<(), Fault> {
    let mut fault: Option<Fault> = None;
    let mut out = out();
    let mut shown = 0;
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
            if let Err(error) = write(&mut out, &run.figures, options.json, shown == 0) {
                return Fault::output(&error);
            }
            shown += 1;
        }
    }
    for recording in &interrupted {
        if options.json {
            say(format_args!("groundwave: {recording}"));
        } else if let Err(error) = writeln!(out, "{recording}") {
            return Fault::output(&error);
        }
    }
    if shown == 0 && fault.is_none() {
        say("no finished captures here; `groundwave demo --record` makes one");
    }
    fault.map_or(Ok(()), Err)
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
