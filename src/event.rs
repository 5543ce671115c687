//! Events (changes that the model takes) and effects (actions that the model requests).
//!
//! The model takes an [`Event`] and returns [`Effect`]s. The robot's acknowledgement of a command is an event like
//! any other.

use std::sync::Arc;

use groundwave_lines::OwnLine;
use groundwave_protocol::Waypoint;
use groundwave_protocol::decoder::Counters;
use groundwave_protocol::telemetry::{AckLine, Line};
use serde::{Deserialize, Serialize};

pub use groundwave_captures::event::{
    AlarmEvent, AlarmStatus, CommandId, CommandStatus, Failure, Figure, Landmark, Level, LineRate,
    LinkEvent, Mark, Moment, Notice, NoticeCode, OutageCause, Reception, Remark, Shortfall,
    SuggestionCode, SuggestionEvent, SuggestionStatus, Truth,
};

use groundwave_captures::messages::{EstimateMessage, FloorMessage};

use crate::figures::{Listed, Overlaid};
use crate::outages::Outage;
use crate::parameter_file::ParameterFile;
use crate::playback::Control;
use crate::request::Request;
use crate::statistics::Statistics;

/// Name of the station itself where it gives commands without the operator.
pub const GROUND: &str = "ground";

/// An event. Its time, since the station started, is passed separately.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// An intact 80-byte line arrived.
    Line {
        /// The decoded line.
        line: Box<Line>,
        /// The line's 80 bytes.
        raw: [u8; 80],
    },
    /// A line A was repaired. It counts as damaged: only the ground's estimate takes it.
    Repaired(Box<Line>),
    /// An intact acknowledgement line arrived.
    Ack(AckLine),
    /// A line of the robot's own arrived, in a form that is not Groundwave's.
    Own(OwnLine),
    /// The decoder's totals changed.
    Counters(Counters),
    /// Statistics of the link, at most once a second.
    Statistics(Box<Statistics>),
    /// The connection to the radio changed.
    Link(LinkEvent),
    /// The kind of bytes from the radio changed.
    Reception {
        /// The new kind.
        reception: Reception,
        /// Time at which this kind began.
        since: Moment,
    },
    /// A time without lines began, or one has ended.
    Outage(Outage),
    /// This station was suspended until now, for this duration.
    Suspended(Moment),
    /// A command was queued.
    Asked {
        /// Number of the command.
        id: CommandId,
        /// The request.
        request: Request,
        /// The client of the shared link that gave the command, or [`GROUND`]; `None` for this station's operator.
        by: Option<String>,
    },
    /// A command has a new status.
    Command {
        /// Number of the command.
        id: CommandId,
        /// Status of the command; never [`CommandStatus::Queued`].
        status: CommandStatus,
    },
    /// The state of the recording changed.
    Recording(Recording),
    /// Files were listed for [`Effect::ListFiles`].
    Files {
        /// The requested beginning of the file names.
        beginning: String,
        /// The files; folders end with a slash.
        files: Vec<String>,
    },
    /// A route file was read for [`Effect::LoadRoute`], or reading failed.
    RouteLoaded {
        /// The requested file.
        path: String,
        /// Waypoints of the file, or the mistake with its position.
        route: Result<Vec<Waypoint>, String>,
    },
    /// A parameter file was read for [`Effect::LoadParameters`], or reading failed.
    ParametersLoaded {
        /// Parameters of the file, or the mistake with its position.
        read: Result<ParameterFile, String>,
    },
    /// A file was written for [`Effect::Save`], or writing failed.
    Saved {
        /// Kind of the file.
        kind: FileKind,
        /// The requested file.
        path: String,
        /// The result.
        saved: Result<(), SaveProblem>,
    },
    /// The runs of a folder were read for [`Effect::ListRuns`], or the error.
    Runs(Result<Arc<Listed>, String>),
    /// Two runs were read for [`Effect::CompareRuns`], or the error.
    Overlaid(Result<Arc<Overlaid>, String>),
    /// The operator set or cleared a mark.
    Mark(Mark),
    /// The status of an alarm changed.
    Alarm(AlarmEvent),
    /// An operator of another program on this link answered an alarm; it is reported as [`Event::Alarm`], too.
    AlarmAnswer(AlarmAnswer),
    /// The status of a suggestion changed.
    Suggestion(SuggestionEvent),
    /// The ground's estimate of the robot's pose, at most once a second.
    Estimate(EstimateMessage),
    /// The floor that the robot has seen, at most once a minute.
    Floor(Box<FloorMessage>),
    /// The true state of a simulated robot's world; it is only shown.
    Truth(Truth),
    /// A line for the log.
    Notice(Notice),
    /// A key was pressed, repeated or released.
    Key(crossterm::event::KeyEvent),
    /// Text was pasted.
    Paste(String),
    /// The mouse was used on an object on the screen.
    Pointer {
        /// The object.
        on: Spot,
        /// The gesture.
        gesture: Gesture,
    },
    /// The size of the terminal changed.
    Resize {
        /// Number of columns.
        width: u16,
        /// Number of rows.
        height: u16,
    },
    /// Only time has passed.
    Tick,
}

