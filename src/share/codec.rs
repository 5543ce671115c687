//! Lines of the shared socket: one JSON object per line.
//!
//! A station begins each connection with [`ANNOUNCEMENT`], then sends the raw bytes from the radio. On a port, the client's first
//! line is the station's token.
//!
//! A client that sends `{"groundwave":1,"pid":1234}` gets only lines from then on; with `"raw":true` also the raw bytes, as
//! `{"rx":"A0012..."}`, one character per byte. Its commands are `{"id":1,"do":"mode prowl","timeout_ms":20000}`, as typed
//! for `groundwave send`, or `{"id":2,"route":[[48,0],[48,48]],"timeout_ms":20000}`; `{"id":3,"own":"goto 48 0"}` is a command string of
//! the robot. Each status has the `id` of its command;
//! `{"cancel":2}` ends a command. `{"drive":[6,-3]}` drives by hand for half a second, in inches per second; `{"drive":[0,0]}` stops.
//! `{"alarm":"battery_low","answer":"acknowledged"}` answers an alarm; other answers are `"unshelved"` and `{"shelved_s":600}`. All
//! programs on the link take the answer.
//! Commands of other clients and the station's operator come with the station's number:
//! `{"command":7,"by":"pid 31","do":"mode prowl"}`, then `{"command":7,"status":"confirmed"}`.
//! The last line before the station closes a connection is `{"code":"gave-way","error":"..."}`.

use std::time::Duration;

use groundwave_protocol::Waypoint;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::status::StatusJson;
use crate::event::{AlarmAnswer, Answer, SHELF_MAX, Truth};
use crate::request::Request;

/// Version of these lines.
const VERSION: u32 = 1;

/// First bytes of each connection to a shared link; a program that opens the link as a radio can recognize them.
pub const ANNOUNCEMENT: &[u8] = b"{\"groundwave\":1}\n";

/// Beginning of [`ANNOUNCEMENT`] in any version.
const ANNOUNCED: &[u8] = b"{\"groundwave\":";

/// Whether a connection that begins with these bytes is to a shared link; `None` if there are too few bytes.
#[must_use]
pub fn is_announced(bytes: &[u8]) -> Option<bool> {
    let count = bytes.len().min(ANNOUNCED.len());
    if bytes[..count] != ANNOUNCED[..count] {
        return Some(false);
    }
    (count == ANNOUNCED.len()).then_some(true)
}

/// Default timeout of a command.
const TIMEOUT_DEFAULT: Duration = Duration::from_secs(20);

/// Maximum timeout of a command.
const TIMEOUT_MAX: Duration = Duration::from_hours(24);

/// Reason why a line is invalid.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CodecError {
    /// The line is not JSON of the expected form.
    #[error(
        "not understood: {0}. This is a groundwave station: begin with {{\"groundwave\":{VERSION}}}, or only receive"
    )]
    Json(String),
    /// The client has another version.
    #[error("version {0} is not supported, only {VERSION}; use the same groundwave on both sides")]
    Version(u32),
    /// The line is JSON but has other fields.
    #[error(
        "a line needs `groundwave`, `cancel`, `drive`, `alarm` and `answer`, or `id` and one of `do`, `own` or `route`"
    )]
    Shape,
    /// The time for which an alarm is to be shelved is too short or too long.
    #[error("shelved_s must be from 1 to {}", SHELF_MAX.as_secs())]
    Shelf,
    /// The command is invalid.
    #[error("{0}")]
    Request(String),
    /// The timeout is too short or too long.
    #[error("timeout_ms must be from 1 to {}", TIMEOUT_MAX.as_millis())]
    Timeout,
}

impl CodecError {
    /// Stable code.
    #[must_use]
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Version(_) => "version",
            Self::Json(_) | Self::Shape | Self::Shelf | Self::Request(_) | Self::Timeout => {
                "not-understood"
            }
        }
    }
}

/// A line from a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClientLine {
    /// The client sends JSON lines from now on.
    Hello {
        /// Process number that the client reports.
        pid: Option<u32>,
        /// Whether the client also gets the raw bytes.
        raw: bool,
    },
    /// A command.
    Ask(Ask),
    /// Cancels the command with this number, given by the client.
    Cancel(u32),
    /// Answers an alarm.
    Answer {
        /// Stable code of the alarm.
        alarm: String,
        /// The answer.
        answer: Answer,
    },
    /// Drives by hand for half a second; zeros stop the robot.
    Drive {
        /// Forward speed, in/s.
        velocity_in_s: i8,
        /// Speed of the left wheel minus that of the right wheel, in/s.
        rotation_in_s: i8,
    },
}

/// A command of a client.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ask {
    /// Number of the command, given by the client.
    pub tag: u32,
    /// The command.
    pub request: Request,
    /// Timeout for the confirmation.
    pub timeout: Duration,
}

#[derive(Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ClientJson {
    #[serde(skip_serializing_if = "Option::is_none")]
    groundwave: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pid: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    raw: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    id: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    r#do: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    own: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    route: Option<Vec<(i16, i16)>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    timeout_ms: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cancel: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    drive: Option<(i8, i8)>,
    #[serde(skip_serializing_if = "Option::is_none")]
    alarm: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    answer: Option<Answer>,
}

