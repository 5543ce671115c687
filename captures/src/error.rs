//! Errors of reading and writing captures.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use super::repair::Problem;
use crate::hint::{self, shell_word};

/// Treatment of an existing file with the name of the file to be written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Existing {
    /// Keep the file and fail.
    #[default]
    Refuse,
    /// Append to the file; raw captures only.
    Append,
    /// Replace the file.
    Overwrite,
}

/// Fate of a file while it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fate {
    /// The file has no name any more.
    Removed,
    /// The file has another name.
    Moved,
    /// The file has another name or none; not all systems say which.
    Unknown,
}

impl fmt::Display for Fate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Removed => {
                f.write_str("it was removed, and its content is lost; start a new recording")
            }
            Self::Unknown => f.write_str("it was moved or removed; start a new recording"),
            Self::Moved => f.write_str(
                "it was moved or renamed, and its content is kept there; start a new recording",
            ),
        }
    }
}

/// A capture could not be written or read.
#[derive(Debug, thiserror::Error)]
pub enum CaptureError {
    /// The file exists and may not be overwritten.
    #[error(
        "will not record to {}: the file exists; choose another name, or give --force to replace it{}",
        path.display(),
        if *can_append { ", or --append to append to it" } else { "" }
    )]
    Exists {
        /// The file.
        path: PathBuf,
        /// Whether `--append` is possible.
        can_append: bool,
    },
    /// Two captures of one session would go to the same file.
    #[error("will not record to {} twice: give --tee and --record different names", .0.display())]
    SameFile(PathBuf),
    /// The name is reserved for recovery or for a label.
    #[error(
        "will not write {}: names that end in .finishing or .damaged are reserved for recovery, .run.toml for labels; choose another name",
        .0.display()
    )]
    OwnName(PathBuf),
    /// A recovery could not write its result.
    #[error(
        "recovering {} failed: {}; {}nothing was changed",
        path.display(), hint::words(error),
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
        /// The operating system's error.
        error: io::Error,
    },
    /// Another program records to the file.
    #[error("will not record to {}: another groundwave is recording it; choose another name", .0.display())]
    InUse(PathBuf),
    /// The recording to be recovered is in use.
    #[error("will not recover {}: another groundwave is recording or recovering it; end it there first", .0.display())]
    UnderWay(PathBuf),
    /// No part of the file can be read as a recording.
    #[error("nothing of {} can be saved: no part of a Groundwave recording in it can be read; raw text needs no recovery", .0.display())]
    NothingLeft(PathBuf),
    /// The chunks have an unsupported compression.
    #[error("will not recover {}: {}", .0.display(), Problem::Lz4)]
    Compression(PathBuf),
    /// The file is a route.
    #[error(
        "{} is a route, not a capture: groundwave send LINK route {} sends it; in the dashboard r loads it as a draft",
        .0.display(), shell_word(.0)
    )]
    Route(PathBuf),
    /// Recordings cannot be appended to.
    #[error("cannot append to {}: only raw text can be appended to; choose another name", .0.display())]
    CannotAppend(PathBuf),
    /// The file cannot be created.
    #[error("cannot create {}: {}{}", path.display(), hint::words(error), hint(error))]
    Create {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// An interrupted recording keeps its name, which a new one needs.
    #[error(
        "cannot rename the interrupted recording {}, to free its name: {}; choose another name",
        path.display(),
        hint::words(error)
    )]
    SetAside {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// Writing failed in the middle.
    #[error(
        "recording to {} stopped: {}; everything before is kept{}{}",
        path.display(),
        hint::words(error),
        recovery(path),
        hint(error)
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// The operating system's error, or that of the format.
        error: io::Error,
    },
    /// The first bytes could not be written.
    #[error("cannot record to {}: {}; nothing was written{}", path.display(), hint::words(error), hint(error))]
    NothingWritten {
        /// The file, which is empty.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The file was removed or renamed while it was written.
    #[error("recording to {}: the file no longer exists; {fate}", path.display())]
    Gone {
        /// The file.
        path: PathBuf,
        /// Whether the file was removed or renamed.
        fate: Fate,
    },
    /// The disk has stopped writing.
    #[error("recording to {}: the disk has written nothing for 30 s; a power cut would lose everything since", .0.display())]
    Stalled(PathBuf),
    /// The file cannot be opened.
    #[error("cannot open {}: {}", path.display(), hint::of_reading(error))]
    Open {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// Reading failed in the middle.
    #[error("cannot read {}: {}", path.display(), hint::of_reading(error))]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's error.
        error: io::Error,
    },
    /// The finished copy of a recording differs from it.
    #[error(
        "{} could not be finished: its copy did not read back correctly; the recording is unchanged; \
         `groundwave recover {}` tries again",
        .0.display(), shell_word(.0)
    )]
    NotConfirmed(PathBuf),
    /// The recording is in progress or was interrupted.
    #[error("{}", unfinished_words(path, *is_in_use))]
    Unfinished {
        /// The file.
        path: PathBuf,
        /// Whether a program is recording it now.
        is_in_use: bool,
    },
    /// Checksums or structure of the recording are wrong.
    #[error("{} cannot be read completely: {problem}; everything else has been read", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The damaged parts.
        problem: String,
    },
    /// The MCAP file is not a Groundwave recording.
    #[error("{} holds no {} channel of groundwave.RawBytes: not a Groundwave recording", .0.display(), super::topics::RAW_RX)]
    NoRawBytes(PathBuf),
}

/// The command that finishes a recording whose writing failed.
fn recovery(path: &Path) -> String {
    if path
        .extension()
        .is_some_and(|extension| extension == "mcap")
    {
        return format!(
            "; then `groundwave recover {}` finishes the recording",
            shell_word(path)
        );
    }
    String::new()
}

fn unfinished_words(path: &Path, is_in_use: bool) -> String {
    let name = path.display();
    if is_in_use {
        return format!("{name} is being recorded: its end is not written yet");
    }
    format!(
        "{name} was interrupted; it has been read to its end; `groundwave recover {}` finishes it",
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
