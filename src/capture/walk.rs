//! Walks the records of an MCAP from its front, and goes on after damage.
//!
//! Most tools stop at the first chunk whose checksum does not hold and lose everything after it. Here a
//! damaged chunk is skipped and named; where not even the length of a record can be believed, the walk
//! goes on at the next chunk that is whole. Nothing of a chunk is told before its checksum holds.

use std::fmt;
use std::io::{self, Read};
use std::ops::Range;

use ::mcap::records::op;
use ::mcap::{MAGIC, parse_record};

use super::unpacker::{Header, Lost, Unpacker};

/// The largest record that is believed, and the largest chunk when it is unpacked: many times what a
/// recording has.
const RECORD_BYTES_MAX: usize = 16 << 20;

/// Operation code and length.
const HEAD_BYTES: usize = 1 + 8;

/// How much is read at a time.
const READ_BYTES: usize = 256 << 10;

/// A part of the file that does not hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where in the file it begins, bytes.
    pub offset: u64,
    /// Bytes of the file that are skipped because of it.
    pub length: u64,
    /// What does not hold.
    pub problem: String,
    /// First and last log time of the messages lost, nanoseconds, where the chunk still says it.
    pub times_ns: Option<(u64, u64)>,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { offset, length, .. } = self;
        write!(f, "{} ({length} bytes at byte {offset}", self.problem)?;
        if let Some((first_ns, last_ns)) = self.times_ns {
            let s = last_ns.saturating_sub(first_ns) as f64 / 1e9;
            write!(f, ", {s:.1} s of the recording")?;
        }
        f.write_str(")")
    }
}

