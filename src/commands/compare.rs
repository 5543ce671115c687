//! `compare`: compares the paths and figures of two runs.

use std::io::{self, Write};
use std::path::Path;

use super::cli::Compare;
use super::output::write_file;
use super::runs::read_run_with_track;
use super::{Fault, out, say_fault};
use crate::capture::picture::{self, Picture};
use crate::capture::runs::comparison::{Apart, Figures};
use crate::capture::runs::sketch::sketch;
use crate::capture::runs::{Comparison, Course};
use crate::capture::track::Track;

/// Maximum number of columns and rows of the sketch.
const SKETCH: (usize, usize) = (78, 30);

pub(super) fn run(options: &Compare) -> Result<(), Fault> {
    let (first, a, first_track, first_problem) = read(&options.first)?;
    let (second, b, second_track, second_problem) = read(&options.second)?;
    if let Some(path) = &options.svg {
        let (first_track, second_track) = (first_track.since_reset(), second_track.since_reset());
        let runs = [
            drawn(&first, &options.first, &first_track),
            drawn(&second, &options.second, &second_track),
        ];
        if let Some(picture) = Picture::of_pair([&runs[0], &runs[1]]) {
            let inputs = [options.first.as_path(), &options.second];
            write_file(path, &picture.svg(), options.force, &inputs)?;
        }
    }
    let comparison = Comparison {
        runs: [first, second],
        apart: Apart::between(&a, &b),
    };
    show(&comparison, [&a, &b], options.json).or_else(|error| Fault::output(&error))?;
    // The readable parts have been compared; report the missing parts.
    match (first_problem, second_problem) {
        (None, None) => Ok(()),
        (Some(problem), None) | (None, Some(problem)) => Err(problem),
        (Some(first), Some(second)) => {
            say_fault(&first);
            Err(second)
        }
    }
}

fn drawn<'a>(figures: &Figures, path: &Path, track: &'a Track) -> picture::Run<'a> {
    let file = path.file_stem().unwrap_or_default().display().to_string();
    picture::Run {
        name: figures.name.clone().unwrap_or(file),
        track,
        closing_error_in: figures.closing_error_in,
    }
}

/// Reads a run, its track, and the fault if it is incomplete.
fn read(path: &Path) -> Result<(Figures, Course, Track, Option<Fault>), Fault> {
    let (run, track) = read_run_with_track(path)?;
    let problem = run.problem.map(Fault::from);
    if run.course.points().is_empty() {
        return Err(problem.unwrap_or_else(|| Fault::no_lines(path, run.counters.bytes)));
    }
    Ok((run.figures, run.course, track, problem))
}

fn show(comparison: &Comparison, courses: [&Course; 2], json: bool) -> io::Result<()> {
    let mut out = out();
    if json {
        serde_json::to_writer(&mut out, comparison)?;
        writeln!(out)?;
        return out.flush();
    }
    comparison.write_text(&mut out)?;
    let (columns, rows) = SKETCH;
    writeln!(out)?;
    out.write_all(sketch(courses, columns, rows).as_bytes())?;
    out.flush()
}
