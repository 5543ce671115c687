//! How the program ends: the numbers that scripts rely on, and why.

use std::fmt::Display;
use std::io;
use std::path::Path;

use crate::capture::CaptureError;

/// How the program ends; scripts rely on the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Something failed that has no number of its own, or a capture ends early: what came before is told.
    Failed = 1,
    /// Wrong usage or a bad input file.
    Usage = 2,
    /// The robot did not confirm in time.
    NotConfirmed = 3,
    /// The link cannot be opened.
    NoLink = 4,
    /// The robot refused.
    Refused = 5,
    /// The link is receive-only.
    ReceiveOnly = 6,
}

impl Exit {
    /// Every number with which the program ends, and what it means.
    pub fn meanings() -> impl Iterator<Item = (u8, &'static str)> {
        let all = [
            Self::Failed,
            Self::Usage,
            Self::NotConfirmed,
            Self::NoLink,
            Self::Refused,
            Self::ReceiveOnly,
        ];
        let failures = all.into_iter().map(|exit| (exit as u8, exit.meaning()));
        [(0, "done; what was sent is proven")]
            .into_iter()
            .chain(failures)
    }

    const fn meaning(self) -> &'static str {
        match self {
            Self::Failed => "failed, or a capture ends early: what came before is told",
            Self::Usage => "wrong usage, or a bad input file",
            Self::NotConfirmed => {
                "the robot did not confirm in time: its list is the old one or the new one, whole"
            }
            Self::NoLink => "the link cannot be opened: missing, busy, no permission",
            Self::Refused => "the robot refused, with its reason",
            Self::ReceiveOnly => "the link is receive-only",
        }
    }
}

/// Why a command ended early, for a person and for a script.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct Fault {
    pub(super) exit: Exit,
    message: String,
}

impl Fault {
    pub(super) fn new(exit: Exit, message: impl Display) -> Self {
        Self {
            exit,
            message: message.to_string(),
        }
    }

    /// The same fault, told with what goes before it and after it.
    pub(super) fn within(self, before: impl Display, after: impl Display) -> Self {
        Self {
            message: format!("{before}{}{after}", self.message),
            ..self
        }
    }

    /// A file that is no capture of a robot.
    pub(super) fn no_lines(path: &Path, bytes: u64) -> Self {
        let path = if path == Path::new("-") {
            Path::new("standard input")
        } else {
            path
        };
        Self::new(
            Exit::Usage,
            format!(
                "{}: not one line of a robot in {bytes} bytes; it is no capture, or one of nothing but noise, as at a wrong \
                 baud rate",
                path.display()
            ),
        )
    }

    /// An error of standard output; a reader that has gone away is none.
    pub(super) fn output(error: &io::Error) -> Result<(), Self> {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Ok(());
        }
        Err(Self::new(
            Exit::Failed,
            format!("cannot write to standard output: {error}"),
        ))
    }
}

impl From<CaptureError> for Fault {
    /// A usage fault for a file that cannot or must not be used; a failure for a failing disk.
    fn from(error: CaptureError) -> Self {
        let exit = match error {
            CaptureError::Exists { .. }
            | CaptureError::SameFile(_)
            | CaptureError::InUse(_)
            | CaptureError::UnderWay(_)
            | CaptureError::Missing(_)
            | CaptureError::OwnName(_)
            | CaptureError::Compression(_)
            | CaptureError::NoChannels(_)
            | CaptureError::Foreign(_)
            | CaptureError::CannotAppend(_)
            | CaptureError::Journal(_)
            | CaptureError::Route(_)
            | CaptureError::Open { .. } => Exit::Usage,
            CaptureError::Read { ref error, .. } | CaptureError::Create { ref error, .. }
                if error.kind() == io::ErrorKind::IsADirectory =>
            {
                Exit::Usage
            }
            _ => Exit::Failed,
        };
        Self::new(exit, error)
    }
}
