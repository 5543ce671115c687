//! What was saved and what was not, also for a person.

use std::io::{self, Write};
use std::path::PathBuf;

use serde::Serialize;

use super::Damage;
use crate::event::Level;
use crate::journal::Waste;

/// What was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// The recording is whole; nothing was done.
    Whole,
    /// Everything that was received and reached the disk is in the recording.
    Recovered,
    /// Something is missing; the rest was saved.
    Partly,
}

/// What was saved and what was not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Recovery {
    /// The recording.
    pub path: PathBuf,
    /// What was done.
    pub outcome: Outcome,
    /// Messages in the recording now.
    pub messages: u64,
    /// Bytes of the radio in the recording now.
    pub rx_bytes: u64,
    /// Bytes to the radio.
    pub tx_bytes: u64,
    /// Bytes of the radio that were received and are lost: where in the stream, and how many.
    pub rx_missing: Vec<Missing>,
    /// Chunks taken over as they were.
    pub chunks_kept: u64,
    /// Places of the old file that are of no use, in its order.
    pub damage: Vec<Damage>,
    /// Bytes of the radio that came from the journal.
    pub rx_from_journal: u64,
    /// Bytes of the journal that are of no use.
    pub journal_damaged_bytes: u64,
    /// Whether it is known what came last.
    pub end: End,
    /// Where the old file is, when something of it was of no use.
    pub original: Option<PathBuf>,
    /// Where its journal is, when something of that was damaged.
    pub journal_kept: Option<PathBuf>,
}

/// What proves that nothing that reached the disk came after the last byte of a recording. A power cut takes what had not:
/// then the journal usually ends with the last entry that the disk was made to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// The journal ends with a whole entry, or the file is finished.
    Known,
    /// There is no journal.
    NoJournal,
    /// The journal ends in the middle of an entry.
    JournalCut,
    /// The last bytes of the journal are damaged.
    JournalDamaged,
    /// The journal ends before the recording does.
    JournalShort,
    /// A finished file ends before its end.
    FileCut,
}

impl End {
    pub(super) const fn of_journal(waste: Waste) -> Self {
        match waste {
            Waste { tail_bytes: 0, .. } => Self::Known,
            Waste { is_cut: true, .. } => Self::JournalCut,
            Waste { .. } => Self::JournalDamaged,
        }
    }
}

/// A step in the stream of received bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Missing {
    /// Bytes of the stream before it.
    pub offset: u64,
    /// Bytes missing.
    pub bytes: u64,
}

impl Recovery {
    /// One line.
    #[must_use]
    pub fn headline(&self) -> String {
        let path = self.path.display();
        let (messages, bytes) = (self.messages, self.rx_bytes);
        let missing: u64 = self.rx_missing.iter().map(|missing| missing.bytes).sum();
        match self.outcome {
            Outcome::Whole => {
                format!("{path} is whole: {messages} messages, {bytes} bytes received")
            }
            Outcome::Recovered => match self.unknown_end() {
                None => {
                    format!(
                        "recovered {path}: {messages} messages, all {bytes} bytes that reached the disk"
                    )
                }
                Some(unknown) => format!(
                    "recovered {path}: {messages} messages, {bytes} bytes received; {unknown}"
                ),
            },
            Outcome::Partly if missing > 0 => format!(
                "saved part of {path}: {messages} messages, {bytes} bytes received; {missing} bytes are lost"
            ),
            Outcome::Partly => format!(
                "saved what holds of {path}: {messages} messages, {bytes} bytes received; what was in the damaged places is lost"
            ),
        }
    }

    /// What is not known about the end, if it is not.
    fn unknown_end(&self) -> Option<String> {
        let why = match self.end {
            End::Known => return None,
            End::NoJournal => "the journal is missing",
            End::JournalCut => "the journal ends in the middle of an entry",
            End::JournalDamaged => "the end of the journal is damaged",
            End::JournalShort => "the journal ends before the recording does",
            End::FileCut => "the file was cut",
        };
        let missing: u64 = self.rx_missing.iter().map(|missing| missing.bytes).sum();
        let end = self.rx_bytes + missing;
        Some(format!(
            "{why}: what came after byte {end}, if anything, is not known"
        ))
    }

    /// How much it matters to an operator.
    #[must_use]
    pub const fn level(&self) -> Level {
        match self.outcome {
            Outcome::Whole | Outcome::Recovered => Level::Info,
            Outcome::Partly => Level::Warning,
        }
    }

    /// Everything, a line a fact.
    ///
    /// # Errors
    /// When the output takes no more.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        writeln!(output, "{}", self.headline())?;
        if self.outcome == Outcome::Partly
            && let Some(unknown) = self.unknown_end()
        {
            writeln!(output, "  {unknown}")?;
        }
        if self.rx_from_journal > 0 {
            writeln!(
                output,
                "  {} bytes received came from the journal",
                self.rx_from_journal
            )?;
        }
        for missing in &self.rx_missing {
            writeln!(
                output,
                "  lost: {} bytes received, after the first {} of them",
                missing.bytes, missing.offset
            )?;
        }
        for damage in &self.damage {
            if damage.bytes == 0 {
                writeln!(output, "  {}", damage.problem)?;
                continue;
            }
            writeln!(
                output,
                "  of no use: {} bytes from byte {} of the file: {}",
                damage.bytes, damage.offset, damage.problem
            )?;
        }
        if self.journal_damaged_bytes > 0 {
            writeln!(
                output,
                "  of no use: {} bytes of the journal",
                self.journal_damaged_bytes
            )?;
        }
        if let Some(journal) = &self.journal_kept {
            writeln!(
                output,
                "  the damaged journal is kept as {}",
                journal.display()
            )?;
        }
        if let Some(original) = &self.original {
            writeln!(
                output,
                "  the damaged file is kept as {}",
                original.display()
            )?;
        }
        Ok(())
    }
}
