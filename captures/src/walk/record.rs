//! What single records of an MCAP say of themselves: <https://mcap.dev/spec>.

use ::mcap::parse_record;

use crate::unpacker::Header;
use crate::writer::CheckedChunk;
use crate::writer::records::{HEAD_BYTES, Reader, op};

/// The largest record that is believed, and the largest chunk when it is unpacked: many times what a
/// recording has.
pub(crate) const RECORD_BYTES_MAX: usize = 64 << 20;

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
        op::CHUNK => (Header::read(body).is_some(), "a chunk makes no sense"),
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

/// The chunk that is this record, with what has been unpacked from it.
pub(super) fn checked<'a>(record: &'a [u8], content: &'a [u8]) -> CheckedChunk<'a> {
    let header = record.get(HEAD_BYTES..).and_then(Header::read);
    let (compression, compressed_bytes) = header.map_or(("", 0), |header| {
        (header.compression, header.data.len() as u64)
    });
    CheckedChunk {
        record,
        compression,
        compressed_bytes,
        content,
    }
}

pub(super) fn u32_at(bytes: &[u8]) -> u32 {
    bytes
        .first_chunk()
        .map_or(0, |bytes| u32::from_le_bytes(*bytes))
}
