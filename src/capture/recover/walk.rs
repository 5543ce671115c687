//! Walks the records of an MCAP that may be damaged anywhere, and finds everything that still holds.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use super::super::unpacker::{Header, Unpacker};
use super::super::writer::CheckedChunk;
use super::super::writer::records::{HEAD_BYTES, Reader, op};

/// A longer record is not believed.
pub(super) const RECORD_BYTES_MAX: usize = 64 * 1024 * 1024;

/// A chunk that says that it holds more is not believed.
const CONTENT_BYTES_MAX: usize = 256 * 1024 * 1024;

/// Bytes read at one go in search of the next chunk.
const SEARCH_BYTES: usize = 1024 * 1024;

/// Bytes of a chunk record before the name of its compression.
const CHUNK_HEAD_BYTES: usize = 32; // times, sizes, CRC, length of the name

/// Something in a file.
#[derive(Debug)]
pub(super) enum Found<'a> {
    /// Which program wrote it.
    Header(&'a str),
    Chunk(CheckedChunk<'a>),
    /// A schema, outside of a chunk.
    Schema(&'a [u8]),
    /// A channel, outside of a chunk.
    Channel(&'a [u8]),
    /// The content of a metadata record.
    Metadata(&'a [u8]),
    /// The content of an attachment whose checksum holds.
    Attachment(&'a [u8]),
    /// Bytes that are not what they should be.
    Damage(Damage),
    /// The beginning of a record that was never finished.
    Cut(Damage),
}

/// A place where a file is not what it should be.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Damage {
    /// First byte.
    pub offset: u64,
    /// Bytes that are of no use.
    pub bytes: u64,
    /// What is wrong with them.
    pub problem: &'static str,
}

/// Reads a file record by record.
pub(super) struct Walker {
    file: File,
    length: u64,
    position: u64,
    record: Vec<u8>,
    content: Vec<u8>,
    unpacker: Unpacker,
    has_begun: bool,
    /// Where the data section ends, and the checksum that it is to have.
    data_end: Option<(u64, u32)>,
}

impl Walker {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        Ok(Self {
            length: file.metadata()?.len(),
            file,
            position: 0,
            record: Vec::new(),
            content: Vec::new(),
            unpacker: Unpacker::default(),
            has_begun: false,
            data_end: None,
        })
    }

    /// Whether the file was finished, as far as it has been read.
    pub(super) const fn has_data_end(&self) -> bool {
        self.data_end.is_some()
    }

    /// Bytes in the file.
    pub(super) const fn length(&self) -> u64 {
        self.length
    }

    /// Whether the checksum over everything holds, which covers what has none of its own: tables, schemas,
    /// indexes. An unfinished file has none.
    pub(super) fn data_holds(&mut self) -> io::Result<bool> {
        let Some((length, crc)) = self.data_end.filter(|(_, crc)| *crc != 0) else {
            return Ok(true);
        };
        self.file.seek(SeekFrom::Start(0))?;
        let mut rest = self.file.by_ref().take(length);
        let mut hasher = crc32fast::Hasher::new();
        let mut buffer = vec![0; SEARCH_BYTES];
        loop {
            match rest.read(&mut buffer)? {
                0 => return Ok(hasher.finalize() == crc),
                read => hasher.update(&buffer[..read]),
            }
        }
    }

    /// The next thing in the file that matters; `None` at its end.
    pub(super) fn next(&mut self) -> io::Result<Option<Found<'_>>> {
        if !self.has_begun {
            self.has_begun = true;
            let magic = self.read_at(0, ::mcap::MAGIC.len())?;
            self.position = self.record.len() as u64;
            if magic && self.record == ::mcap::MAGIC {
                return self.next_record();
            }
            let bytes = self.position;
            return Ok((bytes > 0).then_some(Found::Damage(Damage {
                offset: 0,
                bytes,
                problem: "it does not begin as an MCAP does",
            })));
        }
        self.next_record()
    }

    fn next_record(&mut self) -> io::Result<Option<Found<'_>>> {
        // The borrow checker cannot follow a loop that returns what it has read.
        let judged = loop {
            match self.judge()? {
                Judged::Pass => {}
                judged => break judged,
            }
        };
        Ok(match judged {
            Judged::End | Judged::Pass => None,
            Judged::Damage(damage) => Some(Found::Damage(damage)),
            Judged::Cut(damage) => Some(Found::Cut(damage)),
            Judged::Good(opcode) => self.found(opcode),
        })
    }

    /// What the record is that is in memory.
    fn found(&self, opcode: u8) -> Option<Found<'_>> {
        let body = &self.record[HEAD_BYTES..];
        let mut fields = Reader(body);
        match opcode {
            op::HEADER => {
                fields.text()?;
                Some(Found::Header(fields.text()?))
            }
            op::SCHEMA => Some(Found::Schema(&self.record)),
            op::CHANNEL => Some(Found::Channel(&self.record)),
            op::METADATA => Some(Found::Metadata(body)),
            op::ATTACHMENT => Some(Found::Attachment(body)),
            _ => {
                let header = Header::read(body)?;
                Some(Found::Chunk(CheckedChunk {
                    record: &self.record,
                    compression: header.compression,
                    compressed_bytes: header.data.len() as u64,
                    content: &self.content,
                }))
            }
        }
    }

    /// Reads the next record and says what to do with it.
    fn judge(&mut self) -> io::Result<Judged> {
        let start = self.position;
        if start >= self.length {
            return Ok(Judged::End);
        }
        let Some((opcode, bytes)) = self.head_at(start)? else {
            return self.resynchronise(start, "no record begins where one should");
        };
        if start + bytes > self.length {
            return self.resynchronise(start, "a record is longer than what is left of the file");
        }
        self.read_at(start, bytes as usize)?;
        self.position = start + bytes;
        let body = &self.record[HEAD_BYTES..];
        let problem = match opcode {
            op::CHUNK => self.decompress(),
            op::ATTACHMENT => {
                let crc = body.split_last_chunk::<4>();
                let holds = crc
                    .is_some_and(|(said, crc)| crc32fast::hash(said) == u32::from_le_bytes(*crc));
                (!holds).then_some("the checksum of an attachment does not hold")
            }
            op::METADATA => {
                let mut fields = Reader(body);
                let is_whole = fields.text().is_some() && fields.map().is_some();
                (!is_whole).then_some("metadata make no sense")
            }
            op::HEADER | op::SCHEMA | op::CHANNEL => None,
            // Everything after this can be made anew.
            op::DATA_END => {
                self.data_end = Reader(body).u32().map(|crc| (start, crc));
                self.position = self.length;
                return Ok(Judged::End);
            }
            _ => return Ok(Judged::Pass),
        };
        match problem {
            None => Ok(Judged::Good(opcode)),
            // Is it the content that is damaged, or the length?
            Some(problem)
                if self.position == self.length || self.head_at(self.position)?.is_some() =>
            {
                Ok(Judged::Damage(Damage {
                    offset: start,
                    bytes,
                    problem,
                }))
            }
            Some(problem) => self.resynchronise(start, problem),
        }
    }

    /// Finds the next chunk that holds, and takes everything before it for damaged.
    fn resynchronise(&mut self, start: u64, problem: &'static str) -> io::Result<Judged> {
        let mut from = start + 1;
        let mut window = Vec::new();
        while from < self.length {
            window.clear();
            self.file.seek(SeekFrom::Start(from))?;
            let end = (SEARCH_BYTES + 2 * CHUNK_HEAD_BYTES) as u64;
            self.file.by_ref().take(end).read_to_end(&mut window)?;
            let reach = window.len().min(SEARCH_BYTES);
            for at in 0..reach {
                if window[at] == op::CHUNK
                    && let Some(bytes) = claimed_bytes(&window[at..])
                    && from + at as u64 + bytes <= self.length
                {
                    let candidate = from + at as u64;
                    self.read_at(candidate, bytes as usize)?;
                    if self.decompress().is_none() {
                        self.position = candidate;
                        return Ok(Judged::Damage(Damage {
                            offset: start,
                            bytes: candidate - start,
                            problem,
                        }));
                    }
                }
            }
            from += reach as u64;
        }
        self.position = self.length;
        Ok(Judged::Cut(Damage {
            offset: start,
            bytes: self.length - start,
            problem,
        }))
    }

    /// Opcode and whole length of the record there, if it may be one.
    fn head_at(&mut self, position: u64) -> io::Result<Option<(u8, u64)>> {
        if !self.read_at(position, HEAD_BYTES)? {
            return Ok(None);
        }
        let mut head = Reader(&self.record);
        let (Some(opcode), Some(length)) = (head.u8(), head.u64()) else {
            return Ok(None);
        };
        let is_known = (op::HEADER..=op::DATA_END).contains(&opcode);
        Ok((is_known && length <= RECORD_BYTES_MAX as u64)
            .then_some((opcode, length + HEAD_BYTES as u64)))
    }

    /// Has so many bytes of the file in memory; says whether there were so many.
    fn read_at(&mut self, position: u64, bytes: usize) -> io::Result<bool> {
        self.record.clear();
        self.file.seek(SeekFrom::Start(position))?;
        self.file
            .by_ref()
            .take(bytes as u64)
            .read_to_end(&mut self.record)?;
        Ok(self.record.len() == bytes)
    }

    /// Has the content of the chunk in memory; says what is wrong with it.
    fn decompress(&mut self) -> Option<&'static str> {
        let body = self.record.get(HEAD_BYTES..)?;
        let unpacked = self
            .unpacker
            .unpack(body, CONTENT_BYTES_MAX, &mut self.content);
        unpacked.err().map(|(problem, _)| problem)
    }
}

enum Judged {
    Good(u8),
    /// Of no interest.
    Pass,
    Damage(Damage),
    Cut(Damage),
    End,
}

/// How long the chunk would be that begins here, if it is one.
fn claimed_bytes(from: &[u8]) -> Option<u64> {
    let mut fields = Reader(from.get(1..)?);
    let length = fields.u64()?;
    let (start_ns, end_ns, bytes, _) = (fields.u64()?, fields.u64()?, fields.u64()?, fields.u32()?);
    let compression = fields.bytes()?;
    let compressed = fields.u64()?;
    let head = CHUNK_HEAD_BYTES + compression.len() + 8;
    let is_sound = start_ns <= end_ns
        && bytes <= CONTENT_BYTES_MAX as u64
        && length <= RECORD_BYTES_MAX as u64
        && [&b"zstd"[..], b""].contains(&compression)
        && compressed.checked_add(head as u64) == Some(length);
    is_sound.then_some(length + HEAD_BYTES as u64)
}
