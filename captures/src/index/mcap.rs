//! MCAP recordings from any place.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::sync::Arc;

use ::mcap::records::{Record, op};
use foxglove::messages::Log;
use prost::Message;

use super::block::{Block, CHUNK_BYTES_MAX, Item, Topic, take_channel, unpack};
use super::chunk_index::{ChunkIndex, Counts, MessageIndex};
use super::marks::Marks;
use super::{Piece, Place, Source, Tape, read_at};
use crate::CaptureError;
use crate::composer::Session;
use crate::event::Landmark;
use crate::event::{Moment, Truth};
use crate::messages::{RawBytes, UplinkEvent};
use crate::topics::StationEvent;
use crate::unpacker::Unpacker;
use crate::writer::records::HEAD_BYTES;

/// Footer and magic at the end of a finished file.
const END_BYTES: usize = HEAD_BYTES + 20 + 8;

/// The first message is looked for in so many chunks.
const CHUNKS_BEFORE_MESSAGES: usize = 64;

/// A longer table is not believed.
const TABLE_BYTES_MAX: u64 = 1024 * 1024;

/// Records are walked through with reads of this size.
const WALK_BYTES: usize = 4096;

/// A recording.
#[derive(Clone)]
pub struct McapTape {
    source: Arc<dyn Source>,
    size: u64,
    /// Where chunks begin.
    marks: Marks,
    start_ns: u64,
    end_ns: u64,
    topics: BTreeMap<u16, Topic>,
    truth: Option<Truth>,
    block: Option<Block>,
    unpacker: Unpacker,
    place: Place,
    /// The message given out last.
    current: RawBytes,
}

impl McapTape {
    /// A recording from its beginning.
    ///
    /// # Errors
    /// When it cannot be read or has no channel of received bytes.
    pub fn new(source: Arc<dyn Source>, name: &Path) -> Result<Self, CaptureError> {
        let read_error = |error| CaptureError::Read {
            path: name.to_owned(),
            error,
        };
        let size = source.size().map_err(read_error)?;
        let mut tape = Self {
            source,
            size,
            marks: Marks::default(),
            start_ns: 0,
            end_ns: 0,
            topics: BTreeMap::new(),
            truth: None,
            block: None,
            unpacker: Unpacker::default(),
            place: Place::default(),
            current: RawBytes::default(),
        };
        let has_summary = tape.read_summary().map_err(read_error)?;
        if !has_summary {
            tape.walk(::mcap::MAGIC.len() as u64, None)
                .map_err(read_error)?;
        }
        tape.place.offset = ::mcap::MAGIC.len() as u64;
        tape.start_ns = tape.first_message_ns();
        tape.end_ns = tape.end_ns.max(tape.start_ns);
        if !tape.topics.values().any(|topic| *topic == Topic::Received) {
            return Err(CaptureError::NoRawBytes(name.to_owned()));
        }
        tape.go(Place {
            offset: ::mcap::MAGIC.len() as u64,
            stream: Some(0),
            ..Place::default()
        });
        Ok(tape)
    }

    /// Reads the chunks' times and the channels from the end of a finished file; whether there was such an end.
    fn read_summary(&mut self) -> io::Result<bool> {
        let mut end = [0; END_BYTES];
        let Some(end_at) = self.size.checked_sub(END_BYTES as u64) else {
            return Ok(false);
        };
        read_at(&*self.source, end_at, &mut end)?;
        let (footer, magic) = end.split_at(END_BYTES - 8);
        if footer[0] != op::FOOTER || magic != ::mcap::MAGIC {
            return Ok(false);
        }
        let summary_at = u64_at(footer, HEAD_BYTES);
        if summary_at == 0 || summary_at >= end_at {
            return Ok(false);
        }
        self.walk(summary_at, Some(end_at))?;
        Ok(self.marks.first().is_some())
    }

