//! Finds the mistakes in the lines of a decoder.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::crc;
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{ACK_LINE_BYTES, AckLine, Body, Detail, Line};

use super::Finding;
use super::conduct::Conduct;
use super::kind::{self, Kind};
use super::{checksum, forms};
use crate::words::counted;

/// Minimum number of occurrences of a mistake that the radio may also cause.
const RECURS: u64 = 3;

/// Minimum number of occurrences of a field that is too long or too short in only some of the lines.
const RECURS_SOMETIMES: u64 = 12;

/// Maximum number of intact lines per such occurrence; the radio makes one line in 200 too long or too short.
const SOMETIMES: u64 = 20;

/// Maximum length of an examined line, bytes.
const LINE_BYTES_MAX: usize = 2 * LINE_BYTES;

/// Longest text between two lines that is examined.
const GAP_BYTES_MAX: usize = 100;

/// Evidence that the robot puts text between its lines: minimum number of texts between consecutive lines, and maximum number of line
/// pairs per text.
const RECURS_BETWEEN: u64 = 12;
const BETWEEN: u64 = 20;

/// Collects the mistakes in the lines of a decoder.
#[derive(Clone, Debug, Default)]
pub struct Examiner {
    piece: Vec<u8>,
    /// Bytes since the latest intact line.
    gap: Vec<u8>,
    /// Lines that followed one another with bytes between them.
    gaps: u64,
    row: u64,
    /// Suspected mistakes by code, letter and column.
    suspects: BTreeMap<(&'static str, u8, Option<usize>), Finding>,
    conduct: Conduct,
    /// Number of intact and of damaged lines, by letter.
    intact: BTreeMap<u8, u64>,
    damaged: BTreeMap<u8, u64>,
    /// Number of damaged lines that no usual mistake explains.
    unexplained: u64,
    /// The checksum that the latest damaged line should have, and how the one that it has differs.
    checksum: Option<(u32, u32)>,
    level: u8,
    /// Whether mistakes were suspected since the latest call of [`Self::news`].
    has_suspects: bool,
    /// Codes of the findings returned by [`Self::news`].
    known: BTreeSet<&'static str>,
}

impl Examiner {
    /// Takes a line or a part of one, with the empty lines after it (`groundwave_lines::runs`), after the decoder took them; the
    /// last intact line in these bytes, with the decoder's noise bytes right after it; and the decoder's earlier counts.
    pub fn take(
        &mut self,
        run: &[u8],
        last: Option<(Received, u64)>,
        before: &Counters,
        decoder: &Decoder,
    ) {
        let line_feed = run.iter().position(|&byte| byte == b'\n');
        let (piece, empty) = run.split_at(line_feed.map_or(run.len(), |at| at + 1));
        self.piece.extend_from_slice(piece);
        let room = self.gap_room();
        self.gap
            .extend_from_slice(&piece[piece.len().saturating_sub(room)..]);
        while self.piece.len() > 2 * LINE_BYTES_MAX {
            let head: Vec<u8> = self.piece.drain(..LINE_BYTES_MAX).collect();
            self.take_headless(&head);
        }
        if piece.ends_with(b"\n") {
            self.take_line(last, before, decoder);
        }
        self.row += empty.split(|&byte| byte == b'\n').skip(1).count() as u64;
        let room = self.gap_room().min(GAP_BYTES_MAX);
        self.gap.extend(empty.iter().take(room));
    }

    /// Number of bytes that the gap still takes. A full gap is too long to be examined, with or without its last line.
    const fn gap_room(&self) -> usize {
        (GAP_BYTES_MAX + LINE_BYTES + 1).saturating_sub(self.gap.len())
    }

    /// Takes the receiver's clock.
    pub fn take_time(&mut self, now: Duration) {
        self.conduct.take_time(now);
    }

    /// Takes a place where bytes are missing, or a line that is not in Groundwave's form.
    pub fn skip(&mut self) {
        self.piece.clear();
        self.gap.clear();
    }

