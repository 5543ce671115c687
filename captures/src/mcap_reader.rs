//! Reads the messages of an MCAP file in file order, skipping damaged parts.

use std::collections::BTreeMap;
use std::fmt::{Display, Write as _};
use std::io::{self, Read};

use ::mcap::records::{MessageHeader, Record, op};

use super::record::parse;
use super::repair::{Damage, Part, Position, RepairingReader};
use super::topics::Topic;

/// Maximum accepted length of a topic or schema name, bytes.
const NAME_BYTES_MAX: usize = 256;

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name.
    pub topic: String,
    /// Type name of the messages; empty if the channel has no schema.
    pub schema: String,
    /// Groundwave's topic with this name and schema, if there is one.
    pub ours: Option<Topic>,
}

impl Channel {
    fn new(topic: String, schema: String) -> Self {
        let ours = Topic::from_name(&topic).filter(|ours| ours.schema().name == schema);
        Self {
            topic,
            schema,
            ours,
        }
    }
}

/// Channels by their numbers.
pub type Channels = BTreeMap<u16, Channel>;

/// The next part of a recording.
#[derive(Debug)]
pub enum Entry<'a> {
    /// A message.
    Message {
        /// Topic of the message.
        channel: &'a Channel,
        /// Times and number of the message.
        header: MessageHeader,
        /// Encoded content of the message.
        data: &'a [u8],
    },
    /// Any other record; records after [`op::DATA_END`] belong to the summary.
    Other {
        /// Opcode of the record.
        opcode: u8,
        /// The record after its length.
        body: &'a [u8],
    },
    /// A part that was skipped.
    Damage(Damage),
}

/// Reads the entries of a recording in file order.
pub struct Entries<R> {
    reader: RepairingReader<R>,
    schemas: BTreeMap<u16, String>,
    channels: Channels,
    is_damaged: bool,
    /// Whether another program wrote the recording, so that channel numbers differ from Groundwave's.
    is_foreign: bool,
}

impl<R: Read> Entries<R> {
    /// Reads from the beginning of `source`.
    pub fn new(source: R) -> Self {
        Self::of_channels(source, Channels::new())
    }

    /// Reads from the beginning of `source`, whose channels are known.
    pub(crate) fn of_channels(source: R, channels: Channels) -> Self {
        Self::of(RepairingReader::new(source), channels)
    }

    /// Continues reading at a position, with the channels known there; `source` begins at its offset.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn resume(source: R, position: Position, channels: Channels) -> io::Result<Self> {
        Ok(Self::of(
            RepairingReader::resume(source, position)?,
            channels,
        ))
    }

    const fn of(reader: RepairingReader<R>, channels: Channels) -> Self {
        Self {
            reader,
            schemas: BTreeMap::new(),
            channels,
            is_damaged: false,
            is_foreign: false,
        }
    }

    /// The next entry; `None` at the end.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub fn next_entry(&mut self) -> io::Result<Option<Entry<'_>>> {
        let Some(part) = self.reader.next_part()? else {
            return Ok(None);
        };
        let (opcode, body) = match part {
            Part::Damage(damage) => {
                self.is_damaged = true;
                return Ok(Some(Entry::Damage(damage)));
            }
            Part::Record { opcode, body } => (opcode, body),
        };
        match opcode {
            op::MESSAGE => {
                if let Some((header, data)) = message(body) {
                    let id = header.channel_id;
                    if self.is_damaged
                        && !self.is_foreign
                        && !self.channels.contains_key(&id)
                        && let Some(channel) = usual_channel(id)
                    {
                        self.channels.insert(id, channel);
                    }
                    if let Some(channel) = self.channels.get(&id) {
                        return Ok(Some(Entry::Message {
                            channel,
                            header,
                            data,
                        }));
                    }
                }
            }
            op::HEADER | op::SCHEMA | op::CHANNEL => match parse(opcode, body) {
                Some(Record::Header(header)) => {
                    self.is_foreign = !header.library.starts_with("groundwave ");
                }
                Some(Record::Schema { header, .. }) if header.name.len() <= NAME_BYTES_MAX => {
                    self.schemas.insert(header.id, header.name);
                }
                Some(Record::Channel(channel)) if channel.topic.len() <= NAME_BYTES_MAX => {
                    let schema = self.schemas.get(&channel.schema_id);
                    let schema = schema.cloned().unwrap_or_default();
                    let known = Channel::new(channel.topic, schema);
                    self.channels.insert(channel.id, known);
                }
                _ => {}
            },
            _ => {}
        }
        Ok(Some(Entry::Other { opcode, body }))
    }

    /// The channels found so far.
    pub const fn channels(&self) -> &Channels {
        &self.channels
    }

    /// Position of the next entry.
    #[must_use]
    pub fn position(&self) -> Position {
        self.reader.position()
    }

    /// Offset in the file of the latest entry's record, or of its chunk.
    #[must_use]
    pub const fn part_offset(&self) -> u64 {
        self.reader.part_offset()
    }

    /// Whether the file ends in the middle of a record; known at the end.
    #[must_use]
    pub const fn is_torn(&self) -> bool {
        self.reader.is_torn()
    }

    /// Whether the file has its end mark; known at the end.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.reader.is_finished()
    }
}

/// The channel with this number in recordings of Groundwave.
fn usual_channel(id: u16) -> Option<Channel> {
    let topic = *Topic::ALL.get(usize::from(id.checked_sub(1)?))?;
    let schema = topic.schema().name.into_owned();
    Some(Channel::new(topic.name().to_owned(), schema))
}

/// The header and data of a message record.
fn message(body: &[u8]) -> Option<(MessageHeader, &[u8])> {
    let (channel_id, rest) = body.split_first_chunk()?;
    let (sequence, rest) = rest.split_first_chunk()?;
    let (log_time, rest) = rest.split_first_chunk()?;
    let (publish_time, data) = rest.split_first_chunk()?;
    let header = MessageHeader {
        channel_id: u16::from_le_bytes(*channel_id),
        sequence: u32::from_le_bytes(*sequence),
        log_time: u64::from_le_bytes(*log_time),
        publish_time: u64::from_le_bytes(*publish_time),
    };
    Some((header, data))
}

/// Maximum number of damaged parts listed; more are only counted.
const PARTS_NAMED: usize = 3;

/// The damaged parts of a recording.
#[derive(Clone, Debug, Default)]
pub struct Damages {
    count: usize,
    first: Vec<String>,
}

impl Damages {
    /// Adds a damaged part.
    pub fn push(&mut self, damage: impl Display) {
        self.count += 1;
        if self.first.len() < PARTS_NAMED {
            self.first.push(damage.to_string());
        }
    }

    /// Whether there are no damaged parts.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// All of them in one line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = self.first.join("; ");
        if self.count > self.first.len() {
            // Writing to a string cannot fail.
            let _ = write!(words, "; and {} more places", self.count - self.first.len());
        }
        words
    }
}
