//! Writes MCAP files fast: each chunk is gathered in memory and compressed in one go.
//!
//! The library's writer hands each field of each message to a streaming compressor, which then takes most
//! of the time; that suits a recording at three lines a second. For whole files this is several times
//! faster (`docs/measurements.md`), and messages are encoded straight into the chunk.

use std::collections::BTreeMap;
use std::io::{self, Write};

use ::mcap::MAGIC;
use ::mcap::records::op;

/// Bytes of messages in a chunk.
const CHUNK_BYTES: usize = 1 << 20;

/// As for recordings: a higher level saves 3 per cent of the file.
const ZSTD_LEVEL: i32 = 1;

const COMPRESSION: &str = "zstd";

/// The times of a message, nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Times {
    /// When it was received.
    pub log: u64,
    /// When it was made.
    pub publish: u64,
}

/// Writes an MCAP to anything that takes bytes, front to back.
pub struct BlockWriter<W> {
    output: W,
    offset: u64,
    /// Of everything written; starts again with the summary.
    crc: crc32fast::Hasher,
    compressor: zstd::bulk::Compressor<'static>,
    chunk: Vec<u8>,
    packed: Vec<u8>,
    chunk_times: Option<(u64, u64)>,
    schemas: Vec<Vec<u8>>,
    channels: Vec<Channel>,
    chunk_indexes: Vec<u8>,
    attachment_indexes: Vec<u8>,
    metadata_indexes: Vec<u8>,
    counts: Counts,
    times: Option<(u64, u64)>,
}

struct Channel {
    record: Vec<u8>,
    messages: u64,
    /// Log time and place of each message of the chunk being gathered.
    index: Vec<(u64, u64)>,
}

#[derive(Default)]
struct Counts {
    messages: u64,
    attachments: u32,
    metadata: u32,
    chunks: u32,
}