    /// Returns the next mistake of a kind not returned before.
    pub fn news(&mut self) -> Option<Finding> {
        if !self.has_suspects {
            return None;
        }
        let mut findings = self.findings().into_iter();
        let found = findings.find(|it| !self.known.contains(it.kind.code));
        match &found {
            Some(finding) => _ = self.known.insert(finding.kind.code),
            None => self.has_suspects = false,
        }
        found
    }

    /// Takes bytes without a line feed.
    fn take_headless(&mut self, bytes: &[u8]) {
        let without_end = bytes.windows(LINE_BYTES + 1).find(|it| {
            let (line, next) = it.split_at(LINE_BYTES - 2);
            begins(line) && is_sealed(line, 74) && begins(next)
        });
        if let Some(line) = without_end {
            let place = "lines have no end".to_owned();
            let line = &line[..LINE_BYTES - 2];
            self.suspect(kind::LINE_END, false, line, Some(79), place);
            return;
        }
        let mut ends = bytes.iter().enumerate();
        let line = ends.find_map(|(end, byte)| {
            let line = bytes.get(end.checked_sub(LINE_BYTES - 2)?..end)?;
            let is_line = *byte == b'\r' && begins(line) && begins(&bytes[end + 1..]);
            is_line.then_some(line)
        });
        if let Some(line) = line {
            let place = "lines end with CR alone".to_owned();
            self.suspect(kind::LINE_END, false, line, Some(80), place);
        }
    }

    fn take_line(&mut self, last: Option<(Received, u64)>, before: &Counters, decoder: &Decoder) {
        self.row += 1;
        let mut piece = std::mem::take(&mut self.piece);
        let line = piece.strip_suffix(b"\n").unwrap_or(&piece);
        let counters = decoder.counters();
        if before.other_robots[0].is_none()
            && let Some(other) = counters.other_robots[0]
        {
            let place = format!("robot {other} is on the channel, too");
            self.suspect(kind::TWO_ROBOTS, true, line, None, place)
                .is_refused = false;
        }
        if let Some((received, noise)) = last {
            self.take_intact(&received, line, noise);
        } else if counters.field_rejected > before.field_rejected {
            self.take_unreadable(line, decoder);
        } else if counters.received() == before.received() {
            self.take_damaged(line);
        } else if let Some(received) = decoder.latest_undecided() {
            self.take_intact(&received, line, counters.noise_bytes);
        } else {
            // An intact line of another robot.
            self.gap.clear();
        }
        piece.clear();
        self.piece = piece;
    }

    fn take_unreadable(&mut self, line: &[u8], decoder: &Decoder) {
        let Some(error) = decoder.last_field_error() else {
            return;
        };
        // The line ends the piece; noise may precede it.
        let is_long = last(line, LINE_BYTES - 1).is_some_and(|line| is_sealed(line, 74));
        let length = if is_long { LINE_BYTES } else { ACK_LINE_BYTES };
        let line = last(line, length - 1).unwrap_or(line);
        let column = usize::from(error.column);
        let misread = forms::judge(line, column);
        self.suspect(misread.kind, true, line, Some(column), misread.place);
    }

    fn take_damaged(&mut self, line: &[u8]) {
        let letter = line.first().copied().unwrap_or_default();
        if begins(line) {
            *self.damaged.entry(letter).or_default() += 1;
        }
        if let Some((kind, column, place)) = shape(line) {
            self.suspect(kind, false, line, column, place);
            return;
        }
        let Some(content) = line.strip_suffix(b"\r") else {
            self.unexplained += u64::from(begins(line));
            return;
        };
        let misread = begins(content).then(|| misread(content)).flatten();
        if let Some((column, kind)) = checksum::mistake(content) {
            let place = place(letter, column);
            // The line is as the robot sent it, so its fields are judged, too.
            if let Some((column, misread)) = misread {
                self.suspect(misread.kind, false, line, Some(column), misread.place);
            }
            self.suspect(kind, false, line, Some(column), place);
        } else if begins(content) {
            let is_long = !AckLine::begins_with(letter) && content.len() == LINE_BYTES - 2;
            if is_long && misread.is_none() {
                let kind = self.unusual_checksum(content);
                self.suspect(kind, false, line, Some(75), place(letter, 75));
            } else {
                self.unexplained += 1;
            }
        }
    }

