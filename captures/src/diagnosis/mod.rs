//! Reads a robot's lines, finds mistakes in them, and distinguishes these from damage by the radio.
//!
//! A valid checksum with an unreadable field is always the robot's mistake: the radio produces one in 10^9 damaged
//! lines. A wrong checksum or shape is the robot's mistake if it recurs and a usual mistake explains it.

mod checksum;
mod conduct;
mod examiner;
mod forms;
pub mod kind;
#[cfg(test)]
mod tests;

use std::convert::Infallible;
use std::time::Duration;

use groundwave_lines::{Content, OwnLine, Recognizer, runs};
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use kind::Kind;
use serde::{Serialize, Serializer};

use crate::chunk::{counters_until, set_time};
use crate::own_lines::{DescribedFields, are_robots};
use crate::source::Form;
use crate::statistics::Damaged;

pub use examiner::Examiner;

/// A mistake of the robot, with its first occurrence.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// Code, likely cause and remedy.
    #[serde(flatten)]
    pub kind: &'static Kind,
    /// Number of the first such line, from 1, counted by line feeds.
    pub row: u64,
    /// The first such line, without its line feed.
    #[serde(serialize_with = "serialize_line")]
    pub line: Vec<u8>,
    /// First wrong column, from 1.
    pub column: Option<usize>,
    /// Line and column as text, the content, and the expected form.
    pub place: String,
    /// Number of occurrences.
    pub count: u64,
    /// Whether the station rejects lines with this mistake.
    pub is_refused: bool,
    /// Whether the radio cannot have caused the mistake.
    #[serde(skip)]
    is_sure: bool,
}

impl Finding {
    /// The mistake in one clause.
    #[must_use]
    pub fn clause(&self) -> String {
        format!("{}: {}", self.place, self.kind.cause)
    }
}

fn serialize_line<S: Serializer>(line: &[u8], to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(String::from_utf8_lossy(line).trim_end_matches('\r'))
}

/// Mistakes in one clause: the first one and the number of others; `None` if there are none.
#[must_use]
pub fn clause(findings: &[Finding]) -> Option<String> {
    let (first, others) = findings.split_first()?;
    let others = match others.len() {
        0 => String::new(),
        count => format!(", and {count} more"),
    };
    Some(first.clause() + &others)
}

/// A line of Groundwave's form, or one of the robot's own.
pub(crate) enum Line<'a> {
    Wire(&'a Received),
    Own(&'a OwnLine),
}

/// Reads the lines in a stream of bytes, and collects the robot's mistakes in them.
#[derive(Debug, Default)]
pub struct Diagnosis {
    decoder: Decoder,
    examiner: Examiner,
    own: Recognizer,
    own_lines: u64,
    /// Those with values.
    own_values: u64,
    described: DescribedFields,
}

impl Diagnosis {
    /// A diagnosis of a robot whose own lines are read so.
    #[must_use]
    pub fn new(own: Recognizer) -> Self {
        Self {
            own,
            ..Self::default()
        }
    }

    /// Takes bytes of the robot.
    pub fn take(&mut self, bytes: &[u8]) {
        let Ok(()) = self.each_line(bytes, |_, _| Ok::<(), Infallible>(()));
    }

    /// Takes bytes of the robot; passes each line, with the decoder's totals right after it, to `take`.
    ///
    /// # Errors
    /// The errors of `take`.
    pub(crate) fn each_line<E>(
        &mut self,
        bytes: &[u8],
        mut take: impl FnMut(Line<'_>, &Counters) -> Result<(), E>,
    ) -> Result<(), E> {
        for run in runs(bytes) {
            let before = *self.decoder.counters();
            let mut rest = run;
            let mut last = None;
            while let Some(received) = self.decoder.next_own_line(&mut rest) {
                let counters = self.decoder.counters();
                take(Line::Wire(&received), counters)?;
                if let Received::Line(line, _) = &received
                    && let Some(values) = self.described.take(&line.body)
                {
                    take(Line::Own(&values), counters)?;
                }
                last = Some((received, counters.noise_bytes));
            }
            let is_wire = self.decoder.counters().received() != before.received();
            if let Some(line) = self.own.take(run, is_wire) {
                self.own_lines += u64::from(line.content != Content::Damaged);
                self.own_values += u64::from(matches!(line.content, Content::Values(_)));
                self.decoder.disown(run.len(), before.damaged);
                take(Line::Own(&line), self.decoder.counters())?;
            }
            self.examiner.take(run, last, &before, &self.decoder);
        }
        Ok(())
    }

    /// The lines at the end of the stream that may be another robot's (see [`Decoder::undecided_lines`]), and the decoder's totals.
    pub(crate) fn undecided_lines(&self) -> impl Iterator<Item = (Received, &Counters)> {
        let counters = self.decoder.counters();
        self.decoder
            .undecided_lines()
            .map(move |line| (line, counters))
    }

    /// Whether bytes of the robot contain an intact line, or a line of the robot's own with values.
    pub fn finds_line(&mut self, bytes: &[u8]) -> bool {
        let found = self.each_line(bytes, |line, _| match line {
            Line::Own(line) if !matches!(line.content, Content::Values(_)) => Ok(()),
            Line::Own(_) | Line::Wire(_) => Err(()),
        });
        found.is_err()
    }

    /// Takes the receiver's clock when bytes have arrived.
    pub fn take_time(&mut self, now: Duration) {
        self.examiner.take_time(now);
    }

    /// Sets the time of the next bytes in the decoder, which counts lost lines.
    pub(crate) const fn set_time(&mut self, at: Duration) {
        set_time(&mut self.decoder, at);
    }

    /// Takes a place where bytes are missing.
    pub fn skip(&mut self) {
        self.decoder.skip();
        self.break_off();
    }

    /// Takes an interruption of the link: lines sent meanwhile are lost.
    pub(crate) fn interrupt(&mut self) {
        self.decoder.interrupt();
        self.break_off();
    }

    /// Drops the unfinished line.
    fn break_off(&mut self) {
        self.examiner.skip();
        self.own.interrupt();
    }

    /// The robot's mistakes, in the order of their first occurrence.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        self.examiner.findings()
    }

    /// The decoder's counts.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// The decoder's counts if the capture ends at a time.
    pub(crate) fn counters_until(&self, at: Duration) -> Counters {
        counters_until(&self.decoder, at)
    }

    /// Lines of the robot's own: level 0.
    #[must_use]
    pub const fn own_lines(&self) -> u64 {
        self.own_lines
    }

    /// Whether the lines of a capture in this form that are not Groundwave's are a robot's own: prose has few values.
    #[must_use]
    pub fn has_own_lines(&self, form: Form) -> bool {
        let damaged = Damaged::of(self.counters()).lines();
        let texts = self.own_lines - self.own_values;
        are_robots(form, self.own_values, texts, damaged)
    }

    /// Level of the robot by its lines, 1 to 5 (SPEC.md section 1); 0 without an intact line.
    #[must_use]
    pub const fn level(&self) -> u8 {
        self.examiner.level()
    }
}
