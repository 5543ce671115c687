//! Events and other facts of a recording that are not in the bytes.

use std::fmt;
use std::time::Duration;

pub use groundwave_protocol::arq::{CommandStatus, Failure, Shortfall};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Value, json};

/// Maximum number of figures of each kind in a [`Truth`] that is read; further ones are left out. Every frame draws all of them, and a
/// recording may come from others.
const FIGURES_MAX: usize = 2000;

fn few<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    let mut figures = Vec::deserialize(from)?;
    figures.truncate(FIGURES_MAX);
    figures.shrink_to_fit();
    Ok(figures)
}

/// The true state of a simulated robot's world, in the robot's frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Truth {
    /// Walls, windows and edges of the floor as segments, inches.
    #[serde(deserialize_with = "few")]
    pub walls: Vec<[(f64, f64); 2]>,
    /// The same walls filled, as rectangles along the axes: two opposite corners, inches.
    #[serde(deserialize_with = "few")]
    pub blocks: Vec<[(f64, f64); 2]>,
    /// Furniture and low objects as segments, inches.
    #[serde(deserialize_with = "few")]
    pub furniture: Vec<[(f64, f64); 2]>,
    /// Round obstacles: centre and radius, inches.
    #[serde(deserialize_with = "few")]
    pub circles: Vec<((f64, f64), f64)>,
}

/// An enum with a stable code for each variant.
macro_rules! coded {
    ($(#[$doc:meta])+ $name:ident { $($(#[$variant_doc:meta])+ $variant:ident = $code:literal,)+ }) => {
        $(#[$doc])+
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum $name {
            $($(#[$variant_doc])+ $variant,)+
        }

        impl $name {
            /// Stable code.
            #[must_use]
            pub const fn code(self) -> &'static str {
                match self {
                    $(Self::$variant => $code,)+
                }
            }

            /// The variant with a code; `None` for an unknown one.
            #[must_use]
            pub fn from_code(code: &str) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)+
                    _ => None,
                }
            }

            /// Number of variants.
            pub const COUNT: usize = [$(Self::$variant,)+].len();
        }
    };
}

coded! {
    /// Severity of a notice.
    Level {
        /// Information.
        Info = "info",
        /// The operator should check it.
        Warning = "warning",
        /// The operator must act.
        Alarm = "alarm",
    }
}

coded! {
    /// Subject of a notice.
    NoticeCode {
        /// A session with the robot was opened.
        SessionOpened = "session-opened",
        /// The session with the robot ended.
        SessionEnded = "session-ended",
        /// Hint about a radio that delivers no intact line, or the end of that state.
        Radio = "radio",
        /// The device does not accept bytes.
        NotTaken = "not-taken",
        /// The other end closed connections without a byte.
        EmptyConnections = "empty-connections",
        /// Lines were not printed, because standard output was not read.
        NotPrinted = "not-printed",
        /// The link is shared.
        Shared = "shared",
        /// A client of the shared link was closed.
        ShareClient = "share-client",
        /// The station that shares this link lost its own, or closed the connection.
        SharingStation = "sharing-station",
        /// The Foxglove server listens.
        Foxglove = "foxglove",
        /// A recording began.
        RecordingBegun = "recording-begun",
        /// A recording ended.
        RecordingEnded = "recording-ended",
        /// A recording began, ended, failed or was recovered.
        Recording = "recording",
        /// The beginning of a recording is missing.
        BeginningMissing = "beginning-missing",
        /// A label was saved beside a capture, or saving failed.
        Label = "label",
        /// Answer to a key or a prompt.
        Operator = "operator",
        /// Another robot sends on the channel.
        OtherRobot = "other-robot",
        /// Another robot is followed, because the one before was not heard for a minute.
        RobotReplaced = "robot-replaced",
        /// A mistake in the robot's lines.
        RobotMistake = "robot-mistake",
        /// The robot has more fields of its own than the station keeps.
        FieldsLeftOut = "fields-left-out",
        /// State of the playback.
        Playback = "playback",
        /// Bytes are missing from a capture.
        Missing = "missing",
        /// A part of a capture cannot be read.
        Damaged = "damaged",
        /// The hook of the alarms failed, or an event was not passed to it.
        AlarmHook = "alarm-hook",
        /// Something in the configuration needs attention.
        Configuration = "configuration",
        /// A code of a newer version.
        Other = "other",
    }
}

coded! {
    /// Cause of an outage.
    OutageCause {
        /// The link was lost.
        Unplugged = "unplugged",
        /// The link was open, but almost no bytes arrived.
        Silent = "silent",
        /// Bytes arrived, but no line was intact.
        Damaged = "damaged",
        /// This station was suspended.
        Suspended = "suspended",
        /// The robot rebooted.
        Rebooted = "rebooted",
        /// Lines are missing by the robot's clock, although the capture's times show no gap.
        Gap = "gap",
    }
}