impl<W: Write> BlockWriter<W> {
    /// Begins a file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(output: W) -> io::Result<Self> {
        let mut writer = Self {
            output,
            offset: 0,
            crc: crc32fast::Hasher::new(),
            compressor: zstd::bulk::Compressor::new(ZSTD_LEVEL)?,
            chunk: Vec::with_capacity(CHUNK_BYTES),
            packed: Vec::new(),
            chunk_times: None,
            schemas: Vec::new(),
            channels: Vec::new(),
            chunk_indexes: Vec::new(),
            attachment_indexes: Vec::new(),
            metadata_indexes: Vec::new(),
            counts: Counts::default(),
            times: None,
        };
        let mut header = Vec::new();
        put_text(&mut header, "");
        put_text(
            &mut header,
            concat!("groundwave ", env!("CARGO_PKG_VERSION")),
        );
        writer.put(MAGIC)?;
        writer.put_record(op::HEADER, &header)?;
        Ok(writer)
    }

    /// Adds the description of a message type; returns its number.
    ///
    /// # Errors
    /// When writing fails, or there are more than a file can hold.
    pub fn add_schema(&mut self, name: &str, encoding: &str, data: &[u8]) -> io::Result<u16> {
        let id = number(self.schemas.len() + 1)?;
        let mut record = Vec::new();
        record.extend(id.to_le_bytes());
        put_text(&mut record, name);
        put_text(&mut record, encoding);
        record.extend((data.len() as u32).to_le_bytes());
        record.extend(data);
        self.put_record(op::SCHEMA, &record)?;
        self.schemas.push(record);
        Ok(id)
    }

    /// Adds a topic; returns its number. Schema 0 is none.
    ///
    /// # Errors
    /// When writing fails, or there are more than a file can hold.
    pub fn add_channel(
        &mut self,
        schema: u16,
        topic: &str,
        encoding: &str,
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<u16> {
        let id = number(self.channels.len())?;
        let mut record = Vec::new();
        record.extend(id.to_le_bytes());
        record.extend(schema.to_le_bytes());
        put_text(&mut record, topic);
        put_text(&mut record, encoding);
        put_table(&mut record, metadata);
        self.put_record(op::CHANNEL, &record)?;
        self.channels.push(Channel {
            record,
            messages: 0,
            index: Vec::new(),
        });
        Ok(id)
    }

    /// Adds a message, which `encode` appends to the vector it is given. The messages of a channel are
    /// numbered in their order.
    ///
    /// # Errors
    /// When writing fails, or there is no such channel.
    pub fn write(
        &mut self,
        channel: u16,
        times: Times,
        encode: impl FnOnce(&mut Vec<u8>),
    ) -> io::Result<()> {
        /// Channel, number, two times.
        const HEADER_BYTES: usize = 2 + 4 + 8 + 8;
        let place = self.chunk.len() as u64;
        let Some(state) = self.channels.get_mut(usize::from(channel)) else {
            return Err(io::Error::other(format!("there is no channel {channel}")));
        };
        let chunk = &mut self.chunk;
        chunk.push(op::MESSAGE);
        let length_at = chunk.len();
        chunk.extend([0; 8]);
        chunk.extend(channel.to_le_bytes());
        chunk.extend((state.messages as u32).to_le_bytes());
        chunk.extend(times.log.to_le_bytes());
        chunk.extend(times.publish.to_le_bytes());
        encode(chunk);
        let length = (chunk.len() - length_at - 8) as u64;
        debug_assert!(length >= HEADER_BYTES as u64, "encoding only appends");
        chunk[length_at..length_at + 8].copy_from_slice(&length.to_le_bytes());
        state.messages += 1;
        state.index.push((times.log, place));
        self.counts.messages += 1;
        let (first, last) = self.chunk_times.unwrap_or((times.log, times.log));
        self.chunk_times = Some((first.min(times.log), last.max(times.log)));
        if self.chunk.len() >= CHUNK_BYTES {
            self.flush()?;
        }
        Ok(())
    }

    /// Adds a table of names and values.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_metadata(
        &mut self,
        name: &str,
        table: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        let mut record = Vec::new();
        put_text(&mut record, name);
        put_table(&mut record, table);
        let index = &mut Vec::new();
        let at = self.offset;
        let length = self.put_record(op::METADATA, &record)?;
        index.extend(at.to_le_bytes());
        index.extend(length.to_le_bytes());
        put_text(index, name);
        append_record(&mut self.metadata_indexes, op::METADATA_INDEX, index);
        self.counts.metadata += 1;
        Ok(())
    }

    /// Adds an attached file.
    ///
    /// # Errors
    /// When writing fails.
    pub fn attach(
        &mut self,
        name: &str,
        media_type: &str,
        times: Times,
        data: &[u8],
    ) -> io::Result<()> {
        let mut record = Vec::with_capacity(data.len() + 64);
        record.extend(times.log.to_le_bytes());
        record.extend(times.publish.to_le_bytes());
        put_text(&mut record, name);
        put_text(&mut record, media_type);
        record.extend((data.len() as u64).to_le_bytes());
        record.extend(data);
        let crc = crc32fast::hash(&record);
        record.extend(crc.to_le_bytes());
        let at = self.offset;
        let length = self.put_record(op::ATTACHMENT, &record)?;
        let index = &mut Vec::new();
        index.extend(at.to_le_bytes());
        index.extend(length.to_le_bytes());
        index.extend(times.log.to_le_bytes());
        index.extend(times.publish.to_le_bytes());
        index.extend((data.len() as u64).to_le_bytes());
        put_text(index, name);
        put_text(index, media_type);
        append_record(&mut self.attachment_indexes, op::ATTACHMENT_INDEX, index);
        self.counts.attachments += 1;
        Ok(())
    }

    /// Writes the chunk gathered so far.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> io::Result<()> {
        let Some((first, last)) = self.chunk_times.take() else {
            return Ok(());
        };
        self.times = Some(match self.times {
            None => (first, last),
            Some((earlier, later)) => (earlier.min(first), later.max(last)),
        });
        self.packed.clear();
        self.packed
            .reserve(zstd::zstd_safe::compress_bound(self.chunk.len()));
        self.compressor
            .compress_to_buffer(&self.chunk, &mut self.packed)?;
        let mut head = Vec::new();
        head.extend(first.to_le_bytes());
        head.extend(last.to_le_bytes());
        head.extend((self.chunk.len() as u64).to_le_bytes());
        head.extend(crc32fast::hash(&self.chunk).to_le_bytes());
        put_text(&mut head, COMPRESSION);
        head.extend((self.packed.len() as u64).to_le_bytes());
        let at = self.offset;
        let packed = std::mem::take(&mut self.packed);
        self.put_head(op::CHUNK, head.len() + packed.len())?;
        self.put(&head)?;
        self.put(&packed)?;
        self.packed = packed;
        self.write_indexes(at, (first, last))?;
        self.counts.chunks += 1;
        self.chunk.clear();
        Ok(())
    }

    /// Where each message of the chunk that began at `at` is, and where that is said.
    fn write_indexes(&mut self, at: u64, (first, last): (u64, u64)) -> io::Result<()> {
        let chunk_length = self.offset - at;
        let indexes_at = self.offset;
        let mut places = Vec::new();
        let mut record = Vec::new();
        for id in 0..self.channels.len() {
            let index = std::mem::take(&mut self.channels[id].index);
            if index.is_empty() {
                continue;
            }
            record.clear();
            record.extend((id as u16).to_le_bytes());
            record.extend((index.len() as u32 * 16).to_le_bytes());
            for (log, place) in &index {
                record.extend(log.to_le_bytes());
                record.extend(place.to_le_bytes());
            }
            places.extend((id as u16).to_le_bytes());
            places.extend(self.offset.to_le_bytes());
            self.put_record(op::MESSAGE_INDEX, &record)?;
            self.channels[id].index = index;
            self.channels[id].index.clear();
        }
        let mut index = Vec::new();
        index.extend(first.to_le_bytes());
        index.extend(last.to_le_bytes());
        index.extend(at.to_le_bytes());
        index.extend(chunk_length.to_le_bytes());
        index.extend((places.len() as u32).to_le_bytes());
        index.extend(places);
        index.extend((self.offset - indexes_at).to_le_bytes());
        put_text(&mut index, COMPRESSION);
        index.extend((self.packed.len() as u64).to_le_bytes());
        index.extend((self.chunk.len() as u64).to_le_bytes());
        append_record(&mut self.chunk_indexes, op::CHUNK_INDEX, &index);
        Ok(())
    }

    /// Writes the summary and the end mark, and returns the output.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        let crc = self.crc.clone().finalize();
        self.put_record(op::DATA_END, &crc.to_le_bytes())?;
        self.crc = crc32fast::Hasher::new();
        let summary_at = self.offset;
        let groups = self.summary();
        let mut offsets = Vec::new();
        for (opcode, group) in groups {
            if group.is_empty() {
                continue;
            }
            let mut offset = vec![opcode];
            offset.extend(self.offset.to_le_bytes());
            offset.extend((group.len() as u64).to_le_bytes());
            append_record(&mut offsets, op::SUMMARY_OFFSET, &offset);
            self.put(&group)?;
        }
        let offsets_at = self.offset;
        self.put(&offsets)?;
        self.put_head(op::FOOTER, 8 + 8 + 4)?;
        self.put(&summary_at.to_le_bytes())?;
        self.put(&offsets_at.to_le_bytes())?;
        let crc = self.crc.clone().finalize();
        self.put(&crc.to_le_bytes())?;
        self.put(MAGIC)?;
        self.output.flush()?;
        Ok(self.output)
    }

    fn summary(&mut self) -> [(u8, Vec<u8>); 6] {
        let mut schemas = Vec::new();
        for schema in &self.schemas {
            append_record(&mut schemas, op::SCHEMA, schema);
        }
        let mut channels = Vec::new();
        let mut counts = Vec::new();
        for (id, channel) in self.channels.iter().enumerate() {
            append_record(&mut channels, op::CHANNEL, &channel.record);
            if channel.messages > 0 {
                counts.extend((id as u16).to_le_bytes());
                counts.extend(channel.messages.to_le_bytes());
            }
        }
        let (first, last) = self.times.unwrap_or_default();
        let mut record = Vec::new();
        record.extend(self.counts.messages.to_le_bytes());
        record.extend((self.schemas.len() as u16).to_le_bytes());
        record.extend((self.channels.len() as u32).to_le_bytes());
        record.extend(self.counts.attachments.to_le_bytes());
        record.extend(self.counts.metadata.to_le_bytes());
        record.extend(self.counts.chunks.to_le_bytes());
        record.extend(first.to_le_bytes());
        record.extend(last.to_le_bytes());
        record.extend((counts.len() as u32).to_le_bytes());
        record.extend(counts);
        let mut statistics = Vec::new();
        append_record(&mut statistics, op::STATISTICS, &record);
        [
            (op::SCHEMA, schemas),
            (op::CHANNEL, channels),
            (op::STATISTICS, statistics),
            (op::CHUNK_INDEX, std::mem::take(&mut self.chunk_indexes)),
            (
                op::ATTACHMENT_INDEX,
                std::mem::take(&mut self.attachment_indexes),
            ),
            (
                op::METADATA_INDEX,
                std::mem::take(&mut self.metadata_indexes),
            ),
        ]
    }

    /// Writes a record; returns its length with its head.
    fn put_record(&mut self, opcode: u8, body: &[u8]) -> io::Result<u64> {
        let at = self.offset;
        self.put_head(opcode, body.len())?;
        self.put(body)?;
        Ok(self.offset - at)
    }

    fn put_head(&mut self, opcode: u8, length: usize) -> io::Result<()> {
        self.put(&[opcode])?;
        self.put(&(length as u64).to_le_bytes())
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.offset += bytes.len() as u64;
        self.output.write_all(bytes)
    }
}

fn number(count: usize) -> io::Result<u16> {
    u16::try_from(count).map_err(|_| io::Error::other("more topics than an MCAP can hold"))
}

fn append_record(to: &mut Vec<u8>, opcode: u8, body: &[u8]) {
    to.push(opcode);
    to.extend((body.len() as u64).to_le_bytes());
    to.extend(body);
}

fn put_text(to: &mut Vec<u8>, text: &str) {
    to.extend((text.len() as u32).to_le_bytes());
    to.extend(text.as_bytes());
}

fn put_table(to: &mut Vec<u8>, table: &BTreeMap<String, String>) {
    let length: usize = table.iter().map(|(k, v)| 8 + k.len() + v.len()).sum();
    to.extend((length as u32).to_le_bytes());
    for (name, value) in table {
        put_text(to, name);
        put_text(to, value);
    }
}
