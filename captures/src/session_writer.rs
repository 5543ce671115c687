//! Writes a finished recording: every topic, in compressed and indexed chunks.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

use ::mcap::records::{MessageHeader, Metadata};
use ::mcap::write::NoSeek;
use ::mcap::{Attachment, McapError, WriteOptions, Writer};
use groundwave_protocol::telemetry::FirmwareVersion;

use super::layout;
use super::observations::{Item, Observation};
use super::session::{ROBOT, Session, since_1970_ns};
use super::topics::{Deriver, StationEvent, Topic, TopicMessage, register};

/// Default size of a chunk, uncompressed bytes: about ten minutes.
pub const CHUNK_BYTES: u64 = 1024 * 1024;

/// Library name in the header of a finished recording.
pub(super) const LIBRARY: &str =
    concat!("groundwave ", env!("CARGO_PKG_VERSION"), ", fixed topics");

/// Writes a finished recording from bytes and station events.
pub struct SessionWriter<W: Write> {
    deriver: Deriver,
    mcap: TopicWriter<W>,
}

impl<W: Write> SessionWriter<W> {
    /// Begins a recording of a session.
    ///
    /// # Errors
    /// If writing fails.
    pub fn new(output: W, session: &Session) -> io::Result<Self> {
        let mut writer = Self::with_chunks(output, CHUNK_BYTES)?;
        writer.handle_event(since_1970_ns(session.start), &session.beginning())?;
        let table = session.table();
        writer.take_session(&table);
        writer.write_metadata(&table)?;
        if let Some(configuration) = session.configuration() {
            writer.attach(&configuration)?;
        }
        Ok(writer)
    }

    /// Begins a recording in chunks of `chunk_bytes`, uncompressed, without a session.
    ///
    /// # Errors
    /// If writing fails.
    pub(super) fn with_chunks(output: W, chunk_bytes: u64) -> io::Result<Self> {
        Ok(Self {
            deriver: Deriver::new(),
            mcap: TopicWriter::new(output, chunk_bytes)?,
        })
    }

    /// Writes bytes received, read at `at_ns` since 1970, and the messages derived from them.
    ///
    /// # Errors
    /// If writing fails.
    pub fn handle_rx(&mut self, at_ns: u64, bytes: &[u8]) -> io::Result<()> {
        let mcap = &mut self.mcap;
        self.deriver
            .handle_rx(at_ns, bytes, |message| mcap.write(&message))?;
        self.write_robot()
    }

    /// Writes the table of the robot, if the latest lines name one.
    fn write_robot(&mut self) -> io::Result<()> {
        match self.deriver.take_robot() {
            Some(robot) => self.write_metadata(&about(robot)),
            None => Ok(()),
        }
    }

    /// Writes bytes sent at `at_ns` since 1970.
    ///
    /// # Errors
    /// If writing fails.
    pub fn handle_tx(&mut self, at_ns: u64, bytes: &[u8]) -> io::Result<()> {
        let mcap = &mut self.mcap;
        self.deriver
            .handle_tx(at_ns, bytes, |message| mcap.write(&message))
    }

    /// Writes a station event and the messages derived from it.
    ///
    /// # Errors
    /// If writing fails.
    pub fn handle_event(&mut self, at_ns: u64, event: &StationEvent) -> io::Result<()> {
        let mcap = &mut self.mcap;
        self.deriver
            .handle_event(at_ns, event, |message| mcap.write(&message))
    }

    /// Writes an item of another recording. A gap in its stream offsets is kept.
    ///
    /// # Errors
    /// If writing fails.
    pub(super) fn handle_item(&mut self, item: Item) -> io::Result<()> {
        match item {
            Item::Observation { at_ns, observation } => match observation {
                Observation::Received(raw) => {
                    let Some((step, bytes)) = raw.after(self.deriver.rx_bytes()) else {
                        return Ok(());
                    };
                    if step > 0 {
                        let mcap = &mut self.mcap;
                        self.deriver.skip_rx(step, |message| mcap.write(&message))?;
                    }
                    self.handle_rx(at_ns, bytes)
                }
                Observation::Sent(raw) => {
                    let Some((step, bytes)) = raw.after(self.deriver.tx_bytes()) else {
                        return Ok(());
                    };
                    self.deriver.skip_tx(step);
                    self.handle_tx(at_ns, bytes)
                }
                Observation::Event(event) => self.handle_event(at_ns, &event),
            },
            // Both are written again.
            Item::Table(table) if table.name == ROBOT => Ok(()),
            Item::Attachment(attachment) if attachment.name == layout::NAME => Ok(()),
            Item::Table(table) => {
                self.take_session(&table);
                self.write_metadata(&table)
            }
            Item::Attachment(attachment) => self.attach(&attachment),
            Item::Library(_) | Item::Damage(_) => Ok(()),
        }
    }

