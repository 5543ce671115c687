//! The MCAP form of a capture: <https://mcap.dev/spec>.

use std::collections::BTreeMap;
use std::io::Write;

use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::write::NoSeek;
use ::mcap::{Compression, McapResult, WriteOptions};

use super::messages::{RawBytes, Telemetry};
use super::schema::{DESCRIPTORS, Schema};

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