coded! {
    /// A new status of an alarm.
    AlarmStatus {
        /// The cause has lasted long enough.
        Begun = "begun",
        /// The cause is over.
        Ended = "ended",
        /// The operator acknowledged the alarm.
        Acknowledged = "acknowledged",
        /// The operator shelved the alarm for a time.
        Shelved = "shelved",
        /// The shelving ended, by time or by the operator.
        Unshelved = "unshelved",
    }
}

coded! {
    /// Reason for a suggestion.
    SuggestionCode {
        /// The robot's pose is clearly not the estimated one.
        PoseOff = "pose-off",
        /// The diameters of the wheels differ clearly from the robot's parameters.
        WheelsDiffer = "wheels-differ",
        /// The robot's heading is unknown.
        HeadingUnknown = "heading-unknown",
        /// The battery lasts little longer than the drive to the dock takes.
        DockNow = "dock-now",
        /// The robot has moved for minutes without leaving a small place.
        Held = "held",
        /// Floor that was seen has never been visited.
        Unvisited = "unvisited",
    }
}

coded! {
    /// A new status of a suggestion.
    SuggestionStatus {
        /// The reason was found.
        Begun = "begun",
        /// The reason is over, or something else has precedence.
        Ended = "ended",
        /// The operator accepted the suggestion; its commands follow.
        Accepted = "accepted",
        /// The operator did not accept the suggestion in time.
        Expired = "expired",
    }
}

/// A figure in the reason for a suggestion.
#[derive(Clone, PartialEq, prost::Message, Serialize)]
pub struct Figure {
    /// Stable code: `position`, `heading`, `wheels`, `dock-takes`, `battery-lasts`, `held-for` or `never-visited`.
    #[prost(string, tag = 1)]
    pub code: String,
    /// The difference between the robot's value and the estimated one, or the figure itself if it has no interval.
    #[prost(double, tag = 2)]
    pub value: f64,
    /// Half of the 95 % interval of the estimated value.
    #[prost(double, optional, tag = 3)]
    pub half: Option<f64>,
    /// Unit of both.
    #[prost(string, tag = 4)]
    pub unit: String,
}

/// Writes text such as `heading off by 9.0 +-4.0 deg` or `battery lasts 25 min`.
impl fmt::Display for Figure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            code,
            value,
            half,
            unit,
        } = self;
        match half {
            Some(half) => write!(f, "{code} off by {value:.1} +-{half:.1} {unit}"),
            None => write!(f, "{} {value:.0} {unit}", code.replace('-', " ")),
        }
    }
}

/// A change of a suggestion's status. A suggestion is commands that the operator may accept.
#[derive(Clone, Debug, PartialEq)]
pub struct SuggestionEvent {
    /// The reason.
    pub code: SuggestionCode,
    /// The new status.
    pub status: SuggestionStatus,
    /// The commands in words.
    pub commands: Vec<String>,
    /// The reason in figures.
    pub figures: Vec<Figure>,
}

impl SuggestionEvent {
    /// The event as JSON for other programs.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "event": "suggestion",
            "code": self.code.code(),
            "status": self.status.code(),
            "commands": self.commands,
            "figures": self.figures,
        })
    }
}

/// Writes text such as `suggestion begun: set-pose 12 40 93 (heading off by 9.0 +-4.0 deg)`.
impl fmt::Display for SuggestionEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let commands = self.commands.join(", ");
        write!(f, "suggestion {}: {commands}", self.status.code())?;
        let figures = self.figures.iter().map(Figure::to_string);
        let figures: Vec<String> = figures.collect();
        if figures.is_empty() {
            write!(f, " ({})", self.code.code())
        } else {
            write!(f, " ({})", figures.join(", "))
        }
    }
}

/// A change of an alarm's status.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmEvent {
    /// Stable code of the alarm.
    pub code: String,
    /// Name of the alarm, for display.
    pub name: String,
    /// Severity.
    pub level: Level,
    /// The new status.
    pub status: AlarmStatus,
    /// Time of the session at which its cause began; `None` for an answer to an alarm that is not on.
    pub began_at: Option<Moment>,
    /// Latest measured value.
    pub value: Option<f64>,
    /// Limit of the value.
    pub limit: Option<f64>,
    /// Unit of value and limit.
    pub unit: String,
    /// Time for which the alarm is shelved.
    pub shelved_for: Option<Moment>,
    /// The other program whose operator answered, for display; `None` for the own operator.
    pub by: Option<String>,
}

impl AlarmEvent {
    /// The event as JSON for other programs; absent values are left out.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let mut value = json!({
            "event": "alarm",
            "code": self.code,
            "severity": self.level.code(),
            "status": self.status.code(),
        });
        if let (Some(figure), Some(limit)) = (self.value, self.limit) {
            value["value"] = json!(figure);
            value["limit"] = json!(limit);
            value["unit"] = json!(self.unit);
        }
        if let Some(time) = self.shelved_for {
            value["shelved_s"] = json!(time.as_secs_f64());
        }
        if let Some(by) = &self.by {
            value["by"] = json!(by);
        }
        value
    }
}

