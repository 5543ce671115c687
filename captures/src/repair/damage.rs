//! Damaged parts of a file.

use std::fmt;

use serde::{Serialize, Serializer};

use crate::words::counted;

/// Reason why a part of a file cannot be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A chunk with LZ4, the other compression of the MCAP specification. It may be intact.
    #[error(
        "a chunk is compressed with LZ4, which is not read here; `mcap compress` rewrites the file with zstd"
    )]
    Lz4,
    /// Any other reason.
    #[error("{0}")]
    Flaw(&'static str),
}

impl From<&'static str> for Problem {
    fn from(text: &'static str) -> Self {
        Self::Flaw(text)
    }
}

impl Serialize for Problem {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// A damaged part of the file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Damage {
    /// Offset of the first damaged byte in the file.
    pub offset: u64,
    /// Number of bytes skipped; 0 if unknown.
    pub bytes: u64,
    /// Reason for the damage.
    pub problem: Problem,
    /// First and last log time of the lost messages, nanoseconds; known if the chunk's header is intact.
    #[serde(skip)]
    pub times_ns: Option<(u64, u64)>,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset, bytes, .. } = self;
        if *bytes == 0 {
            return write!(f, "{}", self.problem);
        }
        write!(
            f,
            "{} ({} at byte {offset}",
            self.problem,
            counted(*bytes, "byte")
        )?;
        if let Some((first_ns, last_ns)) = self.times_ns {
            let s = last_ns.saturating_sub(first_ns) as f64 / 1e9;
            write!(f, ", {s:.1} s of the recording")?;
        }
        f.write_str(")")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_problem_is_its_text_for_programs_too() {
        for problem in [Problem::Lz4, Problem::from("a record is malformed")] {
            let json = serde_json::to_value(problem).unwrap();
            assert_eq!(json, problem.to_string());
        }
    }
}