    /// Goes from record to record without reading chunks, and keeps what says where they are; to the end
    /// of the data, or to the given end.
    fn walk(&mut self, from: u64, until: Option<u64>) -> io::Result<()> {
        let until = until.unwrap_or(self.size);
        let mut window = Window::default();
        let mut offset = from;
        while let Some(head) = window.read(&*self.source, offset, HEAD_BYTES)? {
            let (opcode, length) = (head[0], u64_at(head, 1));
            let body_at = offset + HEAD_BYTES as u64;
            let Some(end) = body_at.checked_add(length).filter(|end| *end <= until) else {
                break;
            };
            match opcode {
                op::CHUNK if length >= 16 => {
                    if let Some(body) = window.read(&*self.source, body_at, 16)? {
                        let (start_ns, end_ns) = (u64_at(body, 0), u64_at(body, 8));
                        self.mark(start_ns, end_ns, offset, None);
                    }
                }
                op::CHUNK_INDEX if length < WALK_BYTES as u64 => {
                    if let Some(body) = window.read(&*self.source, body_at, length as usize)?
                        && let Some(index) = ChunkIndex::read(body)
                    {
                        let counts = Counts::of(&index, &self.topics);
                        self.mark(index.start_ns, index.end_ns, index.offset, counts);
                    }
                }
                op::CHANNEL if length < WALK_BYTES as u64 => {
                    if let Some(body) = window.read(&*self.source, body_at, length as usize)? {
                        take_channel(&mut self.topics, body);
                    }
                }
                op::METADATA if length <= TABLE_BYTES_MAX => {
                    if let Some(body) = window.read(&*self.source, body_at, length as usize)? {
                        self.take_metadata(body);
                    }
                }
                op::METADATA_INDEX if length < WALK_BYTES as u64 => {
                    if let Some(body) = window.read(&*self.source, body_at, length as usize)?
                        && let Ok(Record::MetadataIndex(index)) = ::mcap::parse_record(opcode, body)
                        && index.name == Session::TABLE
                        && index.length <= TABLE_BYTES_MAX
                    {
                        let mut record = vec![0; index.length as usize];
                        read_at(&*self.source, index.offset, &mut record)?;
                        self.take_metadata(record.get(HEAD_BYTES..).unwrap_or_default());
                    }
                }
                op::DATA_END | op::FOOTER => break,
                _ => {}
            }
            offset = end;
        }
        Ok(())
    }

    /// What the recording says of itself.
    fn take_metadata(&mut self, body: &[u8]) {
        if let Ok(Record::Metadata(table)) = ::mcap::parse_record(op::METADATA, body)
            && table.name == Session::TABLE
        {
            let truth = table.metadata.get(Session::TRUTH);
            self.truth = truth.and_then(|truth| serde_json::from_str(truth).ok());
        }
    }

    fn mark(&mut self, start_ns: u64, end_ns: u64, offset: u64, counts: Option<Counts>) {
        self.end_ns = self.end_ns.max(end_ns);
        // A chunk without messages says no time.
        if end_ns > 0 && offset < self.size {
            self.marks.add(start_ns, offset, counts);
        }
    }

    /// The time of the first message that can be read.
    fn first_message_ns(&mut self) -> u64 {
        let mut next = Some(::mcap::MAGIC.len() as u64);
        for _ in 0..CHUNKS_BEFORE_MESSAGES {
            let Some(block) = next.and_then(|offset| self.load(offset)) else {
                break;
            };
            if let Some(at_ns) = block.first_ns {
                return at_ns;
            }
            next = block.next;
        }
        self.marks.first().map_or(0, |mark| mark.start_ns)
    }

    /// The messages of the first chunk at an offset or after it; `None` at the end of the data.
    fn load(&mut self, mut offset: u64) -> Option<Block> {
        let mut head = [0; HEAD_BYTES];
        loop {
            let damage = |text: &str| {
                Some(Block {
                    offset,
                    items: vec![(0, Item::Damage(text.to_owned()))],
                    ..Block::default()
                })
            };
            match read_at(&*self.source, offset, &mut head) {
                Ok(HEAD_BYTES) => {}
                Ok(_) => {
                    return damage("the recording was interrupted: the file ends in the middle");
                }
                Err(error) => return damage(&format!("the capture cannot be read on: {error}")),
            }
            let (opcode, length) = (head[0], u64_at(&head, 1));
            if matches!(opcode, op::DATA_END | op::FOOTER) {
                return None;
            }
            let body_at = offset + HEAD_BYTES as u64;
            let Some(next) = body_at.checked_add(length).filter(|end| *end <= self.size) else {
                return damage("the recording was interrupted: the file ends in the middle");
            };
            match opcode {
                op::CHUNK | op::MESSAGE | op::CHANNEL if length <= CHUNK_BYTES_MAX => {
                    let mut record = vec![0; HEAD_BYTES + length as usize];
                    match read_at(&*self.source, offset, &mut record) {
                        Ok(read) if read == record.len() => {}
                        _ => return damage("the capture cannot be read on"),
                    }
                    if opcode == op::CHANNEL {
                        take_channel(&mut self.topics, &record[HEAD_BYTES..]);
                    } else {
                        return Some(self.unpack(offset, next, &record));
                    }
                }
                op::CHUNK => return damage("a chunk is too large to be one"),
                0 => return damage("what follows is no record"),
                _ => {}
            }
            offset = next;
        }
    }

