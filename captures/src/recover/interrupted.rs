//! Recordings that nobody finished, in words for whoever wants to read one.

use std::fmt;
use std::path::{Path, PathBuf};

use super::survey::Survey;
use super::{Paths, is_in_use, refuse_foreign};
use crate::hint::shell_word;

/// A recording that was never finished: what is missing from it, and what to do.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interrupted {
    target: PathBuf,
    /// Received bytes that had been read already, where any could be.
    read_bytes: u64,
    /// Received bytes that only the journal has.
    more_bytes: u64,
    is_in_use: bool,
}

impl Interrupted {
    /// Looks for the files of an unfinished recording, whichever of its names is given. `read_bytes` of the radio are known
    /// already.
    #[must_use]
    pub fn find(path: &Path, read_bytes: u64) -> Option<Self> {
        let paths = Paths::of(path);
        if !paths.are_interrupted() || refuse_foreign(&paths).is_err() {
            return None;
        }
        let is_in_use = is_in_use(&paths);
        // What of a journal cannot be read is for the recovery to tell.
        let journal_bytes = Survey::of(&paths.journal).map_or(0, |survey| survey.rx_end);
        Some(Self {
            target: paths.target,
            read_bytes,
            more_bytes: journal_bytes.saturating_sub(read_bytes),
            is_in_use,
        })
    }

    /// What is to be said before what there is of it is shown.
    #[must_use]
    pub fn beforehand(&self) -> String {
        let missing = if self.is_in_use {
            "it is being recorded: its newest part is missing"
        } else {
            "its end is missing"
        };
        format!("{missing}{}", self.hint())
    }

    fn hint(&self) -> String {
        if self.is_in_use {
            return "; it can be read when the recording has ended".to_owned();
        }
        format!(
            "; `groundwave recover {}` puts it right",
            shell_word(&self.target)
        )
    }
}

impl fmt::Display for Interrupted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let target = self.target.display();
        let what = if self.is_in_use {
            "is being recorded"
        } else {
            "was interrupted"
        };
        write!(f, "{target} {what}")?;
        match (self.more_bytes, self.read_bytes) {
            (0, _) => {}
            (bytes, 0) => write!(f, ": {bytes} bytes of the radio lie in its journal")?,
            (bytes, _) => write!(f, ": {bytes} bytes more lie in its journal")?,
        }
        f.write_str(&self.hint())
    }
}
