//! Raw captures as MCAP.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::time::{Duration, UNIX_EPOCH};

use super::composer::{Composer, Session};
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

/// What was converted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Converted {
    /// Bytes of the radio.
    pub bytes: u64,
    /// Intact lines among them.
    pub lines: u64,
}

/// Writes a raw capture as MCAP with every topic, as if it had been recorded from `start_ns` since 1970 on,
/// from a radio at 2400 baud that never paused.
///
/// # Errors
/// When reading or writing fails.
pub fn convert_raw(
    source: impl Read,
    start_ns: u64,
    output: impl Write,
) -> Result<Converted, ConvertError> {
    let session = Session {
        link: "a raw capture".to_owned(),
        start: UNIX_EPOCH + Duration::from_nanos(start_ns),
        notes: BTreeMap::new(),
        configuration: String::new(),
    };
    let mut reader = RawReader::new(source);
    let mut composer = Composer::new(output, &session).map_err(ConvertError::Write)?;
    while let Some(chunk) = reader.next_chunk().map_err(ConvertError::Read)? {
        let since_ns = u64::try_from(chunk.at.as_nanos()).unwrap_or(u64::MAX);
        let at_ns = start_ns.saturating_add(since_ns);
        composer
            .handle_rx(at_ns, chunk.bytes)
            .map_err(ConvertError::Write)?;
    }
    let bytes = composer.deriver().rx_bytes();
    // Whatever is left over after the last line feed is no line.
    let counters = *composer.deriver().counters();
    composer.finish().map_err(ConvertError::Write)?;
    Ok(Converted {
        bytes,
        lines: counters.lines + counters.ack_lines,
    })
}
