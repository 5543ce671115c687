//! Exports the floor that was seen as a map for ROS: its `map_server` and others read the YAML file, which names the image.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Duration;

use groundwave_mapping::{CELL_IN, FloorCell, FloorMap, Mapper, NoMap, SessionMap};
use groundwave_protocol::decoder::{Arrival, Counters, Received};

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

/// The target of the second file for each target: an image for a YAML file, a YAML file for a PNG image.
///
/// # Errors
/// If a target is neither, or the second file must not be written.
pub(in super::super) fn seconds(
    targets: &[Target],
    captures: &[PathBuf],
) -> Result<Vec<Target>, Fault> {
    let usage = |problem: String| Fault::new(Exit::Usage, problem);
    let other = |target: &Target| {
        let Target::File(path, force) = target else {
            let problem = "a map is written as two files; name the first one with -o NAME.yaml";
            return Err(usage(problem.into()));
        };
        let name = path.display();
        if path.to_str().is_none() {
            return Err(usage(format!(
                "{name}: the YAML file names its image, so the name must be UTF-8; choose another name"
            )));
        }
        let extension = path.extension().unwrap_or_default();
        if is_png(path) {
            second(path, *force, "yaml", captures)
        } else if extension.eq_ignore_ascii_case("yaml") {
            second(path, *force, "pgm", captures)
        } else {
            Err(usage(format!(
                "{name}: a map is a YAML file and an image beside it; choose a name such as floor.yaml (with a PGM image) or floor.png"
            )))
        }
    };
    targets.iter().map(other).collect()
}

fn is_png(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default();
    extension.eq_ignore_ascii_case("png")
}

/// What a capture has for a map.
pub(in super::super) struct ReadRun {
    pub(in super::super) made: SessionMap,
    /// Time from which on it was seen, if the robot got a new pose or was restarted.
    since: Option<Duration>,
    /// Reason why the capture was read only in part.
    pub(in super::super) problem: Option<Fault>,
}

/// Reads what a capture has for a map.
///
/// # Errors
/// If the capture cannot be read or has nothing for a map.
pub(in super::super) fn read(path: &Path, progress: &Progress) -> Result<ReadRun, Fault> {
    let mut capture = input::open_capture(path, progress)?;
    let mut mapper = Mapper::default();
    let (_, counters, problem) =
        Track::read_with(&mut capture, Vec::new(), |now, arrival| match arrival {
            Arrival::Line(Received::Line(line, _)) | Arrival::Repaired(line) => {
                mapper.handle_line(now, line);
            }
            Arrival::Line(Received::Ack(_)) => {}
        });
    let problem = problem.map(Fault::from);
    let since = mapper.since();
    match mapper.finish() {
        Ok(made) => Ok(ReadRun {
            made,
            since,
            problem,
        }),
        Err(reason) => Err(problem.unwrap_or_else(|| no_map(path, &counters, since, reason))),
    }
}

/// Writes the map of one capture.
pub(super) fn export(
    path: &Path,
    progress: &Progress,
    target: &Target,
    second: &Target,
) -> Result<Made, Fault> {
    let run = read(path, progress)?;
    let files = write(&run.made.map, target, second)?;
    let (size, parts) = (size(&run.made.map), parts(&run));
    Ok(Made {
        what: format!("{size}{parts}; {files}"),
        problem: run.problem,
        mistakes: None,
    })
}

/// Writes the YAML file and the image; returns words for the second file.
pub(in super::super) fn write(
    map: &FloorMap,
    target: &Target,
    second: &Target,
) -> Result<String, Fault> {
    let is_png = matches!(target, Target::File(path, _) if is_png(path));
    let (yaml, image, pixels) = if is_png {
        let png = png(map).map_err(|error| {
            Fault::new(Exit::Failed, format!("cannot encode the image: {error}"))
        })?;
        (second, target, png)
    } else {
        (target, second, pgm(map))
    };
    let base = |target: &Target| match target {
        Target::File(path, _) => path.file_name().unwrap_or_default().display().to_string(),
        Target::Standard => String::new(),
    };
    let text = description(map, &base(image));
    write_pair([(image, &pixels), (yaml, text.as_bytes())])?;
    let kind = if is_png { "description" } else { "image" };
    Ok(format!("{kind} {}", base(second)))
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

/// The image's grey levels, row by row: X to the right, Y up.
fn pixels(map: &FloorMap) -> Vec<u8> {
    let rows = map.cells.chunks(map.columns).rev();
    let pixels = rows.flatten().map(|cell| match cell {
        FloorCell::Obstacle | FloorCell::Drop => OCCUPIED,
        FloorCell::Free => FREE,
        FloorCell::Unknown => UNKNOWN,
    });
    pixels.collect()
}

fn pgm(map: &FloorMap) -> Vec<u8> {
    let rows = map.cells.len() / map.columns;
    let mut pgm = format!("P5\n{} {rows}\n255\n", map.columns).into_bytes();
    pgm.extend(pixels(map));
    pgm
}

fn png(map: &FloorMap) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let rows = map.cells.len() / map.columns;
    let mut encoder = png::Encoder::new(&mut bytes, map.columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Grayscale);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels(map))?;
    writer.finish()?;
    Ok(bytes)
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

/// The size of a map, in words.
pub(in super::super) fn size(map: &FloorMap) -> String {
    let feet = |cells: usize| cells as f64 * CELL_IN / 12.0;
    format!(
        "map of {:.0} x {:.0} ft",
        feet(map.columns),
        feet(map.cells.len() / map.columns)
    )
}

/// Which part of a capture is on a map, each clause after a comma; empty for all of it.
pub(in super::super) fn parts(run: &ReadRun) -> String {
    let from = run.since.map(|since| {
        let since = clock_words(since);
        format!(", from {since} on, after a new pose or a restart")
    });
    let until = run.made.until.map(|until| {
        let until = clock_words(until);
        format!(", up to {until}, because the heading was not known well after that")
    });
    from.into_iter().chain(until).collect()
}
