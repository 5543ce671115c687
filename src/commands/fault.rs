//! Exit codes and the errors that lead to them.

use std::fmt::Display;
use std::io;
use std::path::Path;

use crate::capture::diagnosis::{self, Diagnosis};
use crate::capture::source::Form;
use crate::capture::{Capture, CaptureError, content};
use crate::hint;
use crate::safe_text;
use groundwave_captures::words::counted;

/// Number of bytes examined in a file without a line.
const CONTENT_BYTES: usize = 64 * 1024;

/// Maximum characters of a line of a message.
const MESSAGE_MAX: usize = 1000;

/// Exit codes of the program; scripts rely on the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Exit {
    /// Any other failure, or a capture that could be read only in part.
    Failed = 1,
    /// Wrong usage or a bad input file.
    Usage = 2,
    /// The robot did not confirm in time.
    NotConfirmed = 3,
    /// The link cannot be opened.
    NoLink = 4,
    /// The robot refused, or reports that it cannot do it.
    Refused = 5,
    /// The link is receive-only.
    ReceiveOnly = 6,
}

impl Exit {
    /// All exit codes with their meanings.
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
        [(0, "success; commands are confirmed")]
            .into_iter()
            .chain(failures)
    }

    const fn meaning(self) -> &'static str {
        match self {
            Self::Failed => "failed, or a capture was read only in part",
            Self::Usage => "wrong usage, or a bad input file",
            Self::NotConfirmed => {
                "the robot did not confirm in time, and has the whole old route or the whole new one; or a condition was not met"
            }
            Self::NoLink => "the link cannot be opened: missing, busy or no permission",
            Self::Refused => "the robot refused or cannot do it, for the reason given",
            Self::ReceiveOnly => "the link is receive-only",
        }
    }
}

/// An error message, safe to show, and its exit code.
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
            message: shortened(&safe_text::line(&hint::plain(&message.to_string()))),
        }
    }

    /// A fault with a message of several lines.
    pub(super) fn of_lines(exit: Exit, lines: &[String]) -> Self {
        let lines = lines.iter().map(|line| shortened(&safe_text::line(line)));
        let lines: Vec<String> = lines.collect();
        Self {
            exit,
            message: lines.join("\n"),
        }
    }

    /// The same fault with text before and after its message.
    pub(super) fn within(self, before: impl Display, after: impl Display) -> Self {
        Self {
            message: format!(
                "{}{}{}",
                safe_text::line(&before.to_string()),
                self.message,
                safe_text::line(&after.to_string())
            ),
            ..self
        }
    }

    /// A file without a single line.
    pub(super) fn no_lines(path: &Path, bytes: u64) -> Self {
        let path = if path == Path::new("-") {
            Path::new("standard input")
        } else {
            path
        };
        let bytes = counted(bytes, "byte");
        let found = match content_words(path) {
            None => format!("no line found in {bytes}; the file is not a capture"),
            Some(Content::Recording) => "nothing was received in this recording".to_owned(),
            Some(Content::OwnLines) => {
                "no line of SPEC.md, only a robot's own lines, as `groundwave info` shows"
                    .to_owned()
            }
            Some(Content::Received(words)) => {
                format!("no line found in the {bytes} of this recording: {words}")
            }
            Some(Content::Other(words)) => {
                format!("no line found in {bytes}; the file is not a capture: {words}")
            }
        };
        Self::new(Exit::Usage, format!("{}: {found}", path.display()))
    }

    /// An error of standard output; a closed pipe is not an error.
    pub(super) fn output(error: &io::Error) -> Result<(), Self> {
        if error.kind() == io::ErrorKind::BrokenPipe {
            return Ok(());
        }
        Err(Self::new(
            Exit::Failed,
            format!("cannot write to standard output: {}", hint::words(error)),
        ))
    }
}

/// A message that quotes a long text, without the middle.
fn shortened(message: &str) -> String {
    let count = message.chars().count();
    if count <= MESSAGE_MAX {
        return message.to_owned();
    }
    let begin: String = message.chars().take(MESSAGE_MAX / 2).collect();
    let end: String = message.chars().skip(count - MESSAGE_MAX / 2).collect();
    format!("{begin} ... {end}")
}

impl From<CaptureError> for Fault {
    /// Makes a usage fault for a file that cannot or must not be used, and a failure for a failing disk.
    fn from(error: CaptureError) -> Self {
        let exit = match error {
            CaptureError::Exists { .. }
            | CaptureError::SameFile(_)
            | CaptureError::InUse(_)
            | CaptureError::UnderWay(_)
            | CaptureError::OwnName(_)
            | CaptureError::Compression(_)
            | CaptureError::CannotAppend(_)
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

/// The content of a file without a line by SPEC.md.
enum Content {
    /// A recording without received bytes.
    Recording,
    /// Own lines of a robot.
    OwnLines,
    /// A recording with other bytes, and what they look like.
    Received(String),
    /// Another file.
    Other(String),
}

/// The content of a file without a line; `None` for a stream, which cannot be read again.
fn content_words(path: &Path) -> Option<Content> {
    let mut capture = path.is_file().then(|| Capture::open(path).ok()).flatten()?;
    let (mut head, mut diagnosis) = (Vec::new(), Diagnosis::default());
    while head.len() < CONTENT_BYTES
        && let Ok(Some(chunk)) = capture.next_chunk()
    {
        head.extend_from_slice(chunk.bytes);
        diagnosis.take(chunk.bytes);
    }
    let is_recording = capture.form() == Form::Mcap;
    if is_recording && head.is_empty() {
        return Some(Content::Recording);
    }
    let words = match diagnosis::clause(&diagnosis.findings()) {
        Some(clause) => format!("lines with mistakes: {clause}; `groundwave check` shows more"),
        None if diagnosis.has_own_lines(capture.form()) => return Some(Content::OwnLines),
        None => content::words(&head).to_owned(),
    };
    Some(if is_recording {
        Content::Received(words)
    } else {
        Content::Other(words)
    })
}
