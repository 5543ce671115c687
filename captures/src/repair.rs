//! Reads the records of an MCAP file and continues after damage.
//!
//! The `mcap` crate reads records and checks every checksum, but stops at the first damage. The repairing reader skips
//! a damaged record and reports it. When the length of a record is damaged, it continues at the next whole chunk or,
//! outside of chunks, at the next row of messages (consecutive intact records). A chunk is checked before its records are returned.

mod allowance;
mod chunk;
mod damage;
#[cfg(test)]
mod tests;
mod window;

use std::io::{self, Read};

use ::mcap::records::op;
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use ::mcap::{MAGIC, McapError};
use allowance::Allowance;
use chunk::{Chunk, Lost};
pub use damage::{Damage, Problem};
use window::Window;

use crate::record::{
    CHECKSUM, CHECKSUM_BYTES, HEAD_BYTES, RECORD_BYTES_MAX, bytes_after_fields, confirms_length,
    head, parse,
};

/// Maximum length of a damaged part, bytes. Longer damage is returned in parts, to keep each step short. A torn record is shorter.
const SEARCH_BYTES_MAX: u64 = (HEAD_BYTES + RECORD_BYTES_MAX) as u64;

/// Number of consecutive intact records needed to resume reading a file without chunks.
const ROW_RECORDS: usize = 3;

/// Maximum pause between two messages of such a row, nanoseconds.
const ROW_PAUSE_NS: u64 = 86_400_000_000_000;

/// The next part of the file.
#[derive(Debug)]
pub enum Part<'a> {
    /// A record; the records of a chunk are returned instead of the chunk.
    Record {
        /// Opcode of the record: [`op`].
        opcode: u8,
        /// The record after its length.
        body: &'a [u8],
    },
    /// A part that was skipped.
    Damage(Damage),
}

/// Position at which reading can continue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Offset in the file of a record outside of chunks, or of a chunk.
    pub offset: u64,
    /// Number of records in the chunk before the position.
    pub record: u32,
}

/// The way in which the end of the file was found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Finished,
    Unfinished,
    /// The file ends in the middle of a record.
    Torn,
}

/// The kind of a found part, without its body.
enum Found {
    Record(u8),
    Damage(Damage),
}

/// Reads the records of a file or a stream and skips damaged parts.
pub struct RepairingReader<R> {
    window: Window<R>,
    allowance: Allowance,
    /// Reads the file without unpacking chunks.
    outer: LinearReader,
    /// Number of bytes of the window already passed to `outer`.
    given: usize,
    chunk: Option<Chunk>,
    /// The record returned last.
    body: Vec<u8>,
    /// Log time of the latest message outside of chunks, nanoseconds.
    last_ns: Option<u64>,
    /// CRC-32 of the next message, from the private record before it.
    checksum: Option<u32>,
    /// Whether the damaged part returned last may continue here.
    is_searching: bool,
    /// Offset in the file of the record or chunk returned last.
    part_offset: u64,
    has_footer: bool,
    is_damaged: bool,
    end: Option<End>,
}

impl<R: Read> RepairingReader<R> {
    /// Reads from the beginning of `source`, which need not be buffered.
    pub fn new(source: R) -> Self {
        let options = outer_options()
            .with_skip_start_magic(false)
            .with_validate_data_section_crc(true);
        Self {
            window: Window::new(source),
            allowance: Allowance::new(),
            outer: LinearReader::new_with_options(options),
            given: 0,
            chunk: None,
            body: Vec::new(),
            last_ns: None,
            checksum: None,
            is_searching: false,
            part_offset: 0,
            has_footer: false,
            is_damaged: false,
            end: None,
        }
    }

