//! The report of a recovery.

use std::io::{self, Write};
use std::path::PathBuf;

use serde::Serialize;

use super::event::Level;
use super::repair::Damage;
use crate::words::{counted, plural};

/// Maximum parts of each kind that a report lists: the first ones.
pub(super) const LISTED_MAX: usize = 1000;

/// The result of a recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The recording is complete; nothing was changed.
    Whole,
    /// Everything that was received and reached the disk is in the recording.
    Recovered,
    /// A part is lost; the rest was saved.
    Partly,
}

/// Report of saved and lost parts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// The recording.
    pub path: PathBuf,
    /// The result.
    pub outcome: Outcome,
    /// Number of messages in the recording.
    pub messages: u64,
    /// Number of bytes from the radio in the recording.
    pub rx_bytes: u64,
    /// Number of bytes to the radio in the recording.
    pub tx_bytes: u64,
    /// Number of lost bytes from the radio.
    pub rx_bytes_missing: u64,
    /// Lost bytes from the radio, in order: the first 1000 parts.
    pub rx_missing: Vec<Missing>,
    /// Damaged parts of the old file, in order: the first 1000.
    pub damage: Vec<Damage>,
    /// Number of parts that are not listed.
    pub unlisted: u64,
    /// Whether the old file ended in the middle of a record, or was a finished file without its end.
    pub is_cut: bool,
    /// Number of messages whose topic is unknown.
    pub nameless: u64,
    /// Path of the old file, kept if it was damaged.
    pub original: Option<PathBuf>,
}

/// A gap in the stream of received bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Number of bytes in the stream before the gap.
    pub offset: u64,
    /// Number of missing bytes.
    pub bytes: u64,
}

impl Recovery {
    /// The report in one line.
    #[must_use]
    pub fn headline(&self) -> String {
        let path = self.path.display();
        let messages = counted(self.messages, "message");
        let (bytes, received) = (self.rx_bytes, counted(self.rx_bytes, "byte"));
        match self.outcome {
            Outcome::Whole => {
                format!("{path} is whole: {messages}, {received} received")
            }
            Outcome::Recovered if self.is_cut => format!(
                "recovered {path}: {messages}, {received} received; the file ended in the middle of a message: bytes \
                 received after byte {bytes}, if any, are lost"
            ),
            Outcome::Recovered => {
                format!("recovered {path}: {messages}, all {received} that reached the disk")
            }
            Outcome::Partly => {
                let lost = match (self.rx_bytes_missing, self.is_cut) {
                    (0, true) => {
                        format!("the file was cut: bytes received after byte {bytes} are lost")
                    }
                    (0, false) => "the damaged parts are lost".to_owned(),
                    (1, _) => "1 byte is lost".to_owned(),
                    (missing, _) => format!("{missing} bytes are lost"),
                };
                format!("saved part of {path}: {messages}, {received} received; {lost}")
            }
        }
    }

    /// Severity for an operator.
    #[must_use]
    pub const fn level(&self) -> Level {
        match self.outcome {
            Outcome::Whole | Outcome::Recovered => Level::Info,
            Outcome::Partly => Level::Warning,
        }
    }

    /// Writes the report as text, one fact per line.
    ///
    /// # Errors
    /// The output's error.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(output, "{}", self.headline())?;
        for Missing { offset, bytes } in &self.rx_missing {
            let bytes = counted(*bytes, "byte");
            writeln!(output, "  lost: {bytes} received after byte {offset}")?;
        }
        for damage in &self.damage {
            writeln!(output, "  skipped: {damage}")?;
        }
        if self.unlisted > 0 {
            let (count, s) = (self.unlisted, plural(self.unlisted));
            writeln!(output, "  lost or skipped: {count} more part{s}")?;
        }
        if self.nameless > 0 {
            let messages = counted(self.nameless, "message");
            writeln!(output, "  skipped: {messages} of unknown topics")?;
        }
        if let Some(original) = &self.original {
            let original = original.display();
            writeln!(output, "  the damaged file is kept as {original}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_a_kind_is_in_the_singular() {
        let recovery = Recovery {
            path: PathBuf::from("a.mcap"),
            outcome: Outcome::Partly,
            messages: 1,
            rx_bytes: 1,
            tx_bytes: 0,
            rx_bytes_missing: 1,
            rx_missing: vec![Missing {
                offset: 0,
                bytes: 1,
            }],
            damage: Vec::new(),
            unlisted: 1,
            is_cut: false,
            nameless: 1,
            original: None,
        };
        let mut text = Vec::new();
        recovery.write_text(&mut text).unwrap();
        assert_eq!(
            String::from_utf8(text).unwrap(),
            "saved part of a.mcap: 1 message, 1 byte received; 1 byte is lost\n  \
             lost: 1 byte received after byte 0\n  lost or skipped: 1 more part\n  \
             skipped: 1 message of unknown topics\n"
        );
    }
}
