//! The MCAP form of a capture: <https://mcap.dev/spec>.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::time::Duration;

use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::sans_io::LinearReaderOptions;
use ::mcap::write::NoSeek;
use ::mcap::{Compression, McapError, McapResult, WriteOptions};
use prost::Message;

use super::messages::{RawBytes, Telemetry};
use super::schema::{DESCRIPTORS, Schema};
use super::source::Chunk;
use crate::statistics::Uplink;

/// Every byte read from the radio.
pub const RAW_RX: &str = "/raw/rx";
/// Every byte sent to the radio.
pub const RAW_TX: &str = "/raw/tx";
/// Every intact line, decoded.
pub const TELEMETRY: &str = "/telemetry";

const CHUNK_BYTES: u64 = 256 * 1024;

/// The fastest level: the lines are so alike that a higher one saves 3 per cent of the file and takes
/// more memory for its window than everything else here.
const ZSTD_LEVEL: u32 = 1;

/// The topics of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topic {
    /// [`RAW_RX`]
    RawRx,
    /// [`RAW_TX`]
    RawTx,
    /// [`TELEMETRY`]
    Telemetry,
}

#[derive(Clone, Copy, Debug)]
struct Channel {
    id: u16,
    sequence: u32,
}

/// Writes a recording to anything that takes bytes.
///
/// Whole chunks go out in one write, and a flushed recording can be read up to the flush by tools
/// that read from the front, however it ends.
pub struct McapWriter<W: Write> {
    writer: ::mcap::Writer<NoSeek<W>>,
    channels: [Channel; 3],
    log_time_ns: u64,
}

impl<W: Write> McapWriter<W> {
    /// Begins a recording: everything a reader needs to understand the rest, then a flush.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(output: W) -> McapResult<Self> {
        let mut writer = WriteOptions::new()
            .compression(Some(Compression::Zstd))
            .compression_level(ZSTD_LEVEL)
            .compression_threads(0)
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true)
            .library(concat!("groundwave ", env!("CARGO_PKG_VERSION")))
            .create(NoSeek::new(output))?;
        let raw = writer.add_schema(RawBytes::NAME, "protobuf", DESCRIPTORS)?;
        let telemetry = writer.add_schema(Telemetry::NAME, "protobuf", DESCRIPTORS)?;
        let mut channel = |schema, topic| {
            let id = writer.add_channel(schema, topic, "protobuf", &BTreeMap::new())?;
            McapResult::Ok(Channel { id, sequence: 0 })
        };
        let channels = [
            channel(raw, RAW_RX)?,
            channel(raw, RAW_TX)?,
            channel(telemetry, TELEMETRY)?,
        ];
        writer.flush()?;
        Ok(Self {
            writer,
            channels,
            log_time_ns: 0,
        })
    }

    /// Writes a message that was received at `log_time_ns` since 1970; should the clock have been set
    /// back, at the time of the message before. `publish_time_ns` is the robot's own time.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(
        &mut self,
        topic: Topic,
        log_time_ns: u64,
        publish_time_ns: Option<u64>,
        message: &impl Schema,
    ) -> McapResult<()> {
        self.log_time_ns = self.log_time_ns.max(log_time_ns);
        let channel = &mut self.channels[topic as usize];
        let header = MessageHeader {
            channel_id: channel.id,
            sequence: channel.sequence,
            log_time: self.log_time_ns,
            publish_time: publish_time_ns.unwrap_or(self.log_time_ns),
        };
        channel.sequence = channel.sequence.wrapping_add(1);
        self.writer
            .write_to_known_channel(&header, &message.encode_to_vec())
    }

    /// Writes a table of names and values about the recording.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_metadata(
        &mut self,
        name: &str,
        metadata: BTreeMap<String, String>,
    ) -> McapResult<()> {
        self.writer.write_metadata(&Metadata {
            name: name.to_owned(),
            metadata,
        })
    }

    /// Closes the chunk being filled and hands it to the output.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> McapResult<()> {
        self.writer.flush()
    }

    /// Writes the index and the statistics.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> McapResult<W> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().into_inner())
    }
}

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
