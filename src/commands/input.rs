//! Opens captures for reading and counts the bytes read.

use std::io::{self, Cursor, Read};
use std::path::Path;

use super::progress::Progress;
use super::{Exit, Fault, batch};
use crate::capture::source::{Form, HEAD_BYTES, open_file, unfinished};
use crate::capture::{Capture, CaptureError};

/// A file or a stream.
pub(super) type Source = Box<dyn Read + Send>;

/// Opens a file, or standard input for `-`.
pub(super) fn open(path: &Path, progress: &Progress) -> Result<Source, Fault> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin()));
    }
    if let Some(pattern) = batch::pattern(path) {
        return Err(Fault::new(
            Exit::Usage,
            format!("{pattern}: no file matches"),
        ));
    }
    let file = open_file(path)?;
    Ok(Box::new(progress.count(file)))
}

/// Opens a capture in either format.
pub(super) fn open_capture(path: &Path, progress: &Progress) -> Result<Capture, Fault> {
    let source = open(path, progress)?;
    let name = if path == Path::new("-") {
        Path::new("standard input")
    } else {
        path
    };
    Capture::read(name, source).map_err(Fault::from)
}

/// Detects the format by the first bytes; returns the format and the whole source.
pub(super) fn detect_form(path: &Path, mut source: Source) -> Result<(Form, Source), Fault> {
    let mut head = Vec::new();
    source
        .by_ref()
        .take(HEAD_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(|error| cannot_read(path, error))?;
    let form = Form::tell(&head);
    Ok((form, Box::new(Cursor::new(head).chain(source))))
}

/// The fault for an error while reading.
pub(super) fn cannot_read(path: &Path, error: io::Error) -> Fault {
    let path = path.to_owned();
    Fault::from(CaptureError::Read { path, error })
}

/// The fault for a capture that could be read only in part.
pub(super) fn not_whole(path: &Path, problem: &str) -> Fault {
    let shown = path.display();
    let fault = match unfinished(path) {
        Some(unfinished) => format!("{shown}: {problem}: {unfinished}"),
        None => format!("{shown}: {problem}"),
    };
    Fault::new(Exit::Failed, fault)
}
