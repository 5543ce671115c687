//! The runs in a folder.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use groundwave_protocol::decoder::{Arrival, Counters, Decoder};

use super::label::LabelError;
use super::{Course, Label};
use crate::runs::figures::Figures;
use crate::track::Track;
use crate::{Capture, CaptureError};

/// Number of bytes of a file that are searched for a robot's line.
const LOOK_BYTES: usize = 64 * 1024;

/// A run cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The label cannot be read.
    #[error(transparent)]
    Label(#[from] LabelError),
    /// The capture cannot be read.
    #[error(transparent)]
    Capture(#[from] CaptureError),
}

/// A run as far as it could be read.
#[derive(Debug)]
pub struct Run {
    /// Figures of the run.
    pub figures: Figures,
    /// Path of the run.
    pub course: Course,
    /// The decoder's totals.
    pub counters: Counters,
    /// Reason why the capture could not be read completely.
    pub problem: Option<CaptureError>,
}

impl Run {
    /// Reads a whole capture and its label.
    ///
    /// # Errors
    /// If the capture or its label cannot be opened.
    pub fn read(path: &Path) -> Result<Self, RunError> {
        let label = Label::of(path)?;
        let mut capture = Capture::open(path)?;
        let (course, counters, problem) = Course::read(&mut capture);
        let name = path.display().to_string();
        Ok(Self {
            figures: Figures::of(
                name,
                capture.start(),
                label,
                capture.marks(),
                &course,
                capture.end(),
                &counters,
            ),
            course,
            counters,
            problem,
        })
    }

    /// Reads a whole capture and its label as [`Self::read`] does; also returns the track for a picture.
    ///
    /// # Errors
    /// The errors of [`Self::read`].
    pub fn read_with_track(path: &Path) -> Result<(Self, Track), RunError> {
        let label = Label::of(path)?;
        let mut capture = Capture::open(path)?;
        let mut course = Course::default();
        let (track, counters, problem) =
            Track::read_with(&mut capture, Vec::new(), |at, arrival| {
                if let Arrival::Line(received) = arrival {
                    course.take(at, received);
                }
            });
        let name = path.display().to_string();
        let run = Self {
            figures: Figures::of(
                name,
                capture.start(),
                label,
                capture.marks(),
                &course,
                track.duration,
                &counters,
            ),
            course,
            counters,
            problem,
        };
        Ok((run, track))
    }
}

/// Sorts runs by start, the newest last; runs without a date come first.
pub fn sort(runs: &mut [Figures]) {
    runs.sort_by(|a, b| a.start.cmp(&b.start));
}

/// The captures in a folder, sorted by name.
///
/// # Errors
/// If the folder cannot be read.
pub fn captures(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let file = entry?.path();
        if is_capture(&file) {
            // Names in the current folder have no `./`.
            let short = file.strip_prefix(".").map(Path::to_owned);
            found.push(short.unwrap_or(file));
        }
    }
    found.sort();
    Ok(found)
}

fn is_capture(file: &Path) -> bool {
    // Opening a pipe could block forever.
    if !file.is_file() {
        return false;
    }
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
        looked += chunk.bytes.len();
        if decoder.lines(chunk.bytes).next().is_some() {
            return true;
        }
    }
    false
}
