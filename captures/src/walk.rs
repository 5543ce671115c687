//! Walks the records of an MCAP from its front, and goes on after damage.
//!
//! Most tools stop at the first chunk whose checksum does not hold and lose everything after it. Here a
//! damaged chunk is skipped and named; where not even the length of a record can be believed, the walk
//! goes on at the next chunk that is whole. Nothing of a chunk is told before its checksum holds.

mod record;

use std::io::{self, Read};
use std::ops::Range;

pub use super::repair::{Damage, Problem};
use super::unpacker::{Lost, Unpacker};
use super::writer::CheckedChunk;
use super::writer::records::{HEAD_BYTES, op};
use ::mcap::MAGIC;
pub(super) use record::RECORD_BYTES_MAX;
use record::{checked, fills_its_length, flaw, head, u32_at};

/// How much is read at a time.
const READ_BYTES: usize = 256 << 10;

/// The next thing in the file.
#[derive(Debug)]
pub enum Step<'a> {
    /// A record, in the order of the file; those of a chunk one by one, the chunk itself never.
    Record {
        /// What kind: [`op`].
        opcode: u8,
        /// The rest of it, as [`mcap::parse_record`] wants it.
        body: &'a [u8],
    },
    /// Something was skipped.
    Damage(Damage),
}

/// The next thing in the file, chunks as they are.
#[derive(Debug)]
pub(super) enum Part<'a> {
    /// A record that is in no chunk, with its head.
    Record(u8, &'a [u8]),
    Chunk(CheckedChunk<'a>),
    Damage(Damage),
}

/// Walks a file or a stream.
pub struct Walker<R> {
    source: R,
    /// What has been read; `start..` is not yet consumed.
    buffer: Vec<u8>,
    start: usize,
    offset: u64,
    source_ended: bool,
    unpacker: Unpacker,
    /// What the chunk that has been unpacked holds.
    content: Vec<u8>,
    /// How much of that has been given out.
    unpacked_at: usize,
    place: Place,
    has_data_end: bool,
    /// Of everything consumed since the beginning, and since the summary began.
    crc: crc32fast::Hasher,
    is_damaged: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Begin,
    Data,
    Summary,
    Finished,
    Unfinished,
}

/// What stands at a place in the file.
enum Found {
    /// A record with so many bytes after its head.
    Record(usize),
    /// Likewise, and they make no sense.
    Broken(usize, &'static str),
    /// The file ends first.
    TooShort,
    /// None.
    Nonsense,
}

impl<R: Read> Walker<R> {
    /// A walk from the beginning of `source`, which needs no buffer of its own.
    pub fn new(source: R) -> Self {
        Self {
            source,
            buffer: Vec::new(),
            start: 0,
            offset: 0,
            source_ended: false,
            unpacker: Unpacker::default(),
            content: Vec::new(),
            unpacked_at: 0,
            place: Place::Begin,
            has_data_end: false,
            crc: crc32fast::Hasher::new(),
            is_damaged: false,
        }
    }

    /// Where the walk is: bytes of the file behind it.
    #[must_use]
    pub const fn offset(&self) -> u64 {
        self.offset
    }

    /// Whether the file had its end mark; known when there is no next step.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.place == Place::Finished
    }

    /// Whether nothing but the summary can follow.
    pub(super) const fn has_data_end(&self) -> bool {
        self.has_data_end
    }

    /// The next record or damage; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn next_step(&mut self) -> io::Result<Option<Step<'_>>> {
        loop {
            if self.unpacked_at < self.content.len() {
                return Ok(Some(self.step_in_chunk()));
            }
            match self.advance()? {
                // To a reader the end of what was interrupted is no damage.
                Some(Taken::Chunk(_) | Taken::Torn(_)) => {}
                Some(Taken::Damage(damage)) => return Ok(Some(Step::Damage(damage))),
                Some(Taken::Record(opcode, body)) => {
                    let body = &self.buffer[body];
                    return Ok(Some(Step::Record { opcode, body }));
                }
                None => return Ok(None),
            }
        }
    }

    /// The next record of the chunk that has been unpacked.
    fn step_in_chunk(&mut self) -> Step<'_> {
        let rest = &self.content[self.unpacked_at..];
        let Some((opcode, length)) = head(rest).filter(|h| h.1 <= rest.len() - HEAD_BYTES) else {
            self.unpacked_at = self.content.len();
            let problem = "the inside of a chunk makes no sense";
            return Step::Damage(self.damage(self.offset, problem, None));
        };
        let from = self.unpacked_at + HEAD_BYTES;
        self.unpacked_at = from + length;
        let body = &self.content[from..from + length];
        Step::Record { opcode, body }
    }

    /// The next record outside of chunks, chunk or damage; `None` where nothing but the summary follows. The beginning
    /// of a record that the end of the file cuts off is damage.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub(super) fn next_part(&mut self) -> io::Result<Option<Part<'_>>> {
        if self.has_data_end {
            return Ok(None);
        }
        let Some(taken) = self.advance()? else {
            return Ok(None);
        };
        Ok(Some(match taken {
            Taken::Damage(damage) | Taken::Torn(damage) => Part::Damage(damage),
            Taken::Record(opcode, body) => Part::Record(opcode, &self.buffer[with_head(body)]),
            Taken::Chunk(body) => {
                self.unpacked_at = self.content.len();
                Part::Chunk(checked(&self.buffer[with_head(body)], &self.content))
            }
        }))
    }

    fn advance(&mut self) -> io::Result<Option<Taken>> {
        loop {
            let taken = match self.place {
                Place::Finished | Place::Unfinished => return Ok(None),
                Place::Begin => self.begin()?.map(Taken::Damage),
                Place::Data | Place::Summary => match self.find()? {
                    Found::Record(length) => Some(self.take(length)?),
                    Found::Broken(length, problem) => {
                        let at = self.offset;
                        self.consume(HEAD_BYTES + length);
                        Some(Taken::Damage(self.damage(at, problem, None)))
                    }
                    found => self.seek(&found)?,
                },
            };
            if taken.is_some() {
                return Ok(taken);
            }
        }
    }

    /// Takes the mark that every MCAP begins with.
    fn begin(&mut self) -> io::Result<Option<Damage>> {
        self.place = Place::Data;
        if self.fill(MAGIC.len() + HEAD_BYTES)? < MAGIC.len() {
            return Ok(None);
        }
        let (mark, after) = self.unread().split_at(MAGIC.len());
        let is_mark = mark == MAGIC;
        if is_mark || head(after).is_some() {
            self.consume(MAGIC.len());
        }
        let problem = "it does not begin as an MCAP does";
        Ok((!is_mark && self.offset > 0).then(|| self.damage(0, problem, None)))
    }

    /// What stands here.
    fn find(&mut self) -> io::Result<Found> {
        if self.fill(HEAD_BYTES)? < HEAD_BYTES {
            return Ok(Found::TooShort);
        }
        let Some((opcode, length)) = head(self.unread()) else {
            return Ok(Found::Nonsense);
        };
        let end = HEAD_BYTES + length;
        self.fill(end + HEAD_BYTES)?;
        let unread = &self.buffer[self.start..];
        if unread.len() < end {
            return Ok(Found::TooShort);
        }
        let body = &unread[HEAD_BYTES..end];
        let after = &unread[end..];
        let goes_on = match opcode {
            op::FOOTER => after.starts_with(MAGIC) || MAGIC.starts_with(after),
            // An interrupted recording ends after any record.
            _ => after.len() < HEAD_BYTES || head(after).is_some(),
        };
        Ok(match flaw(opcode, body) {
            None if goes_on => Found::Record(length),
            // What follows is damaged, and not the length of this one.
            None if fills_its_length(opcode, body) => Found::Record(length),
            None if opcode == op::CHUNK && self.is_whole(length) => Found::Record(length),
            Some(problem) if goes_on => Found::Broken(length, problem),
            _ => Found::Nonsense,
        })
    }

    /// Consumes the record that stands here.
    fn take(&mut self, length: usize) -> io::Result<Taken> {
        let at = self.offset;
        let opcode = self.unread()[0];
        if opcode == op::DATA_END {
            let stored = u32_at(&self.unread()[HEAD_BYTES..]);
            let found = self.crc.clone().finalize();
            let body = self.consume(HEAD_BYTES + length);
            self.place = Place::Summary;
            self.has_data_end = true;
            self.crc = crc32fast::Hasher::new();
            let is_wrong = stored != 0 && stored != found && !self.is_damaged;
            let problem = "the checksum of the data section does not hold";
            let damage = is_wrong.then(|| self.damage(self.offset, problem, None));
            // The summary has a checksum of its own.
            self.is_damaged = false;
            return Ok(damage.map_or(Taken::Record(opcode, body), Taken::Damage));
        }
        if opcode == op::FOOTER {
            return self.take_footer();
        }
        let body = self.consume(HEAD_BYTES + length);
        if opcode != op::CHUNK {
            return Ok(Taken::Record(opcode, body));
        }
        self.unpacked_at = 0;
        Ok(match self.unpack(body.clone()) {
            Ok(()) => Taken::Chunk(body),
            Err((problem, times_ns)) => Taken::Damage(self.damage(at, problem, times_ns)),
        })
    }

    fn take_footer(&mut self) -> io::Result<Taken> {
        /// The head, where the summary begins, where its offsets begin.
        const CHECKED_BYTES: usize = HEAD_BYTES + 16;
        const BYTES: usize = CHECKED_BYTES + 4;
        let from = self.start;
        self.crc.update(&self.buffer[from..from + CHECKED_BYTES]);
        let found = self.crc.clone().finalize();
        let stored = u32_at(&self.buffer[from + CHECKED_BYTES..]);
        let body = self.consume(BYTES);
        // One byte more than the end mark, to see that nothing follows it.
        self.fill(MAGIC.len() + 1)?;
        let has_mark = self.unread().starts_with(MAGIC);
        let has_more = has_mark && self.unread().len() > MAGIC.len();
        self.place = if has_mark {
            Place::Finished
        } else {
            Place::Unfinished
        };
        let is_wrong = stored != 0 && stored != found && !self.is_damaged;
        let problem = match (is_wrong, has_more) {
            (true, _) => "the checksum of the summary does not hold",
            (_, true) => "something follows the end mark",
            _ => return Ok(Taken::Record(op::FOOTER, body)),
        };
        Ok(Taken::Damage(self.damage(self.offset, problem, None)))
    }

    /// Skips what is no record, to where the file can be understood again.
    fn seek(&mut self, found: &Found) -> io::Result<Option<Taken>> {
        let at = self.offset;
        while !self.unread().is_empty() {
            self.consume(1);
            if self.is_anchor()? {
                let problem = "no record begins here";
                return Ok(Some(Taken::Damage(self.damage(at, problem, None))));
            }
        }
        self.place = Place::Unfinished;
        if self.offset == at {
            return Ok(None);
        }
        Ok(Some(if matches!(found, Found::TooShort) {
            let problem = "a record is longer than what is left of the file";
            Taken::Torn(self.damage(at, problem, None))
        } else {
            let problem = "nothing makes sense from here to the end";
            Taken::Damage(self.damage(at, problem, None))
        }))
    }

    /// Whether something stands here from which the file can be understood again: a whole chunk, or what
    /// follows the last of them. Single messages are not trusted: they have no checksum.
    fn is_anchor(&mut self) -> io::Result<bool> {
        self.fill(HEAD_BYTES)?;
        let Some((opcode, _)) = head(self.unread()) else {
            return Ok(false);
        };
        if !matches!(opcode, op::CHUNK | op::DATA_END | op::FOOTER) {
            return Ok(false);
        }
        let Found::Record(length) = self.find()? else {
            return Ok(false);
        };
        if opcode != op::CHUNK {
            return Ok(true);
        }
        Ok(self.is_whole(length))
    }

    /// Whether the chunk that stands here holds. It is unpacked again when it is taken.
    fn is_whole(&mut self, length: usize) -> bool {
        let from = self.start + HEAD_BYTES;
        let is_whole = self.unpack(from..from + length).is_ok();
        self.content.clear();
        is_whole
    }

    fn unpack(&mut self, body: Range<usize>) -> Result<(), Lost> {
        let body = &self.buffer[body];
        let unpacked = self
            .unpacker
            .unpack(body, RECORD_BYTES_MAX, &mut self.content);
        if unpacked.is_err() {
            self.content.clear();
        }
        unpacked
    }

    /// Names what begins at `at` and ends here.
    fn damage(
        &mut self,
        at: u64,
        problem: impl Into<Problem>,
        times_ns: Option<(u64, u64)>,
    ) -> Damage {
        self.is_damaged = true;
        Damage {
            offset: at,
            bytes: self.offset - at,
            problem: problem.into(),
            times_ns,
        }
    }

    fn unread(&self) -> &[u8] {
        &self.buffer[self.start..]
    }

    /// Goes on by so many bytes; returns where in the buffer the body of a record of that size was.
    fn consume(&mut self, bytes: usize) -> Range<usize> {
        let end = self.start + bytes;
        self.crc.update(&self.buffer[self.start..end]);
        let body = (self.start + HEAD_BYTES).min(end)..end;
        self.start = end;
        self.offset += bytes as u64;
        body
    }

    /// Reads until so many bytes are unread, or the source ends; returns how many are.
    fn fill(&mut self, bytes: usize) -> io::Result<usize> {
        while self.unread().len() < bytes && !self.source_ended {
            self.buffer.drain(..self.start);
            self.start = 0;
            let wanted = (bytes - self.buffer.len()).max(READ_BYTES) as u64;
            let read = self
                .source
                .by_ref()
                .take(wanted)
                .read_to_end(&mut self.buffer)?;
            self.source_ended = read == 0;
        }
        Ok(self.unread().len())
    }
}

/// What has been consumed: where in the buffer its body is.
enum Taken {
    Record(u8, Range<usize>),
    /// A chunk, which has been unpacked.
    Chunk(Range<usize>),
    Damage(Damage),
    /// The beginning of a record that the end of the file cuts off.
    Torn(Damage),
}

/// The whole record that has this body.
const fn with_head(body: Range<usize>) -> Range<usize> {
    body.start - HEAD_BYTES..body.end
}