    /// Compares the checksum of a line with the line before.
    fn unusual_checksum(&mut self, content: &[u8]) -> &'static Kind {
        let difference = checksum::difference(content);
        let right = crc::update(crc::DOWNLINK_INIT, &content[..74]);
        let before = std::mem::replace(&mut self.checksum, difference.map(|it| (right, it)));
        match (before, difference) {
            (Some((before, _)), _) if content[74..] == crc::characters(before) => kind::CRC_STALE,
            (Some((_, before)), Some(difference)) if before == difference => kind::CRC_CONSTANT,
            _ => kind::CRC_UNKNOWN,
        }
    }

    /// Takes the bytes between an intact line and the one before.
    fn take_gap(&mut self, received: &Received, is_next: bool) {
        let length = match received {
            Received::Line(..) => LINE_BYTES,
            Received::Ack(_) => ACK_LINE_BYTES,
        };
        let mut gap = std::mem::take(&mut self.gap);
        gap.truncate(gap.len().saturating_sub(length));
        let is_text = |byte: &u8| matches!(byte, 0 | b'\t' | b'\r' | b'\n' | b' '..=b'~');
        if gap.is_empty() || gap.len() > GAP_BYTES_MAX || !is_next || !gap.iter().all(is_text) {
            return;
        }
        self.gaps += 1;
        let text = String::from_utf8_lossy(&gap).escape_default().to_string();
        let place = format!("between two lines: \"{text}\"");
        self.suspect(kind::BETWEEN, false, &gap, None, place)
            .is_refused = false;
    }

    fn take_intact(&mut self, received: &Received, line: &[u8], noise: u64) {
        self.level = self.level.max(level(received, true));
        let letter = match received {
            Received::Line(line, _) => line.body.line_type().letter(),
            Received::Ack(line) if line.listens => b'G',
            Received::Ack(_) => b'K',
        };
        *self.intact.entry(letter).or_default() += 1;
        let taken = self.conduct.take(received, noise);
        for (column, kind) in taken.found {
            let is_sure = [
                kind::ABILITIES,
                kind::NO_ABILITIES,
                kind::BOOT_CHANGES,
                kind::BOOT_DISAGREES,
                kind::BOOT_SAME,
                kind::DIGEST_EMPTY,
                kind::ERA_TWICE,
                kind::HEARING,
                kind::ID_DISAGREES,
                kind::ID_ZERO,
                kind::LINE_RATE,
                kind::WRAP,
            ]
            .contains(&kind);
            self.suspect(kind, is_sure, line, Some(column), place(letter, column))
                .is_refused = false;
        }
        self.take_gap(received, taken.is_next);
    }

    fn suspect(
        &mut self,
        kind: &'static Kind,
        is_sure: bool,
        line: &[u8],
        column: Option<usize>,
        place: String,
    ) -> &mut Finding {
        self.has_suspects = true;
        let row = self.row;
        // All types share one sequence.
        let letter = if column == Some(2) {
            0
        } else {
            line.first().copied().unwrap_or_default()
        };
        let key = (kind.code, letter, column);
        let finding = self.suspects.entry(key).or_insert_with(|| Finding {
            kind,
            row,
            line: line.to_vec(),
            column,
            place,
            count: 0,
            is_refused: true,
            is_sure,
        });
        finding.count += 1;
        finding
    }

