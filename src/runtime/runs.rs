//! Reads runs for the dashboard.

use std::path::Path;
use std::sync::Arc;

use crate::capture::runs::comparison::{Apart, Comparison};
use crate::capture::runs::folder::{self, Run};
use crate::figures::{Listed, Overlaid};
use crate::hint;

/// Reads the runs of the captures in a folder; captures that cannot be read are listed as problems.
pub(super) fn list(folder: String) -> Result<Arc<Listed>, String> {
    let captures = folder::captures(Path::new(&folder))
        .map_err(|error| format!("cannot read {folder}: {}", hint::of_reading(&error)))?;
    let (mut runs, mut problems) = (Vec::new(), Vec::new());
    for capture in captures {
        match Run::read(&capture) {
            Ok(run) => {
                problems.extend(run.problem.map(|problem| problem.to_string()));
                runs.push(run.figures);
            }
            Err(error) => problems.push(error.to_string()),
        }
    }
    folder::sort(&mut runs);
    Ok(Arc::new(Listed {
        folder,
        runs,
        problems,
    }))
}

/// Reads two runs for comparison.
pub(super) fn overlay(captures: &[String; 2]) -> Result<Arc<Overlaid>, String> {
    let [a, b] = captures;
    let (a, b) = (read(a)?, read(b)?);
    let apart = Apart::between(&a.course, &b.course);
    let problems = [a.problem, b.problem].into_iter().flatten();
    Ok(Arc::new(Overlaid {
        problems: problems.map(|problem| problem.to_string()).collect(),
        paths: [&a.course, &b.course].map(|course| course.points().to_vec()),
        comparison: Comparison {
            runs: [a.figures, b.figures],
            apart,
        },
    }))
}

fn read(capture: &str) -> Result<Run, String> {
    let run = Run::read(Path::new(capture)).map_err(|error| error.to_string())?;
    if run.course.points().is_empty() {
        return Err(format!(
            "{capture}: no position in the capture, so there is nothing to compare"
        ));
    }
    Ok(run)
}
