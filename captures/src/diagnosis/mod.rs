//! Mistakes in the lines that a robot sends, told from damage by the radio.
//!
//! A line with a valid checksum and an unreadable field is the robot's mistake in any case: the radio makes one in 10^9 damaged
//! lines. A wrong checksum or shape is one if it recurs and a usual mistake explains it.

mod checksum;
mod forms;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use groundwave_lines::runs;
use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{Body, Detail, Line, SEQUENCE_MODULUS};

/// How often a wrong checksum or shape has to recur, because the radio may cause it once.
const RECURS: u64 = 3;

/// Longest piece between two line feeds that is kept; of a longer one the end.
const PIECE_BYTES_MAX: usize = 2 * LINE_BYTES;

/// A mistake of the robot, with its first occurrence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Number of the line feed that ended the first such line, from 1.
    pub row: u64,
    /// That line, without its line feed.
    pub line: Vec<u8>,
    /// First column to blame, from 1.
    pub column: Option<usize>,
    /// The likely cause, with the form expected.
    pub cause: String,
    /// Occurrences.
    pub count: u64,
}

/// Collects the mistakes in a stream of lines.
#[derive(Debug, Default)]
pub struct Diagnosis {
    decoder: Decoder,
    piece: Vec<u8>,
    row: u64,
    suspects: BTreeMap<(bool, String), Finding>,
    previous: Option<(u8, u64)>,
    /// Neighbouring intact lines without a byte between them, and those among them whose sequence does not advance by one.
    pairs: u64,
    /// Intact lines by their letter.
    intact: BTreeMap<u8, u64>,
    level: u8,
}

impl Diagnosis {
    /// Takes bytes of the robot.
    pub fn take(&mut self, bytes: &[u8]) {
        for run in runs(bytes) {
            let line_feed = run.iter().position(|&byte| byte == b'\n');
            let (piece, empty) = run.split_at(line_feed.map_or(run.len(), |at| at + 1));
            self.piece.extend_from_slice(piece);
            let excess = self.piece.len().saturating_sub(PIECE_BYTES_MAX);
            self.piece.drain(..excess);
            self.take_piece(piece);
            // Empty lines are no intact ones.
            self.decoder.lines(empty).for_each(drop);
            self.row += empty.split(|&byte| byte == b'\n').skip(1).count() as u64;
        }
    }

    fn take_piece(&mut self, piece: &[u8]) {
        let before = *self.decoder.counters();
        let received = self.decoder.lines(piece).last();
        if !piece.ends_with(b"\n") {
            return;
        }
        self.row += 1;
        let mut line = std::mem::take(&mut self.piece);
        line.pop();
        match received {
            Some(received) => self.take_intact(&received, &line),
            None if self.decoder.counters().field_rejected > before.field_rejected => {
                self.take_unreadable(&line);
            }
            None => {
                if let Some((column, cause)) = shape(&line).or_else(|| checksum::mistake(&line)) {
                    self.suspect(false, line, column, cause);
                }
            }
        }
    }

    fn take_unreadable(&mut self, line: &[u8]) {
        let Some(error) = self.decoder.last_field_error() else {
            return;
        };
        // The line is the end of the piece; noise may be before it.
        let start = line.len().saturating_sub(LINE_BYTES - 1);
        let line = line[start..].to_vec();
        let column = usize::from(error.column);
        let cause = forms::expected(&line, column);
        self.suspect(true, line, Some(column), cause);
    }

    fn take_intact(&mut self, received: &Received, line: &[u8]) {
        self.level = self.level.max(level(received));
        if let Received::Line(line, _) = received {
            *self
                .intact
                .entry(line.body.line_type().letter())
                .or_default() += 1;
        }
        let sequence = received.sequence();
        let noise = self.decoder.counters().noise_bytes;
        if let Some((previous, noise_before)) = self.previous.replace((sequence, noise))
            && noise == noise_before
        {
            self.pairs += 1;
            let expected = (previous + 1) % SEQUENCE_MODULUS;
            if sequence == previous {
                let cause = "the sequence stands still; it counts the lines of all types together";
                self.suspect(false, line.to_vec(), Some(2), cause.to_owned());
            } else if sequence != expected && sequence != 0 {
                let cause = "the sequence jumps; it counts by one from 00 to 99 over the lines of all types";
                self.suspect(false, line.to_vec(), Some(2), cause.to_owned());
            }
        }
    }

