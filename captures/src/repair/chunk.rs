//! Opens chunks with a valid checksum.

use ::mcap::McapError;
use ::mcap::records::{Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use super::allowance::Allowance;
use super::{Position, Problem};
use crate::record::{HEAD_BYTES, RECORD_BYTES_MAX, bytes_after_fields, parse};

/// Reason why a chunk is lost, and first and last log time of its messages, nanoseconds, if known.
pub(super) type Lost = (Problem, Option<(u64, u64)>);

/// A chunk with a valid checksum.
pub(super) struct Chunk {
    pub(super) reader: LinearReader,
    /// First record of the chunk; read to check the chunk.
    pub(super) first: Option<(u8, Vec<u8>)>,
    pub(super) position: Position,
}

impl Chunk {
    /// Opens the chunk in a record body at an offset of the file.
    pub(super) fn open(body: &[u8], offset: u64, allowance: &mut Allowance) -> Result<Self, Lost> {
        let header = match parse(op::CHUNK, body) {
            Some(Record::Chunk { header, .. })
                if bytes_after_fields(op::CHUNK, body) == Some(0) =>
            {
                header
            }
            _ => return Err(("a chunk is malformed".into(), None)),
        };
        let times_ns = Some((header.message_start_time, header.message_end_time));
        if header.uncompressed_size > RECORD_BYTES_MAX as u64 {
            return Err(("a chunk declares an implausible size".into(), times_ns));
        }
        if !allowance.takes_unpacked(header.uncompressed_size) {
            let problem = "a chunk declares an implausible compression ratio";
            return Err((problem.into(), times_ns));
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(RECORD_BYTES_MAX);
        let mut reader = LinearReader::new_with_options(options);
        let (opcode, rest) = reader.insert(HEAD_BYTES + body.len()).split_at_mut(1);
        opcode[0] = op::CHUNK;
        let (length, content) = rest.split_at_mut(HEAD_BYTES - 1);
        length.copy_from_slice(&(body.len() as u64).to_le_bytes());
        content.copy_from_slice(body);
        reader.notify_read(HEAD_BYTES + body.len());
        let first = match reader.next_event() {
            Some(Ok(LinearReadEvent::Record { data, opcode })) => Some((opcode, data.to_vec())),
            Some(Err(error)) => return Err((chunk_problem(&error), times_ns)),
            _ => None,
        };
        Ok(Self {
            reader,
            first,
            position: Position { offset, record: 0 },
        })
    }
}

fn chunk_problem(error: &McapError) -> Problem {
    Problem::Flaw(match error {
        McapError::UnsupportedCompression(name) if name == "lz4" => return Problem::Lz4,
        McapError::UnsupportedCompression(_) => "a chunk has an unknown compression",
        McapError::BadChunkCrc { .. } => "a chunk has a wrong checksum",
        _ => "a chunk cannot be unpacked",
    })
}
