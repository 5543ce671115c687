//! What the summary of a recording says of a chunk: where it is, and how much of what it holds.

use std::collections::BTreeMap;

use super::block::Topic;
use crate::writer::records::{HEAD_BYTES, Reader};

/// Channel and length before the entries of a message index.
const INDEX_HEAD_BYTES: u64 = 2 + 4;

/// Log time and offset of a message.
const ENTRY_BYTES: u64 = 16;

/// The messages of a channel in a chunk.
pub(super) struct MessageIndex;

impl MessageIndex {
    /// How many there are in a record of so many bytes, without operation code and length.
    pub(super) const fn count(bytes: u64) -> u64 {
        bytes.saturating_sub(INDEX_HEAD_BYTES) / ENTRY_BYTES
    }

    /// The log time of the message of a number, from 1, and how many messages are earlier than that; the record is without
    /// operation code and length.
    pub(super) fn read(body: &[u8], number: u64) -> Option<(u64, u64)> {
        let mut fields = Reader(body);
        fields.u16()?;
        let mut entries = Reader(fields.bytes()?);
        let mut times_ns = Vec::new();
        while let (Some(at_ns), Some(_)) = (entries.u64(), entries.u64()) {
            times_ns.push(at_ns);
        }
        times_ns.sort_unstable();
        let place = usize::try_from(number.checked_sub(1)?).ok()?;
        let at_ns = *times_ns.get(place)?;
        let earlier = times_ns.partition_point(|time_ns| *time_ns < at_ns);
        Some((at_ns, earlier as u64))
    }
}

/// Messages of the topics that are counted without being read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Counts {
    /// Intact lines, those that only acknowledge among them.
    pub(super) lines: u64,
    /// `None` where the recording has no such topic: what it tells of may still have happened.
    pub(super) uplinks: Option<u64>,
    /// Likewise.
    pub(super) logs: Option<u64>,
}

impl Counts {
    /// None of any.
    pub(super) const ZERO: Self = Self {
        lines: 0,
        uplinks: Some(0),
        logs: Some(0),
    };

    /// Those of a chunk; `None` where its index does not tell, or not of which channel the topics are.
    pub(super) fn of(index: &ChunkIndex, topics: &BTreeMap<u16, Topic>) -> Option<Self> {
        let is_known = |topic| topics.values().any(|known| *known == topic);
        let are_known = is_known(Topic::Received) && is_known(Topic::Telemetry);
        let mut counts = Self {
            lines: 0,
            uplinks: is_known(Topic::Uplink).then_some(0),
            logs: is_known(Topic::Log).then_some(0),
        };
        for &(channel_id, messages) in index.messages.as_ref().filter(|_| are_known)? {
            let mut of_channel = Self::ZERO;
            match topics.get(&channel_id) {
                Some(Topic::Telemetry) => of_channel.lines = messages,
                Some(Topic::Uplink) => of_channel.uplinks = Some(messages),
                Some(Topic::Log) => of_channel.logs = Some(messages),
                Some(Topic::Received | Topic::Sent) | None => {}
            }
            counts.add(of_channel);
        }
        Some(counts)
    }

    /// A damaged index may say anything.
    pub(super) fn add(&mut self, other: Self) {
        let sum = |one: Option<u64>, other: Option<u64>| Some(one?.saturating_add(other?));
        self.lines = self.lines.saturating_add(other.lines);
        self.uplinks = sum(self.uplinks, other.uplinks);
        self.logs = sum(self.logs, other.logs);
    }
}

/// The summary's record of a chunk.
#[derive(Debug)]
pub(super) struct ChunkIndex {
    /// First log time of its messages.
    pub(super) start_ns: u64,
    /// Last log time of its messages.
    pub(super) end_ns: u64,
    /// Byte of the file.
    pub(super) offset: u64,
    /// Channels and how many messages each has, as the lengths of the message indexes after the chunk tell; `None`
    /// where there are none.
    messages: Option<Vec<(u16, u64)>>,
}

impl ChunkIndex {
    /// That of a record without operation code and length; `None` where it cannot be one.
    pub(super) fn read(body: &[u8]) -> Option<Self> {
        let mut fields = Reader(body);
        let (start_ns, end_ns) = (fields.u64()?, fields.u64()?);
        let (offset, length) = (fields.u64()?, fields.u64()?);
        let mut entries = Reader(fields.bytes()?);
        let mut indexes = Vec::new();
        while !entries.0.is_empty() {
            let channel_id = entries.u16()?;
            indexes.push((entries.u64()?, channel_id));
        }
        let indexes_end = offset.checked_add(length)?.checked_add(fields.u64()?)?;
        Some(Self {
            start_ns,
            end_ns,
            offset,
            messages: count(indexes, indexes_end),
        })
    }
}

/// A message index ends where the next begins.
fn count(mut indexes: Vec<(u64, u16)>, end: u64) -> Option<Vec<(u16, u64)>> {
    indexes.sort_unstable();
    let ends = indexes.iter().skip(1).map(|(at, _)| *at).chain([end]);
    let counted = indexes.iter().zip(ends).map(|(&(at, channel_id), end)| {
        let bytes = end.checked_sub(at)?.checked_sub(HEAD_BYTES as u64)?;
        Some((channel_id, MessageIndex::count(bytes)))
    });
    let counted: Option<Vec<_>> = counted.collect();
    counted.filter(|counted| !counted.is_empty())
}
