//! Whether a capture is what it should be.
//!
//! Of an MCAP every checksum, the numbers of the messages, the offsets of the bytes, the statistics, and that each
//! message of a topic that follows from the bytes is what they give today (`derived`); and that the raw file and the
//! journal beside it hold the same bytes (`side_car`). A raw capture has no checksums but those of its lines. What the
//! radio lost on the way is told and no fault of the capture.

mod derived;
mod recording;
mod side_car;

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder};
use serde::Serialize;

use super::source::Form;
use super::text::TextReader;
use super::topics::RAW_RX;
pub use recording::{Beside, verify_mcap};

/// Faults that are told one by one.
const FAULTS_TOLD: usize = 10;

/// What was found.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// How it is stored.
    pub form: Form,
    /// Bytes received that it holds.
    pub bytes: u64,
    /// Bytes received that it does not hold.
    pub missing_bytes: u64,
    /// Intact lines.
    pub lines: u64,
    /// Lines that the radio lost, by their sequence.
    pub lines_lost: u64,
    /// Times in a row that lines were lost.
    pub gaps: u64,
    /// The longest of these.
    pub worst_gap: Option<Gap>,
    /// Messages by topic.
    pub messages: BTreeMap<String, u64>,
    /// Messages that are what follows from the bytes and the station's events.
    pub derived_equal: u64,
    /// Messages of which it is not known what they follow from: bytes are missing, or came before the beginning.
    pub derived_unchecked: u64,
    /// Whether the bytes are those of the raw file and the journal beside it; unknown where there is neither.
    pub is_as_side_car: Option<bool>,
    /// What is wrong, the first of it.
    pub faults: Vec<String>,
    /// How much is wrong.
    pub fault_count: u64,
}

/// Lines lost in a row.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// How many.
    pub lines: u64,
    /// When the next one came, seconds since the beginning.
    pub until_s: f64,
}

impl Verdict {
    fn new(form: Form) -> Self {
        Self {
            form,
            bytes: 0,
            missing_bytes: 0,
            lines: 0,
            lines_lost: 0,
            gaps: 0,
            worst_gap: None,
            messages: BTreeMap::new(),
            derived_equal: 0,
            derived_unchecked: 0,
            is_as_side_car: None,
            faults: Vec::new(),
            fault_count: 0,
        }
    }

    /// Whether nothing is wrong.
    #[must_use]
    pub const fn is_good(&self) -> bool {
        self.fault_count == 0
    }

    fn fault(&mut self, what: impl Into<String>) {
        self.fault_count += 1;
        if self.faults.len() < FAULTS_TOLD {
            self.faults.push(what.into());
        }
    }

    /// Writes it for a person.
    ///
    /// # Errors
    /// When the output takes no more.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        write!(output, "bytes      {}", self.bytes)?;
        match self.missing_bytes {
            0 => writeln!(output)?,
            missing => writeln!(output, ", and {missing} missing")?,
        }
        write!(
            output,
            "lines      {} intact, {} lost by the radio",
            self.lines, self.lines_lost
        )?;
        match self.worst_gap {
            None => writeln!(output)?,
            Some(gap) => writeln!(
                output,
                " in {} gaps; the longest, {} lines, until {:.1} s",
                self.gaps, gap.lines, gap.until_s
            )?,
        }
        if self.form == Form::Mcap {
            let messages: u64 = self.messages.values().sum();
            let topics = self.messages.len();
            writeln!(output, "messages   {messages} of {topics} topics")?;
            write!(
                output,
                "derived    {} messages are what follows from {RAW_RX}",
                self.derived_equal
            )?;
            match self.derived_unchecked {
                0 => writeln!(output)?,
                unchecked => writeln!(output, "; {unchecked} follow from what is not here")?,
            }
        }
        if self.is_as_side_car == Some(true) {
            writeln!(output, "side-car   holds the same bytes")?;
        }
        for fault in &self.faults {
            writeln!(output, "wrong      {fault}")?;
        }
        let untold = self.fault_count - self.faults.len() as u64;
        if untold > 0 {
            writeln!(output, "wrong      and {untold} more")?;
        }
        Ok(())
    }
}

/// Looks through a raw capture.
///
/// # Errors
/// When it cannot be read.
pub fn verify_raw(source: impl Read) -> io::Result<Verdict> {
    let mut verdict = Verdict::new(Form::Raw);
    let mut reader = TextReader::new(source);
    let mut lines = Lines::default();
    while let Some(piece) = reader.next_piece()? {
        lines.take(piece.radio, piece.at, &mut verdict);
    }
    lines.finish(&mut verdict);
    if verdict.lines == 0 {
        verdict.fault("not one line of a robot");
    }
    Ok(verdict)
}

/// Counts the lines in a stream and the gaps between them.
#[derive(Default)]
struct Lines {
    decoder: Decoder,
}

impl Lines {
    fn take(&mut self, mut bytes: &[u8], at: Duration, verdict: &mut Verdict) {
        let mut before = self.decoder.counters().lines_lost;
        while self.decoder.next_line(&mut bytes).is_some() {
            let counted = self.decoder.counters().lines_lost;
            // The count falls after a late line or a reboot.
            let lost = counted.saturating_sub(before);
            before = counted;
            if lost > 0 {
                verdict.gaps += 1;
                if verdict.worst_gap.is_none_or(|worst| worst.lines < lost) {
                    let until_s = at.as_secs_f64();
                    verdict.worst_gap = Some(Gap {
                        lines: lost,
                        until_s,
                    });
                }
            }
        }
    }

    fn finish(&self, verdict: &mut Verdict) {
        let Counters {
            bytes,
            lines,
            ack_lines,
            lines_lost,
            ..
        } = *self.decoder.counters();
        verdict.bytes = bytes;
        verdict.lines = lines + ack_lines;
        verdict.lines_lost = lines_lost;
    }
}