/// Writes text such as `battery low: begun, 11.5 V (limit 11.6 V)`.
impl fmt::Display for AlarmEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.name, self.status.code())?;
        if let Some(time) = self.shelved_for {
            write!(f, " for {} s", time.as_secs())?;
        }
        if let Some(by) = &self.by {
            write!(f, " by {by}")?;
        }
        if let (Some(value), Some(limit)) = (self.value, self.limit) {
            let unit = &self.unit;
            let space = if unit.is_empty() { "" } else { " " };
            write!(
                f,
                ", {value:.1}{space}{unit} (limit {limit:.1}{space}{unit})"
            )?;
        }
        Ok(())
    }
}

/// A line for the log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Subject.
    pub code: NoticeCode,
    /// Severity.
    pub level: Level,
    /// Text in one line, for display.
    pub text: String,
}

impl Notice {
    /// A notice.
    #[must_use]
    pub fn new(code: NoticeCode, level: Level, text: impl Into<String>) -> Self {
        Self {
            code,
            level,
            text: text.into(),
        }
    }
}

/// Time since the station started.
pub type Moment = Duration;
/// Number of a command in this session, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandId(pub u32);

/// The connection to the radio.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LinkEvent {
    /// Opened, with the name that the operator gave.
    Opened {
        /// Device, address or file.
        name: String,
        /// Whether commands can be sent.
        can_send: bool,
    },
    /// Lost; the station keeps trying to connect.
    Lost {
        /// Reason, for display.
        reason: String,
    },
    /// Ended: end of a file or of standard input.
    Ended,
}

impl LinkEvent {
    /// Reason of a link that was lost because the station that shares it closed the connection.
    pub const STATION_CLOSED: &str = "the station closed the connection";
}

/// Kind of the bytes from the radio over the last seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reception {
    /// Intact lines.
    Lines,
    /// No bytes.
    Nothing,
    /// Bytes without structure.
    Noise,
    /// Text without an intact line.
    Damaged,
    /// Bytes with structure that are not text: the port's baud rate differs from the radio's.
    WrongRate(LineRate),
}

impl Reception {
    /// All kinds.
    pub const ALL: [Self; 6] = [
        Self::Lines,
        Self::Nothing,
        Self::Noise,
        Self::Damaged,
        Self::WrongRate(LineRate::Slower),
        Self::WrongRate(LineRate::Faster),
    ];

    /// Stable code.
    #[must_use]
    pub const fn code(self) -> &'static str {
        match self {
            Self::Lines => "lines",
            Self::Nothing => "nothing",
            Self::Noise => "noise",
            Self::Damaged => "damaged",
            Self::WrongRate(LineRate::Slower) => "slower-rate",
            Self::WrongRate(LineRate::Faster) => "faster-rate",
        }
    }

    /// The kind with a code; `None` for an unknown one.
    #[must_use]
    pub fn from_code(code: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.code() == code)
    }
}

/// Relation of the radio's baud rate to the port's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRate {
    /// The radio's rate is lower.
    Slower,
    /// The radio's rate is higher.
    Faster,
}

/// A label of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remark {
    /// Name.
    Name(String),
    /// A note.
    Note(String),
    /// The run is void, for a reason.
    Void(String),
    /// The run is valid again.
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

/// A mark that the operator set or cleared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mark {
    /// Time since the marked moment.
    pub ago: Moment,
    /// Whether the mark was set; `false` if it was cleared.
    pub is_set: bool,
}

impl fmt::Display for Mark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let word = if self.is_set { "marked" } else { "unmarked" };
        write!(f, "{word} {:.3} s ago", self.ago.as_secs_f64())
    }
}

/// A kind of moment to jump to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Landmark {
    /// A line of the robot.
    Line,
    /// An alarm.
    Alarm,
    /// The bumper touched an obstacle.
    Bump,
    /// Another layer took control of the motors (not hand steering), or the mode changed.
    Behaviour,
    /// A command was queued or ended; in a capture without events, the robot acknowledged another command.
    Command,
    /// A moment that the operator marked.
    Marker,
}

impl Landmark {
    /// Plural noun.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::Line => "lines",
            Self::Alarm => "alarms",
            Self::Bump => "bumps",
            Self::Behaviour => "behaviour changes",
            Self::Command => "commands",
            Self::Marker => "marks",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_has_bounded_figures() {
        let circle = "[[1,2],3],".repeat(3 * FIGURES_MAX);
        let text = format!("{{\"circles\":[{}]}}", circle.trim_end_matches(','));
        let truth: Truth = serde_json::from_str(&text).unwrap();
        assert_eq!(truth.circles, vec![((1.0, 2.0), 3.0); FIGURES_MAX]);
        assert!(truth.walls.is_empty());
    }
}
