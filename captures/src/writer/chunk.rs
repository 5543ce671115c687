//! A chunk of messages: filled, compressed at one go, indexed.

use std::io;

use zstd::zstd_safe::CParameter;

use super::records::{Fields, HEAD_BYTES, op, record};

/// The lines are so alike that what higher levels try finds little more: level 3 saves 4 per cent of a converted day and
/// takes half as long again.
const ZSTD_LEVEL: i32 = -1;

/// Shorter matches than the level would look for: fields repeat, and the times between them do not.
const MATCH_BYTES_MIN: u32 = 5;

/// The table of matches fits into the fastest cache of a core, 32 KiB.
const MATCH_TABLE_BITS: u32 = 13;

/// Bytes of a message's entry in an index: its log time and its place in the chunk.
const PLACE_BYTES: usize = 16;

/// What the summary has to know of a chunk that was written.
#[derive(Debug)]
pub(super) struct Written {
    pub(super) messages: u64,
    pub(super) start_ns: u64,
    pub(super) end_ns: u64,
}

/// The chunk being filled. Its memory is used again for the next one.
pub(super) struct Chunk {
    records: Vec<u8>,
    /// By channel: the entries of its index as they are written.
    places: Vec<Vec<u8>>,
    start_ns: u64,
    end_ns: u64,
    messages: u64,
    compressor: zstd::bulk::Compressor<'static>,
    compressed: Vec<u8>,
}

impl Chunk {
    pub(super) fn new() -> io::Result<Self> {
        let mut compressor = zstd::bulk::Compressor::new(ZSTD_LEVEL)?;
        compressor.set_parameter(CParameter::MinMatch(MATCH_BYTES_MIN))?;
        compressor.set_parameter(CParameter::HashLog(MATCH_TABLE_BITS))?;
        Ok(Self {
            records: Vec::new(),
            places: Vec::new(),
            start_ns: 0,
            end_ns: 0,
            messages: 0,
            compressor,
            compressed: Vec::new(),
        })
    }

    pub(super) const fn bytes(&self) -> usize {
        self.records.len()
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// Messages in it.
    pub(super) const fn messages(&self) -> u64 {
        self.messages
    }

    /// Messages of a channel in it.
    pub(super) fn count(&self, channel_id: u16) -> u64 {
        self.places
            .get(usize::from(channel_id))
            .map_or(0, |places| count(places))
    }

    /// Messages in it, by channel; of those that have any.
    pub(super) fn counts(&self) -> impl Iterator<Item = (u16, u64)> + '_ {
        let counts = self.places.iter().map(|places| count(places));
        (0..=u16::MAX).zip(counts).filter(|(_, count)| *count > 0)
    }

    /// A schema or a channel.
    pub(super) fn add_record(&mut self, record: &[u8]) {
        self.records.extend_from_slice(record);
    }

    pub(super) fn add_message(
        &mut self,
        channel_id: u16,
        sequence: u32,
        log_time_ns: u64,
        publish_time_ns: u64,
        data: &[u8],
    ) {
        self.note(channel_id, log_time_ns, self.records.len() as u64);
        let mut head = [0; HEAD_BYTES + 22];
        head[0] = op::MESSAGE;
        head[1..9].copy_from_slice(&(data.len() as u64 + 22).to_le_bytes());
        head[9..11].copy_from_slice(&channel_id.to_le_bytes());
        head[11..15].copy_from_slice(&sequence.to_le_bytes());
        head[15..23].copy_from_slice(&log_time_ns.to_le_bytes());
        head[23..31].copy_from_slice(&publish_time_ns.to_le_bytes());
        self.records.extend_from_slice(&head);
        self.records.extend_from_slice(data);
    }

    /// A message of a chunk that is copied stands at this offset.
    pub(super) fn note(&mut self, channel_id: u16, log_time_ns: u64, offset: u64) {
        let channel = usize::from(channel_id);
        if self.places.len() <= channel {
            self.places.resize_with(channel + 1, Vec::new);
        }
        let mut place = [0; PLACE_BYTES];
        place[..8].copy_from_slice(&log_time_ns.to_le_bytes());
        place[8..].copy_from_slice(&offset.to_le_bytes());
        self.places[channel].extend_from_slice(&place);
        if self.messages == 0 {
            self.start_ns = log_time_ns;
            self.end_ns = log_time_ns;
        }
        self.start_ns = self.start_ns.min(log_time_ns);
        self.end_ns = self.end_ns.max(log_time_ns);
        self.messages += 1;
    }

