//! What there is in an MCAP that may be damaged.

use std::collections::HashSet;
use std::path::Path;

use prost::Message;

use super::channels::{Declared, Raw, Topics, has_channels};
use super::fill::{ChunkStart, StreamStart, event_key};
use super::{End, Missing, Outcome, Paths, Recovery, open};
use crate::CaptureError;
use crate::journal::Kind;
use crate::messages::RawBytes;
use crate::topics::Topic;
use crate::walk::{Damage, Part, Step};
use crate::writer::LIBRARY;
use crate::writer::records::{HEAD_BYTES, Reader, op};

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
    /// The summary is damaged, or something follows the end mark.
    pub(super) bad_end: Option<Damage>,
    /// What holds declares channels.
    pub(super) has_channels: bool,
    /// What only the summary declares, and was needed.
    pub(super) declared: Declared,
    /// A message of a chunk that holds has no channel.
    pub(super) has_nameless: bool,
    /// A message in no chunk has none; what stands there may be damaged.
    has_strays: bool,
    pub(super) earliest_ns: u64,
}

impl Scan {
    pub(super) fn of(path: &Path) -> Result<Self, CaptureError> {
        let scan = Self::walk(path, Self::default())?;
        if !scan.has_nameless && !scan.has_strays {
            return Ok(scan);
        }
        let declared = Declared::in_summary(path)?;
        // Without its beginning a file does not say whose it is. Most are ours.
        let is_ours = scan.library.is_empty() && !scan.has_channels && declared.is_empty();
        let library = if is_ours { LIBRARY } else { "" };
        let known = Self {
            library: library.to_owned(),
            declared,
            ..Self::default()
        };
        Self::walk(path, known)
    }

    /// The topics that need no chunk to be known.
    pub(super) fn known_topics(&self) -> Topics {
        let mut topics = Topics::of(&self.library);
        for record in self.declared.channels() {
            topics.add(&record[HEAD_BYTES..]);
        }
        topics
    }

    fn walk(path: &Path, mut scan: Self) -> Result<Self, CaptureError> {
        let mut walker = open(path)?;
        let mut topics = scan.known_topics();
        let read_error = |error| CaptureError::Read {
            path: path.to_owned(),
            error,
        };
        let mut stretches = Stretches::default();
        while let Some(part) = walker.next_part().map_err(read_error)? {
            if stretches.begins_with(&part, &topics) {
                scan.starts.push(ChunkStart::END);
            }
            match part {
                Part::Record(op::HEADER, record) => {
                    let mut fields = Reader(&record[HEAD_BYTES..]);
                    if let (Some(_), Some(library)) = (fields.text(), fields.text()) {
                        library.clone_into(&mut scan.library);
                        topics = scan.known_topics();
                    }
                }
                Part::Record(op::CHANNEL, record) => {
                    topics.add(&record[HEAD_BYTES..]);
                    scan.has_channels = true;
                }
                Part::Record(opcode, record) => match topics.loose(opcode, record) {
                    Some(message) => scan.take(&message),
                    None => scan.has_strays |= opcode == op::MESSAGE,
                },
                Part::Chunk(chunk) => {
                    scan.chunks += 1;
                    topics.for_each_message(chunk.content, |message| scan.take(&message));
                    scan.has_channels |= has_channels(chunk.content);
                }
                Part::Damage(damage) => scan.damage.push(damage),
            }
        }
        // What the summary lacks is made anew; its end has to be that of the file.
        while let Some(step) = walker.next_step().map_err(read_error)? {
            if let Step::Damage(damage) = step {
                scan.bad_end = Some(damage);
            }
        }
        scan.look_ahead();
        Ok(scan)
    }

    /// Whether nothing holds.
    pub(super) const fn is_empty(&self) -> bool {
        self.starts.is_empty()
    }

    fn take(&mut self, message: &Raw<'_>) {
        self.has_nameless |= !message.has_channel;
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
            Some(Topic::Station) => {
                let key = event_key(Kind::Event, message.log_time_ns, message.data);
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
