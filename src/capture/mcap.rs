//! Reads the MCAP form of a capture: <https://mcap.dev/spec>.

use std::io::{self, Read};
use std::time::Duration;

use ::mcap::McapError;
use ::mcap::sans_io::LinearReaderOptions;
use prost::Message;

use super::messages::RawBytes;
use super::schema::Schema;
use super::source::Chunk;
use super::topics::Topic;
use crate::statistics::Uplink;

/// Every byte read from the radio.
pub const RAW_RX: &str = Topic::RawRx.name();
/// Every byte sent to the radio.
pub const RAW_TX: &str = Topic::RawTx.name();

/// Why reading an MCAP ended early.
#[derive(Debug, thiserror::Error)]
pub enum McapProblem {
    /// The operating system.
    #[error(transparent)]
    Read(io::Error),
    /// The file ends before its end mark.
    #[error("the file ends in the middle")]
    Unfinished,
    /// A checksum or the structure does not hold.
    #[error("{0}")]
    Damaged(String),
    /// No channel of raw bytes.
    #[error("there is no channel {RAW_RX}")]
    NoRawBytes,
}

impl From<McapError> for McapProblem {
    fn from(error: McapError) -> Self {
        match error {
            McapError::UnexpectedEof => Self::Unfinished,
            McapError::Io(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                Self::Unfinished
            }
            McapError::Io(error) => Self::Read(error),
            error => Self::Damaged(error.to_string()),
        }
    }
}

/// The largest record that is believed.
const RECORD_BYTES_MAX: usize = 64 * 1024 * 1024;

/// Reads [`RAW_RX`] from a recording, and what [`RAW_TX`] says beside it, from the front, and checks every checksum on the way.
pub struct McapReader<R> {
    messages: ::mcap::io::MessageReader<R>,
    start_ns: Option<u64>,
    current: RawBytes,
    next_offset: u64,
    missing_bytes: u64,
    uplink: Uplink,
}

impl<R: Read> McapReader<R> {
    /// A reader from the beginning of `source`.
    pub fn new(source: R) -> Self {
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_validate_data_section_crc(true)
            .with_validate_summary_section_crc(true)
            .with_record_length_limit(RECORD_BYTES_MAX);
        Self {
            messages: ::mcap::io::MessageReader::new_with_options(source, options),
            start_ns: None,
            current: RawBytes::default(),
            next_offset: 0,
            missing_bytes: 0,
            uplink: Uplink::default(),
        }
    }

    /// The next bytes, and when they were read, counted from the first of them.
    ///
    /// # Errors
    /// Says why the rest cannot be read; what came before is good.
    pub fn next_chunk(&mut self) -> Result<Option<Chunk<'_>>, McapProblem> {
        for message in self.messages.by_ref() {
            let message = message?;
            if message.channel.topic == RAW_TX {
                let sent = RawBytes::decode(&*message.data)
                    .map_err(|error| McapProblem::Damaged(format!("{RAW_TX}: {error}")))?;
                self.uplink
                    .take(Duration::from_nanos(message.log_time), &sent.data);
            }
            if message.channel.topic != RAW_RX {
                continue;
            }
            if message
                .channel
                .schema
                .as_ref()
                .is_none_or(|s| s.name != RawBytes::NAME)
            {
                return Err(McapProblem::NoRawBytes);
            }
            self.current = RawBytes::decode(&*message.data)
                .map_err(|error| McapProblem::Damaged(format!("{RAW_RX}: {error}")))?;
            let start_ns = *self.start_ns.get_or_insert(message.log_time);
            let step = self.current.stream_offset.checked_sub(self.next_offset);
            self.missing_bytes += step.ok_or_else(|| {
                McapProblem::Damaged(format!("the bytes of {RAW_RX} are out of order"))
            })?;
            self.next_offset = self.current.stream_offset + self.current.data.len() as u64;
            return Ok(Some(Chunk {
                at: Duration::from_nanos(message.log_time.saturating_sub(start_ns)),
                bytes: &self.current.data,
            }));
        }
        if self.start_ns.is_none() && !self.has_raw_bytes() {
            return Err(McapProblem::NoRawBytes);
        }
        Ok(None)
    }

    fn has_raw_bytes(&self) -> bool {
        let mut channels = (0..=u16::MAX).filter_map(|id| self.messages.get_channel(id));
        channels.any(|channel| channel.topic == RAW_RX)
    }

    /// What was sent up to the bytes read last.
    #[must_use]
    pub const fn uplink(&self) -> &Uplink {
        &self.uplink
    }

    /// Bytes that the recorder read and could not record.
    #[must_use]
    pub const fn missing_bytes(&self) -> u64 {
        self.missing_bytes
    }
}