    /// Appends the chunk and its message indexes, which will stand at `position` of the file, to `to`,
    /// and its entry in the summary to `index`. The chunk is empty then.
    pub(super) fn write(
        &mut self,
        position: u64,
        to: &mut Vec<u8>,
        index: &mut Vec<u8>,
    ) -> io::Result<Written> {
        self.compressed.clear();
        self.compressed
            .reserve(zstd::zstd_safe::compress_bound(self.records.len()));
        self.compressor
            .compress_to_buffer(&self.records, &mut self.compressed)?;
        let crc = crc32fast::hash(&self.records);
        let (uncompressed, compressed) = (self.records.len() as u64, &self.compressed);
        let start = to.len();
        record(to, op::CHUNK, |to| {
            to.u64(self.start_ns);
            to.u64(self.end_ns);
            to.u64(uncompressed);
            to.u32(crc);
            to.text("zstd");
            to.u64(compressed.len() as u64);
            to.extend_from_slice(compressed);
        });
        let length = (to.len() - start) as u64;
        let sizes = (compressed.len() as u64, uncompressed);
        self.records.clear();
        Ok(self.write_indexes(position, length, "zstd", sizes, to, index))
    }

    /// Appends a chunk that has been read elsewhere, as it is; its messages have been noted.
    pub(super) fn write_copy(
        &mut self,
        position: u64,
        chunk: &[u8],
        compression: &str,
        sizes: (u64, u64),
        to: &mut Vec<u8>,
        index: &mut Vec<u8>,
    ) -> Written {
        to.extend_from_slice(chunk);
        let length = chunk.len() as u64;
        self.write_indexes(position, length, compression, sizes, to, index)
    }

    fn write_indexes(
        &mut self,
        position: u64,
        length: u64,
        compression: &str,
        (compressed, uncompressed): (u64, u64),
        to: &mut Vec<u8>,
        index: &mut Vec<u8>,
    ) -> Written {
        let before = to.len();
        let mut offsets = Vec::new();
        for (channel_id, places) in (0..=u16::MAX).zip(&mut self.places) {
            if places.is_empty() {
                continue;
            }
            let at = position + length + (to.len() - before) as u64;
            offsets.push((channel_id, at));
            record(to, op::MESSAGE_INDEX, |to| {
                to.u16(channel_id);
                to.bytes(places);
            });
            places.clear();
        }
        let written = Written {
            messages: self.messages,
            start_ns: self.start_ns,
            end_ns: self.end_ns,
        };
        record(index, op::CHUNK_INDEX, |index| {
            index.u64(written.start_ns);
            index.u64(written.end_ns);
            index.u64(position);
            index.u64(length);
            index.u32((offsets.len() * 10) as u32);
            for (channel_id, at) in offsets {
                index.u16(channel_id);
                index.u64(at);
            }
            index.u64((to.len() - before) as u64);
            index.text(compression);
            index.u64(compressed);
            index.u64(uncompressed);
        });
        (self.start_ns, self.end_ns, self.messages) = (0, 0, 0);
        written
    }
}

/// Messages that have these places.
const fn count(places: &[u8]) -> u64 {
    (places.len() / PLACE_BYTES) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_channel_is_one_like_any() {
        let mut chunk = Chunk::new().unwrap();
        chunk.add_message(u16::MAX, 0, 5, 5, b"last");
        assert_eq!(chunk.counts().collect::<Vec<_>>(), [(u16::MAX, 1)]);
        let (mut to, mut index) = (Vec::new(), Vec::new());
        let written = chunk.write(0, &mut to, &mut index).unwrap();
        assert_eq!((written.messages, written.end_ns), (1, 5));
        assert_eq!(chunk.counts().count(), 0);
    }
}
