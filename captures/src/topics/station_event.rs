//! What the station knows that no byte says.

use foxglove::messages::Log;
use foxglove::messages::log::Level as LogLevel;

use crate::messages::{UplinkEvent, UplinkStep};

/// Who says in the log that a moment was marked.
pub const MARK: &str = "mark";

/// An event of the station that belongs into a capture: the steps of commands, who asked for them,
/// the link's ups and downs, notices, and moments that the operator marked.
///
/// Lines, totals and statistics are no part of it, since they follow from the bytes; neither are keys.
#[derive(Clone, Debug, PartialEq)]
pub enum StationEvent {
    /// A command went a step further. Goes to `/uplink`; its end to `/log` too.
    Uplink(UplinkEvent),
    /// Something worth a line in `/log`. The time in it is set by the [`super::Deriver`].
    Log(Log),
}

impl StationEvent {
    /// Something that the station does, for the log.
    #[must_use]
    pub fn note(text: impl Into<String>) -> Self {
        Self::log(LogLevel::Info, "station", text)
    }

    /// Whether it shall be on the disk at once: a command begins or ends, or something is wrong.
    #[must_use]
    pub fn is_urgent(&self) -> bool {
        match self {
            Self::Uplink(event) => !matches!(
                event.step(),
                UplinkStep::Sent | UplinkStep::Progress | UplinkStep::Asked
            ),
            Self::Log(log) => log.level >= LogLevel::Warning as i32,
        }
    }

    /// Whether the link was lost.
    pub(crate) fn is_loss_of_link(&self) -> bool {
        matches!(self, Self::Log(log) if is_loss_of_link(log))
    }

    /// A line of the log, with the name of who says it.
    #[must_use]
    pub fn log(level: LogLevel, name: &str, message: impl Into<String>) -> Self {
        Self::Log(Log {
            level: level as i32,
            name: name.to_owned(),
            message: message.into(),
            ..Log::default()
        })
    }
}

/// Who says in the log that the link came or went.
pub const LINK: &str = "link";
/// How the log begins to tell of a lost link.
pub const LINK_LOST: &str = "link lost: ";

/// Whether the link went.
pub(crate) fn is_loss_of_link(log: &Log) -> bool {
    log.name == LINK && log.message.starts_with(LINK_LOST)
}