    /// The robot's mistakes, in the order of their first occurrence.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        let of = |counts: &BTreeMap<u8, u64>, finding: &Finding| {
            let letter = finding.line.iter().find(|it| **it != b'\r');
            letter.and_then(|it| counts.get(it)).copied().unwrap_or(0)
        };
        let same_kind = |finding: &Finding| {
            let letter = finding.line.first();
            let suspects = self.suspects.values();
            let same = suspects.filter(|it| it.kind == finding.kind && it.line.first() == letter);
            same.map(|it| it.count).sum::<u64>()
        };
        // Losses on the radio make the sequence jump, and lines too short or too long, but rarely and not
        // always at the same column.
        let is_mistake = |finding: &&Finding| {
            let count = finding.count;
            let kind = finding.kind;
            if finding.is_sure {
                // A robot with two ids counts as two robots.
                return kind != kind::TWO_ROBOTS || !self.has(kind::ID_DISAGREES);
            }
            if count < RECURS {
                return false;
            }
            let intact = of(&self.intact, finding);
            // A bad radio damages most lines in ways that no mistake explains.
            let is_clear = same_kind(finding) > self.unexplained;
            if kind == kind::STUCK {
                count > self.conduct.pairs / 2
            } else if kind == kind::JUMP {
                self.conduct.jumps()
            } else if kind == kind::PER_TYPE {
                count > self.conduct.changes / 2
            } else if kind == kind::NO_STATE {
                count > intact / 4
            } else if kind == kind::LINE_END {
                is_clear && count > intact
            } else if kind == kind::LENGTH {
                let all = same_kind(finding);
                is_clear
                    && (all > intact && count * 5 > all
                        || count >= RECURS_SOMETIMES
                            && count * 5 > all * 3
                            && count * SOMETIMES > intact)
            } else if kind == kind::CRC_ZERO {
                // One flipped bit turns a backtick into a space.
                count > intact / 100
            } else if kind == kind::CRC_STALE {
                // One flipped bit in the sequence gives the line of another one.
                count > intact / 10
            } else if kind == kind::BETWEEN {
                // A radio that doubles bytes makes some of one byte.
                let pairs = self.conduct.pairs + self.gaps;
                if finding.line.len() < 4 {
                    count > pairs / 2
                } else {
                    count >= RECURS_BETWEEN && count > pairs / BETWEEN
                }
            } else if kind == kind::CRC_UNKNOWN || kind == kind::CRC_CONSTANT {
                is_clear && count > 4 * intact && count > of(&self.damaged, finding) / 2
            } else {
                true
            }
        };
        let suspects = self.suspects.values().filter(is_mistake);
        let mut findings: Vec<_> = suspects.cloned().collect();
        findings.sort_by_key(|finding| finding.row);
        findings
    }

    fn has(&self, kind: &'static Kind) -> bool {
        self.suspects.values().any(|it| it.kind == kind)
    }

    /// Level of the robot by its lines, 1 to 5 (SPEC.md section 1); 0 without an intact line.
    #[must_use]
    pub const fn level(&self) -> u8 {
        self.level
    }
}

/// The lowest level whose robots send such a line; with `is_stated` that which a line I states.
pub(super) fn level(received: &Received, is_stated: bool) -> u8 {
    let by_ack = match received.ack().detail {
        Detail::CannotHear { .. } => 1,
        _ => 2,
    };
    let by_type = match received {
        Received::Ack(line) if line.listens => 5,
        Received::Ack(_) => 4,
        Received::Line(Line { body, .. }, _) => match body {
            Body::Abilities(abilities) if is_stated => abilities.level,
            Body::State(_) | Body::Abilities(_) => 1,
            Body::Status(_) => 3,
            Body::Field(_) | Body::Values(_) => 2,
            Body::Counters(_) | Body::Text(_) => 4,
            Body::Parameter(_) | Body::Song(_) => 5,
        },
    };
    if by_ack == 1 { 1 } else { by_type.max(by_ack) }
}

