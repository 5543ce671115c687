//! Captures that a verb reads, with what is read counted.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;

use super::progress::Progress;
use super::{Exit, Fault, keeping};
use crate::capture::source::{Form, HEAD_BYTES};
use crate::capture::{Capture, CaptureError};

/// A file or a stream.
pub(super) type Source = Box<dyn Read + Send>;

/// Opens a file, or standard input for `-`.
pub(super) fn open(path: &Path, progress: &Progress) -> Result<Source, Fault> {
    if path == Path::new("-") {
        return Ok(Box::new(io::stdin()));
    }
    let file = File::open(path).map_err(|error| {
        let path = path.to_owned();
        keeping::fault(CaptureError::Open { path, error })
    })?;
    Ok(Box::new(progress.count(file)))
}

/// Opens a capture of either form.
pub(super) fn open_capture(path: &Path, progress: &Progress) -> Result<Capture, Fault> {
    let source = open(path, progress)?;
    let name = if path == Path::new("-") {
        Path::new("standard input")
    } else {
        path
    };
    Capture::read(name, source).map_err(keeping::fault)
}

/// Which form it has, by its first bytes, and the whole of it.
pub(super) fn tell_form(path: &Path, mut source: Source) -> Result<(Form, Source), Fault> {
    let mut head = Vec::new();
    source
        .by_ref()
        .take(HEAD_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(|error| cannot_read(path, error))?;
    let form = Form::tell(&head, path).map_err(keeping::fault)?;
    Ok((form, Box::new(Cursor::new(head).chain(source))))
}

/// Reading failed in the middle.
pub(super) fn cannot_read(path: &Path, error: io::Error) -> Fault {
    let path = path.to_owned();
    keeping::fault(CaptureError::Read { path, error })
}

/// What came before is good and has been written, but it is not all.
pub(super) fn not_whole(path: &Path, problem: &str) -> Fault {
    Fault::new(Exit::Failed, format!("{}: {problem}", path.display()))
}