/// An operator's answer to an alarm, given in another program on the link.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct AlarmAnswer {
    /// Stable code of the alarm.
    pub alarm: String,
    /// The answer.
    pub answer: Answer,
    /// Name of the program, for display.
    pub by: String,
}

/// An operator's answer to an alarm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// The alarm is known until it begins again.
    Acknowledged,
    /// The alarm is put off for this time, seconds.
    #[serde(rename = "shelved_s")]
    Shelved(u64),
    /// The alarm is not put off any more.
    Unshelved,
}

/// Maximum time for which an alarm is shelved.
pub const SHELF_MAX: Moment = Moment::from_hours(24);

impl Answer {
    /// The answer in the event that reports it; `None` if it is no answer.
    #[must_use]
    pub fn of(event: &AlarmEvent) -> Option<Self> {
        match event.status {
            AlarmStatus::Acknowledged => Some(Self::Acknowledged),
            AlarmStatus::Shelved => Some(Self::Shelved(event.shelved_for?.as_secs().max(1))),
            AlarmStatus::Unshelved => Some(Self::Unshelved),
            AlarmStatus::Begun | AlarmStatus::Ended => None,
        }
    }

    /// The status that the alarm has then.
    #[must_use]
    pub const fn status(self) -> AlarmStatus {
        match self {
            Self::Acknowledged => AlarmStatus::Acknowledged,
            Self::Shelved(_) => AlarmStatus::Shelved,
            Self::Unshelved => AlarmStatus::Unshelved,
        }
    }

    /// Time for which the alarm is shelved.
    #[must_use]
    pub const fn shelved_for(self) -> Option<Moment> {
        match self {
            Self::Shelved(seconds) => Some(Moment::from_secs(seconds)),
            Self::Acknowledged | Self::Unshelved => None,
        }
    }
}

/// An object on the screen under the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Spot {
    /// A point on the floor, whole inches in the robot's frame.
    Floor {
        /// X, inches; positive right.
        x_in: i16,
        /// Y, inches; positive ahead.
        y_in: i16,
        /// Radius within which other objects also match, inches.
        reach_in: i16,
    },
    /// A waypoint in the route editor's list, from 0.
    Waypoint(usize),
    /// A panel, by its index in the order of the Tab key.
    Panel(usize),
}

/// A gesture of the mouse.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gesture {
    /// A click of the left button.
    Click,
    /// Steps of the wheel; positive away from the hand.
    Wheel(i8),
}