    fn suspect(&mut self, is_sure: bool, line: Vec<u8>, column: Option<usize>, cause: String) {
        let row = self.row;
        let finding = self.suspects.entry((is_sure, cause.clone()));
        let finding = finding.or_insert(Finding {
            row,
            line,
            column,
            cause,
            count: 0,
        });
        finding.count += 1;
    }

    /// The robot's mistakes, in the order of their first occurrence.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        // Lines and bytes that the radio lost make the sequence jump and lines too short or too long, but not mostly.
        let is_mistake = |((is_sure, cause), finding): &(&(bool, String), &Finding)| {
            let letter = finding.line.first();
            let others = if cause.starts_with("the sequence") {
                self.pairs / 2
            } else if finding.column == Some(checksum::COLUMN) {
                0
            } else {
                letter
                    .and_then(|it| self.intact.get(it))
                    .map_or(0, |it| *it)
            };
            *is_sure || finding.count >= RECURS && finding.count > others
        };
        let suspects = self.suspects.iter().filter(is_mistake);
        let mut findings: Vec<_> = suspects.map(|(_, finding)| finding.clone()).collect();
        findings.sort_by_key(|finding| finding.row);
        findings
    }

    /// The decoder's counts.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        self.decoder.counters()
    }

    /// The level that the lines show, 1 to 5 (SPEC.md section 1); 0 without an intact line.
    #[must_use]
    pub const fn level(&self) -> u8 {
        self.level
    }
}

/// The lowest level whose robots send such a line.
fn level(received: &Received) -> u8 {
    let by_ack = match received.ack().detail {
        Detail::CannotHear { .. } => 1,
        _ => 2,
    };
    let by_type = match received {
        Received::Ack(line) if line.listens => 5,
        Received::Ack(_) => 4,
        Received::Line(Line { body, .. }, _) => match body {
            Body::State(_) => 1,
            Body::Status(_) => 3,
            Body::Abilities(abilities) => abilities.level,
            Body::Field(_) | Body::Values(_) => 2,
            Body::Counters(_) | Body::Text(_) => 4,
            Body::Parameter(_) | Body::Song(_) => 5,
        },
    };
    if by_ack == 1 { 1 } else { by_type.max(by_ack) }
}

/// A mistake in the line's end or length. `line` lacks its line feed.
fn shape(line: &[u8]) -> Option<(Option<usize>, String)> {
    let is_type = |byte: &u8| b"ABCTPSIFV".contains(byte);
    let begins =
        |line: &[u8]| line.first().is_some_and(is_type) && line.get(1..3).is_some_and(is_sequence);
    if !begins(line) {
        return None;
    }
    let letter = char::from(line[0]);
    let body = line.strip_suffix(b"\r");
    let length = body.unwrap_or(line).len();
    match (body, length) {
        (None, 78) => Some((
            Some(79),
            format!("line {letter} ends with LF alone; it must end with CR LF"),
        )),
        (Some(_), 80) if checksum::is_hex(&line[74..80]) => Some((
            Some(checksum::COLUMN),
            format!(
                "line {letter} has its checksum as hexadecimal digits; it takes four 6-bit characters"
            ),
        )),
        (Some(_), 78) | (None, _) => None,
        (Some(_), length) => Some((
            None,
            format!(
                "line {letter} has {} bytes with CR LF; it must have {LINE_BYTES}",
                length + 2
            ),
        )),
    }
}

fn is_sequence(bytes: &[u8]) -> bool {
    bytes.iter().all(u8::is_ascii_digit)
}
