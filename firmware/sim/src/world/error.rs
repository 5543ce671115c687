//! Errors in world files, with their position.

use std::path::PathBuf;

use super::built_in::NAMES;

/// Reason why a world cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// An error in the file; line and column count from 1.
    #[error("{file}:{line}:{column}: {problem}")]
    At {
        /// File name or name of a built-in world.
        file: String,
        /// Line.
        line: usize,
        /// Column, in characters.
        column: usize,
        /// The problem and its hint.
        problem: String,
    },
    /// The file cannot be read.
    #[error(
        "cannot read the world {}: {}; give a file, a built-in world ({}) or generated:SEED",
        path.display(),
        match source.kind() {
            std::io::ErrorKind::NotFound => "file not found".to_owned(),
            _ => source.to_string(),
        },
        NAMES
    )]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Cause.
        source: std::io::Error,
    },
}

/// The text of a world, which converts offsets to positions.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// Line number of a byte offset, from 1.
    pub(super) fn line(&self, offset: usize) -> usize {
        let before = self.text.get(..offset).unwrap_or(self.text);
        before.matches('\n').count() + 1
    }

    /// An error at a byte offset.
    pub(super) fn error(&self, offset: usize, problem: impl Into<String>) -> WorldError {
        let before = self.text.get(..offset).unwrap_or(self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        WorldError::At {
            file: self.file.to_owned(),
            line: self.line(offset),
            column: before[line_start..].chars().count() + 1,
            problem: problem.into(),
        }
    }
}
