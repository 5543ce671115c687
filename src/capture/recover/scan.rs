//! What there is in an MCAP that may be damaged.

use std::collections::{BTreeMap, HashSet};
use std::path::Path;

use prost::Message;

use super::fill::{ChunkStart, StreamStart, event_key};
use super::{End, Missing, Outcome, Paths, Recovery, open};
use crate::capture::CaptureError;
use crate::capture::journal::Kind;
use crate::capture::messages::RawBytes;
use crate::capture::topics::Topic;
use crate::capture::walk::{Damage, Part};
use crate::capture::writer::records::{HEAD_BYTES, Reader, op};
use crate::capture::writer::{LIBRARY, next_record};

/// What there is in an MCAP.
#[derive(Debug, Default)]
pub(super) struct Scan {
    pub(super) library: String,
    pub(super) messages: u64,
    pub(super) chunks: u64,
    pub(super) rx_end: u64,
    pub(super) tx_end: u64,
    /// Of the chunks that hold and of the messages between them, in their order.
    pub(super) starts: Vec<ChunkStart>,
    /// What [`event_key`] says of the events in them.
    pub(super) events: HashSet<u64>,
    pub(super) missing: Vec<Missing>,
    pub(super) damage: Vec<Damage>,
    pub(super) topics: Topics,
    /// What holds has them.
    pub(super) has_channels: bool,
    pub(super) earliest_ns: u64,
}

impl Scan {
    pub(super) fn of(path: &Path) -> Result<Self, CaptureError> {
        let mut walker = open(path)?;
        let mut scan = Self::default();
        let read_error = |error| CaptureError::Read {
            path: path.to_owned(),
            error,
        };
        let mut stretches = Stretches::default();
        while let Some(part) = walker.next_part().map_err(read_error)? {
            if stretches.begins_with(&part, &scan.topics) {
                scan.starts.push(ChunkStart::END);
            }
            match part {
                Part::Record(op::HEADER, record) => {
                    let mut fields = Reader(&record[HEAD_BYTES..]);
                    if let (Some(_), Some(library)) = (fields.text(), fields.text()) {
                        library.clone_into(&mut scan.library);
                        scan.topics = Topics::of(library);
                    }
                }
                Part::Record(op::CHANNEL, record) => {
                    scan.topics.add(&record[HEAD_BYTES..]);
                    scan.has_channels = true;
                }
                Part::Record(opcode, record) => {
                    if let Some(message) = scan.topics.loose(opcode, record) {
                        scan.take(&message);
                    }
                }
                Part::Chunk(chunk) => {
                    scan.chunks += 1;
                    let mut topics = std::mem::take(&mut scan.topics);
                    topics.for_each_message(chunk.content, |message| scan.take(&message));
                    scan.topics = topics;
                    scan.has_channels |= has_channels(chunk.content);
                }
                Part::Damage(damage) => scan.damage.push(damage),
            }
        }
        scan.look_ahead();
        Ok(scan)
    }

    /// Whether nothing holds.
    pub(super) const fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    pub(super) fn take(&mut self, message: &Raw<'_>) {
        if self.messages == 0 {
            self.earliest_ns = message.log_time_ns;
        }
        self.messages += 1;
        let Some(chunk) = self.starts.last_mut() else {
            return;
        };
        chunk.at_ns = chunk.at_ns.min(message.log_time_ns);
        let (start, end) = match message.topic {
            Some(Topic::RawRx) => (&mut chunk.rx, &mut self.rx_end),
            Some(Topic::RawTx) => (&mut chunk.tx, &mut self.tx_end),
            Some(topic @ (Topic::Uplink | Topic::Log)) => {
                let kind = match topic {
                    Topic::Uplink => Kind::Uplink,
                    _ => Kind::Log,
                };
                let key = event_key(kind, message.log_time_ns, message.data);
                self.events.insert(key);
                return;
            }
            _ => return,
        };
        let Ok(raw) = RawBytes::decode(message.data) else {
            return;
        };
        if !start.is_here {
            *start = StreamStart {
                offset: raw.stream_offset,
                is_here: true,
            };
        }
        if raw.stream_offset > *end && message.topic == Some(Topic::RawRx) {
            self.missing.push(Missing {
                offset: *end,
                bytes: raw.stream_offset - *end,
            });
        }
        // Bytes that come twice take nothing back.
        *end = (*end).max(raw.stream_offset.saturating_add(raw.data.len() as u64));
    }