impl ClientJson {
    /// Takes the fields of the command with this number.
    fn take_ask(&mut self, tag: u32) -> Result<Ask, CodecError> {
        let request = RequestJson {
            r#do: self.r#do.take(),
            own: self.own.take(),
            route: self.route.take(),
        };
        let timeout_ms = self.timeout_ms.take();
        Ok(Ask {
            tag,
            request: request.read()?,
            timeout: read_timeout(timeout_ms)?,
        })
    }
}

impl ClientLine {
    /// Parses a line, with or without its line feed. Accepts any bytes.
    ///
    /// # Errors
    /// If the line is invalid.
    pub fn parse(line: &[u8]) -> Result<Self, CodecError> {
        let mut json: ClientJson =
            serde_json::from_slice(line).map_err(|error| CodecError::Json(error.to_string()))?;
        let line = if let Some(version) = json.groundwave.take() {
            let (pid, raw) = (json.pid.take(), json.raw.take().unwrap_or_default());
            if version == VERSION {
                Ok(Self::Hello { pid, raw })
            } else {
                Err(CodecError::Version(version))
            }
        } else if let Some(tag) = json.id.take() {
            json.take_ask(tag).map(Self::Ask)
        } else if let Some(tag) = json.cancel.take() {
            Ok(Self::Cancel(tag))
        } else if let Some((velocity_in_s, rotation_in_s)) = json.drive.take() {
            Ok(Self::Drive {
                velocity_in_s,
                rotation_in_s,
            })
        } else if let (Some(alarm), Some(answer)) = (json.alarm.take(), json.answer.take()) {
            let time = answer.shelved_for();
            if time.is_some_and(|time| time.is_zero() || time > SHELF_MAX) {
                Err(CodecError::Shelf)
            } else {
                Ok(Self::Answer { alarm, answer })
            }
        } else {
            Err(CodecError::Shape)
        };
        // A line has no fields of another kind of line.
        if json == ClientJson::default() {
            line
        } else {
            Err(CodecError::Shape)
        }
    }

    /// The line, with its line feed.
    #[must_use]
    pub fn to_line(&self) -> Vec<u8> {
        let json = match self {
            Self::Hello { pid, raw } => ClientJson {
                groundwave: Some(VERSION),
                pid: *pid,
                raw: raw.then_some(true),
                ..ClientJson::default()
            },
            Self::Ask(ask) => {
                let RequestJson { r#do, own, route } = RequestJson::from(&ask.request);
                ClientJson {
                    id: Some(ask.tag),
                    timeout_ms: Some(ask.timeout.as_millis() as u64),
                    r#do,
                    own,
                    route,
                    ..ClientJson::default()
                }
            }
            Self::Cancel(tag) => ClientJson {
                cancel: Some(*tag),
                ..ClientJson::default()
            },
            Self::Drive {
                velocity_in_s,
                rotation_in_s,
            } => ClientJson {
                drive: Some((*velocity_in_s, *rotation_in_s)),
                ..ClientJson::default()
            },
            Self::Answer { alarm, answer } => ClientJson {
                alarm: Some(alarm.clone()),
                answer: Some(*answer),
                ..ClientJson::default()
            },
        };
        line_of(&json)
    }
}

/// A command as one of three keys of a JSON object.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RequestJson {
    /// As typed for `groundwave send`.
    #[serde(skip_serializing_if = "Option::is_none")]
    r#do: Option<String>,
    /// A command string of the robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    own: Option<String>,
    /// Waypoints of a route, inches.
    #[serde(skip_serializing_if = "Option::is_none")]
    route: Option<Vec<(i16, i16)>>,
}

impl From<&Request> for RequestJson {
    fn from(request: &Request) -> Self {
        let mut json = Self::default();
        match request {
            Request::Route(waypoints) => {
                let points = waypoints.iter().map(|at| (at.x_in, at.y_in));
                json.route = Some(points.collect());
            }
            Request::Own(words) => json.own = Some(words.clone()),
            // The text of a request parses to the same request.
            request => json.r#do = Some(request.to_string()),
        }
        json
    }
}

impl RequestJson {
    /// The request.
    ///
    /// # Errors
    /// If it is invalid.
    pub fn read(self) -> Result<Request, CodecError> {
        let refused = |error: crate::request::RequestError| CodecError::Request(error.to_string());
        match (self.r#do, self.own, self.route) {
            (Some(words), None, None) => {
                let words: Vec<&str> = words.split_whitespace().collect();
                Request::from_words(&words).map_err(refused)
            }
            (None, Some(words), None) if !words.trim().is_empty() => {
                let words: Vec<&str> = words.split_whitespace().collect();
                Ok(Request::Own(words.join(" ")))
            }
            (None, None, Some(points)) => read_route(points),
            _ => Err(CodecError::Shape),
        }
    }
}

