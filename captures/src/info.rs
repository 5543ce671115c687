//! Summary of a capture.

mod survey;
mod text;

use groundwave_protocol::decoder::Received;
use serde::{Serialize, Serializer};

use super::Capture;
use super::own_lines::OwnSummary;
use super::runs::label::Label;
use super::source::Form;
use crate::diagnosis::Finding;
use crate::marks::{MarkWithText, with_texts};
use crate::messages::{LINE_TYPES, line_type};
use crate::outages::Outage;
use crate::statistics::{Damaged, Loss, OtherRobot, Resync};
use survey::Survey;

/// Summary of a capture.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// Form of the capture.
    pub form: Form,
    /// Differences of a raw text from the radio's bytes: timestamps, other line ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stored: Option<String>,
    /// Start in UTC, from the metadata of a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// Link of the session, from the metadata of a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// Program and version that recorded the session, from the metadata of a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub software: Option<String>,
    /// Name of the run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Reason why the run is void; `None` if it is valid.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void: Option<String>,
    /// Marks set by the operator, in order.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub marks: Vec<MarkWithText>,
    /// The operator's notes about the whole run.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Time from the beginning to the last byte, seconds; for raw text without timestamps, the transmission time at the rate of the
    /// robot's clock, or at 2400 baud.
    pub duration_s: f64,
    /// Time between lines C by the robot's clock, seconds, of all pairs of the same boot; `None` without such a pair. Raw text without
    /// timestamps has no pauses, so its duration can be shorter.
    pub robot_clock_s: Option<u64>,
    /// Number of bytes received.
    pub bytes: u64,
    /// Number of bytes outside intact lines.
    pub noise_bytes: u64,
    /// Number of bytes at the end that may begin a line; part of `noise_bytes`.
    pub unfinished_bytes: u64,
    /// Number of received bytes that are missing from the capture.
    pub missing_bytes: u64,
    /// Intact lines.
    pub lines: LineCounts,
    /// Loss of lines.
    #[serde(flatten)]
    pub loss: Loss,
    /// Number of places between two intact lines where lines were lost or damaged, or the link was interrupted.
    pub gaps: u64,
    /// Damaged lines.
    pub damaged: Damaged,
    /// Mistakes in the robot's lines.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mistakes: Vec<Finding>,
    /// Another robot on the channel.
    #[serde(flatten)]
    pub other: OtherRobot,
    /// Times without lines.
    pub outages: Vec<Outage>,
    /// Bytes between intact lines, if there are any.
    pub resync: Option<Resync>,
    /// Downlink airtime, per cent; `None` for raw text and a recording converted from text without timestamps, and for a capture not made
    /// in real time: from a pipe or a faster simulator.
    pub airtime_down_pct: Option<f64>,
    /// Totals sent; `None` for raw text.
    pub sent: Option<Sent>,
    /// Robot and firmware, as last reported.
    pub robot: Option<Robot>,
    /// Number of restarts of the robot: changes of the boot counter or backward jumps of the uptime.
    pub restarts: u64,
    /// Distance between the reported positions, inches, across gaps too.
    pub distance_in: f64,
    /// Behaviours that controlled the motors, in per cent of the ticks between the first and the last line C.
    pub holders: Vec<HolderShare>,
    /// First voltage reported.
    pub battery_first_v: Option<f64>,
    /// Last voltage reported.
    pub battery_last_v: Option<f64>,
    /// Bumper contacts: the robot's own count between the first and the last line C; elsewhere counted from lines A.
    pub bumps: u32,
    /// Lines of the robot's own, if there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own: Option<OwnSummary>,
    /// Reason why the capture could not be read completely.
    pub problem: Option<String>,
}

/// Number of line types, the first of [`LINE_TYPES`], that JSON always has; it leaves out others without lines.
const COMMON_TYPES: usize = 5;

/// Numbers of intact lines by type, in the order of `LINE_TYPES`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounts([u64; LINE_TYPES.len()]);

impl LineCounts {
    /// Counts a line.
    fn add(&mut self, received: &Received) {
        if let Some(place) = line_type(received) {
            self.0[place] += 1;
        }
    }

    /// Number of intact lines of the type with this letter.
    #[must_use]
    pub fn of(&self, letter: &str) -> u64 {
        let mut counts = LINE_TYPES.iter().zip(self.0);
        let found = counts.find(|(of, _)| **of == letter);
        found.map_or(0, |(_, count)| count)
    }

    /// Number of intact lines of every type.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }
}

impl Serialize for LineCounts {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let counts = LINE_TYPES.iter().zip(self.0).enumerate();
        let shown = counts.filter(|(place, (_, count))| *place < COMMON_TYPES || *count > 0);
        serializer.collect_map(shown.map(|(_, count)| count))
    }
}

/// Totals sent during the recording.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sent {
    /// Number of bytes handed to the device.
    pub bytes: u64,
    /// Frames: STOPs, session requests, commands and waypoints.
    pub frames: u64,
    /// Number of repeated frames; part of `frames`.
    pub frames_again: u64,
    /// Uplink airtime, per cent; `None` when `airtime_down_pct` is.
    pub airtime_up_pct: Option<f64>,
}

/// The robot that sent the lines.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Robot {
    /// Number of the robot, 1 to 99.
    pub id: u8,
    /// Firmware version: major and minor number.
    pub firmware_version: String,
}

/// Share of the time for which a behaviour controlled the motors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HolderShare {
    /// A layer or `prowl`.
    pub holder: &'static str,
    /// Share, per cent.
    pub share_pct: f64,
}

impl Info {
    /// Reads a capture to its end, or as far as it can be read.
    #[must_use]
    pub fn read(capture: &mut Capture) -> Self {
        let mut survey = Survey::default();
        let (diagnosis, result) = survey.take_all(capture);
        let problem = result.err().map(|error| error.to_string());
        survey.into_info(capture, &diagnosis, problem)
    }

    /// Whether the capture has an intact line of a robot.
    #[must_use]
    pub fn has_lines(&self) -> bool {
        let own = self.own.as_ref();
        let is_own = |own: &OwnSummary| own.is_of_robot(self.form, &self.damaged);
        self.lines.total() > 0 || own.is_some_and(is_own)
    }

    /// Adds the operator's label of the run.
    #[must_use]
    pub fn with_label(self, label: Label) -> Self {
        let marks = with_texts(self.marks, &label);
        let about_all = label.notes.into_iter().filter(|note| note.at_s.is_none());
        Self {
            name: label.name,
            void: label.void,
            marks,
            notes: about_all.map(|note| note.text).collect(),
            ..self
        }
    }
}