/// A request of the operator, to be carried out by the runtime.
#[derive(Clone, Debug, PartialEq)]
pub enum Effect {
    /// Deliver a command until the robot has confirmed it.
    Send(Request),
    /// Deliver a command that the operator has not given, by [`GROUND`].
    SendUnasked(Request),
    /// Drive by hand; renewed while the operator holds the key.
    Drive {
        /// Speed at the centre, in/s.
        velocity_in_s: i8,
        /// Speed of the left wheel minus that of the right wheel, in/s.
        rotation_in_s: i8,
    },
    /// End hand drive; the robot stops.
    DriveEnd,
    /// Cancel the current command and the waiting ones.
    CancelCommands,
    /// Report the operator's answer to an alarm, also to other programs on the link; the report comes back as [`Event::Alarm`].
    AnswerAlarm(AlarmEvent),
    /// Report that the operator accepted a suggestion; the report comes back as [`Event::Suggestion`].
    Suggestion(SuggestionEvent),
    /// Begin a recording that includes the remembered observations, or end the current recording.
    ToggleRecording,
    /// Save a remark in the label beside a capture.
    Label {
        /// The capture.
        capture: String,
        /// The remark.
        remark: Remark,
        /// Time since the moment of the remark.
        ago: Moment,
    },
    /// Read the runs of the captures in a folder; the answer is [`Event::Runs`].
    ListRuns(String),
    /// Read two runs for comparison; the answer is [`Event::Overlaid`].
    CompareRuns([String; 2]),
    /// End the session and replay a capture.
    Replay(String),
    /// List the files whose names begin with a text; the answer is [`Event::Files`].
    ListFiles {
        /// Beginning of the names.
        beginning: String,
        /// Wanted extensions; other files are listed only if there is none with these.
        extensions: &'static [&'static str],
    },
    /// Read a route file; the answer is [`Event::RouteLoaded`].
    LoadRoute(String),
    /// Read a parameter file; the answer is [`Event::ParametersLoaded`].
    LoadParameters(String),
    /// Write a file; the answer is [`Event::Saved`].
    Save {
        /// Kind of the file.
        kind: FileKind,
        /// Path of the file.
        path: String,
        /// Content of the file.
        text: String,
        /// Whether an existing file may be overwritten.
        overwrite: bool,
    },
    /// Show another moment of the session or capture.
    Playback(Control),
    /// Log a notice; the notice comes back as [`Event::Notice`].
    Notice(Notice),
    /// Put a text on the terminal's clipboard.
    Copy(String),
    /// Ring the bell, for a song or an alarm.
    Ring,
    /// Redraw the whole screen, after another program has written to it.
    Redraw,
    /// Stop the program and put it in the background.
    Suspend,
    /// Leave the program.
    Quit,
}

/// A text without its enclosing quotes.
pub(crate) fn unquoted(text: &str) -> String {
    match shlex::split(text).as_deref() {
        Some([word]) => word.clone(),
        _ => text.to_owned(),
    }
}

/// Parses `name TEXT`, `note TEXT`, `void [REASON]` or `counts`; `None` for other words. Enclosing quotes are removed.
///
/// # Errors
/// If a text is missing, or not expected.
#[must_use]
pub fn remark_from_words(words: &[&str]) -> Option<Result<Remark, String>> {
    let (first, rest) = words.split_first()?;
    let text = unquoted(&rest.join(" "));
    Some(match *first {
        "name" | "note" if text.is_empty() => Err(format!("`{first}` needs a text: {first} TEXT")),
        "name" => Ok(Remark::Name(text)),
        "note" => Ok(Remark::Note(text)),
        "void" => Ok(Remark::Void(text)),
        "counts" if rest.is_empty() => Ok(Remark::Counts),
        "counts" => Err("`counts` stands alone".to_owned()),
        _ => return None,
    })
}

/// Kind of a file that the operator saves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// The drafted route.
    Route,
    /// The robot's parameters.
    Parameters,
}

/// Reason why a file was not written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SaveProblem {
    /// The file exists and may not be overwritten.
    Exists,
    /// Another error, as one line.
    Failed(String),
}

/// State of the recording of a session.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Recording {
    /// File of the raw bytes.
    pub tee: Option<String>,
    /// MCAP file.
    pub mcap: Option<String>,
    /// Number of bytes recorded.
    pub bytes: u64,
    /// Reason why recording failed, and the loss.
    pub problem: Option<String>,
    /// Whether the disk or the pipe has stopped accepting bytes.
    pub is_disk_silent: bool,
}
