//! Writes captures in the MCAP form: <https://mcap.dev/spec>.
//!
//! The `mcap` crate's own writer hands the compressor each message in five small pieces, which takes
//! most of the time of a conversion, and cannot take over a chunk as it is, which recovery needs. This
//! one compresses whole chunks and copies others unread. Reading is the crate's business.

mod chunk;
mod group;
pub(super) mod records;

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::topics::{Topic, TopicMessage};
use chunk::Chunk;
use group::Group;
use records::{Fields, Reader, op, record};

/// Uncompressed bytes of a chunk: some ten minutes. Seeking has to decompress one; a quarter of it would make the file of a
/// day 5 per cent larger.
const CHUNK_BYTES: usize = 1024 * 1024;

/// What a file says wrote it, if its topics have the numbers that they always have here.
pub(super) const LIBRARY: &str =
    concat!("groundwave ", env!("CARGO_PKG_VERSION"), ", fixed topics");

/// Whether that says a version of ours, whichever.
pub(super) fn has_fixed_topics(library: &str) -> bool {
    library.starts_with("groundwave ") && library.ends_with(", fixed topics")
}

/// Writes a recording to anything that takes bytes.
///
/// A chunk and its index go out in one write, and a flushed recording can be read up to the flush by
/// tools that read from the front, however it ends. What is held in memory is the chunk being filled
/// and about 170 bytes for each chunk written.
pub struct McapWriter<W> {
    output: Output<W>,
    chunk: Chunk,
    /// Uncompressed, at which a chunk ends.
    chunk_bytes: usize,
    /// One after the other, as they stand in the data section and again in the summary.
    schemas: Group,
    channels: Group,
    /// By topic: the sequence of its next message.
    sequences: [u32; Topic::ALL.len()],
    chunk_indexes: Group,
    attachment_indexes: Group,
    metadata_indexes: Group,
    /// By channel, in the chunks written.
    messages: BTreeMap<u16, u64>,
    /// Of all messages.
    bounds_ns: Option<(u64, u64)>,
    /// What goes out next; kept for its memory.
    scratch: Vec<u8>,
}

/// An attachment: a file within the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attachment<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it is: `application/json`.
    pub media_type: &'a str,
    /// When it was made, nanoseconds since 1970.
    pub time_ns: u64,
    /// What is in it.
    pub data: &'a [u8],
}

/// A chunk of another recording, whose checksum was found to hold.
#[derive(Clone, Copy, Debug)]
pub(super) struct CheckedChunk<'a> {
    /// The whole record.
    pub(super) record: &'a [u8],
    pub(super) compression: &'a str,
    pub(super) compressed_bytes: u64,
    /// What it says when it is decompressed.
    pub(super) content: &'a [u8],
}

impl<W: Write> McapWriter<W> {
    /// Begins a recording with every topic there is, so that a reader knows them from the start. They are
    /// part of the first chunk, whose checksum covers them.
    ///
    /// # Errors
    /// When writing fails.
    pub fn new(output: W) -> io::Result<Self> {
        let mut writer = Self::empty(output, LIBRARY)?;
        writer.register_topics();
        Ok(writer)
    }

    /// Begins a copy of a recording, whose schemas and channels are still to come.
    pub(super) fn empty(output: W, library: &str) -> io::Result<Self> {
        let mut writer = Self {
            output: Output {
                inner: output,
                position: 0,
                crc: crc32fast::Hasher::new(),
            },
            chunk: Chunk::new()?,
            chunk_bytes: CHUNK_BYTES,
            schemas: Group::default(),
            channels: Group::default(),
            sequences: [0; Topic::ALL.len()],
            chunk_indexes: Group::default(),
            attachment_indexes: Group::default(),
            metadata_indexes: Group::default(),
            messages: BTreeMap::new(),
            bounds_ns: None,
            scratch: Vec::new(),
        };
        writer.scratch.extend(::mcap::MAGIC);
        record(&mut writer.scratch, op::HEADER, |to| {
            to.text("");
            to.text(library);
        });
        writer.output.write(&mut writer.scratch)?;
        Ok(writer)
    }

