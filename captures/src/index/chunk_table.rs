//! Table of a recording's chunks: offset, time, and number of earlier messages of each.

use std::collections::BTreeMap;

use ::mcap::records::ChunkIndex;

use crate::event::Landmark;
use crate::mcap_reader::Channel;
use crate::record::HEAD_BYTES;
use crate::topics::Topic;

/// Length of the channel number and the length field before the entries of a message index, bytes.
const INDEX_HEAD_BYTES: u64 = 2 + 4;

/// Length of an entry of a message index (log time and offset), bytes.
const ENTRY_BYTES: u64 = 16;

/// Message counts (lines, commands and bumps), found without reading the messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    /// Number of intact lines, acknowledgement lines among them.
    pub(super) lines: u64,
    /// Number of messages about commands; `None` if the recording has no such topic but may have commands.
    uplinks: Option<u64>,
    /// Number of messages about bumps; `None` if the recording has no such topic but may have bumps.
    logs: Option<u64>,
}

impl Counts {
    const ZERO: Self = Self {
        lines: 0,
        uplinks: Some(0),
        logs: Some(0),
    };

    /// Adds counts, saturating because a damaged index may contain any number.
    fn add(&mut self, other: Self) {
        let sum = |one: Option<u64>, other: Option<u64>| Some(one?.saturating_add(other?));
        self.lines = self.lines.saturating_add(other.lines);
        self.uplinks = sum(self.uplinks, other.uplinks);
        self.logs = sum(self.logs, other.logs);
    }
}

/// A chunk of the table, or a record outside of chunks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// First log time, nanoseconds.
    pub(super) start_ns: u64,
    /// Offset in the file.
    pub(super) offset: u64,
    /// Number of messages before the entry.
    pub(super) before: Counts,
    /// Offset in the file of the message index of its lines; 0 if there is none.
    pub(super) lines_at: u64,
}

/// Chunks in order of time.
#[derive(Clone, Debug)]
pub(super) struct ChunkTable {
    entries: Vec<Entry>,
    counts: Counts,
    /// Whether the numbers of messages of all chunks are known.
    are_counted: bool,
    ids: Ids,
}

impl Default for ChunkTable {
    fn default() -> Self {
        Self {
            entries: Vec::new(),
            counts: Counts::ZERO,
            are_counted: true,
            ids: Ids::default(),
        }
    }
}

impl ChunkTable {
    /// Adds a channel that a summary lists before the chunks.
    pub(super) fn know(&mut self, id: u16, channel: &Channel) {
        let known = match channel.ours {
            Some(Topic::RawRx) => &mut self.ids.received,
            Some(Topic::Telemetry) => &mut self.ids.lines,
            Some(Topic::Uplink) => &mut self.ids.uplinks,
            Some(Topic::Log) => &mut self.ids.logs,
            _ => return,
        };
        known.get_or_insert(id);
    }

    /// Adds the next chunk that a summary lists.
    pub(super) fn add(&mut self, index: &ChunkIndex) {
        // A chunk without messages has no time.
        if index.message_end_time == 0 {
            return;
        }
        let ids = self.ids;
        let lines_at = ids
            .counted_lines()
            .and_then(|id| index.message_index_offsets.get(&id));
        self.entries.push(Entry {
            start_ns: index.message_start_time,
            offset: index.chunk_start_offset,
            before: self.counts,
            lines_at: lines_at.map_or(0, |at| *at),
        });
        let counts = counts(index, ids);
        self.are_counted &= counts.is_some();
        self.counts.add(counts.unwrap_or(Counts::ZERO));
    }

    /// Adds a record by its first log time, nanoseconds, and its offset in the file. Its messages are not counted.
    pub(super) fn add_uncounted(&mut self, start_ns: u64, offset: u64) {
        self.are_counted = false;
        self.entries.push(Entry {
            start_ns,
            offset,
            before: self.counts,
            lines_at: 0,
        });
    }

    /// The last entry.
    pub(super) fn last(&self) -> Option<&Entry> {
        self.entries.last()
    }

    /// The last entry that begins before a log time, nanoseconds.
    pub(super) fn before(&self, at_ns: u64) -> Option<&Entry> {
        let after = self.entries.partition_point(|entry| entry.start_ns < at_ns);
        self.entries.get(after.checked_sub(1)?)
    }

    /// The chunk with line `number`, from 1; `None` if lines are not counted or there are fewer.
    pub(super) fn of_line(&self, number: u64) -> Option<&Entry> {
        let fewer = |entry: &Entry| entry.before.lines < number;
        let after = self.entries.partition_point(fewer);
        let is_there = self.are_counted && self.counts.lines >= number;
        self.entries.get(after.checked_sub(1).filter(|_| is_there)?)
    }

    /// Whether there may be a landmark of a kind between two log times, both included.
    pub(super) fn may_hold(&self, landmark: Landmark, from_ns: u64, until_ns: u64) -> bool {
        let count = |counts: Counts| match landmark {
            // Each of these landmarks has a message.
            Landmark::Bump => counts.logs,
            Landmark::Command => counts.uplinks,
            // These landmarks have no topic with one message each.
            Landmark::Line | Landmark::Alarm | Landmark::Behaviour | Landmark::Marker => None,
        };
        let later = self
            .entries
            .partition_point(|entry| entry.start_ns <= until_ns);
        // The end of a damaged recording may contain more than its last chunk declares.
        let Some(after) = self.entries.get(later).filter(|_| self.are_counted) else {
            return true;
        };
        let before = self.before(from_ns);
        let before = before.map_or(Counts::ZERO, |entry| entry.before);
        match (count(before), count(after.before)) {
            (Some(before), Some(after)) => after > before,
            _ => true,
        }
    }
}

/// Channels whose messages are counted.
#[derive(Clone, Copy, Debug, Default)]
struct Ids {
    received: Option<u16>,
    lines: Option<u16>,
    uplinks: Option<u16>,
    logs: Option<u16>,
}

impl Ids {
    /// The channel of lines in a recording of received bytes.
    fn counted_lines(&self) -> Option<u16> {
        self.lines.filter(|_| self.received.is_some())
    }
}

/// Number of messages in a chunk, from the lengths of its message indexes; each index ends where the next begins.
/// `None` if the summary lacks them.
fn counts(index: &ChunkIndex, ids: Ids) -> Option<Counts> {
    let mut indexes: BTreeMap<u64, u16> = BTreeMap::new();
    for (id, at) in &index.message_index_offsets {
        indexes.insert(*at, *id);
    }
    let chunk_end = index.chunk_start_offset.checked_add(index.chunk_length)?;
    let end = chunk_end.checked_add(index.message_index_length)?;
    let ends = indexes.keys().copied().skip(1).chain([end]);
    let mut counts = Counts {
        lines: ids.counted_lines().map(|_| 0)?,
        uplinks: ids.uplinks.map(|_| 0),
        logs: ids.logs.map(|_| 0),
    };
    for ((at, id), end) in indexes.iter().zip(ends) {
        let bytes = end.checked_sub(*at)?.checked_sub(HEAD_BYTES as u64)?;
        let messages = bytes.saturating_sub(INDEX_HEAD_BYTES) / ENTRY_BYTES;
        if ids.lines == Some(*id) {
            counts.lines = messages;
        } else if ids.uplinks == Some(*id) {
            counts.uplinks = Some(messages);
        } else if ids.logs == Some(*id) {
            counts.logs = Some(messages);
        }
    }
    (!indexes.is_empty()).then_some(counts)
}
