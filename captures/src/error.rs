//! What can go wrong with a capture.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::repair::Problem;
use crate::hint::{self, shell_word};

/// What to do when the file to be written exists.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Leave it alone and say so.
    #[default]
    Refuse,
    /// Write on at its end. Only raw captures can.
    Append,
    /// Write over it.
    Overwrite,
}

/// What became of a file that was taken away while it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It has no name any more.
    Removed,
    /// It has another name.
    Moved,
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Removed => f.write_str(
                "it was removed, and what was written until then cannot be reached: start a new recording",
            ),
            Self::Moved => f.write_str(
                "it was moved or renamed, and what was written until then is where it is now: start a new recording",
            ),
        }
    }
}

/// A capture could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The file is there and nobody allowed to touch it.
    #[error(
        "will not record to {}: the file exists; choose another name, or say --force to lose what is in it{}",
        path.display(),
        if *can_append { ", or --append to write on at its end" } else { "" }
    )]
    Exists {
        /// The file.
        path: PathBuf,
        /// Whether appending is a way out.
        can_append: bool,
    },
    /// Two recordings in one file.
    #[error("will not record to {} twice: give --tee and --record different names", .0.display())]
    SameFile(PathBuf),
    /// A name that the recorder gives to files of its own.
    #[error(
        "will not write {}: names that end in .finishing or .damaged are those of files that recovery makes; choose another \
         name",
        .0.display()
    )]
    OwnName(PathBuf),
    /// A recovery could not write its result.
    #[error(
        "recovering {} failed: {error}; {}nothing was changed",
        path.display(),
        match error.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge =>
                "make room and run recover again; ",
            io::ErrorKind::InvalidFilename => "give it a shorter name and run recover again; ",
            _ => "",
        }
    )]
    Recovering {
        /// The recording.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// Another program records under that name now.
    #[error("will not record to {}: another groundwave is recording it; choose another name", .0.display())]
    InUse(PathBuf),
    /// A recording that is being recorded or recovered is not recovered.
    #[error("will not recover {}: another groundwave is recording or recovering it; end it there first", .0.display())]
    UnderWay(PathBuf),
    /// Nothing in a file can be read as a recording.
    #[error("nothing of {} can be saved: no part of a Groundwave recording in it can be read", .0.display())]
    NothingLeft(PathBuf),
    /// Chunks in a form that others write.
    #[error("will not recover {}: {}", .0.display(), Problem::Lz4)]
    Compression(PathBuf),
    /// Waypoints, and no capture.
    #[error(
        "{} is a route, not a capture: groundwave send LINK route {} sends it; in the dashboard l loads it as a draft",
        .0.display(), shell_word(.0)
    )]
    Route(PathBuf),
    /// An MCAP cannot be written on.
    #[error("cannot append to {}: only raw captures can be appended to; choose another name", .0.display())]
    CannotAppend(PathBuf),
    /// The file cannot be made.
    #[error("cannot create {}: {error}{}", path.display(), hint(error))]
    Create {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// Writing failed in the middle.
    #[error(
        "recording to {} stopped: {error}; what was written until then is kept{}{}",
        path.display(),
        recovery(path),
        hint(error)
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// What the operating system or the format says.
        error: io::Error,
    },
    /// Somebody took the file away while it was written.
    #[error("recording to {}: the file is gone; {fate}", path.display())]
    Gone {
        /// The file.
        path: PathBuf,
        /// What that means for what was written.
        fate: Fate,
    },
    /// The disk takes its time.
    #[error("recording to {}: the disk has kept nothing for 30 s; a power cut would lose what came in since", .0.display())]
    Stalled(PathBuf),
    /// The file cannot be opened.
    #[error("cannot open {}: {}", path.display(), hint::of_reading(error))]
    Open {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// Reading failed in the middle.
    #[error("cannot read {}: {}", path.display(), hint::of_reading(error))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// A finished recording does not read back as it was written.
    #[error(
        "{} could not be finished: its copy did not read back as it was written; the recording is as it was, and \
         `groundwave recover {}` tries again",
        .0.display(), shell_word(.0)
    )]
    NotProven(PathBuf),
    /// A recording that is under way or was interrupted.
    #[error("{}", unfinished_words(path, *is_in_use))]
    Unfinished {
        /// The file.
        path: PathBuf,
        /// Whether a program is recording it now.
        is_in_use: bool,
    },
    /// An MCAP whose checksums or structure do not hold.
    #[error("{} cannot be read whole: {problem}; everything else has been read", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not hold.
        problem: String,
    },
    /// An MCAP of something else.
    #[error("{} holds no {} channel of groundwave.RawBytes: not a Groundwave recording", .0.display(), super::topics::RAW_RX)]
    NoRawBytes(PathBuf),
}

/// What becomes of an MCAP that takes no more.
fn recovery(path: &Path) -> String {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        return format!(
            ", and `groundwave recover {}` finishes it when this has ended",
            shell_word(path)
        );
    }
    String::new()
}

fn unfinished_words(path: &Path, is_in_use: bool) -> String {
    let name = path.display();
    if is_in_use {
        return format!("{name} is being recorded: its end is still to come");
    }
    format!(
        "{name} was interrupted: it is read up to its end; `groundwave recover {}` finishes it",
        shell_word(path)
    )
}

fn hint(error: &io::Error) -> &'static str {
    match error.kind() {
        io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
            "; make room and start a new recording"
        }
        io::ErrorKind::NotFound => "; create the folder first",
        io::ErrorKind::IsADirectory => "; name a file in it",
        io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
            "; choose a writable folder"
        }
        _ => "",
    }
}

/// Opens a file for writing and leaves an existing one alone unless told otherwise.
pub(super) fn create(
    path: &Path,
    existing: Existing,
    can_append: bool,
) -> Result<File, CaptureError> {
    let mut options = OpenOptions::new();
    match existing {
        Existing::Refuse => options.write(true).create_new(true),
        Existing::Append => options.append(true).create(true),
        Existing::Overwrite => options.write(true).create(true).truncate(true),
    };
    options
        .open(path)
        .map_err(|error| create_error(path, error, can_append))
}

/// The error for a file that could not be created.
pub(super) fn create_error(path: &Path, error: io::Error, can_append: bool) -> CaptureError {
    let path = path.to_owned();
    if path.is_dir() {
        let error = io::ErrorKind::IsADirectory.into();
        CaptureError::Create { path, error }
    } else if error.kind() == io::ErrorKind::AlreadyExists {
        CaptureError::Exists { path, can_append }
    } else {
        CaptureError::Create { path, error }
    }
}