/// The next thing in the file.
#[derive(Debug)]
pub enum Step<'a> {
    /// A record, in the order of the file; those of a chunk one by one, the chunk itself never.
    Record {
        /// What kind: [`op`].
        opcode: u8,
        /// The rest of it, as [`parse_record`] wants it.
        body: &'a [u8],
    },
    /// Something was skipped.
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
    unpacked: Vec<u8>,
    unpacked_at: usize,
    unpacker: Unpacker,
    place: Place,
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
            unpacked: Vec::new(),
            unpacked_at: 0,
            unpacker: Unpacker::default(),
            place: Place::Begin,
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

    /// The next record or damage; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn next_step(&mut self) -> io::Result<Option<Step<'_>>> {
        let taken = loop {
            if self.unpacked_at < self.unpacked.len() {
                break self.take_unpacked();
            }
            match self.place {
                Place::Finished | Place::Unfinished => return Ok(None),
                Place::Begin => {
                    if self.fill(MAGIC.len())? >= MAGIC.len() && self.unread().starts_with(MAGIC) {
                        self.consume(MAGIC.len());
                    }
                    self.place = Place::Data;
                }
                Place::Data | Place::Summary => {
                    let taken = match self.find()? {
                        Found::Record(length) => self.take(length)?,
                        found => self.seek(&found)?.map(Taken::Damage),
                    };
                    if let Some(taken) = taken {
                        break taken;
                    }
                }
            }
        };
        Ok(Some(match taken {
            Taken::Damage(damage) => Step::Damage(damage),
            Taken::Record { opcode, body } => Step::Record {
                opcode,
                body: &self.buffer[body],
            },
            Taken::Unpacked { opcode, body } => Step::Record {
                opcode,
                body: &self.unpacked[body],
            },
        }))
    }

    /// The next record of the chunk that has been unpacked.
    fn take_unpacked(&mut self) -> Taken {
        let rest = &self.unpacked[self.unpacked_at..];
        let Some((opcode, length)) = head(rest).filter(|h| h.1 <= rest.len() - HEAD_BYTES) else {
            self.unpacked_at = self.unpacked.len();
            let problem = "the inside of a chunk makes no sense";
            return Taken::Damage(self.damage(self.offset, problem, None));
        };
        let from = self.unpacked_at + HEAD_BYTES;
        self.unpacked_at = from + length;
        let body = from..from + length;
        Taken::Unpacked { opcode, body }
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
        let unread = self.unread();
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
        let is_record = goes_on && is_body(opcode, body);
        Ok(if is_record {
            Found::Record(length)
        } else {
            Found::Nonsense
        })
    }

    /// Consumes the record that stands here.
    fn take(&mut self, length: usize) -> io::Result<Option<Taken>> {
        let at = self.offset;
        let opcode = self.unread()[0];
        if opcode == op::DATA_END {
            let stored = u32_at(&self.unread()[HEAD_BYTES..]);
            let found = self.crc.clone().finalize();
            let body = self.consume(HEAD_BYTES + length);
            self.place = Place::Summary;
            self.crc = crc32fast::Hasher::new();
            if stored != 0 && stored != found && !self.is_damaged {
                let problem = "the checksum of the data section does not hold";
                return Ok(Some(Taken::Damage(self.damage(at, problem, None))));
            }
            return Ok(Some(Taken::Record { opcode, body }));
        }
        if opcode == op::FOOTER {
            return self.take_footer(at).map(Some);
        }
        let body = self.consume(HEAD_BYTES + length);
        if opcode == op::CHUNK {
            return Ok(self.unpack(&body).err().map(|(problem, times_ns)| {
                self.unpacked.clear();
                self.unpacked_at = 0;
                Taken::Damage(self.damage(at, problem, times_ns))
            }));
        }
        Ok(Some(Taken::Record { opcode, body }))
    }

    fn take_footer(&mut self, at: u64) -> io::Result<Taken> {
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
            _ => {
                let opcode = op::FOOTER;
                return Ok(Taken::Record { opcode, body });
            }
        };
        Ok(Taken::Damage(self.damage(at, problem, None)))
    }

    /// Unpacks the chunk whose body this is.
    fn unpack(&mut self, body: &Range<usize>) -> Result<(), Lost> {
        self.unpacked_at = 0;
        let body = &self.buffer[body.clone()];
        self.unpacker
            .unpack(body, RECORD_BYTES_MAX, &mut self.unpacked)
    }

    /// Skips what is no record, to where the file can be understood again.
    fn seek(&mut self, found: &Found) -> io::Result<Option<Damage>> {
        let at = self.offset;
        // What an interruption has left of its last record is no damage.
        let is_torn = matches!(found, Found::TooShort);
        while !self.unread().is_empty() {
            self.consume(1);
            if self.is_anchor()? {
                let problem = "no record begins here";
                return Ok(Some(self.damage(at, problem, None)));
            }
        }
        self.place = Place::Unfinished;
        let problem = "nothing makes sense from here to the end";
        Ok((!is_torn).then(|| self.damage(at, problem, None)))
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
        let from = self.start + HEAD_BYTES;
        let is_whole = self.unpack(&(from..from + length)).is_ok();
        // It is unpacked again when it is taken.
        self.unpacked.clear();
        self.unpacked_at = 0;
        Ok(is_whole)
    }

    /// Names what begins at `at` and ends here.
    fn damage(&mut self, at: u64, problem: &str, times_ns: Option<(u64, u64)>) -> Damage {
        self.is_damaged = true;
        Damage {
            offset: at,
            length: self.offset - at,
            problem: problem.to_owned(),
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

/// What a record turned out to be; its body in the buffer.
enum Taken {
    Record {
        opcode: u8,
        body: Range<usize>,
    },
    /// One of the chunk that has been unpacked.
    Unpacked {
        opcode: u8,
        body: Range<usize>,
    },
    Damage(Damage),
}

/// The operation code and the length of the body, if they can be those of a record.
fn head(bytes: &[u8]) -> Option<(u8, usize)> {
    let (head, _) = bytes.split_first_chunk::<HEAD_BYTES>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let is_known = matches!(opcode, op::HEADER..=op::DATA_END | 0x80..);
    (is_known && length <= RECORD_BYTES_MAX).then_some((opcode, length))
}

/// An attachment without a name, a type and content: two times and three lengths.
const ATTACHMENT_BYTES_MIN: usize = 8 + 8 + 4 + 4 + 8;

/// Whether the body can be that of a record of its kind.
fn is_body(opcode: u8, body: &[u8]) -> bool {
    match opcode {
        op::DATA_END => body.len() == 4,
        op::FOOTER => body.len() == 20,
        op::MESSAGE => body.len() >= 22,
        op::MESSAGE_INDEX => body.len() >= 6 && body.len() == 6 + u32_at(&body[2..]) as usize,
        op::CHUNK => Header::read(body).is_some(),
        op::ATTACHMENT => body.split_last_chunk().is_some_and(|(rest, crc)| {
            let crc = u32::from_le_bytes(*crc);
            rest.len() >= ATTACHMENT_BYTES_MIN && (crc == 0 || crc32fast::hash(rest) == crc)
        }),
        op::HEADER..=op::SUMMARY_OFFSET => parse_record(opcode, body).is_ok(),
        _ => true,
    }
}

fn u32_at(bytes: &[u8]) -> u32 {
    bytes
        .first_chunk()
        .map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
