//! Verification of captures.
//!
//! For a recording, verification checks every checksum, the numbers of the messages, the offsets of the bytes and the statistics;
//! that each derived message equals the one derived again from the bytes (`derived`); and that a raw text beside the recording holds the
//! same bytes (`raw_file`). For raw text, only the lines' checksums are checked. Lines lost by the radio are counted, but are
//! not a fault.

mod derived;
mod raw_file;
mod recording;

use std::collections::BTreeMap;
use std::convert::Infallible;
use std::io::{self, Read, Write};
use std::time::Duration;

use groundwave_protocol::decoder::Counters;
use serde::Serialize;

use super::session::Session;
use super::source::Form;
use super::text::TextReader;
use super::topics::RAW_RX;
use crate::diagnosis::{Diagnosis, Finding, Line};
use crate::gaps::Gaps;
use crate::messages::StationEvent;
use crate::outages::{Outage, OutageList};
use crate::own_lines::{OwnSummary, recognizer};
use crate::statistics::{Damaged, Loss, OtherRobot};
use crate::words::counted;
pub use raw_file::RawCopy;
pub use recording::verify_mcap;

/// Maximum number of faults listed.
const FAULTS_LISTED: usize = 10;

/// Result of a verification.
#[derive(Clone, Debug, Serialize)]
pub struct Verdict {
    /// Form of the capture.
    pub form: Form,
    /// Number of received bytes in the capture.
    pub bytes: u64,
    /// Number of received bytes missing from the capture.
    pub missing_bytes: u64,
    /// Number of intact lines.
    pub lines: u64,
    /// Lines lost by the radio.
    #[serde(flatten)]
    pub loss: Loss,
    /// Damaged lines.
    pub damaged: Damaged,
    /// Another robot on the channel.
    #[serde(flatten)]
    pub other: OtherRobot,
    /// Lines of the robot's own; `None` if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub own: Option<OwnSummary>,
    /// Mistakes in the robot's lines. Mistakes in rejected lines count as faults.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mistakes: Vec<Finding>,
    /// Number of places between two intact lines where lines were lost or damaged, or the link was interrupted.
    pub gaps: u64,
    /// The longest gap.
    pub worst_gap: Option<Gap>,
    /// Times without lines.
    pub outages: Vec<Outage>,
    /// Messages by topic.
    pub messages: BTreeMap<String, u64>,
    /// Number of derived messages equal to those derived again.
    pub derived_equal: u64,
    /// Number of derived messages that cannot be checked, because their bytes are missing or precede the capture.
    pub derived_unchecked: u64,
    /// Result of the comparison with a raw text; `None` if there is none.
    pub raw_file: Option<Comparison>,
    /// The first faults.
    pub faults: Vec<String>,
    /// Number of faults.
    pub fault_count: u64,
}

/// Result of the comparison of a recording with a raw text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Comparison {
    /// All bytes are equal.
    Same,
    /// Bytes differ, which is a fault.
    Different,
    /// A text that the operator did not name begins with other bytes, so it counts as another capture.
    OtherCapture,
}

/// Consecutive lines lost.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// Number of lines.
    pub lines: u64,
    /// Time of the next line, seconds since the beginning.
    pub until_s: f64,
}

impl Verdict {
    fn new(form: Form) -> Self {
        Self {
            form,
            bytes: 0,
            missing_bytes: 0,
            lines: 0,
            loss: Loss::default(),
            damaged: Damaged::default(),
            other: OtherRobot::default(),
            own: None,
            mistakes: Vec::new(),
            gaps: 0,
            worst_gap: None,
            outages: Vec::new(),
            messages: BTreeMap::new(),
            derived_equal: 0,
            derived_unchecked: 0,
            raw_file: None,
            faults: Vec::new(),
            fault_count: 0,
        }
    }

    /// Whether the capture has an intact line of a robot.
    #[must_use]
    pub fn has_lines(&self) -> bool {
        let own = self.own.as_ref();
        self.lines > 0 || own.is_some_and(|own| own.is_of_robot(self.form, &self.damaged))
    }

    /// Whether there are no faults.
    #[must_use]
    pub const fn is_good(&self) -> bool {
        self.fault_count == 0
    }

    fn fault(&mut self, what: impl Into<String>) {
        self.fault_count += 1;
        if self.faults.len() < FAULTS_LISTED {
            self.faults.push(what.into());
        }
    }

    /// Writes Groundwave's lines.
    fn write_lines(&self, output: &mut impl Write) -> io::Result<()> {
        write!(
            output,
            "lines      {} intact, {} damaged, {} lost by the radio",
            self.lines,
            self.damaged.lines(),
            self.loss.lines()
        )?;
        if self.gaps > 0 {
            write!(output, " in {}", counted(self.gaps, "gap"))?;
        }
        match self.worst_gap {
            None => writeln!(output)?,
            Some(gap) => writeln!(
                output,
                "; the longest, {}, until {:.1} s",
                counted(gap.lines, "line"),
                gap.until_s
            )?,
        }
        if self.damaged.lines() > 0 {
            self.damaged.write_row(output)?;
        }
        self.other.write_rows(output)
    }

