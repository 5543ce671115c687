//! What can go wrong with a capture.

use std::fmt;
use std::fs::{File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::recover::Interrupted;
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
    /// It has gone; the journal of that recording has not.
    InJournal(PathBuf),
    /// The journal alone has gone.
    NoJournal,
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
            Self::InJournal(target) => write!(
                f,
                "its journal holds everything that was received: groundwave recover {}",
                shell_word(target)
            ),
            Self::NoJournal => f.write_str(
                "the recording goes on without it, and a power cut would cost its last seconds",
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
    /// A finished recording cannot take the name it was given.
    #[error(
        "cannot name the recording {}: a file of that name has appeared; the recording is complete in {}",
        path.display(),
        partial.display()
    )]
    Appeared {
        /// The name.
        path: PathBuf,
        /// Where the recording is.
        partial: PathBuf,
    },
    /// A name that the recorder gives to files of its own.
    #[error(
        "will not write {}: names that end in .partial, .journal, .recovering or .damaged are those of \
         unfinished and damaged recordings; choose another name",
        .0.display()
    )]
    OwnName(PathBuf),
    /// A file has the name of an unfinished recording and is none.
    #[error(
        "{} has the name of an unfinished recording and does not begin as one does: it was left alone, and \
         so was what belongs to it; give it another name and run groundwave recover again",
        .0.display()
    )]
    Foreign(PathBuf),
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
    /// Not one chunk of a recording holds.
    #[error("nothing of {} can be saved: not one of its chunks holds, and there is no journal", .0.display())]
    NothingLeft(PathBuf),
    /// What declares a channel is damaged, and nothing else tells of it.
    #[error(
        "will not recover {}: what says which topics its messages belong to is damaged, and nobody could read what was \
         made of it; it was left alone",
        .0.display()
    )]
    NoChannels(PathBuf),
    /// Chunks in a form that others write.
    #[error("will not recover {}: {}", .0.display(), Problem::Lz4)]
    Compression(PathBuf),
    /// A finished recording does not read back as what was received.
    #[error(
        "{} does not hold everything that was received; the journal {} does: groundwave recover {}",
        path.display(), journal.display(), shell_word(path)
    )]
    NotProven {
        /// The recording.
        path: PathBuf,
        /// Its journal.
        journal: PathBuf,
    },
    /// The disk was too slow for a recording, and its journal failed too.
    #[error(
        "{} does not hold everything that was received: the disk was too slow for it, and its journal ended early; both \
         are kept, and groundwave recover {} makes a recording of its own of what the journal has",
        path.display(), shell_word(path)
    )]
    Incomplete {
        /// The recording.
        path: PathBuf,
    },
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
    /// The file cannot be opened.
    #[error("cannot open {}: {}", path.display(), hint::of_reading(error))]
    Open {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// There is no such recording, but what one left behind that was never finished.
    #[error("cannot open that recording: {0}")]
    Missing(Interrupted),
    /// Reading failed in the middle.
    #[error("cannot read {}: {}", path.display(), hint::of_reading(error))]
    Read {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        error: io::Error,
    },
    /// An MCAP that ends too soon.
    #[error(
        "{} ends in the middle: the recording was interrupted; everything before that has been read",
        .0.display()
    )]
    Unfinished(PathBuf),
    /// The file of a recording that was never finished: what could be read of it has been.
    #[error("the recording ends in the middle: {0}")]
    Interrupted(Interrupted),
    /// An MCAP whose checksums or structure do not hold.
    #[error("{} cannot be read whole: {problem}; everything else has been read", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What does not hold.
        problem: String,
    },
    /// The side-car of a recording in the place of a recording.
    #[error("{} is the journal of a recording: groundwave recover {}", .0.display(), shell_word(.0))]
    Journal(PathBuf),
    /// An MCAP of something else.
    #[error("{} holds no {} channel of groundwave.RawBytes: not a Groundwave recording", .0.display(), super::topics::RAW_RX)]
    NoRawBytes(PathBuf),
}

/// What becomes of a recording that could not be finished.
fn recovery(path: &Path) -> String {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("partial" | "journal") => format!(
            ", and `groundwave recover {}` makes it whole when this has ended",
            shell_word(&path.with_extension(""))
        ),
        _ => String::new(),
    }
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
    options.open(path).map_err(|error| {
        let path = path.to_owned();
        if path.is_dir() {
            let error = io::ErrorKind::IsADirectory.into();
            CaptureError::Create { path, error }
        } else if error.kind() == io::ErrorKind::AlreadyExists {
            CaptureError::Exists { path, can_append }
        } else {
            CaptureError::Create { path, error }
        }
    })
}
