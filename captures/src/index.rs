//! Seekable captures: opening and seeking take constant time.
//!
//! Raw text needs no index: either timestamps are in order, or the offset of a byte gives its time on a 2400-baud
//! radio. The summary of an MCAP file lists the chunks with their times and message counts. An unfinished recording has
//! no summary and is read once from beginning to end.

mod chunk_table;
mod mcap;
mod prefilter;
mod text;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use groundwave_lines::Recognizer;

use super::CaptureError;
use super::source::{Form, HEAD_BYTES, ROUTE_HEAD_BYTES, is_route, open_file};
use crate::event::Landmark;
use crate::event::{Moment, Truth};
use crate::hint;
use crate::pieces::PiecePosition;

pub use crate::pieces::Piece;
pub use mcap::SeekableRecording;
pub use text::SeekableText;

/// Position of a piece in a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    position: PiecePosition,
    /// Time of the previous piece, since the capture began.
    at: Moment,
}

impl Place {
    /// Time of the previous piece, since the capture began.
    #[must_use]
    pub const fn at(&self) -> Moment {
        self.at
    }
}

/// A capture that can be read from any position.
pub trait SeekableReader {
    /// Time of the next piece, since the capture began; `None` at the end.
    fn next_at(&mut self) -> Option<Moment>;

    /// The next piece; `None` at the end.
    fn next_piece(&mut self) -> Option<Piece<'_>>;

    /// Position of the next piece.
    fn place(&self) -> Place;

    /// Continues reading at a position in this capture.
    fn seek(&mut self, place: Place);

    /// A position shortly before the first piece at or after a moment.
    fn find(&mut self, at: Moment) -> Place;

    /// Estimates the time of line `number`, from 1, without reading the lines before; also returns the number of lines
    /// before that time. `None` if the capture allows no estimate.
    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)>;

    /// Whether a landmark of a kind may lie between two moments, both included.
    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool;

    /// Duration of the capture; may be too long if the capture is damaged.
    fn length(&self) -> Moment;

    /// Start of the capture, as time since 1970, if known.
    fn unix(&self) -> Option<Moment>;

    /// The true state of a simulated robot's world, if the capture has it.
    fn truth(&self) -> Option<Truth> {
        None
    }

    /// Baud rate of the radio, if the capture contains it.
    fn baud(&self) -> Option<u32> {
        None
    }

    /// Recognizer for the lines of the robot's own, from the session's table.
    fn own_lines(&self) -> Recognizer {
        Recognizer::default()
    }

    /// Whether the times of the bytes were measured.
    fn has_times(&self) -> bool {
        true
    }

    /// A second, independent reader of this capture.
    fn reopen(&self) -> Box<dyn SeekableReader + Send>;
}

/// Bytes with random access, for several readers at a time.
pub trait Source: Send + Sync {
    /// Reads bytes at an offset; returns their number, 0 at the end.
    ///
    /// # Errors
    /// The operating system's error.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize>;

    /// Size in bytes.
    ///
    /// # Errors
    /// The operating system's error.
    fn size(&self) -> io::Result<u64>;
}

impl Source for File {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        return std::os::unix::fs::FileExt::read_at(self, buffer, offset);
        #[cfg(windows)]
        return std::os::windows::fs::FileExt::seek_read(self, buffer, offset);
    }

    fn size(&self) -> io::Result<u64> {
        Ok(self.metadata()?.len())
    }
}

impl Source for Vec<u8> {
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let from = usize::try_from(offset).unwrap_or(usize::MAX);
        let bytes = self.get(from..).unwrap_or_default();
        let read = bytes.len().min(buffer.len());
        buffer[..read].copy_from_slice(&bytes[..read]);
        Ok(read)
    }

    fn size(&self) -> io::Result<u64> {
        Ok(self.len() as u64)
    }
}

/// Opens a capture; its content determines the form. `-` is standard input. A pipe is first copied to an unlinked
/// temporary file.
///
/// # Errors
/// If the file cannot be opened, or is not a capture.
pub fn open(path: &Path) -> Result<Box<dyn SeekableReader + Send>, CaptureError> {
    let open_error = |error| CaptureError::Open {
        path: path.to_owned(),
        error,
    };
    if path == Path::new("-") {
        return spool(&mut io::stdin().lock(), path);
    }
    let mut file = open_file(path)?;
    if file.metadata().map_err(open_error)?.is_file() {
        read(Arc::new(file), path)
    } else {
        spool(&mut file, path)
    }
}

fn spool(from: &mut dyn Read, path: &Path) -> Result<Box<dyn SeekableReader + Send>, CaptureError> {
    let read_error = |error| CaptureError::Read {
        path: path.to_owned(),
        error,
    };
    let mut spool = unlinked_file().map_err(|error| {
        let folder = std::env::temp_dir();
        read_error(io::Error::other(format!(
            "its copy cannot be created in {}: {}; set TMPDIR to another folder",
            folder.display(),
            hint::words(&error)
        )))
    })?;
    io::copy(from, &mut spool).map_err(read_error)?;
    read(Arc::new(spool), path)
}

/// A file that is deleted when it is closed.
fn unlinked_file() -> io::Result<File> {
    let mut tries = 0;
    loop {
        let name = format!("groundwave-{}-{tries}.spool", std::process::id());
        let path = std::env::temp_dir().join(name);
        let made = File::options()
            .read(true)
            .write(true)
            .create_new(true)
            .open(&path);
        match made {
            Ok(file) => {
                // On systems that cannot unlink an open file, it stays in the temporary folder.
                let _ = std::fs::remove_file(&path);
                return Ok(file);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && tries < 100 => tries += 1,
            Err(error) => return Err(error),
        }
    }
}

/// Opens a capture from a source with random access; the name appears in error messages.
///
/// # Errors
/// If the source cannot be read, or is not a capture.
pub fn read(
    source: Arc<dyn Source>,
    name: &Path,
) -> Result<Box<dyn SeekableReader + Send>, CaptureError> {
    let read_error = |error| CaptureError::Read {
        path: name.to_owned(),
        error,
    };
    let mut head = [0; ROUTE_HEAD_BYTES];
    let length = read_at(&*source, 0, &mut head).map_err(read_error)?;
    let head = &head[..length];
    if is_route(head) {
        return Err(CaptureError::Route(name.to_owned()));
    }
    Ok(match Form::tell(&head[..length.min(HEAD_BYTES)]) {
        Form::Mcap => Box::new(SeekableRecording::new(source, name)?),
        Form::Raw => Box::new(SeekableText::new(source).map_err(read_error)?),
    })
}

/// Fills the buffer with bytes from an offset; returns their number, which is smaller than the buffer only at the end.
fn read_at(source: &dyn Source, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read_at(offset + filled as u64, &mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}
