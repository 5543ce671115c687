//! Raw captures as MCAP.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use ::mcap::McapError;
use groundwave_protocol::decoder::Decoder;

use super::mcap::{McapWriter, Topic};
use super::messages::{RawBytes, Telemetry};
use super::raw::RawReader;

/// Why a capture was not converted.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The capture cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// The result cannot be written.
    #[error("{0}")]
    Write(io::Error),
}

impl From<McapError> for ConvertError {
    fn from(error: McapError) -> Self {
        Self::Write(match error {
            McapError::Io(error) => error,
            error => io::Error::other(error),
        })
    }
}

/// What was converted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Converted {
    /// Bytes of the radio.
    pub bytes: u64,
    /// Intact lines among them.
    pub lines: u64,
}

/// Writes a raw capture as MCAP, as if it had been recorded from `start_ns` since 1970 on, from a radio at
/// 2400 baud that never paused.
///
/// # Errors
/// When reading or writing fails.
pub fn convert_raw(
    source: impl Read,
    start_ns: u64,
    output: impl Write,
) -> Result<Converted, ConvertError> {
    let mut reader = RawReader::new(source);
    let mut writer = McapWriter::new(output)?;
    writer.write_metadata("session", BTreeMap::new())?;
    let mut decoder = Decoder::default();
    let mut offset = 0;
    while let Some(chunk) = reader.next_chunk().map_err(ConvertError::Read)? {
        let at_ns = start_ns + u64::try_from(chunk.at.as_nanos()).unwrap_or(u64::MAX);
        let raw = RawBytes {
            stream_offset: offset,
            data: chunk.bytes.to_vec(),
        };
        writer.write(Topic::RawRx, at_ns, None, &raw)?;
        offset += chunk.bytes.len() as u64;
        let mut bytes = chunk.bytes;
        while !bytes.is_empty() {
            let (taken, received) = decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            if let Some(received) = received {
                writer.write(Topic::Telemetry, at_ns, None, &Telemetry::from(&received))?;
            }
        }
    }
    writer.finish()?;
    let counters = decoder.counters();
    Ok(Converted {
        bytes: counters.bytes,
        lines: counters.lines + counters.ack_lines,
    })
}