/// Reads a route in whole inches; fails if the robot cannot hold it.
pub(super) fn read_route(points: Vec<(i16, i16)>) -> Result<Request, CodecError> {
    let waypoints: Result<Vec<Waypoint>, CodecError> = points
        .into_iter()
        .map(|(x_in, y_in)| {
            Waypoint::new(x_in, y_in)
                .ok_or_else(|| CodecError::Request(format!("({x_in}, {y_in}) is too far away")))
        })
        .collect();
    Request::route(waypoints?).map_err(|error| CodecError::Request(error.to_string()))
}

/// Reads the timeout of a command; default 20 s.
pub(super) fn read_timeout(ms: Option<u64>) -> Result<Duration, CodecError> {
    let timeout = ms.map_or(TIMEOUT_DEFAULT, Duration::from_millis);
    if timeout.is_zero() || timeout > TIMEOUT_MAX {
        return Err(CodecError::Timeout);
    }
    Ok(timeout)
}

/// Number of bytes and lines received during a command.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Heard {
    /// Number of bytes of any kind.
    pub bytes: u64,
    /// Number of intact lines, including acknowledgement lines.
    pub lines: u64,
}

impl Heard {
    /// Counts since an earlier moment.
    #[must_use]
    pub const fn since(self, then: Self) -> Self {
        Self {
            bytes: self.bytes.saturating_sub(then.bytes),
            lines: self.lines.saturating_sub(then.lines),
        }
    }
}

/// The answer to a hello.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Welcome {
    groundwave: u32,
    /// The operator's name of the link.
    pub link: String,
    /// Whether the station sends commands.
    pub can_send: bool,
    /// Whether the station runs the operator's command for alarms.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub runs_alarm_hook: bool,
    /// The answers to alarms that apply now.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub answers: Vec<AlarmAnswer>,
    /// The world of a simulated robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<Truth>,
    /// Time at which the station began, ms since 1970: two stations at one address, one after the other, may have two robots.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub began_ms: Option<u64>,
}

impl Welcome {
    /// The welcome to a link with this name.
    #[must_use]
    pub const fn new(link: String, can_send: bool) -> Self {
        Self {
            groundwave: VERSION,
            link,
            can_send,
            runs_alarm_hook: false,
            answers: Vec::new(),
            truth: None,
            began_ms: None,
        }
    }
}

/// Bytes from the radio as text: each byte as the character with its number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct RawBytes(pub Vec<u8>);

impl TryFrom<String> for RawBytes {
    type Error = std::char::TryFromCharError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        text.chars()
            .map(u8::try_from)
            .collect::<Result<_, _>>()
            .map(Self)
    }
}

impl From<RawBytes> for String {
    fn from(bytes: RawBytes) -> Self {
        bytes.0.into_iter().map(char::from).collect()
    }
}

/// A line from the station.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StationLine {
    /// Bytes from the radio.
    Received {
        /// The bytes.
        rx: RawBytes,
    },
    /// The station sends JSON lines from now on.
    Welcome(Welcome),
    /// A command has a new status.
    Status {
        /// Number of the command, given by the client.
        id: u32,
        /// The status.
        #[serde(flatten)]
        status: StatusJson,
        /// Bytes and lines received since the command was queued.
        heard: Heard,
    },
    /// The link to the robot is lost; the station is reconnecting.
    Lost {
        /// Reason.
        lost: String,
    },
    /// Text of a line T of the robot.
    Said {
        /// The text.
        said: String,
    },
    /// Another client or the station's operator gave a command.
    Asked {
        /// The station's number of the command.
        command: u32,
        /// Who gave it, for display.
        by: String,
        /// The request.
        #[serde(flatten)]
        request: RequestJson,
    },
    /// A command of another client or the station's operator has a new status.
    Command {
        /// The station's number of the command.
        command: u32,
        /// The status.
        #[serde(flatten)]
        status: StatusJson,
    },
    /// Another client or the station's operator answered an alarm.
    Answered(AlarmAnswer),
    /// The station closes the connection.
    Error {
        /// The reason as a stable code.
        code: String,
        /// The reason and a hint, for display.
        error: String,
    },
}

impl StationLine {
    /// The last line to a client, with the reason why the station closes the connection.
    #[must_use]
    pub fn error(code: &str, error: impl Into<String>) -> Self {
        Self::Error {
            code: code.to_owned(),
            error: error.into(),
        }
    }

    /// Parses a line, with or without its line feed; `None` for raw bytes from the radio.
    #[must_use]
    pub fn parse(line: &[u8]) -> Option<Self> {
        serde_json::from_slice(line).ok()
    }

    /// The line, with its line feed.
    #[must_use]
    pub fn to_line(&self) -> Vec<u8> {
        match self {
            Self::Welcome(welcome) => line_of(welcome),
            Self::Answered(answered) => line_of(answered),
            // In a `Value`, the keys are in the order of the alphabet.
            line => line_of(&json!(line)),
        }
    }
}

fn line_of(value: &impl Serialize) -> Vec<u8> {
    // Strings, numbers and string keys always serialise.
    let mut line = serde_json::to_vec(value).unwrap_or_default();
    line.push(b'\n');
    line
}

#[cfg(test)]
mod tests;
