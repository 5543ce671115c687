//! `compare`: two runs over each other.

use std::io::{self, Write};
use std::path::Path;

use super::cli::Compare;
use super::output::write_file;
use super::runs::look;
use super::{Fault, say};
use crate::capture::runs::comparison::{Apart, Figures};
use crate::capture::runs::overlay::overlay;
use crate::capture::runs::sketch::sketch;
use crate::capture::runs::{Comparison, Course};

/// What a page and a terminal hold.
const SKETCH: (usize, usize) = (78, 30);

pub(super) fn run(options: &Compare) -> Result<(), Fault> {
    let (first, a, first_problem) = read(&options.first)?;
    let (second, b, second_problem) = read(&options.second)?;
    let names = [&first, &second].map(|run| run.name.clone().unwrap_or(run.capture.clone()));
    if let Some(path) = &options.svg {
        let drawing = overlay([&a, &b], [&names[0], &names[1]]);
        write_file(path, &drawing, options.force)?;
    }
    let comparison = Comparison {
        runs: [first, second],
        apart: Apart::between(&a, &b),
    };
    show(&comparison, [&a, &b], options.json).or_else(|error| Fault::output(&error))?;
    // What could be read has been compared, and that it is not all is told.
    match (first_problem, second_problem) {
        (None, None) => Ok(()),
        (Some(problem), None) | (None, Some(problem)) => Err(problem),
        (Some(first), Some(second)) => {
            say(format_args!("groundwave: {first}"));
            Err(second)
        }
    }
}

/// What could be read, and why that is not all.
fn read(path: &Path) -> Result<(Figures, Course, Option<Fault>), Fault> {
    let run = look(path)?;
    let problem = run.problem.map(Fault::from);
    if run.course.points().is_empty() {
        return Err(problem.unwrap_or_else(|| Fault::no_lines(path, run.counters.bytes)));
    }
    Ok((run.figures, run.course, problem))
}

fn show(comparison: &Comparison, courses: [&Course; 2], json: bool) -> io::Result<()> {
    let mut out = io::stdout().lock();
    if json {
        serde_json::to_writer(&mut out, comparison)?;
        writeln!(out)?;
        return out.flush();
    }
    comparison.write_text(&mut out)?;
    let (columns, rows) = SKETCH;
    write!(out, "\n{}", sketch(courses, columns, rows))?;
    out.flush()
}
