//! The layout of MCAP records: <https://mcap.dev/spec>.

use ::mcap::parse_record;
use ::mcap::records::{Record, op};
use prost::encoding::{DecodeContext, decode_key, skip_field};

/// Length of a record's head (opcode and length), bytes.
pub(crate) const HEAD_BYTES: usize = 9;

/// Opcode of the private record that holds the CRC-32 of the message record after it.
pub(crate) const CHECKSUM: u8 = 0xC3;

/// Length of the body of a checksum record, bytes.
pub(crate) const CHECKSUM_BYTES: usize = 4;

/// Maximum length of an accepted record, and of an accepted chunk once unpacked, bytes.
pub(crate) const RECORD_BYTES_MAX: usize = 8 << 20;

/// Maximum length of an accepted map of strings, bytes; in memory, a map takes twelve times as much.
const MAP_BYTES_MAX: usize = 1 << 20;

/// Length of a message record before its data, bytes.
pub(crate) const MESSAGE_HEADER_BYTES: usize = 22;

/// A field of a record.
#[derive(Clone, Copy)]
enum Field {
    /// A number, or several, of fixed size in bytes.
    Fixed(usize),
    /// A string or array after its length of 32 bits.
    Sized,
    /// Data after its length of 64 bits.
    Data,
    /// Pairs of strings after their common length of 32 bits.
    Map,
}

use Field::{Data, Fixed, Map, Sized};

/// The opcode and the length of the body, if they are plausible for a record.
pub(crate) fn head(bytes: &[u8]) -> Option<(u8, usize)> {
    let (head, _) = bytes.split_first_chunk::<HEAD_BYTES>()?;
    let [opcode, length @ ..] = *head;
    let length = usize::try_from(u64::from_le_bytes(length)).ok()?;
    let is_known = matches!(opcode, op::HEADER..=op::DATA_END | 0x80..);
    (is_known && length <= RECORD_BYTES_MAX).then_some((opcode, length))
}

/// The fields of a kind of record; a message ends with data of any length.
const fn fields(opcode: u8) -> &'static [Field] {
    match opcode {
        op::HEADER => &[Sized, Sized],
        op::FOOTER => &[Fixed(20)],
        op::SCHEMA => &[Fixed(2), Sized, Sized, Sized],
        op::CHANNEL => &[Fixed(4), Sized, Sized, Map],
        op::MESSAGE => &[Fixed(MESSAGE_HEADER_BYTES)],
        op::CHUNK => &[Fixed(28), Sized, Data],
        op::MESSAGE_INDEX => &[Fixed(2), Sized],
        op::CHUNK_INDEX => &[Fixed(32), Sized, Fixed(8), Sized, Fixed(16)],
        op::ATTACHMENT => &[Fixed(16), Sized, Sized, Data, Fixed(4)],
        op::ATTACHMENT_INDEX => &[Fixed(40), Sized, Sized],
        op::STATISTICS => &[Fixed(42), Sized],
        op::METADATA => &[Sized, Map],
        op::METADATA_INDEX => &[Fixed(16), Sized],
        op::SUMMARY_OFFSET => &[Fixed(17)],
        op::DATA_END => &[Fixed(4)],
        _ => &[],
    }
}

/// Number of bytes in the body after its fields; `None` if a field is longer than the body.
pub(crate) fn bytes_after_fields(opcode: u8, body: &[u8]) -> Option<usize> {
    fn sized<'a>(bytes: &mut &'a [u8]) -> Option<&'a [u8]> {
        let (length, rest) = bytes.split_first_chunk()?;
        let (content, rest) = rest.split_at_checked(u32::from_le_bytes(*length) as usize)?;
        *bytes = rest;
        Some(content)
    }
    let mut rest = body;
    for field in fields(opcode) {
        match field {
            Fixed(bytes) => rest = rest.get(*bytes..)?,
            Sized => drop(sized(&mut rest)?),
            Data => {
                let (length, data) = rest.split_first_chunk()?;
                let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
                rest = data.get(length..)?;
            }
            Map => {
                let mut pairs = sized(&mut rest).filter(|pairs| pairs.len() <= MAP_BYTES_MAX)?;
                while !pairs.is_empty() {
                    sized(&mut pairs)?;
                    sized(&mut pairs)?;
                }
            }
        }
    }
    Some(rest.len())
}

/// Parses a record from its body. Lengths in the body are checked first, because [`parse_record`] reserves memory for them.
#[expect(clippy::disallowed_methods, reason = "the lengths are checked")]
pub(crate) fn parse(opcode: u8, body: &[u8]) -> Option<Record<'_>> {
    bytes_after_fields(opcode, body)?;
    parse_record(opcode, body).ok()
}

/// Whether the fields fill the body, which confirms the length in the head.
pub(crate) fn confirms_length(opcode: u8, body: &[u8]) -> bool {
    if opcode == op::MESSAGE {
        return body.get(MESSAGE_HEADER_BYTES..).is_some_and(is_protobuf);
    }
    let has_lengths = matches!(
        opcode,
        op::HEADER | op::SCHEMA | op::CHANNEL | op::METADATA | op::ATTACHMENT
    );
    has_lengths && bytes_after_fields(opcode, body) == Some(0)
}

/// Whether the bytes consist of whole protobuf fields.
fn is_protobuf(mut bytes: &[u8]) -> bool {
    let is_empty = bytes.is_empty();
    while !bytes.is_empty() {
        let field = decode_key(&mut bytes).and_then(|(tag, wire_type)| {
            skip_field(wire_type, tag, &mut bytes, DecodeContext::default())
        });
        if field.is_err() {
            return false;
        }
    }
    !is_empty
}
