//! `compare`: the paths and figures of two runs.

use std::io::{self, Write};
use std::path::Path;

use super::cli::Compare;
use super::output::write_file;
use super::runs::read_run;
use super::{Fault, out, say_fault};
use crate::capture::runs::comparison::{Apart, Figures};
use crate::capture::runs::overlay::overlay;
use crate::capture::runs::sketch::sketch;
use crate::capture::runs::{Comparison, Course};

/// Columns and rows of the sketch.
const SKETCH: (usize, usize) = (78, 30);

pub(super) fn run(options: &Compare) -> Result<(), Fault> {
    let (first, a, first_problem) = read(&options.first)?;
    let (second, b, second_problem) = read(&options.second)?;
    let names = [&first, &second].map(|run| run.name.clone().unwrap_or(run.capture.clone()));
    if let Some(path) = &options.svg {
        let drawing = overlay([&a, &b], [&names[0], &names[1]]);
        let inputs = [options.first.as_path(), &options.second];
        write_file(path, &drawing, options.force, &inputs)?;
    }
    let comparison = Comparison {
        runs: [first, second],
        apart: Apart::between(&a, &b),
    };
    show(&comparison, [&a, &b], options.json).or_else(|error| Fault::output(&error))?;
    // The readable parts have been compared; report what is missing.
    match (first_problem, second_problem) {
        (None, None) => Ok(()),
        (Some(problem), None) | (None, Some(problem)) => Err(problem),
        (Some(first), Some(second)) => {
            say_fault(&first);
            Err(second)
        }
    }
}

/// Reads a run, and the fault if it is incomplete.
fn read(path: &Path) -> Result<(Figures, Course, Option<Fault>), Fault> {
    let run = read_run(path)?;
    let problem = run.problem.map(Fault::from);
    if run.course.points().is_empty() {
        return Err(problem.unwrap_or_else(|| Fault::no_lines(path, run.counters.bytes)));
    }
    Ok((run.figures, run.course, problem))
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
