//! `map`: makes one map of the floor from several captures.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use groundwave_mapping::{HouseMap, Placement};

use super::cli::{self, Map};
use super::export::floor_map::{self, ReadRun};
use super::output::{Target, check_inputs, targets};
use super::{Exit, Fault, batch, say, say_fault};

pub(super) fn run(options: &Map) -> Result<(), Fault> {
    let files = batch::files(&options.captures)?;
    let (target, second) = pair(options, &files)?;
    let mut house: Option<HouseMap> = None;
    let read = batch::each(
        &files,
        options.captures.quiet,
        |index, progress| floor_map::read(&files[index], progress),
        |index, run| {
            let words = add(&mut house, &files[index], &run)?;
            if !options.captures.quiet {
                say(words);
            }
            // The readable part is on the map; report that a part is missing.
            run.problem.map_or(Ok(ControlFlow::Continue(())), Err)
        },
    );
    let Some(house) = house else {
        return read;
    };
    let written = floor_map::write(house.floor_map(), &target, &second).map(|files| {
        if let Target::File(path, _) = &target
            && !options.captures.quiet
        {
            let size = floor_map::size(house.floor_map());
            say(format_args!("{}: {size}; {files}", path.display()));
        }
    });
    match (read, written) {
        (Err(fault), Err(last)) => {
            say_fault(&fault);
            Err(last)
        }
        (read, written) => read.and(written),
    }
}

/// The targets of both files.
fn pair(options: &Map, files: &[PathBuf]) -> Result<(Target, Target), Fault> {
    let output = cli::Output {
        output: options.output.clone(),
        output_dir: None,
        force: options.force,
    };
    // Without a name, the map has that of the first capture.
    let named = &files[..files.len().min(1)];
    let targets = targets(named, &output, |_| Ok("yaml".to_owned()))?;
    let seconds = floor_map::seconds(&targets, files)?;
    let mut pairs = targets.into_iter().zip(seconds);
    let pair = pairs
        .next()
        .ok_or_else(|| Fault::new(Exit::Usage, "name at least one capture"))?;
    if let Target::File(path, _) = &pair.0
        && path.exists()
    {
        check_inputs(path, files)?;
    }
    Ok(pair)
}

/// Adds a run to the map, or begins the map with it; returns words about the run.
fn add(house: &mut Option<HouseMap>, path: &Path, run: &ReadRun) -> Result<String, Fault> {
    let (name, parts) = (path.display(), floor_map::parts(run));
    let Some(house) = house else {
        *house = Some(HouseMap::new(&run.made));
        return Ok(format!(
            "{name}: added, its home is the map's origin{parts}"
        ));
    };
    let Placement {
        turn_deg,
        shift_in: (x_in, y_in),
    } = house
        .add(&run.made)
        .map_err(|reason| Fault::new(Exit::Failed, format!("{name}: left out: {reason}")))?;
    Ok(format!(
        "{name}: added, turned {turn_deg:.0} deg and moved by ({x_in:.0}, {y_in:.0}) in{parts}"
    ))
}
