//! Converts raw text to MCAP.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::time::{Duration, UNIX_EPOCH};

use super::session::Session;
use super::session_writer::SessionWriter;
use super::text::TextReader;

/// The reason why a capture was not converted.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The capture cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// The result cannot be written.
    #[error("{0}")]
    Write(io::Error),
}

/// The result of a conversion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Converted {
    /// Number of bytes from the radio.
    pub bytes: u64,
    /// Number of intact lines, and lines of the robot's own with values.
    pub lines: u64,
}

/// Writes a raw capture as MCAP with every topic. The recording starts at `start_ns` since 1970; without it, at the
/// date in the lines, else in 1970. `/raw/rx` holds the radio's bytes, without the timestamps and with the line ends
/// restored.
///
/// # Errors
/// If reading or writing fails.
pub fn convert_raw(
    source: impl Read,
    start_ns: Option<u64>,
    output: impl Write,
) -> Result<Converted, ConvertError> {
    let mut reader = TextReader::new(source);
    let style = reader.style().map_err(ConvertError::Read)?;
    let start_ns = start_ns
        .or_else(|| style.unix().map(nanoseconds))
        .unwrap_or_default();
    let mut notes = BTreeMap::new();
    if !style.is_stamped() {
        notes.insert(Session::ESTIMATED_TIMES.to_owned(), String::new());
    }
    let session = Session {
        link: match style.words() {
            None => "a raw capture".to_owned(),
            Some(words) => format!("a raw capture {words}"),
        },
        start: UNIX_EPOCH + Duration::from_nanos(start_ns),
        notes,
        configuration: String::new(),
    };
    let mut writer = SessionWriter::new(output, &session).map_err(ConvertError::Write)?;
    while let Some(piece) = reader.next_piece().map_err(ConvertError::Read)? {
        let at_ns = start_ns.saturating_add(nanoseconds(piece.at));
        writer
            .handle_rx(at_ns, piece.radio)
            .map_err(ConvertError::Write)?;
    }
    let bytes = writer.deriver().rx_bytes();
    // Bytes after the last line feed do not form a line.
    let counters = *writer.deriver().counters();
    let own_lines = writer.deriver().own_lines();
    writer.finish().map_err(ConvertError::Write)?;
    Ok(Converted {
        bytes,
        lines: counters.received() + own_lines,
    })
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
