//! Reads the MCAP form of a capture from its front, every checksum on the way.

use std::collections::{BTreeMap, HashMap};
use std::fmt::{Display, Write as _};
use std::io::{self, Read};
use std::time::Duration;

use ::mcap::parse_record;
use ::mcap::records::{MessageHeader, Record, op};
use foxglove::messages::Log;
use prost::Message as _;

use super::composer::Session;
use super::messages::RawBytes;
use super::schema::Schema;
use super::source::Chunk;
use super::topics::is_loss_of_link;
use super::topics::{RAW_RX, RAW_TX, Topic};
use super::walk::{Damage, Step, Walker};
use crate::statistics::Uplink;

/// Why an MCAP could not be read whole.
#[derive(Debug, thiserror::Error)]
pub enum McapProblem {
    /// The operating system.
    #[error(transparent)]
    Read(#[from] io::Error),
    /// The file ends before its end mark.
    #[error("the file ends in the middle")]
    Unfinished,
    /// A checksum or the structure does not hold somewhere.
    #[error("{0}")]
    Damaged(String),
    /// No channel of raw bytes.
    #[error("there is no channel {RAW_RX}")]
    NoRawBytes,
}

/// A topic of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Its name.
    pub topic: String,
    /// The name of its messages' type; empty where it has no schema.
    pub schema: String,
}

/// The next thing in a recording.
#[derive(Debug)]
pub enum Entry<'a> {
    /// A message.
    Message {
        /// Of which topic.
        channel: &'a Channel,
        /// Its times and its number.
        header: MessageHeader,
        /// What it says, encoded.
        data: &'a [u8],
    },
    /// Any other record of the file; those after [`op::DATA_END`] belong to the summary.
    Other {
        /// What kind.
        opcode: u8,
        /// The rest of it.
        body: &'a [u8],
    },
    /// Something was skipped.
    Damage(Damage),
}

/// The entries of a recording, in the order of the file.
pub struct Entries<R> {
    walker: Walker<R>,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Channel>,
    is_damaged: bool,
}

impl<R: Read> Entries<R> {
    /// From the beginning of `source`.
    pub fn new(source: R) -> Self {
        Self {
            walker: Walker::new(source),
            schemas: HashMap::new(),
            channels: HashMap::new(),
            is_damaged: false,
        }
    }

    /// The next entry; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn next_entry(&mut self) -> io::Result<Option<Entry<'_>>> {
        let Some(step) = self.walker.next_step()? else {
            return Ok(None);
        };
        let (opcode, body) = match step {
            Step::Damage(damage) => {
                self.is_damaged = true;
                return Ok(Some(Entry::Damage(damage)));
            }
            Step::Record { opcode, body } => (opcode, body),
        };
        match opcode {
            op::SCHEMA => {
                if let Ok(Record::Schema { header, .. }) = parse_record(opcode, body) {
                    self.schemas.insert(header.id, header.name);
                }
            }
            op::CHANNEL => {
                if let Ok(Record::Channel(channel)) = parse_record(opcode, body) {
                    let schema = self.schemas.get(&channel.schema_id);
                    let schema = schema.cloned().unwrap_or_default();
                    let topic = channel.topic;
                    self.channels.insert(channel.id, Channel { topic, schema });
                }
            }
            op::MESSAGE => {
                if self.is_damaged && self.channels.is_empty() {
                    self.channels = usual_channels();
                }
                if let Some((header, data)) = message(body)
                    && let Some(channel) = self.channels.get(&header.channel_id)
                {
                    return Ok(Some(Entry::Message {
                        channel,
                        header,
                        data,
                    }));
                }
            }
            _ => {}
        }
        Ok(Some(Entry::Other { opcode, body }))
    }

    /// The topics met so far.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.values()
    }

    /// Whether the file had its end mark; known at the end.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.walker.is_finished()
    }
}

/// The topics of a recording whose own list of them is damaged: their numbers are always the same.
fn usual_channels() -> HashMap<u16, Channel> {
    let channel = |topic: Topic| {
        let channel = Channel {
            topic: topic.name().to_owned(),
            schema: topic.schema().name.into_owned(),
        };
        (topic as u16 + 1, channel)
    };
    Topic::ALL.into_iter().map(channel).collect()
}

/// A message record: its header has a fixed length.
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

/// Damaged places that are told one by one; of more there is the number.
const PLACES_TOLD: usize = 3;

/// The damaged places of a recording, in a few words.
#[derive(Clone, Debug, Default)]
pub struct Damages {
    count: usize,
    first: Vec<String>,
}

impl Damages {
    /// One more.
    pub fn push(&mut self, damage: impl Display) {
        self.count += 1;
        if self.first.len() < PLACES_TOLD {
            self.first.push(damage.to_string());
        }
    }

