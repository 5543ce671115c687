//! Events and effects: what happened, and what the operator wants done.
//!
//! The model takes an [`Event`] and returns [`Effect`]s. The robot's acknowledgement of a command is an event like
//! any other.

use std::sync::Arc;

use groundwave_protocol::Waypoint;
use groundwave_protocol::decoder::Counters;
use groundwave_protocol::telemetry::{AckLine, Line};

pub use groundwave_captures::event::{
    CommandId, CommandStatus, Failure, Landmark, Level, LineRate, LinkEvent, Mark, Moment, Notice,
    NoticeCode, Reception, Remark, Truth,
};

use crate::playback::Control;
use crate::request::Request;
use crate::run::{Listed, Overlaid};
use crate::statistics::Statistics;

/// Something that happened. The time it happened at travels beside it, as the time since the station
/// started.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// An intact 80-byte line arrived.
    Line {
        /// What it says.
        line: Box<Line>,
        /// Its 80 bytes.
        raw: [u8; 80],
    },
    /// An intact acknowledgement line arrived.
    Ack(AckLine),
    /// The decoder's totals changed.
    Counters(Counters),
    /// How the link does, at most once a second.
    Statistics(Box<Statistics>),
    /// The connection to the radio changed.
    Link(LinkEvent),
    /// What comes from the radio is of another kind now.
    Reception {
        /// Of which.
        reception: Reception,
        /// Since when.
        since: Moment,
    },
    /// A command was asked for, and is queued.
    Asked {
        /// The command.
        id: CommandId,
        /// The request.
        request: Request,
        /// The client that asked, when the link is shared; `None` for this station's operator.
        by: Option<String>,
    },
    /// A command has a new status.
    Command {
        /// The command.
        id: CommandId,
        /// Its status, never [`CommandStatus::Queued`].
        status: CommandStatus,
    },
    /// Where the session is being recorded changed.
    Recording(Recording),
    /// A route file was read for [`Effect::LoadRoute`], or could not be.
    RouteLoaded {
        /// The file that was asked for.
        path: String,
        /// Its waypoints, or what is wrong with it and where.
        route: Result<Vec<Waypoint>, String>,
    },
    /// A route file was written for [`Effect::SaveRoute`], or not.
    RouteSaved {
        /// The file that was asked for.
        path: String,
        /// What happened.
        saved: Result<(), SaveProblem>,
    },
    /// The runs of a folder were read for [`Effect::ListRuns`], or why they could not be.
    Runs(Result<Arc<Listed>, String>),
    /// Two runs were read for [`Effect::CompareRuns`], or why they could not be.
    Overlaid(Result<Arc<Overlaid>, String>),
    /// The operator set or cleared a mark.
    Mark(Mark),
    /// What only a simulator knows: shown as the simulator's truth, used for nothing.
    Truth(Truth),
    /// A line for the log.
    Notice(Notice),
    /// A key was pressed, repeated or released.
    Key(crossterm::event::KeyEvent),
    /// Text was pasted.
    Paste(String),
    /// The mouse was used on something that the screen shows.
    Pointer {
        /// On what.
        on: Spot,
        /// How.
        gesture: Gesture,
    },
    /// The terminal has this size now.
    Resize {
        /// Columns.
        width: u16,
        /// Rows.
        height: u16,
    },
    /// Time passed and nothing else happened.
    Tick,
}

/// What the screen shows where the mouse points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// A point on the floor, whole inches in the robot's frame.
    Floor {
        /// To the right.
        x_in: i16,
        /// Ahead.
        y_in: i16,
        /// What lies no farther from it is meant too, inches.
        reach_in: i16,
    },
    /// A waypoint in the route editor's list, from 0.
    Waypoint(usize),
    /// A panel, by its place in the order of the Tab key.
    Panel(usize),
}

/// What the mouse did there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// The left button.
    Click,
    /// The wheel, by steps; away from the hand is positive.
    Wheel(i8),
}

/// What the operator wants done.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Deliver this and prove it.
    Send(Request),
    /// Drive by hand; to be renewed while the operator holds the key, good for a second.
    Drive {
        /// Speed at the centre, in/s.
        velocity_in_s: i8,
        /// Left minus right, in/s.
        rotation_in_s: i8,
    },
    /// The operator let go: no more drive frames after a final standstill.
    DriveEnd,
    /// Forget commands that wait and the one under way.
    CancelCommands,
    /// Begin a recording with what is remembered, or end the one under way.
    ToggleRecording,
    /// Keep beside the capture of this name what is said of its run.
    Label {
        /// The capture.
        capture: String,
        /// What is said.
        remark: Remark,
        /// How long before now was what it is about; in a capture on show it is about the moment shown.
        ago: Moment,
    },
    /// Read the runs of the captures in a folder; the answer is [`Event::Runs`].
    ListRuns(String),
    /// Read two runs and lay them over each other; the answer is [`Event::Overlaid`].
    CompareRuns([String; 2]),
    /// Read a route file; the answer is [`Event::RouteLoaded`].
    LoadRoute(String),
    /// Write a route file; the answer is [`Event::RouteSaved`].
    SaveRoute {
        /// The file.
        path: String,
        /// What goes into it.
        text: String,
        /// Whatever is there may go.
        overwrite: bool,
    },
    /// Show another moment of the session or capture.
    Playback(Control),
    /// Tell of something in the log: it comes back as [`Event::Notice`].
    Notice(Notice),
    /// Ring the bell: the robot sings, or calls.
    Ring,
    /// Draw the whole screen anew: something else wrote on it.
    Redraw,
    /// Stop the program and put it in the background.
    Suspend,
    /// Leave.
    Quit,
}

/// A text without the quotes around all of it.
pub(crate) fn unquoted(text: &str) -> String {
    match shlex::split(text).as_deref() {
        Some([word]) => word.clone(),
        _ => text.to_owned(),
    }
}

/// `name TEXT`, `note TEXT`, `void [REASON]` or `counts`; `None` for other words. Quotes around a whole text are
/// no part of it.
///
/// # Errors
/// When its text is missing, or it takes none.
#[must_use]
pub fn remark_from_words(words: &[&str]) -> Option<Result<Remark, String>> {
    let (first, rest) = words.split_first()?;
    let text = unquoted(&rest.join(" "));
    Some(match *first {
        "name" | "note" if text.is_empty() => Err(format!("`{first}` takes a text: {first} TEXT")),
        "name" => Ok(Remark::Name(text)),
        "note" => Ok(Remark::Note(text)),
        "void" => Ok(Remark::Void(text)),
        "counts" if rest.is_empty() => Ok(Remark::Counts),
        "counts" => Err("`counts` stands alone".to_owned()),
        _ => return None,
    })
}

/// Why a file was not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SaveProblem {
    /// There is one of that name, and nobody said that it may go.
    Exists,
    /// One line for a person.
    Failed(String),
}

/// Where the session is being recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recording {
    /// Raw bytes go here.
    pub tee: Option<String>,
    /// MCAP goes here.
    pub mcap: Option<String>,
    /// Bytes recorded.
    pub bytes: u64,
    /// Recording failed: what happened and what is lost.
    pub problem: Option<String>,
}
