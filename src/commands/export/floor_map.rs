//! Exports the floor that was seen as a map for ROS: its `map_server` and others read the YAML file, which names the image.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use groundwave_mapping::{CELL_IN, FloorCell, FloorMap, Mapper, NoMap, SessionMap};
use groundwave_protocol::decoder::{Counters, Received};

use super::super::input;
use super::super::output::{Target, second, write_pair};
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

/// The image's target for each YAML file.
///
/// # Errors
/// If a target is no YAML file, or an image must not be written.
pub(super) fn images(targets: &[Target], captures: &[PathBuf]) -> Result<Vec<Target>, Fault> {
    let usage = |problem: String| Fault::new(Exit::Usage, problem);
    let image = |target: &Target| {
        let Target::File(yaml, force) = target else {
            let problem = "--to map writes two files; name the first one with -o NAME.yaml";
            return Err(usage(problem.into()));
        };
        let name = yaml.display();
        if yaml.to_str().is_none() {
            return Err(usage(format!(
                "{name}: the YAML file names its image, so the name must be UTF-8; choose another name"
            )));
        }
        let extension = yaml.extension().unwrap_or_default();
        if !extension.eq_ignore_ascii_case("yaml") {
            return Err(usage(format!(
                "{name}: --to map writes a YAML file and an image beside it; choose a name such as floor.yaml"
            )));
        }
        second(yaml, *force, "pgm", captures)
    };
    targets.iter().map(image).collect()
}

/// Writes the YAML file and the image.
pub(super) fn export(
    path: &Path,
    progress: &Progress,
    target: &Target,
    image: &Target,
) -> Result<Made, Fault> {
    let mut capture = input::open_capture(path, progress)?;
    let mut mapper = Mapper::default();
    let (_, counters, problem) = Track::read_with(&mut capture, Vec::new(), |now, received| {
        if let Received::Line(line, _) = received {
            mapper.handle_line(now, line);
        }
    });
    let problem = problem.map(Fault::from);
    let since = mapper.since();
    let made = match mapper.finish() {
        Ok(made) => made,
        Err(reason) => {
            return Err(problem.unwrap_or_else(|| no_map(path, &counters, since, reason)));
        }
    };
    let name = match image {
        Target::File(image, _) => image.file_name().unwrap_or_default().to_string_lossy(),
        Target::Standard => Cow::default(),
    };
    let yaml = description(&made.map, &name);
    write_pair([(image, &pgm(&made.map)), (target, yaml.as_bytes())])?;
    Ok(Made {
        what: format!("{}; image {name}", content(&made, since)),
        problem,
        mistakes: None,
    })
}

fn no_map(path: &Path, counters: &Counters, since: Option<Duration>, reason: NoMap) -> Fault {
    if counters.lines == 0 {
        return Fault::no_lines(path, counters.bytes);
    }
    let name = path.display();
    let problem = since.map_or_else(
        || format!("{name}: no map: {reason}"),
        |since| {
            let since = clock_words(since);
            format!(
                "{name}: no map since {since}, when the robot was given a new pose or was restarted: {reason}; `groundwave cut --to {since}` makes a capture of the part before"
            )
        },
    );
    Fault::new(Exit::Usage, problem)
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
    // A string of JSON is one of YAML, but for characters that YAML takes for line breaks or refuses.
    let mut name = String::new();
    for character in serde_json::Value::from(image).to_string().chars() {
        match character {
            '\u{7f}'..='\u{9f}' | '\u{2028}' | '\u{2029}' | '\u{feff}' => {
                // Writing to a string cannot fail.
                let _ = write!(name, "\\u{:04x}", u32::from(character));
            }
            _ => name.push(character),
        }
    }
    format!(
        "image: {name}\nmode: trinary\nresolution: {:.4}\norigin: [{:.4}, {:.4}, 0.0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n",
        CELL_IN * M_PER_IN,
        x_in * M_PER_IN,
        y_in * M_PER_IN,
    )
}

/// What a map has of a capture.
fn content(made: &SessionMap, since: Option<Duration>) -> String {
    let feet = |cells: usize| cells as f64 * CELL_IN / 12.0;
    let size = format!(
        "map of {:.0} x {:.0} ft",
        feet(made.map.columns),
        feet(made.map.cells.len() / made.map.columns)
    );
    let from = since.map(|since| {
        let since = clock_words(since);
        format!("from {since} on, after a new pose or a restart")
    });
    let until = made.until.map(|until| {
        let until = clock_words(until);
        format!("up to {until}, because the heading was not known well after that")
    });
    let parts = [Some(size), from, until];
    parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
}