    /// Continues reading at a position; `source` begins at its offset.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn resume(source: R, position: Position) -> io::Result<Self> {
        let mut reader = Self::new(source);
        if position.offset > 0 {
            reader.window.offset = position.offset;
            reader.restart();
        }
        while reader.position() < position && reader.advance()?.is_some() {}
        Ok(reader)
    }

    /// Position of the next part.
    #[must_use]
    pub fn position(&self) -> Position {
        let outside = Position {
            offset: self.window.offset,
            record: 0,
        };
        self.chunk.as_ref().map_or(outside, |chunk| chunk.position)
    }

    /// Offset in the file of the record returned last, or of its chunk.
    #[must_use]
    pub const fn part_offset(&self) -> u64 {
        self.part_offset
    }

    /// Whether the file has its end mark; known when there is no next part.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.end == Some(End::Finished)
    }

    /// Whether the file ends in the middle of a record; known when there is no next part.
    #[must_use]
    pub const fn is_torn(&self) -> bool {
        matches!(self.end, Some(End::Torn))
    }

    /// The next record or damaged part; `None` at the end. A record that the end of the file cuts off is skipped.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn next_part(&mut self) -> io::Result<Option<Part<'_>>> {
        Ok(self.advance()?.map(|found| match found {
            Found::Damage(damage) => Part::Damage(damage),
            Found::Record(opcode) => Part::Record {
                opcode,
                body: &self.body,
            },
        }))
    }

    fn advance(&mut self) -> io::Result<Option<Found>> {
        let mut found = self.next_in_chunk();
        while found.is_none() && self.end.is_none() {
            if self.is_searching {
                found = self.search(false)?;
                continue;
            }
            match self.outer.next_event() {
                None => self.end = Some(End::Finished),
                Some(Ok(LinearReadEvent::ReadRequest(bytes))) => {
                    if !self.give(bytes)? {
                        found = self.search(false)?;
                    }
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    self.body.clear();
                    self.body.extend_from_slice(data);
                    found = self.take_record(opcode)?;
                }
                Some(Err(error)) => found = self.take_error(&error)?,
            }
        }
        Ok(found)
    }

    fn next_in_chunk(&mut self) -> Option<Found> {
        let chunk = self.chunk.as_mut()?;
        chunk.position.record += 1;
        let opcode = if let Some((opcode, body)) = chunk.first.take() {
            self.body = body;
            opcode
        } else {
            match chunk.reader.next_event() {
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    self.body.clear();
                    self.body.extend_from_slice(data);
                    opcode
                }
                Some(Ok(LinearReadEvent::ReadRequest(_))) | None => {
                    self.chunk = None;
                    return None;
                }
                Some(Err(_)) => {
                    self.chunk = None;
                    let problem = "a record of a chunk is malformed".into();
                    return Some(self.damage(self.window.offset, (problem, None)));
                }
            }
        };
        Some(match flaw(opcode, &self.body) {
            None => Found::Record(opcode),
            Some(problem) => self.damage(self.window.offset, (problem.into(), None)),
        })
    }

    /// Passes bytes to `outer`, none at the end; returns `false` if they exceed the allowance.
    fn give(&mut self, wanted: usize) -> io::Result<bool> {
        let bytes = self.window.fill(self.given + wanted)?;
        let bytes = bytes.get(self.given..).unwrap_or_default();
        let bytes = &bytes[..bytes.len().min(wanted)];
        if !self.allowance.takes(bytes.len()) {
            return Ok(false);
        }
        self.outer.insert(wanted)[..bytes.len()].copy_from_slice(bytes);
        self.outer.notify_read(bytes.len());
        self.given += bytes.len();
        Ok(true)
    }

    /// Accepts or skips the record in `body`; searches for the next record if the length is not plausible.
    fn take_record(&mut self, opcode: u8) -> io::Result<Option<Found>> {
        let length = HEAD_BYTES + self.body.len();
        // The first record comes after the start mark.
        self.pass(self.given - length);
        let at = self.window.offset;
        let after = self.window.fill(length + HEAD_BYTES)?;
        let after = after.get(length..).unwrap_or_default();
        let goes_on = match opcode {
            op::FOOTER => after.starts_with(MAGIC) || MAGIC.starts_with(after),
            _ => after.len() < HEAD_BYTES || head(after).is_some(),
        };
        let chunk = (opcode == op::CHUNK).then(|| Chunk::open(&self.body, at, &mut self.allowance));
        let flaw = match &chunk {
            Some(opened) => opened.as_ref().err().copied(),
            None => flaw(opcode, &self.body).map(|problem| (problem.into(), None)),
        };
        if opcode == CHECKSUM && self.body.len() != CHECKSUM_BYTES {
            return self.search(false);
        }
        let checksum = self.checksum.take().filter(|_| opcode == op::MESSAGE);
        let is_checked = checksum.is_some_and(|sum| sum == crc32fast::hash(&self.body));
        if checksum.is_some() && !is_checked {
            if !goes_on {
                return self.search(false);
            }
            self.accept(length);
            let problem = "a message has a wrong checksum".into();
            return Ok(Some(self.damage(at, (problem, None))));
        }
        let is_confirmed =
            chunk.is_some() || goes_on || is_checked || confirms_length(opcode, &self.body);
        match flaw {
            None if is_confirmed => {}
            Some(lost) if goes_on => {
                self.accept(length);
                return Ok(Some(self.damage(at, lost)));
            }
            _ => return self.search(false),
        }
        self.accept(length);
        self.part_offset = at;
        match opcode {
            op::CHUNK => {
                self.chunk = chunk.and_then(Result::ok);
                return Ok(self.next_in_chunk());
            }
            op::MESSAGE => self.last_ns = log_time_ns(&self.body),
            CHECKSUM => self.checksum = self.body.first_chunk().map(|sum| u32::from_le_bytes(*sum)),
            // The summary has a separate checksum.
            op::DATA_END => self.is_damaged = false,
            op::FOOTER => self.has_footer = true,
            _ => {}
        }
        Ok(Some(Found::Record(opcode)))
    }

    fn take_error(&mut self, error: &McapError) -> io::Result<Option<Found>> {
        let at = self.window.offset;
        let crc = match error {
            McapError::BadDataCrc { .. } => "the data section has a wrong checksum",
            McapError::BadSummaryCrc { .. } => "the summary has a wrong checksum",
            McapError::BytesAfterEndMagic => {
                self.end = Some(End::Finished);
                let problem = "something follows the end mark".into();
                return Ok(Some(self.damage(at, (problem, None))));
            }
            _ if self.has_footer || self.window.fill(1)?.is_empty() => {
                self.end = Some(End::Unfinished);
                return Ok(None);
            }
            McapError::BadMagic => return self.take_bad_magic(),
            McapError::UnexpectedEof => return self.search(true),
            _ => return self.search(false),
        };
        let is_known = std::mem::replace(&mut self.is_damaged, true);
        self.restart();
        Ok((!is_known).then(|| self.damage(at, (crc.into(), None))))
    }

    /// Continues at the position of the first record after a damaged start mark.
    fn take_bad_magic(&mut self) -> io::Result<Option<Found>> {
        let bytes = self.window.fill(MAGIC.len() + HEAD_BYTES)?;
        if head(bytes.get(MAGIC.len()..).unwrap_or_default()).is_none() {
            return self.search(false);
        }
        self.accept(MAGIC.len());
        self.restart();
        let problem = "it does not begin as an MCAP does".into();
        Ok(Some(self.damage(0, (problem, None))))
    }

    /// Skips to the next part that can be read, by at most [`SEARCH_BYTES_MAX`].
    fn search(&mut self, is_torn: bool) -> io::Result<Option<Found>> {
        let at = self.window.offset;
        self.pass(1);
        while !self.window.fill(1)?.is_empty() {
            self.is_searching = !self.can_go_on()?;
            if !self.is_searching || self.window.offset - at > SEARCH_BYTES_MAX {
                self.restart();
                return Ok(Some(
                    self.damage(at, ("no record begins here".into(), None)),
                ));
            }
            self.pass(1);
        }
        self.end = Some(if is_torn { End::Torn } else { End::Unfinished });
        let problem = "no record can be read from here to the end".into();
        Ok((!is_torn).then(|| self.damage(at, (problem, None))))
    }

    /// Whether reading can continue here, at a whole chunk, the end of the data or a row of messages.
    fn can_go_on(&mut self) -> io::Result<bool> {
        let Some((opcode, length)) = head(self.window.fill(HEAD_BYTES)?) else {
            return Ok(false);
        };
        if opcode == op::MESSAGE {
            return self.is_row();
        }
        if opcode == CHECKSUM {
            return self.is_checked_message();
        }
        if !matches!(opcode, op::CHUNK | op::DATA_END | op::FOOTER) {
            return Ok(false);
        }
        let bytes = self.window.fill(2 * HEAD_BYTES + length)?;
        let Some((body, after)) = bytes[HEAD_BYTES..].split_at_checked(length) else {
            return Ok(false);
        };
        if !self.allowance.takes(length) {
            return Ok(false);
        }
        Ok(match opcode {
            op::CHUNK => Chunk::open(body, 0, &mut self.allowance).is_ok(),
            op::FOOTER => flaw(opcode, body).is_none() && MAGIC.starts_with(after),
            _ => flaw(opcode, body).is_none() && head(after).is_some(),
        })
    }

    /// Whether a checksum record and its matching message begin here.
    fn is_checked_message(&mut self) -> io::Result<bool> {
        const MESSAGE_AT: usize = HEAD_BYTES + CHECKSUM_BYTES;
        let message = self.window.fill(MESSAGE_AT + HEAD_BYTES)?.get(MESSAGE_AT..);
        let Some((op::MESSAGE, length)) = head(message.unwrap_or_default()) else {
            return Ok(false);
        };
        let body_at = MESSAGE_AT + HEAD_BYTES;
        let bytes = self.window.fill(body_at + length)?;
        Ok(bytes.get(body_at..body_at + length).is_some_and(|body| {
            self.allowance.takes(length)
                && crc32fast::hash(body).to_le_bytes() == bytes[HEAD_BYTES..MESSAGE_AT]
        }))
    }

    /// Whether a message begins here, followed by whole records with times in order. Messages outside of
    /// chunks have no checksum.
    fn is_row(&mut self) -> io::Result<bool> {
        let mut at = 0;
        let mut last_ns = self.last_ns;
        for number in 0..ROW_RECORDS {
            let unread = &self.window.fill(at + HEAD_BYTES)?[at..];
            let Some((opcode, length)) = head(unread) else {
                return Ok(number > 0 && unread.is_empty());
            };
            let end = at + HEAD_BYTES + length;
            let Some(body) = self.window.fill(end)?.get(at + HEAD_BYTES..end) else {
                return Ok(number > 0 && opcode == op::MESSAGE);
            };
            if !self.allowance.takes(length) || flaw(opcode, body).is_some() {
                return Ok(false);
            }
            if opcode == op::MESSAGE {
                let at_ns = log_time_ns(body);
                if let (Some(last_ns), Some(at_ns)) = (last_ns, at_ns)
                    && !(last_ns..last_ns.saturating_add(ROW_PAUSE_NS)).contains(&at_ns)
                {
                    return Ok(false);
                }
                last_ns = at_ns;
            }
            at = end;
        }
        Ok(true)
    }

    /// Restarts `outer` at the beginning of the window.
    fn restart(&mut self) {
        self.outer = LinearReader::new_with_options(outer_options());
        self.given = 0;
    }

    /// Moves past an accepted record.
    fn accept(&mut self, length: usize) {
        self.pass(length);
        self.given = 0;
    }

    fn pass(&mut self, bytes: usize) {
        self.window.advance(bytes);
        self.allowance.pass(bytes);
    }

    /// The damaged part from `offset` to the current position.
    fn damage(&mut self, offset: u64, (problem, times_ns): Lost) -> Found {
        self.is_damaged = true;
        Found::Damage(Damage {
            offset,
            bytes: self.window.offset - offset,
            problem,
            times_ns,
        })
    }
}

fn outer_options() -> LinearReaderOptions {
    LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_check_finishes_after_end_magic(true)
        .with_emit_chunks(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(RECORD_BYTES_MAX)
}

/// The defect of a record outside of chunks, if any; chunks are checked when they are unpacked.
fn flaw(opcode: u8, body: &[u8]) -> Option<&'static str> {
    let is_whole = match (opcode, bytes_after_fields(opcode, body)) {
        (_, None) => false,
        (op::MESSAGE, _) => true,
        (op::DATA_END | op::FOOTER | op::MESSAGE_INDEX, Some(rest)) => rest == 0,
        (op::ATTACHMENT, _) if parse(opcode, body).is_none() => {
            return Some("an attachment has a wrong checksum");
        }
        _ => parse(opcode, body).is_some(),
    };
    (!is_whole).then_some("a record is malformed")
}

fn log_time_ns(message: &[u8]) -> Option<u64> {
    let at_ns = message.get(6..)?.first_chunk()?;
    Some(u64::from_le_bytes(*at_ns))
}