    /// Ends chunks at so many uncompressed bytes from now on.
    pub(super) const fn limit_chunks(&mut self, bytes: usize) {
        self.chunk_bytes = bytes;
    }

    /// Adds every topic of ours, under the numbers that it always has.
    pub(super) fn register_topics(&mut self) {
        let mut known: Vec<(String, u16)> = Vec::new();
        for topic in Topic::ALL {
            let schema = topic.schema();
            let id = topic as u16 + 1;
            let first = known.iter().find(|(name, _)| *name == schema.name);
            let schema_id = if let Some((_, schema_id)) = first {
                *schema_id
            } else {
                let mut bytes = Vec::new();
                record(&mut bytes, op::SCHEMA, |to| {
                    to.u16(id);
                    to.text(&schema.name);
                    to.text("protobuf");
                    to.bytes(&schema.descriptors);
                });
                self.add_schema(&bytes);
                known.push((schema.name.into_owned(), id));
                id
            };
            let mut bytes = Vec::new();
            record(&mut bytes, op::CHANNEL, |to| {
                to.u16(id);
                to.u16(schema_id);
                to.text(topic.name());
                to.text("protobuf");
                to.map(&BTreeMap::new());
            });
            self.add_channel(&bytes);
        }
    }

    /// Adds a schema record, to the chunk being filled and the summary.
    pub(super) fn add_schema(&mut self, record: &[u8]) {
        self.chunk.add_record(record);
        self.schemas.add_new(record);
    }

    /// Adds a channel record likewise.
    pub(super) fn add_channel(&mut self, record: &[u8]) {
        self.chunk.add_record(record);
        self.channels.add_new(record);
    }

    /// Adds schema and channel records before everything else and in no chunk: one without messages would have no index.
    pub(super) fn declare(&mut self, schemas: &[Vec<u8>], channels: &[Vec<u8>]) -> io::Result<()> {
        for schema in schemas {
            self.schemas.add_new(schema);
        }
        for channel in channels {
            self.channels.add_new(channel);
        }
        for record in schemas.iter().chain(channels) {
            self.scratch.extend_from_slice(record);
        }
        self.output.write(&mut self.scratch)
    }

