//! `runs`: the captures there are, with what their operator says of them.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use groundwave_protocol::decoder::Decoder;

use super::cli::Runs;
use super::{Exit, Fault, keeping, say};
use crate::capture::Capture;
use crate::capture::recover::{Interrupted, find_interrupted};
use crate::capture::runs::comparison::Figures;
use crate::capture::runs::{Course, Label};
use crate::remedy;

/// A file without one line of a robot in so many bytes is something else.
const LOOK_BYTES: usize = 64 * 1024;

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
        for capture in captures(path)? {
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
        say("no capture here: `groundwave demo --record` makes one");
    }
    fault.map_or(Ok(()), Err)
}

/// One bad file does not hide the others: the last fault is left to the caller.
fn note(fault: &mut Option<Fault>, found: Option<Fault>) {
    if let Some(found) = found
        && let Some(earlier) = fault.replace(found)
    {
        say(format_args!("groundwave: {earlier}"));
    }
}

/// What is said of a capture.
pub(super) fn labelled(capture: &Path) -> Result<Label, Fault> {
    Label::of(capture).map_err(|error| Fault::new(Exit::Usage, error))
}

/// What could be read, and why that is not all.
fn read(path: &Path) -> Result<(Figures, Option<Fault>), Fault> {
    let label = labelled(path)?;
    let mut capture = Capture::open(path).map_err(keeping::fault)?;
    let (course, _, problem) = Course::read(&mut capture);
    let problem = problem.map(keeping::fault);
    match problem {
        Some(problem) if course.points().is_empty() => Err(problem),
        problem => Ok((
            Figures::of(path.display().to_string(), label, &course),
            problem,
        )),
    }
}

/// A file as it is named; of a folder the captures in it, by name.
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
                remedy::of_reading(&error)
            ),
        )
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(path).map_err(unreadable)? {
        let file = entry.map_err(unreadable)?.path();
        if is_capture(&file) {
            found.push(match path {
                path if path == Path::new(".") => {
                    file.strip_prefix(".").unwrap_or(&file).to_owned()
                }
                _ => file,
            });
        }
    }
    found.sort();
    Ok(found)
}

fn is_capture(file: &Path) -> bool {
    let kind = file.extension().and_then(|kind| kind.to_str());
    match kind {
        Some("mcap") => true,
        Some("txt" | "raw" | "log") => {
            Capture::open(file).is_ok_and(|mut capture| has_line(&mut capture))
        }
        _ => false,
    }
}

fn has_line(capture: &mut Capture) -> bool {
    let mut decoder = Decoder::default();
    let mut looked = 0;
    while looked < LOOK_BYTES {
        let Ok(Some(chunk)) = capture.next_chunk() else {
            return false;
        };
        let mut bytes = chunk.bytes;
        looked += bytes.len();
        while !bytes.is_empty() {
            let (taken, received) = decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            if received.is_some() {
                return true;
            }
        }
    }
    false
}

fn write(out: &mut impl Write, run: &Figures, json: bool, first: bool) -> io::Result<()> {
    if json {
        serde_json::to_writer(&mut *out, run)?;
        return writeln!(out);
    }
    if first {
        writeln!(
            out,
            "{:>9} {:>10} {:>10} {:>6}  {:4}  capture",
            "time", "way", "closing", "bumps", ""
        )?;
    }
    let tenths = (run.duration_s * 10.0).round() as u64;
    let time = format!("{}:{:02}.{}", tenths / 600, tenths / 10 % 60, tenths % 10);
    let closing = run
        .closing_error_in
        .map_or_else(String::new, |error_in| format!("{error_in:.1} in"));
    let void = if run.void.is_some() { "VOID" } else { "" };
    let way = format!("{:.1} in", run.distance_in);
    write!(
        out,
        "{time:>9} {way:>10} {closing:>10} {:>6}  {void:4}  {}",
        run.bumps, run.capture
    )?;
    if let Some(name) = &run.name {
        write!(out, "  {name}")?;
    }
    match run.void.as_deref() {
        None | Some("") => writeln!(out),
        Some(reason) => writeln!(out, "  (void: {reason})"),
    }
}
