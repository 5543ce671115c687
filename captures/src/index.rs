//! Captures that are read from anywhere: opening one and going to a place in it take the same time and
//! memory however long it is.
//!
//! A text needs no index: a byte's place is its time on a 2400-baud radio, and the times of one that has them are in
//! order. An MCAP has its chunks' times in the summary at its end, and how many messages each topic has in them; of
//! those of a very long one some are kept, and the headers between them say the rest.

mod chunk_table;
mod mcap;
mod scout;
mod text;

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use super::CaptureError;
use super::source::{Form, HEAD_BYTES, ROUTE_HEAD_BYTES, is_route, open_file};
use crate::event::Landmark;
use crate::event::{Moment, Truth};
use crate::pieces::PiecePosition;

pub use crate::pieces::Piece;
pub use mcap::McapTape;
pub use text::TextTape;

/// Where a piece begins in a capture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    position: PiecePosition,
    /// When the piece before it happened.
    at: Moment,
}

impl Place {
    /// When what came before it happened.
    #[must_use]
    pub const fn at(&self) -> Moment {
        self.at
    }
}

/// A capture that can be read from any place.
pub trait Tape {
    /// When the next piece happened, since the capture began; `None` at the end.
    fn next_at(&mut self) -> Option<Moment>;

    /// The next piece; `None` at the end.
    fn next_piece(&mut self) -> Option<Piece<'_>>;

    /// Where the next piece begins.
    fn place(&self) -> Place;

    /// Goes on reading at a place of this capture.
    fn go(&mut self, place: Place);

    /// A place before everything that happened at a moment or later, and not long before it.
    fn find(&mut self, at: Moment) -> Place;

    /// When the line of a number, from 1, came, and how many lines came before that moment: as far as can be told
    /// without reading what lies before it, which may know better. `None` where nothing tells.
    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)>;

    /// Whether there may be a landmark of a kind from one moment until another, both included, as far as can be told without reading.
    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool;

    /// When the last of it happened; what a damaged capture says of itself may be too much.
    fn length(&self) -> Moment;

    /// Time of day at its beginning, since 1970, if it knows.
    fn unix(&self) -> Option<Moment>;

    /// The simulator's truth, where the capture is of a simulated robot and has it.
    fn truth(&self) -> Option<Truth> {
        None
    }

    /// The same capture once more, for somebody else to read.
    fn again(&self) -> Box<dyn Tape + Send>;
}

/// Anything that can be read from anywhere, by several at a time.
pub trait Source: Send + Sync {
    /// Reads what there is at an offset; nothing at the end.
    ///
    /// # Errors
    /// The operating system's.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize>;

    /// Bytes there are.
    ///
    /// # Errors
    /// The operating system's.
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

/// Opens a capture of either form, told apart by content. `-` is standard input; what cannot be read from
/// anywhere, like a pipe, is read to its end first and kept in a temporary file that nobody sees.
///
/// # Errors
/// When it cannot be opened, or is no capture.
pub fn open(path: &Path) -> Result<Box<dyn Tape + Send>, CaptureError> {
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

fn spool(from: &mut dyn Read, path: &Path) -> Result<Box<dyn Tape + Send>, CaptureError> {
    let read_error = |error| CaptureError::Read {
        path: path.to_owned(),
        error,
    };
    let mut spool = unseen_file().map_err(read_error)?;
    io::copy(from, &mut spool).map_err(read_error)?;
    read(Arc::new(spool), path)
}

/// A file that goes with its handle.
fn unseen_file() -> io::Result<File> {
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
                // Where an open file cannot be unlinked it stays until somebody clears the folder.
                let _ = std::fs::remove_file(&path);
                return Ok(file);
            }
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists && tries < 100 => tries += 1,
            Err(error) => return Err(error),
        }
    }
}

/// A capture in anything that can be read from anywhere; the name is for messages.
///
/// # Errors
/// When it cannot be read, or is no capture.
pub fn read(source: Arc<dyn Source>, name: &Path) -> Result<Box<dyn Tape + Send>, CaptureError> {
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
    Ok(match Form::tell(&head[..length.min(HEAD_BYTES)], name)? {
        Form::Mcap => Box::new(McapTape::new(source, name)?),
        Form::Raw => Box::new(TextTape::new(source).map_err(read_error)?),
    })
}

/// As many bytes as there are from a place on, up to the length of the buffer.
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