    /// Writes a message.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write(&mut self, message: &TopicMessage<'_>) -> io::Result<()> {
        let sequence = &mut self.sequences[message.topic as usize];
        let channel_id = message.topic as u16 + 1;
        self.chunk.add_message(
            channel_id,
            *sequence,
            message.log_time_ns,
            message.publish_time_ns,
            message.data,
        );
        *sequence = sequence.wrapping_add(1);
        if self.chunk.bytes() >= self.chunk_bytes {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// Writes a message of another recording, whose channels have been added; it is numbered anew.
    pub(super) fn copy_message(
        &mut self,
        channel_id: u16,
        log_time_ns: u64,
        publish_time_ns: u64,
        data: &[u8],
    ) -> io::Result<()> {
        let earlier = self.messages.get(&channel_id).copied().unwrap_or_default();
        let sequence = (earlier + self.chunk.count(channel_id)) as u32;
        self.chunk
            .add_message(channel_id, sequence, log_time_ns, publish_time_ns, data);
        if self.chunk.bytes() >= self.chunk_bytes {
            self.end_chunk()?;
        }
        Ok(())
    }

    /// Takes over a chunk of another recording as it is: compressed, unread but for its index.
    /// Schemas and channels that are new to this recording are added to the summary.
    pub(super) fn copy_chunk(&mut self, chunk: &CheckedChunk<'_>) -> io::Result<()> {
        self.end_chunk()?;
        let mut rest = Reader(chunk.content);
        while !rest.0.is_empty() {
            let offset = (chunk.content.len() - rest.0.len()) as u64;
            let start = rest.0;
            let Some((opcode, body)) = next_record(&mut rest) else {
                break;
            };
            let whole = &start[..start.len() - rest.0.len()];
            match opcode {
                op::SCHEMA => self.schemas.add_new(whole),
                op::CHANNEL => self.channels.add_new(whole),
                op::MESSAGE => {
                    let mut fields = Reader(body);
                    let (Some(channel_id), Some(sequence), Some(log_time_ns)) =
                        (fields.u16(), fields.u32(), fields.u64())
                    else {
                        continue;
                    };
                    self.chunk.note(channel_id, log_time_ns, offset);
                    let topic = usize::from(channel_id).checked_sub(1);
                    if let Some(next) = topic.and_then(|topic| self.sequences.get_mut(topic)) {
                        *next = sequence.wrapping_add(1);
                    }
                }
                _ => {}
            }
        }
        self.count_messages();
        let written = self.chunk.write_copy(
            self.output.position,
            chunk.record,
            chunk.compression,
            (chunk.compressed_bytes, chunk.content.len() as u64),
            &mut self.scratch,
            &mut self.chunk_indexes.records,
        );
        self.note_chunk(&written);
        self.output.write(&mut self.scratch)
    }

    /// Writes a table of names and values about the recording.
    ///
    /// # Errors
    /// When writing fails.
    pub fn write_metadata(
        &mut self,
        name: &str,
        metadata: &BTreeMap<String, String>,
    ) -> io::Result<()> {
        self.end_chunk()?;
        let offset = self.output.position;
        record(&mut self.scratch, op::METADATA, |to| {
            to.text(name);
            to.map(metadata);
        });
        let length = self.scratch.len() as u64;
        record(
            &mut self.metadata_indexes.records,
            op::METADATA_INDEX,
            |to| {
                to.u64(offset);
                to.u64(length);
                to.text(name);
            },
        );
        self.metadata_indexes.count += 1;
        self.output.write(&mut self.scratch)
    }

    /// Writes an attachment.
    ///
    /// # Errors
    /// When writing fails.
    pub fn attach(&mut self, attachment: &Attachment<'_>) -> io::Result<()> {
        self.end_chunk()?;
        let Attachment {
            name,
            media_type,
            time_ns,
            data,
        } = *attachment;
        let offset = self.output.position;
        record(&mut self.scratch, op::ATTACHMENT, |to| {
            let start = to.len();
            to.u64(time_ns);
            to.u64(time_ns);
            to.text(name);
            to.text(media_type);
            to.u64(data.len() as u64);
            to.extend_from_slice(data);
            let crc = crc32fast::hash(&to[start..]);
            to.u32(crc);
        });
        let length = self.scratch.len() as u64;
        record(
            &mut self.attachment_indexes.records,
            op::ATTACHMENT_INDEX,
            |to| {
                to.u64(offset);
                to.u64(length);
                to.u64(time_ns);
                to.u64(time_ns);
                to.u64(data.len() as u64);
                to.text(name);
                to.text(media_type);
            },
        );
        self.attachment_indexes.count += 1;
        self.output.write(&mut self.scratch)
    }

    /// Closes the chunk being filled and hands it to the output.
    ///
    /// # Errors
    /// When writing fails.
    pub fn flush(&mut self) -> io::Result<()> {
        self.end_chunk()?;
        self.output.inner.flush()
    }

    /// Bytes handed to the output so far.
    #[must_use]
    pub const fn position(&self) -> u64 {
        self.output.position
    }

    /// Messages written so far.
    #[must_use]
    pub fn message_count(&self) -> u64 {
        self.messages.values().sum::<u64>() + self.chunk.messages()
    }

    /// The output.
    pub const fn get_ref(&self) -> &W {
        &self.output.inner
    }

    fn end_chunk(&mut self) -> io::Result<()> {
        if self.chunk.is_empty() {
            return Ok(());
        }
        self.count_messages();
        let written = self.chunk.write(
            self.output.position,
            &mut self.scratch,
            &mut self.chunk_indexes.records,
        )?;
        self.note_chunk(&written);
        self.output.write(&mut self.scratch)
    }

    /// Those of the chunk that is about to be written.
    fn count_messages(&mut self) {
        for (channel_id, count) in self.chunk.counts() {
            *self.messages.entry(channel_id).or_default() += count;
        }
    }

    fn note_chunk(&mut self, written: &chunk::Written) {
        self.chunk_indexes.count += 1;
        if written.messages > 0 {
            let (start_ns, end_ns) = self.bounds_ns.unwrap_or((u64::MAX, 0));
            self.bounds_ns = Some((start_ns.min(written.start_ns), end_ns.max(written.end_ns)));
        }
    }

    /// Writes the index and the statistics.
    ///
    /// # Errors
    /// When writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.end_chunk()?;
        let crc = self.output.crc.clone().finalize();
        record(&mut self.scratch, op::DATA_END, |to| to.u32(crc));
        self.output.write(&mut self.scratch)?;
        let summary = self.summary();
        self.scratch = summary;
        self.output.write(&mut self.scratch)?;
        self.output.inner.flush()?;
        Ok(self.output.inner)
    }