    fn unpack(&mut self, offset: u64, next: u64, record: &[u8]) -> Block {
        let mut block = Block {
            offset,
            next: Some(next),
            ..Block::default()
        };
        if let Err(error) = unpack(&mut self.unpacker, &mut self.topics, record, &mut block) {
            let text = format!("a part of the recording is left out: {error}");
            let at = if record[0] == op::CHUNK && record.len() >= HEAD_BYTES + 8 {
                u64_at(record, HEAD_BYTES)
            } else {
                0
            };
            block.bytes.clear();
            block.first_ns = None;
            block.items = vec![(at, Item::Damage(text))];
        }
        block
    }

    /// Goes to the next message, if there is one.
    fn settle(&mut self) -> Option<&(u64, Item)> {
        loop {
            if self
                .block
                .as_ref()
                .is_none_or(|block| block.offset != self.place.offset)
            {
                // The place may be that of a record before the chunk: what was loaded says where it is.
                let block = self.load(self.place.offset)?;
                self.place.offset = block.offset;
                self.block = Some(block);
            }
            let block = self.block.as_ref()?;
            if (self.place.item as usize) < block.items.len() {
                break;
            }
            self.place.offset = block.next?;
            self.place.item = 0;
            self.block = None;
        }
        self.block.as_ref()?.items.get(self.place.item as usize)
    }

    fn since_start(&self, log_time_ns: u64) -> Moment {
        let at = Moment::from_nanos(log_time_ns.saturating_sub(self.start_ns));
        at.max(self.place.at)
    }
}

impl Tape for McapTape {
    fn next_at(&mut self) -> Option<Moment> {
        let (log_time_ns, _) = *self.settle()?;
        Some(self.since_start(log_time_ns))
    }

