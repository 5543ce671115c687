//! Targets of a search.

use std::fmt;

use super::control::Landmark;
use crate::event::Moment;

/// A line or landmark that may be in the unread part of a capture.
#[derive(Clone, Copy, Debug)]
pub(super) enum Target {
    /// The line with this number, from 1.
    Line(u64),
    /// The next landmark after a moment, or the last before it.
    Landmark {
        landmark: Landmark,
        from: Moment,
        forward: bool,
    },
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Landmark { landmark, .. } => f.write_str(landmark.words()),
        }
    }
}

impl Target {
    /// Message when the target does not exist.
    pub(super) fn not_found(self) -> String {
        match self {
            Self::Line(_) => format!("there is no {self}"),
            Self::Landmark { forward: true, .. } => format!("there are no later {self}"),
            Self::Landmark { forward: false, .. } => format!("there are no earlier {self}"),
        }
    }
}