    /// Everything after the data section.
    fn summary(&self) -> Vec<u8> {
        let start = self.output.position;
        let mut summary = Vec::new();
        let mut offsets = Vec::new();
        let mut statistics = Group::default();
        self.write_statistics(&mut statistics.records);
        for (opcode, group) in [
            (op::SCHEMA, &self.schemas),
            (op::CHANNEL, &self.channels),
            (op::STATISTICS, &statistics),
            (op::CHUNK_INDEX, &self.chunk_indexes),
            (op::ATTACHMENT_INDEX, &self.attachment_indexes),
            (op::METADATA_INDEX, &self.metadata_indexes),
        ] {
            if group.records.is_empty() {
                continue;
            }
            let group_start = start + summary.len() as u64;
            summary.extend_from_slice(&group.records);
            record(&mut offsets, op::SUMMARY_OFFSET, |to| {
                to.push(opcode);
                to.u64(group_start);
                to.u64(group.records.len() as u64);
            });
        }
        let offset_start = start + summary.len() as u64;
        summary.extend_from_slice(&offsets);
        summary.push(op::FOOTER);
        summary.u64(20);
        summary.u64(start);
        summary.u64(offset_start);
        let crc = crc32fast::hash(&summary);
        summary.u32(crc);
        summary.extend(::mcap::MAGIC);
        summary
    }

    fn write_statistics(&self, to: &mut Vec<u8>) {
        let (start_ns, end_ns) = self.bounds_ns.unwrap_or_default();
        record(to, op::STATISTICS, |to| {
            to.u64(self.message_count());
            to.u16(self.schemas.count as u16);
            to.u32(self.channels.count);
            to.u32(self.attachment_indexes.count);
            to.u32(self.metadata_indexes.count);
            to.u32(self.chunk_indexes.count);
            to.u64(start_ns);
            to.u64(end_ns);
            to.u32((self.messages.len() * 10) as u32);
            for (channel_id, count) in &self.messages {
                to.u16(*channel_id);
                to.u64(*count);
            }
        });
    }
}

/// Opcode and content of the next record.
pub(super) fn next_record<'a>(rest: &mut Reader<'a>) -> Option<(u8, &'a [u8])> {
    let opcode = rest.u8()?;
    let length = usize::try_from(rest.u64()?).ok()?;
    Some((opcode, rest.take(length)?))
}

/// What takes the bytes, and what has to be known of them.
struct Output<W> {
    inner: W,
    position: u64,
    crc: crc32fast::Hasher,
}

impl<W: Write> Output<W> {
    /// Writes everything at one go and leaves the buffer empty.
    fn write(&mut self, bytes: &mut Vec<u8>) -> io::Result<()> {
        self.crc.update(bytes);
        self.position += bytes.len() as u64;
        let result = self.inner.write_all(bytes);
        bytes.clear();
        result
    }
}
