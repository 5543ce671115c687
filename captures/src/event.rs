//! What a recording knows besides bytes, and the words for it.

use std::fmt;
use std::time::Duration;

use serde::{Deserialize, Serialize};

/// The simulator's truth, in the robot's own frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Truth {
    /// Walls and obstacles as segments, inches.
    pub walls: Vec<[(f64, f64); 2]>,
    /// Round obstacles: centre and radius, inches.
    pub circles: Vec<((f64, f64), f64)>,
}

/// How much a notice matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// For the record.
    Info,
    /// Something to look at.
    Warning,
    /// Something to act on.
    Alarm,
}

/// Time since the station started.
pub type Moment = Duration;
/// A command of this session, numbered from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandId(pub u32);

/// Why a command ended without proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// No acknowledgement came in time.
    #[error("not confirmed in time: the robot may or may not have heard it")]
    TimedOut,
    /// The robot booted in the middle.
    #[error("the robot restarted before it confirmed")]
    RobotRestarted,
    /// Another station opened a session.
    #[error("another station took over the robot")]
    TakenOver,
    /// STOP came first.
    #[error("cancelled by STOP")]
    Stopped,
    /// The operator cancelled it.
    #[error("cancelled")]
    Cancelled,
    /// The link carries nothing to the robot.
    #[error("the link is receive-only")]
    ReceiveOnly,
}

impl Failure {
    /// All of them.
    pub const ALL: [Self; 6] = [
        Self::TimedOut,
        Self::RobotRestarted,
        Self::TakenOver,
        Self::Stopped,
        Self::Cancelled,
        Self::ReceiveOnly,
    ];
}

/// The connection to the radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// Open; the name is what the operator called it.
    Opened {
        /// Device, address or file.
        name: String,
        /// Whether commands can be sent.
        can_send: bool,
    },
    /// Gone; the station keeps trying.
    Lost {
        /// What happened, for a person.
        reason: String,
    },
    /// Over for good: end of a file or of standard input.
    Ended,
}

/// What comes from the radio, judged over seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reception {
    /// Intact lines.
    Lines,
    /// Not a byte.
    Nothing,
    /// Bytes without any order.
    Noise,
    /// Text, and no line of it intact.
    Damaged,
    /// Bytes with an order that makes no text: the port's baud rate is not the radio's.
    WrongRate(LineRate),
}

/// How the radio's baud rate differs from the port's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRate {
    /// It is lower.
    Slower,
    /// It is higher.
    Faster,
}

/// What an operator says of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remark {
    /// What to call it.
    Name(String),
    /// Something worth keeping.
    Note(String),
    /// It does not count, and why.
    Void(String),
    /// It counts after all.
    Counts,
}

impl fmt::Display for Remark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(text) => write!(f, "the run is called {text}"),
            Self::Note(text) => write!(f, "note: {text}"),
            Self::Void(reason) if reason.is_empty() => write!(f, "the run is void"),
            Self::Void(reason) => write!(f, "the run is void: {reason}"),
            Self::Counts => write!(f, "the run counts"),
        }
    }
}

/// The operator marked a moment, or took a mark away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// How long ago the moment was; to the millisecond when it is told in words.
    pub ago: Moment,
    /// Set; else taken away.
    pub is_set: bool,
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.is_set { "marked" } else { "unmarked" };
        write!(f, "{word} {:.3} s ago", self.ago.as_secs_f64())
    }
}

impl Mark {
    /// What its words say; `None` for other words.
    #[must_use]
    pub fn from_words(words: &str) -> Option<Self> {
        let (word, ago) = words.split_once(' ')?;
        let is_set = match word {
            "marked" => true,
            "unmarked" => false,
            _ => return None,
        };
        let ago_s = ago.strip_suffix(" s ago")?.parse().ok()?;
        let ago = Moment::try_from_secs_f64(ago_s).ok()?;
        Some(Self { ago, is_set })
    }
}

/// What can be jumped to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landmark {
    /// A line of the robot.
    Line,
    /// Something to act on.
    Alarm,
    /// The bumper touched something.
    Bump,
    /// Somebody else holds the motors, steering aside, or the mode changed.
    Behaviour,
    /// A command was asked for or came to its end; where a capture does not say, the robot acknowledged another.
    Command,
    /// A moment that the operator marked.
    Marker,
}

impl Landmark {
    /// In the plural.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Line => "lines",
            Self::Alarm => "alarms",
            Self::Bump => "bumps",
            Self::Behaviour => "behaviour changes",
            Self::Command => "commands",
            Self::Marker => "markers",
        }
    }
}
