//! The description of a session in its recording.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::time::{SystemTime, UNIX_EPOCH};

use ::mcap::Attachment;
use ::mcap::records::Metadata;
use serde::{Deserialize, Serialize};

use super::event::{Level, NoticeCode};
use super::messages::StationEvent;
use super::name;

/// The name of the attached configuration.
const CONFIGURATION: &str = "groundwave.toml";

/// Name of the metadata table with the robot's number and firmware.
pub(super) const ROBOT: &str = "robot";

/// Name of the metadata table that a recovery with losses adds.
pub(super) const RECOVERY: &str = "recovery";

/// Metadata known when a recording begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Session {
    /// The link as the operator named it.
    pub link: String,
    /// Time at which recording began.
    pub start: SystemTime,
    /// Further metadata: world, seed, command line.
    pub notes: BTreeMap<String, String>,
    /// The active configuration as text; empty if there is none.
    #[serde(default)]
    pub configuration: String,
}

impl Session {
    /// The name of the metadata table that describes the session.
    pub(super) const TABLE: &str = "session";

    /// Key of the note with the port's baud rate.
    pub const BAUD: &str = "baud";

    /// Key of the note that the times are estimated from the number of bytes, as for raw text without timestamps.
    pub const ESTIMATED_TIMES: &str = "estimated_times";

    /// Key of the note with the form of the robot's own lines, as JSON.
    pub const LINES: &str = "lines";

    /// Key of the note with the simulator's true state, as JSON.
    pub const TRUTH: &str = "truth";

    /// Whether the times were measured, from the session's table.
    pub(crate) fn has_times(table: &BTreeMap<String, String>) -> bool {
        !table.contains_key(Self::ESTIMATED_TIMES)
    }

    /// The metadata table that describes the session.
    pub(super) fn table(&self) -> Metadata {
        let mut metadata = self.notes.clone();
        metadata.insert("link".into(), self.link.clone());
        metadata.insert("start".into(), name::utc(self.start));
        metadata.insert("software".into(), "groundwave".into());
        metadata.insert("software_version".into(), env!("CARGO_PKG_VERSION").into());
        Metadata {
            name: Self::TABLE.into(),
            metadata,
        }
    }

    /// The configuration as an attachment.
    pub(super) fn configuration(&self) -> Option<Attachment<'_>> {
        let time_ns = since_1970_ns(self.start);
        (!self.configuration.is_empty()).then(|| Attachment {
            log_time: time_ns,
            create_time: time_ns,
            name: CONFIGURATION.into(),
            media_type: "application/toml".into(),
            data: Cow::Borrowed(self.configuration.as_bytes()),
        })
    }

    /// The first message of the recording.
    pub(super) fn beginning(&self) -> StationEvent {
        let text = format!("recording of {} begins", self.link);
        StationEvent::notice(NoticeCode::RecordingBegun, Level::Info, text)
    }
}

/// The last message of a recording: a silence lasts until it.
#[must_use]
pub fn ending() -> StationEvent {
    StationEvent::notice(NoticeCode::RecordingEnded, Level::Info, "recording ends")
}

/// Time since 1970, nanoseconds; an earlier time counts as 1970.
#[must_use]
pub fn since_1970_ns(wall: SystemTime) -> u64 {
    let since_1970 = wall.duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since_1970.as_nanos()).unwrap_or(u64::MAX)
}
