//! What a capture holds, at a glance.

mod survey;
mod text;

use groundwave_protocol::decoder::Decoder;
use serde::Serialize;

use super::Capture;
use super::runs::label::Label;
use super::source::Form;
use crate::statistics::{Rejected, Resync};
use survey::Survey;

/// What a capture holds.
#[derive(Clone, Debug, Serialize)]
pub struct Info {
    /// How it is stored.
    pub form: Form,
    /// What of a raw capture is not as the radio delivered it, in words: times before the lines, other line ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stored: Option<String>,
    /// When it was made, in UTC, as an MCAP says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// The link it was made with, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub link: Option<String>,
    /// The program that made it and its version, likewise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub software: Option<String>,
    /// What the run is called.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Why the run does not count; of one that counts there is nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub void: Option<String>,
    /// From its beginning to its last byte, seconds. Of a raw capture whose lines say no time, the time that a radio at
    /// 2400 baud takes for as many bytes.
    pub duration_s: f64,
    /// Bytes received.
    pub bytes: u64,
    /// Bytes that belong to no intact line.
    pub noise_bytes: u64,
    /// Those of them that may be the beginning of a line under way when the capture ended.
    pub unfinished_bytes: u64,
    /// Bytes that were received and could not be recorded.
    pub missing_bytes: u64,
    /// Intact lines.
    pub lines: LineCounts,
    /// Lines that the sequence says were sent and that did not arrive intact.
    pub lines_lost: u64,
    /// `lines_lost` in per cent of the lines sent.
    pub loss_pct: f64,
    /// What was taken for a line and rejected.
    pub rejected: Rejected,
    /// Bytes from an intact line to the next, where there were any between them.
    pub resync: Option<Resync>,
    /// Share of the way down in use, per cent; unknown of a raw capture, which knows no time, and where the
    /// clock of the capture is not that of the radio: read from a pipe, or from a simulator that runs faster.
    pub airtime_down_pct: Option<f64>,
    /// What was sent; unknown of a raw capture.
    pub sent: Option<Sent>,
    /// Robot and firmware, as it last said.
    pub robot: Option<Robot>,
    /// Times the robot is seen to have booted in the middle: another boot counter, or an uptime that runs backwards.
    pub restarts: u64,
    /// Way between the reported positions, inches.
    pub distance_in: f64,
    /// Who held the motors, in per cent of the ticks between the first line C and the last.
    pub holders: Vec<HolderShare>,
    /// First voltage reported.
    pub battery_first_v: Option<f64>,
    /// Last voltage reported.
    pub battery_last_v: Option<f64>,
    /// Bumper contacts: by the robot's own count between the first line C and the last, else as seen in lines A.
    pub bumps: u32,
    /// Why the capture could not be read to its end.
    pub problem: Option<String>,
}

/// Intact lines by type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "UPPERCASE")]
pub struct LineCounts {
    /// State.
    pub a: u64,
    /// Status.
    pub b: u64,
    /// Counters.
    pub c: u64,
    /// Text.
    pub t: u64,
    /// Acknowledgement.
    pub k: u64,
    /// Parameter.
    #[serde(skip_serializing_if = "is_none")]
    pub p: u64,
    /// Song.
    #[serde(skip_serializing_if = "is_none")]
    pub s: u64,
}

impl LineCounts {
    /// Intact lines of every type.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.a + self.b + self.c + self.t + self.k + self.p + self.s
    }
}

/// Lines that most captures have none of are told of only where there are some.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
const fn is_none(count: &u64) -> bool {
    *count == 0
}

/// What was sent while it was recorded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Sent {
    /// Bytes handed to the device.
    pub bytes: u64,
    /// STOPs, requests for a session, commands and waypoints.
    pub frames: u64,
    /// Those of them that had gone before.
    pub frames_again: u64,
    /// Share of the way up in use, per cent; unknown where that of the way down is.
    pub airtime_up_pct: Option<f64>,
}

/// Who sent it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Robot {
    /// 1 to 99.
    pub id: u8,
    /// Major and minor.
    pub firmware_version: String,
}

/// The part of the time that a behaviour held the motors.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HolderShare {
    /// A layer or `prowl`.
    pub holder: &'static str,
    /// Per cent.
    pub share_pct: f64,
}

impl Info {
    /// Reads a whole capture. A capture that is damaged or ends early is told about up to there.
    #[must_use]
    pub fn read(capture: &mut Capture) -> Self {
        let mut decoder = Decoder::default();
        let mut survey = Survey::default();
        let result = survey.take_all(capture, &mut decoder);
        survey.into_info(
            capture,
            decoder.counters(),
            result.err().map(|e| e.to_string()),
        )
    }

    /// With what an operator says of the run.
    #[must_use]
    pub fn with_label(self, label: Label) -> Self {
        let Label { name, void, .. } = label;
        Self { name, void, ..self }
    }
}