/// A mistake in the line's end or length, its column, and its place as text. `line` excludes the line feed.
fn shape(line: &[u8]) -> Option<(&'static Kind, Option<usize>, String)> {
    if let [b'\r', line @ ..] = line
        && begins(line)
        && !line.ends_with(b"\r")
    {
        let text = format!("line {} ends with LF CR", char::from(line[0]));
        return Some((kind::LINE_END, Some(line.len() + 1), text));
    }
    if !begins(line) {
        return None;
    }
    let letter = char::from(line[0]);
    let length = if AckLine::begins_with(line[0]) {
        ACK_LINE_BYTES
    } else {
        LINE_BYTES
    };
    let (ends, end) = match line.strip_suffix(b"\r") {
        None if line.len() == length - 2 => ("LF alone", length - 1),
        None => return None,
        Some(content) if content.ends_with(b"\r") => ("CR CR LF", length),
        Some(content) if content.len() == length - 2 || checksum::mistake(content).is_some() => {
            return None;
        }
        Some(content) => {
            let found = content.len() + 2;
            // A longer line is of another type with a damaged letter, or text that the robot printed.
            let is_text = content.iter().all(|byte| (b' '..=b'~').contains(byte));
            if !is_text || !(8..=length + length / 2).contains(&found) {
                return None;
            }
            let covered = length - 2 - crc::CHARACTERS;
            if found > length && is_sealed(content, covered) {
                let extra = found - length;
                let text = format!(
                    "line {letter} has {} before its CR LF",
                    counted(extra as u64, "byte")
                );
                return Some((kind::LINE_END, Some(length - 1), text));
            }
            let (column, place) = match misread(content) {
                Some((column, misread)) => (column, misread.place),
                None => (length - 1, place(line[0], length - 1)),
            };
            let text = format!("{place}; the line has {found} bytes instead of {length}");
            return Some((kind::LENGTH, Some(column), text));
        }
    };
    let text = format!("line {letter} ends with {ends}");
    Some((kind::LINE_END, Some(end), text))
}

/// The first unreadable field in a line of any length, given without CR LF, and its column.
fn misread(content: &[u8]) -> Option<(usize, forms::Misread)> {
    if content.first().is_some_and(|it| AckLine::begins_with(*it)) {
        return None;
    }
    let mut line = [b' '; LINE_BYTES];
    let length = content.len().min(LINE_BYTES - 2);
    line[..length].copy_from_slice(&content[..length]);
    line[LINE_BYTES - 2..].copy_from_slice(b"\r\n");
    let column = usize::from(Line::parse(&line).err()?.column);
    Some((column, forms::judge(&line[..LINE_BYTES - 1], column)))
}

/// Whether a line begins with a type letter (SPEC.md section 5) and a sequence.
fn begins(line: &[u8]) -> bool {
    let is_type = |byte: u8| forms::is_type(byte) || AckLine::begins_with(byte);
    matches!(*line, [letter, tens, units, ..] if is_type(letter) && tens.is_ascii_digit() && units.is_ascii_digit())
}

/// Whether the checksum after the first `covered` columns is valid.
fn is_sealed(line: &[u8], covered: usize) -> bool {
    let remainder = crc::update(crc::DOWNLINK_INIT, &line[..covered]);
    line[covered..].starts_with(&crc::characters(remainder))
}

fn last(bytes: &[u8], count: usize) -> Option<&[u8]> {
    bytes.get(bytes.len().checked_sub(count)?..)
}

fn place(letter: u8, column: usize) -> String {
    format!(
        "line {}, column {column}",
        char::from(letter).escape_default()
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gap_is_held_up_to_its_limit() {
        let mut examiner = Examiner::default();
        let decoder = Decoder::default();
        for run in [&b"\n\n\n"[..], b"\n", b"x\n\n", &[b'\n'; 500], &[b'x'; 500]] {
            for _ in 0..1000 {
                examiner.take(run, None, &Counters::default(), &decoder);
            }
            assert!(examiner.gap.len() <= GAP_BYTES_MAX + LINE_BYTES + 1);
        }
    }
}
