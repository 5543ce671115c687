//! What is looked for and may lie where nobody has read yet.

use std::fmt;

use crate::event::Moment;
use crate::travel::Landmark;

/// What is looked for.
#[derive(Clone, Copy, Debug)]
pub(super) enum Quest {
    /// The line of this number.
    Packet(u64),
    /// A landmark, from a moment on.
    Landmark {
        sought: Landmark,
        from: Moment,
        forward: bool,
    },
}

impl fmt::Display for Quest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Packet(number) => write!(f, "packet {number}"),
            Self::Landmark { sought, .. } => f.write_str(sought.words()),
        }
    }
}

impl Quest {
    /// What is told when there is none.
    pub(super) fn nowhere(self) -> String {
        match self {
            Self::Packet(_) => format!("there is no {self}"),
            Self::Landmark { forward: true, .. } => format!("there are no later {self}"),
            Self::Landmark { forward: false, .. } => format!("there are no earlier {self}"),
        }
    }
}