    /// Writes the result as text.
    ///
    /// # Errors
    /// If writing the output fails.
    pub fn write_text(&self, output: &mut impl Write) -> io::Result<()> {
        write!(output, "bytes      {}", self.bytes)?;
        match self.missing_bytes {
            0 => writeln!(output)?,
            missing => writeln!(output, ", and {missing} missing")?,
        }
        if self.lines + self.damaged.lines() > 0 || self.own.is_none() {
            self.write_lines(output)?;
        }
        if let Some(own) = &self.own {
            own.write_row(output)?;
        }
        if let Some(longest) = self.outages.iter().max_by_key(|it| it.duration()) {
            writeln!(
                output,
                "outages    {}, the longest: {longest}",
                self.outages.len()
            )?;
        }
        if self.form == Form::Mcap {
            let messages: u64 = self.messages.values().sum();
            let topics = self.messages.len();
            let topics = counted(topics as u64, "topic");
            writeln!(output, "messages   {messages} of {topics}")?;
            write!(
                output,
                "derived    {} from {RAW_RX}",
                counted(self.derived_equal, "message")
            )?;
            match self.derived_unchecked {
                0 => writeln!(output)?,
                unchecked => writeln!(output, "; {unchecked} cannot be checked")?,
            }
        }
        match self.raw_file {
            Some(Comparison::Same) => writeln!(output, "raw file   holds the same bytes")?,
            Some(Comparison::OtherCapture) => writeln!(
                output,
                "raw file   begins otherwise: another capture, not compared (--raw FILE compares it)"
            )?,
            Some(Comparison::Different) | None => {}
        }
        for fault in &self.faults {
            writeln!(output, "wrong      {fault}")?;
        }
        let unlisted = self.fault_count - self.faults.len() as u64;
        if unlisted > 0 {
            writeln!(output, "wrong      and {unlisted} more")?;
        }
        Ok(())
    }
}

/// Verifies a raw text.
///
/// # Errors
/// If it cannot be read.
pub fn verify_raw(source: impl Read) -> io::Result<Verdict> {
    let mut verdict = Verdict::new(Form::Raw);
    let mut reader = TextReader::new(source);
    let mut lines = Lines {
        has_estimated_times: !reader.style()?.is_stamped(),
        ..Lines::default()
    };
    while let Some(piece) = reader.next_piece()? {
        lines.take(piece.radio, piece.at, &mut verdict);
    }
    lines.finish(&mut verdict);
    if !verdict.has_lines() {
        verdict.fault("not one line of a robot");
    }
    Ok(verdict)
}

/// Counts lines, gaps and outages in a stream.
#[derive(Default)]
struct Lines {
    gaps: Gaps,
    outages: OutageList,
    diagnosis: Diagnosis,
    own: OwnSummary,
    /// Whether the times of bytes were not measured.
    has_estimated_times: bool,
    end: Duration,
}

impl Lines {
    /// Takes the session's table, which says how the robot's own lines are read.
    fn take_session(&mut self, table: &BTreeMap<String, String>) {
        self.has_estimated_times = !Session::has_times(table);
        if self.diagnosis.counters().bytes == 0 {
            self.diagnosis = Diagnosis::new(recognizer(Some(table)));
        }
    }

    /// Takes a place where bytes are missing.
    fn skip(&mut self) {
        self.diagnosis.skip();
        self.gaps.interrupt();
        self.outages.handle_missing();
    }

    /// Takes an event of the station.
    fn take_event(&mut self, event: &StationEvent, at: Duration) {
        if event.is_loss_of_link() {
            self.diagnosis.interrupt();
            self.gaps.interrupt();
        }
        self.outages.handle_event(at, event);
    }

    fn take(&mut self, bytes: &[u8], at: Duration, verdict: &mut Verdict) {
        let shown = |counters: &Counters| counters.lost().min - counters.hidden.min;
        let mut before = shown(self.diagnosis.counters());
        if !self.has_estimated_times {
            self.diagnosis.set_time(at);
        }
        self.end = self.end.max(at);
        let Ok(()) = self.diagnosis.each_line(bytes, |line, counters| {
            let received = match line {
                Line::Own(line) => {
                    self.own.take(line);
                    return Ok(());
                }
                Line::Wire(received) => received,
            };
            self.outages.handle_line(at, received, counters);
            self.gaps.take_line(at, received, counters);
            let counted = shown(counters);
            // The number of lost lines may decrease after a late line or a reboot.
            let lost = counted.saturating_sub(before);
            before = counted;
            if lost > 0 && verdict.worst_gap.is_none_or(|worst| worst.lines < lost) {
                let until_s = at.as_secs_f64();
                verdict.worst_gap = Some(Gap {
                    lines: lost,
                    until_s,
                });
            }
            Ok::<(), Infallible>(())
        });
    }

    fn finish(mut self, verdict: &mut Verdict) {
        for (received, counters) in self.diagnosis.undecided_lines() {
            self.outages.handle_line(self.end, &received, counters);
            self.gaps.take_line(self.end, &received, counters);
        }
        verdict.gaps = self.gaps.count();
        let counters = self.diagnosis.counters_until(self.end);
        verdict.outages = self.outages.into_outages(self.end, &counters);
        // Outages count whole hundreds of lines, which the sequence does not show.
        for outage in &verdict.outages {
            let lines = outage.lost.min;
            if let Some(end) = outage.end
                && verdict.worst_gap.map_or(0, |worst| worst.lines) < lines
            {
                let until_s = end.as_secs_f64();
                verdict.worst_gap = Some(Gap { lines, until_s });
            }
        }
        verdict.bytes = counters.bytes;
        verdict.lines = counters.intact();
        verdict.loss = Loss::of(&counters);
        verdict.damaged = Damaged::of(&counters);
        verdict.other = OtherRobot::of(&counters);
        verdict.own = Some(self.own).filter(|own| !own.is_empty());
        let is_own = |own: &OwnSummary| own.outweighs(&verdict.damaged);
        if verdict.lines == 0 && verdict.own.as_ref().is_some_and(is_own) {
            // The first line of another kind of robot may not have been recognized as the robot's own.
            verdict.damaged = Damaged::default();
            return;
        }
        verdict.mistakes = self.diagnosis.findings();
        for finding in verdict.mistakes.clone() {
            if finding.is_refused {
                verdict.fault(format!("the robot's {}", finding.clause()));
            }
        }
    }
}