    /// Whether there are none.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// All of them in one line.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = self.first.join("; ");
        if self.count > self.first.len() {
            // A string takes everything.
            let _ = write!(words, "; and {} more places", self.count - self.first.len());
        }
        words
    }
}

/// Reads `/raw/rx` from a recording, and what `/raw/tx` says beside it.
///
/// Damaged parts are skipped: their bytes are counted as missing, and at the end it is told what they
/// were.
pub struct McapReader<R> {
    entries: Entries<R>,
    start_ns: Option<u64>,
    current: RawBytes,
    next_offset: u64,
    missing_bytes: u64,
    is_interrupted: bool,
    session: BTreeMap<String, String>,
    uplink: Uplink,
    damages: Damages,
    has_told: bool,
}

impl<R: Read> McapReader<R> {
    /// A reader from the beginning of `source`.
    pub fn new(source: R) -> Self {
        Self {
            entries: Entries::new(source),
            start_ns: None,
            current: RawBytes::default(),
            next_offset: 0,
            missing_bytes: 0,
            is_interrupted: false,
            session: BTreeMap::new(),
            uplink: Uplink::default(),
            damages: Damages::default(),
            has_told: false,
        }
    }

    /// The next bytes, and when they were read, counted from the first message of the recording.
    ///
    /// # Errors
    /// When the source cannot be read; and once, when everything else has been read, what was damaged or
    /// that the end is missing.
    pub fn next_chunk(&mut self) -> Result<Option<Chunk<'_>>, McapProblem> {
        while let Some(entry) = self.entries.next_entry()? {
            let (channel, header, data) = match entry {
                Entry::Damage(damage) => {
                    self.damages.push(damage);
                    self.is_interrupted = true;
                    continue;
                }
                Entry::Other { opcode, body } => {
                    if opcode == op::METADATA
                        && let Ok(Record::Metadata(table)) = parse_record(opcode, body)
                        && table.name == Session::TABLE
                    {
                        self.session = table.metadata;
                    }
                    continue;
                }
                Entry::Message {
                    channel,
                    header,
                    data,
                } => (channel, header, data),
            };
            let start_ns = *self.start_ns.get_or_insert(header.log_time);
            if channel.topic == RAW_TX {
                match RawBytes::decode(data) {
                    Ok(sent) => {
                        let at = Duration::from_nanos(header.log_time);
                        self.uplink.take(at, &sent.data);
                    }
                    Err(error) => self.damages.push(format_args!("{RAW_TX}: {error}")),
                }
            }
            if channel.topic == Topic::Log.name() {
                self.is_interrupted |= Log::decode(data).is_ok_and(|log| is_loss_of_link(&log));
            }
            if channel.topic != RAW_RX {
                continue;
            }
            if channel.schema != RawBytes::NAME {
                return Err(McapProblem::NoRawBytes);
            }
            let bytes = match RawBytes::decode(data) {
                Ok(bytes) => bytes,
                Err(error) => {
                    self.damages.push(format_args!("{RAW_RX}: {error}"));
                    continue;
                }
            };
            let Some(step) = bytes.stream_offset.checked_sub(self.next_offset) else {
                let offset = bytes.stream_offset;
                let problem = format_args!("{RAW_RX}: the bytes at {offset} come twice");
                self.damages.push(problem);
                continue;
            };
            self.missing_bytes += step;
            let is_interrupted = std::mem::take(&mut self.is_interrupted) || step > 0;
            self.next_offset = bytes.stream_offset.saturating_add(bytes.data.len() as u64);
            self.current = bytes;
            return Ok(Some(Chunk {
                at: Duration::from_nanos(header.log_time.saturating_sub(start_ns)),
                bytes: &self.current.data,
                is_interrupted,
            }));
        }
        if std::mem::replace(&mut self.has_told, true) {
            return Ok(None);
        }
        if !self.damages.is_empty() {
            return Err(McapProblem::Damaged(self.damages.in_words()));
        }
        if !self.entries.is_finished() {
            return Err(McapProblem::Unfinished);
        }
        if !self.entries.channels().any(|c| c.topic == RAW_RX) {
            return Err(McapProblem::NoRawBytes);
        }
        Ok(None)
    }

    /// What was sent up to the bytes read last.
    #[must_use]
    pub const fn uplink(&self) -> &Uplink {
        &self.uplink
    }

    /// What the recording says of itself, as far as it has been read: its link, its start, the software.
    #[must_use]
    pub const fn session(&self) -> &BTreeMap<String, String> {
        &self.session
    }

    /// Bytes of the stream before the ones read last that are not in the recording.
    #[must_use]
    pub const fn missing_bytes(&self) -> u64 {
        self.missing_bytes
    }
}
