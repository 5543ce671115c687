//! A recording in progress: an MCAP file without chunks, under its final name.
//!
//! The file contains everything that cannot be derived: bytes received and sent, station events, the session and its
//! configuration. When a call returns, the operating system has its messages, so a killed program loses none. In MCAP,
//! only chunks have checksums; here, a private record before each message holds its CRC-32.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ::mcap::records::MessageHeader;
use ::mcap::write::NoSeek;
use ::mcap::{McapResult, WriteOptions, Writer};
use prost::Message as _;

use super::interrupted::LIBRARY;
use super::observations::Observation;
use super::record::{CHECKSUM, MESSAGE_HEADER_BYTES};
use super::session::{Session, since_1970_ns};
use super::session_writer::io_error;
use super::topics::{StationEvent, Topic, register};

/// The topics that cannot be derived.
const TOPICS: [Topic; 3] = [Topic::RawRx, Topic::RawTx, Topic::Station];

/// Writes a recording in progress. After an error, nothing more is written.
pub(crate) struct UnfinishedWriter {
    path: PathBuf,
    /// Writer of the MCAP; `None` after an error.
    writer: Option<Writer<NoSeek<Output>>>,
    bytes: Arc<AtomicU64>,
    rx_offset: u64,
    tx_offset: u64,
    /// Number of the next message, by topic.
    sequences: [u32; Topic::ALL.len()],
    /// The body of the message being written; kept to reuse its memory.
    body: Vec<u8>,
}

impl UnfinishedWriter {
    /// Writes header, topics, session, configuration and the note that the recording begins.
    pub(crate) fn begin(file: File, path: &Path, session: &Session) -> io::Result<Self> {
        let bytes = Arc::<AtomicU64>::default();
        let output = Output {
            file,
            pending: Vec::new(),
            bytes: Arc::clone(&bytes),
        };
        let mut writer = WriteOptions::new()
            .library(LIBRARY)
            .use_chunks(false)
            .compression(None)
            .emit_summary_records(false)
            .calculate_data_section_crc(false)
            .create(NoSeek::new(output))
            .map_err(io_error)?;
        register(&mut writer, &TOPICS).map_err(io_error)?;
        let mut unfinished = Self {
            path: path.to_owned(),
            writer: Some(writer),
            bytes,
            rx_offset: 0,
            tx_offset: 0,
            sequences: [0; Topic::ALL.len()],
            body: Vec::new(),
        };
        // Written first, so that the first chunk of the finished recording holds a message.
        unfinished.event(since_1970_ns(session.start), &session.beginning())?;
        unfinished.write(|writer, _| {
            writer.write_metadata(&session.table())?;
            match session.configuration() {
                Some(configuration) => writer.attach(&configuration),
                None => Ok(()),
            }
        })?;
        Ok(unfinished)
    }

    /// The file's name.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The counter of bytes written, for another thread.
    pub(crate) fn counter(&self) -> Arc<AtomicU64> {
        Arc::clone(&self.bytes)
    }

    /// Number of bytes written.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }

    /// Writes an observation made at `at_ns` since 1970. Bytes get their offset in the stream.
    ///
    /// # Errors
    /// The operating system's error.
    pub(crate) fn observation(&mut self, at_ns: u64, observation: Observation) -> io::Result<()> {
        let (topic, mut raw, offset) = match observation {
            Observation::Received(raw) => (Topic::RawRx, raw, &mut self.rx_offset),
            Observation::Sent(raw) => (Topic::RawTx, raw, &mut self.tx_offset),
            Observation::Event(event) => return self.event(at_ns, &event),
        };
        raw.stream_offset = *offset;
        *offset += raw.data.len() as u64;
        self.message(topic, at_ns, &raw.encode_to_vec())
    }

    fn event(&mut self, at_ns: u64, event: &StationEvent) -> io::Result<()> {
        self.message(Topic::Station, at_ns, &event.encode_to_vec())
    }

    /// Writes a message after its checksum.
    #[expect(
        clippy::default_trait_access,
        reason = "mcap does not export the type of a record's options"
    )]
    fn message(&mut self, topic: Topic, at_ns: u64, data: &[u8]) -> io::Result<()> {
        let next = &mut self.sequences[topic as usize];
        let header = MessageHeader {
            channel_id: topic.channel_id(),
            sequence: *next,
            log_time: at_ns,
            publish_time: at_ns,
        };
        *next = next.wrapping_add(1);
        self.body.clear();
        self.body.extend(header.channel_id.to_le_bytes());
        self.body.extend(header.sequence.to_le_bytes());
        self.body.extend(at_ns.to_le_bytes());
        self.body.extend(at_ns.to_le_bytes());
        self.body.extend(data);
        let checksum = crc32fast::hash(&self.body).to_le_bytes();
        self.write(|writer, body| {
            writer.write_private_record(CHECKSUM, &checksum, Default::default())?;
            writer.write_to_known_channel(&header, &body[MESSAGE_HEADER_BYTES..])
        })
    }

    /// Passes everything that `fill` writes to the operating system in one call.
    fn write(
        &mut self,
        fill: impl FnOnce(&mut Writer<NoSeek<Output>>, &[u8]) -> McapResult<()>,
    ) -> io::Result<()> {
        let Some(writer) = &mut self.writer else {
            return Ok(());
        };
        fill(writer, &self.body)
            .and_then(|()| writer.flush())
            .map_err(|error| {
                self.close();
                io_error(error)
            })
    }

    /// Closes the file without an end mark. Dropping the writer would write one.
    fn close(&mut self) {
        if let Some(writer) = self.writer.take() {
            drop(writer.into_inner());
        }
    }
}

impl Drop for UnfinishedWriter {
    fn drop(&mut self) {
        self.close();
    }
}

/// Buffers bytes until a flush writes them in one call.
struct Output {
    file: File,
    pending: Vec<u8>,
    bytes: Arc<AtomicU64>,
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.pending.extend(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.write_all(&self.pending)?;
        let count = self.pending.len() as u64;
        self.bytes.fetch_add(count, Ordering::Release);
        self.pending.clear();
        Ok(())
    }
}