    fn next_piece(&mut self) -> Option<Piece<'_>> {
        let at = self.next_at()?;
        let block = self.block.as_ref()?;
        let (_, item) = block.items.get(self.place.item as usize)?;
        self.place.at = at;
        let (topic, message) = match item {
            Item::Damage(text) => {
                self.place.item += 1;
                self.place.stream = None;
                return Some(Piece::Damaged(text.clone()));
            }
            Item::Message(topic, range) => (*topic, &block.bytes[range.clone()]),
        };
        let current = match topic {
            Topic::Received | Topic::Sent => RawBytes::decode(message),
            Topic::Uplink | Topic::Log | Topic::Telemetry => Ok(RawBytes::default()),
        };
        let event = match topic {
            Topic::Uplink => UplinkEvent::decode(message)
                .ok()
                .map(|it| Some(Box::new(StationEvent::Uplink(it)))),
            Topic::Log => Log::decode(message)
                .ok()
                .map(|it| Some(Box::new(StationEvent::Log(it)))),
            Topic::Received | Topic::Sent | Topic::Telemetry => Some(None),
        };
        self.place.item += 1;
        let (Ok(current), Some(event)) = (current, event) else {
            return Some(Piece::Damaged(
                "a message makes no sense and is left out".to_owned(),
            ));
        };
        self.current = current;
        match topic {
            Topic::Uplink | Topic::Log | Topic::Telemetry => {
                return Some(event.map_or(Piece::Nothing, Piece::Told));
            }
            Topic::Sent => return Some(Piece::Sent(&self.current.data)),
            Topic::Received => {}
        }
        let offset = self.current.stream_offset;
        let missing = offset.saturating_sub(self.place.stream.unwrap_or(offset));
        if missing > 0 {
            self.place.item -= 1;
            self.place.stream = Some(offset);
            return Some(Piece::Missing(missing));
        }
        self.place.stream = Some(offset.saturating_add(self.current.data.len() as u64));
        Some(Piece::Received(&self.current.data))
    }

    fn place(&self) -> Place {
        self.place
    }

    fn go(&mut self, place: Place) {
        self.place = place;
    }

    fn find(&mut self, at: Moment) -> Place {
        let wanted_ns = self.start_ns.saturating_add(at.as_nanos() as u64);
        let first = ::mcap::MAGIC.len() as u64;
        let (before, after) = self.marks.around(wanted_ns);
        let (mut found_ns, mut found) =
            before.map_or((self.start_ns, first), |mark| (mark.start_ns, mark.offset));
        // Between two marks there may be chunks of which no mark was kept.
        let mut window = Window::default();
        let mut offset = found;
        let until = after.map_or(self.size, |mark| mark.offset);
        while offset < until
            && let Some((opcode, body_at, end)) = window.head(&*self.source, offset)
        {
            if opcode == op::CHUNK
                && let Ok(Some(times)) = window.read(&*self.source, body_at, 16)
                && let (start_ns, 1..) = (u64_at(times, 0), u64_at(times, 8))
            {
                if start_ns >= wanted_ns {
                    break;
                }
                (found_ns, found) = (start_ns, offset);
            }
            offset = end;
        }
        Place {
            offset: found,
            item: 0,
            stream: (found == first).then_some(0),
            at: Moment::from_nanos(found_ns.saturating_sub(self.start_ns)),
        }
    }

    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)> {
        let mark = self.marks.before_line(number)?;
        let (mut offset, mut before) = (mark.offset, mark.before.lines);
        let mut window = Window::default();
        loop {
            let (opcode, body_at, end) = window.head(&*self.source, offset)?;
            if opcode == op::MESSAGE_INDEX
                && let Some(index) = window.read(&*self.source, body_at, 2).ok()?
                && let channel_id = u16::from_le_bytes(index.try_into().ok()?)
                && self.topics.get(&channel_id) == Some(&Topic::Telemetry)
            {
                let length = end - body_at;
                let lines = MessageIndex::count(length);
                if before.saturating_add(lines) >= number && length <= TABLE_BYTES_MAX {
                    let index = window.read(&*self.source, body_at, length as usize);
                    let (at_ns, earlier) = MessageIndex::read(index.ok()??, number - before)?;
                    let at = Moment::from_nanos(at_ns.saturating_sub(self.start_ns));
                    return Some((at, before + earlier));
                }
                before = before.saturating_add(lines);
            }
            offset = end;
        }
    }

    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool {
        let ns = |at: Moment| self.start_ns.saturating_add(at.as_nanos() as u64);
        self.marks.may_hold(landmark, ns(from), ns(until))
    }

    fn length(&self) -> Moment {
        Moment::from_nanos(self.end_ns - self.start_ns)
    }

    fn again(&self) -> Box<dyn Tape + Send> {
        Box::new(self.clone())
    }

    fn truth(&self) -> Option<Truth> {
        self.truth.clone()
    }

    fn unix(&self) -> Option<Moment> {
        Some(Moment::from_nanos(self.start_ns))
    }
}

/// A few bytes of a file at a time, read with few calls.
#[derive(Default)]
struct Window {
    at: u64,
    bytes: Vec<u8>,
}

impl Window {
    /// The record of the data that begins at an offset: operation code, where what it says begins, and where it ends.
    /// `None` at the end.
    fn head(&mut self, source: &dyn Source, offset: u64) -> Option<(u8, u64, u64)> {
        let head = self.read(source, offset, HEAD_BYTES).ok()??;
        let (opcode, length) = (head[0], u64_at(head, 1));
        let body_at = offset + HEAD_BYTES as u64;
        let end = body_at.checked_add(length)?;
        (!matches!(opcode, op::DATA_END | op::FOOTER)).then_some((opcode, body_at, end))
    }

    /// So many bytes at an offset; `None` where the file has fewer.
    fn read(
        &mut self,
        source: &dyn Source,
        offset: u64,
        length: usize,
    ) -> io::Result<Option<&[u8]>> {
        let Some(end) = offset.checked_add(length as u64) else {
            return Ok(None);
        };
        if offset < self.at || end > self.at + self.bytes.len() as u64 {
            self.bytes.resize(WALK_BYTES.max(length), 0);
            let read = read_at(source, offset, &mut self.bytes)?;
            self.bytes.truncate(read);
            self.at = offset;
        }
        let from = (offset - self.at) as usize;
        Ok(self.bytes.get(from..from + length))
    }
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let eight = bytes
        .get(at..at + 8)
        .and_then(|eight| eight.try_into().ok());
    eight.map_or(0, u64::from_le_bytes)
}
