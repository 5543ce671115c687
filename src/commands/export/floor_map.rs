//! Exports the floor that was seen as a map for ROS: its `map_server` and others read the YAML file, which names the image.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use groundwave_mapping::{CELL_IN, FloorCell, FloorMap, Mapper, SessionMap};
use groundwave_protocol::decoder::Received;

use super::super::input;
use super::super::output::{Output, Target, second};
use super::super::progress::Progress;
use super::super::{Exit, Fault};
use super::Made;
use crate::capture::track::Track;
use crate::capture::words::clock_words;

const M_PER_IN: f64 = 0.0254;

/// Grey levels of `map_server`: its threshold for free floor, 0.196, is just below that of unknown floor, (255 - 205) / 255.
const OCCUPIED: u8 = 0;
const UNKNOWN: u8 = 205;
const FREE: u8 = 254;

/// Writes the YAML file and the image beside it.
pub(super) fn export(
    path: &Path,
    progress: &Progress,
    target: &Target,
    captures: &[PathBuf],
) -> Result<Made, Fault> {
    let usage = |problem: String| Fault::new(Exit::Usage, problem);
    let Target::File(yaml, force) = target else {
        let problem = "--to map writes two files; name the first one with -o NAME.yaml";
        return Err(usage(problem.into()));
    };
    if yaml.extension().is_none_or(|extension| extension != "yaml") {
        let yaml = yaml.display();
        return Err(usage(format!(
            "{yaml}: --to map writes a YAML file and an image beside it; name it .yaml"
        )));
    }
    let image = second(yaml, *force, "pgm", captures)?;
    let mut capture = input::open_capture(path, progress)?;
    let mut mapper = Mapper::default();
    let (_, _, problem) = Track::read_with(&mut capture, Vec::new(), |now, received| {
        if let Received::Line(line, _) = received {
            mapper.handle_line(now, line);
        }
    });
    let problem = problem.map(Fault::from);
    let made = match mapper.finish() {
        Ok(made) => made,
        Err(reason) => {
            let name = path.display();
            return Err(problem.unwrap_or_else(|| usage(format!("{name}: no map: {reason}"))));
        }
    };
    let name = yaml.with_extension("pgm");
    let name = name.file_name().unwrap_or_default().to_string_lossy();
    write(&image, &pgm(&made.map))?;
    write(target, description(&made.map, &name).as_bytes())?;
    Ok(Made {
        what: format!("{}; image {name}", content(&made)),
        problem,
        mistakes: None,
    })
}

fn write(target: &Target, bytes: &[u8]) -> Result<(), Fault> {
    let mut output = Output::create(target)?;
    match output.write_all(bytes) {
        Ok(()) => output.finish(),
        Err(error) => output.fault(&error),
    }
}

/// The image: X to the right, Y up.
fn pgm(map: &FloorMap) -> Vec<u8> {
    let rows = map.cells.len() / map.columns;
    let mut pgm = format!("P5\n{} {rows}\n255\n", map.columns).into_bytes();
    for row in map.cells.chunks(map.columns).rev() {
        pgm.extend(row.iter().map(|cell| match cell {
            FloorCell::Obstacle | FloorCell::Drop => OCCUPIED,
            FloorCell::Free => FREE,
            FloorCell::Unknown => UNKNOWN,
        }));
    }
    pgm
}

/// The YAML file. Its origin is the lower left corner of the image, in metres.
fn description(map: &FloorMap, image: &str) -> String {
    let (x_in, y_in) = map.corner_in;
    format!(
        "image: {}\nmode: trinary\nresolution: {:.4}\norigin: [{:.4}, {:.4}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        // A string of JSON is one of YAML, too.
        serde_json::Value::from(image),
        CELL_IN * M_PER_IN,
        x_in * M_PER_IN,
        y_in * M_PER_IN,
    )
}

/// What a map has of a capture.
fn content(made: &SessionMap) -> String {
    let feet = |cells: usize| cells as f64 * CELL_IN / 12.0;
    let part = |at: Option<Duration>, before: &str, after: &str| {
        at.map_or_else(String::new, |at| {
            format!(" {before} {}, {after}", clock_words(at))
        })
    };
    format!(
        "map of {:.0} x {:.0} ft{}{}",
        feet(made.map.columns),
        feet(made.map.cells.len() / made.map.columns),
        part(
            made.from,
            "from",
            "when the robot was given a new pose or was restarted"
        ),
        part(
            made.until,
            "up to",
            "since when the robot's heading is not known well"
        ),
    )
}