    /// Takes a metadata table, if it is the session's.
    fn take_session(&mut self, table: &Metadata) {
        if table.name == Session::TABLE {
            self.deriver.take_session(&table.metadata);
        }
    }

    /// Writes a metadata table.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write_metadata(&mut self, table: &Metadata) -> io::Result<()> {
        self.mcap.write_metadata(table)
    }

    /// Ends the current chunk.
    ///
    /// # Errors
    /// If writing fails.
    pub fn end_chunk(&mut self) -> io::Result<()> {
        self.mcap.writer.flush().map_err(io_error)
    }

    fn attach(&mut self, attachment: &Attachment<'_>) -> io::Result<()> {
        self.mcap.writer.attach(attachment).map_err(io_error)
    }

    /// The deriver of the messages.
    #[must_use]
    pub const fn deriver(&self) -> &Deriver {
        &self.deriver
    }

    /// Writes the rest, the layout, the index and the statistics; returns the output.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        let mcap = &mut self.mcap;
        self.deriver.finish(|message| mcap.write(&message))?;
        let start_ns = mcap.start_ns.unwrap_or_default();
        self.write_robot()?;
        self.attach(&Attachment {
            log_time: start_ns,
            create_time: start_ns,
            name: layout::NAME.into(),
            media_type: "application/json".into(),
            data: Cow::Borrowed(layout::JSON.as_bytes()),
        })?;
        self.mcap.finish()
    }
}

/// Writes messages of our topics in compressed and indexed chunks.
pub struct TopicWriter<W: Write> {
    writer: Writer<NoSeek<W>>,
    /// Number of the next message, by topic.
    sequences: [u32; Topic::ALL.len()],
    /// Time of the first message, nanoseconds since 1970.
    start_ns: Option<u64>,
}

impl<W: Write> TopicWriter<W> {
    /// Begins a file in chunks of `chunk_bytes`, uncompressed.
    ///
    /// # Errors
    /// If writing fails.
    pub fn new(output: W, chunk_bytes: u64) -> io::Result<Self> {
        let writer = WriteOptions::new()
            .library(LIBRARY)
            .chunk_size(Some(chunk_bytes))
            .compression_threads(0)
            .disable_seeking(true)
            .create(NoSeek::new(output))
            .map_err(io_error)?;
        Ok(Self {
            writer,
            sequences: [0; Topic::ALL.len()],
            start_ns: None,
        })
    }

    /// Writes a message.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write(&mut self, message: &TopicMessage<'_>) -> io::Result<()> {
        // A chunk with only the schemas would have no index.
        let is_first = self.start_ns.is_none();
        if is_first {
            register(&mut self.writer, &[message.topic]).map_err(io_error)?;
        }
        let sequence = &mut self.sequences[message.topic as usize];
        let header = MessageHeader {
            channel_id: message.topic.channel_id(),
            sequence: *sequence,
            log_time: message.log_time_ns,
            publish_time: message.publish_time_ns,
        };
        *sequence = sequence.wrapping_add(1);
        self.start_ns.get_or_insert(message.log_time_ns);
        self.writer
            .write_to_known_channel(&header, message.data)
            .map_err(io_error)?;
        if is_first {
            register(&mut self.writer, &Topic::ALL).map_err(io_error)?;
        }
        Ok(())
    }

    /// Writes a metadata table.
    ///
    /// # Errors
    /// If writing fails.
    pub fn write_metadata(&mut self, table: &Metadata) -> io::Result<()> {
        self.writer.write_metadata(table).map_err(io_error)
    }

    /// Writes the index and the statistics; returns the output.
    ///
    /// # Errors
    /// If writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        register(&mut self.writer, &Topic::ALL).map_err(io_error)?;
        self.writer.finish().map_err(io_error)?;
        let mut output = self.writer.into_inner().into_inner();
        output.flush()?;
        Ok(output)
    }
}

fn about((robot_id, version): (u8, FirmwareVersion)) -> Metadata {
    let metadata = BTreeMap::from([
        ("robot_id".to_owned(), robot_id.to_string()),
        (
            "firmware_version".to_owned(),
            format!("{}.{:02}", version.major, version.minor),
        ),
    ]);
    Metadata {
        name: ROBOT.into(),
        metadata,
    }
}

/// The operating system's error inside an MCAP error, with its kind; otherwise the MCAP error.
pub(super) fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}
