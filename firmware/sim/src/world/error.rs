//! What is wrong with a world, and where.

use std::path::PathBuf;

/// A world that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// A place in the file is wrong; lines and columns count from 1.
    #[error("{file}:{line}:{column}: {problem}")]
    At {
        /// File or built-in name.
        file: String,
        /// Line.
        line: usize,
        /// Column, in characters.
        column: usize,
        /// What is wrong and what to do.
        problem: String,
    },
    /// The file cannot be read.
    #[error("cannot read the world {}: {source}; the worlds that come with the program are {}, and generated:SEED makes one", path.display(), super::BUILT_IN_NAMES)]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// The text of a world, able to say where an offset lies.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// The line of a byte offset, from 1.
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