    /// Tells each chunk that has none of a stream where a later one goes on with it.
    fn look_ahead(&mut self) {
        let (mut rx, mut tx) = (StreamStart::END, StreamStart::END);
        for start in self.starts.iter_mut().rev() {
            for (here, later) in [(&mut start.rx, &mut rx), (&mut start.tx, &mut tx)] {
                if !here.is_here {
                    here.offset = later.offset;
                }
                *later = *here;
            }
        }
    }

    pub(super) fn report(self, paths: &Paths, outcome: Outcome) -> Recovery {
        Recovery {
            path: paths.target.clone(),
            outcome,
            messages: self.messages,
            rx_bytes: self.rx_end - self.missing.iter().map(|m| m.bytes).sum::<u64>(),
            tx_bytes: self.tx_end,
            rx_missing: self.missing,
            chunks_kept: self.chunks,
            damage: self.damage,
            rx_from_journal: 0,
            journal_damaged_bytes: 0,
            end: End::Known,
            original: None,
            journal_kept: None,
        }
    }
}

/// Tells where a chunk begins, or messages that are in none.
#[derive(Default)]
pub(super) struct Stretches {
    /// The message before was in no chunk.
    is_loose: bool,
}

impl Stretches {
    pub(super) fn begins_with(&mut self, part: &Part<'_>, topics: &Topics) -> bool {
        let was_loose = self.is_loose;
        match part {
            Part::Chunk(_) => {
                self.is_loose = false;
                true
            }
            Part::Damage(_) => {
                self.is_loose = false;
                false
            }
            Part::Record(opcode, record) => {
                self.is_loose |= topics.loose(*opcode, record).is_some();
                self.is_loose && !was_loose
            }
        }
    }
}

/// A message.
pub(super) struct Raw<'a> {
    pub(super) channel_id: u16,
    pub(super) topic: Option<Topic>,
    pub(super) log_time_ns: u64,
    pub(super) publish_time_ns: u64,
    pub(super) data: &'a [u8],
}

/// Which topic a channel is.
#[derive(Debug)]
pub(super) enum Topics {
    /// Ours always have the same numbers, and need not be readable to be known.
    Fixed,
    /// As the channels say; of other people's there is only the number.
    Said(BTreeMap<u16, Option<Topic>>),
}

impl Default for Topics {
    fn default() -> Self {
        Self::Said(BTreeMap::new())
    }
}

impl Topics {
    pub(super) fn of(library: &str) -> Self {
        if library == LIBRARY {
            Self::Fixed
        } else {
            Self::default()
        }
    }

    /// Takes what a channel record says.
    pub(super) fn add(&mut self, body: &[u8]) {
        let Self::Said(topics) = self else {
            return;
        };
        let mut fields = Reader(body);
        if let (Some(id), Some(_), Some(name)) = (fields.u16(), fields.u16(), fields.text()) {
            topics.insert(id, Topic::from_name(name));
        }
    }

    pub(super) fn get(&self, channel_id: u16) -> Option<Topic> {
        match self {
            Self::Fixed => {
                let number = usize::from(channel_id).checked_sub(1)?;
                Topic::ALL.get(number).copied()
            }
            Self::Said(topics) => topics.get(&channel_id).copied().flatten(),
        }
    }

    /// The message that a record outside of chunks is; one without a channel is of no use to anybody.
    pub(super) fn loose<'a>(&self, opcode: u8, record: &'a [u8]) -> Option<Raw<'a>> {
        let body = record.get(HEAD_BYTES..).filter(|_| opcode == op::MESSAGE)?;
        let is_known = |message: &Raw<'_>| match self {
            Self::Fixed => message.topic.is_some(),
            Self::Said(topics) => topics.contains_key(&message.channel_id),
        };
        self.message(body).filter(is_known)
    }

    fn message<'a>(&self, body: &'a [u8]) -> Option<Raw<'a>> {
        let mut fields = Reader(body);
        let (channel_id, _sequence) = (fields.u16()?, fields.u32()?);
        Some(Raw {
            channel_id,
            topic: self.get(channel_id),
            log_time_ns: fields.u64()?,
            publish_time_ns: fields.u64()?,
            data: fields.0,
        })
    }

    pub(super) fn for_each_message<'a>(
        &mut self,
        content: &'a [u8],
        mut take: impl FnMut(Raw<'a>),
    ) {
        let mut rest = Reader(content);
        while let Some((opcode, body)) = next_record(&mut rest) {
            if opcode == op::CHANNEL {
                self.add(body);
            } else if opcode == op::MESSAGE
                && let Some(message) = self.message(body)
            {
                take(message);
            }
        }
    }
}

fn has_channels(content: &[u8]) -> bool {
    let mut rest = Reader(content);
    std::iter::from_fn(|| next_record(&mut rest)).any(|(opcode, _)| opcode == op::CHANNEL)
}
