//! What single records of an MCAP say of themselves: <https://mcap.dev/spec>.

use ::mcap::parse_record;
use ::mcap::records::{ChunkHeader, Record};

use crate::capture::writer::CheckedChunk;
use crate::capture::writer::records::{HEAD_BYTES, Reader, op};

/// The largest record that is believed, and the largest chunk when it is unpacked: many times what a
/// recording has.
pub(in crate::capture) const RECORD_BYTES_MAX: usize = 64 << 20;

/// An attachment without a name, a type and content: two times and three lengths.
const ATTACHMENT_BYTES_MIN: usize = 8 + 8 + 4 + 4 + 8;

/// The operation code and the length of the body, if they can be those of a record.
pub(super) fn head(bytes: &[u8]) -> Option<(u8, usize)> {
    let (head, _) = bytes.split_first_chunk::<HEAD_BYTES>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let is_known = matches!(opcode, op::HEADER..=op::DATA_END | 0x80..);
    (is_known && length <= RECORD_BYTES_MAX).then_some((opcode, length))
}

/// What keeps the body from being that of a record of its kind; what is inside of a chunk is not looked at.
pub(super) fn flaw(opcode: u8, body: &[u8]) -> Option<&'static str> {
    let (is_body, problem) = match opcode {
        op::DATA_END => (body.len() == 4, NONSENSE),
        op::FOOTER => (body.len() == 20, NONSENSE),
        op::MESSAGE => (body.len() >= 22, NONSENSE),
        op::MESSAGE_INDEX => {
            let is_body = body.len() >= 6 && body.len() == 6 + u32_at(&body[2..]) as usize;
            (is_body, NONSENSE)
        }
        op::CHUNK => (is_chunk(body), "a chunk makes no sense"),
        op::ATTACHMENT => (
            is_attachment(body),
            "the checksum of an attachment does not hold",
        ),
        op::HEADER..=op::SUMMARY_OFFSET => (parse_record(opcode, body).is_ok(), NONSENSE),
        _ => (true, NONSENSE),
    };
    (!is_body).then_some(problem)
}

const NONSENSE: &str = "a record makes no sense";

fn is_chunk(body: &[u8]) -> bool {
    let Ok(Record::Chunk { header, .. }) = parse_record(op::CHUNK, body) else {
        return false;
    };
    chunk_head_bytes(&header) + header.compressed_size == body.len() as u64
}

/// Two times, two sizes, the checksum and the compression's name with its length.
const fn chunk_head_bytes(header: &ChunkHeader) -> u64 {
    8 + 8 + 8 + 4 + 4 + header.compression.len() as u64 + 8
}

fn is_attachment(body: &[u8]) -> bool {
    body.split_last_chunk().is_some_and(|(rest, crc)| {
        let crc = u32::from_le_bytes(*crc);
        rest.len() >= ATTACHMENT_BYTES_MIN && (crc == 0 || crc32fast::hash(rest) == crc)
    })
}

/// Whether the body ends where it must by what it says itself, so that the length in the head is proven.
pub(super) fn fills_its_length(opcode: u8, body: &[u8]) -> bool {
    let mut fields = Reader(body);
    let mut read = || {
        match opcode {
            op::HEADER => drop((fields.text()?, fields.text()?)),
            op::SCHEMA => drop((
                fields.u16()?,
                fields.text()?,
                fields.text()?,
                fields.bytes()?,
            )),
            op::CHANNEL => drop((
                fields.u16()?,
                fields.u16()?,
                fields.text()?,
                fields.text()?,
                fields.map()?,
            )),
            op::METADATA => drop((fields.text()?, fields.map()?)),
            // Its checksum stands at its end.
            op::ATTACHMENT => return body.last_chunk().map(|crc| *crc != [0; 4]),
            _ => return None,
        }
        Some(fields.0.is_empty())
    };
    read().unwrap_or(false)
}

/// Unpacks chunks.
#[derive(Default)]
pub(super) struct Unpacker {
    /// One for all chunks: making one takes longer than a small chunk.
    zstd: Option<zstd::bulk::Decompressor<'static>>,
    pub(super) content: Vec<u8>,
}

/// Why a chunk is lost, and the times of its messages.
type Lost = (&'static str, Option<(u64, u64)>);

impl Unpacker {
    /// Has the content of the chunk whose body this is, if its checksum holds.
    pub(super) fn unpack(&mut self, body: &[u8]) -> Result<(), Lost> {
        let unpacked = self.try_unpack(body);
        if unpacked.is_err() {
            self.content.clear();
        }
        unpacked
    }

    /// The chunk that has been unpacked, as a whole record.
    pub(super) fn checked<'a>(&'a self, record: &'a [u8]) -> CheckedChunk<'a> {
        let mut fields = Reader(record);
        // The head, two times, the size, the checksum.
        fields.take(HEAD_BYTES + 8 + 8 + 8 + 4);
        let compression = fields.text().unwrap_or_default();
        CheckedChunk {
            record,
            compression,
            compressed_bytes: fields.u64().unwrap_or_default(),
            content: &self.content,
        }
    }

    fn try_unpack(&mut self, body: &[u8]) -> Result<(), Lost> {
        self.content.clear();
        let Ok(Record::Chunk { header, data }) = parse_record(op::CHUNK, body) else {
            return Err(("a chunk makes no sense", None));
        };
        let times_ns = Some((header.message_start_time, header.message_end_time));
        let lost = |problem| Err((problem, times_ns));
        let Some(size) = usize::try_from(header.uncompressed_size)
            .ok()
            .filter(|size| *size <= RECORD_BYTES_MAX)
        else {
            return lost("a chunk claims to be larger than any");
        };
        match header.compression.as_str() {
            "" => self.content.extend_from_slice(&data),
            "zstd" => {
                self.content.reserve(size);
                let zstd = match &mut self.zstd {
                    Some(zstd) => zstd,
                    none => match zstd::bulk::Decompressor::new() {
                        Ok(new) => none.insert(new),
                        Err(_) => return lost("a chunk cannot be unpacked"),
                    },
                };
                let unpacked = zstd.decompress_to_buffer(&data, &mut self.content);
                if unpacked.is_err() {
                    return lost("a chunk cannot be unpacked");
                }
            }
            _ => return lost("a chunk is compressed with something else than zstd"),
        }
        if self.content.len() != size {
            return lost("a chunk has another length than it says");
        }
        let is_checked = header.uncompressed_crc != 0;
        if is_checked && crc32fast::hash(&self.content) != header.uncompressed_crc {
            return lost("the checksum of a chunk does not hold");
        }
        Ok(())
    }
}

pub(super) fn u32_at(bytes: &[u8]) -> u32 {
    bytes
        .first_chunk()
        .map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
