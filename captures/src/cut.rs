//! A part of a capture, by time, as a capture of the same form.
//!
//! A line belongs to the part in which it ends, with all of its bytes; so parts that meet make up the
//! whole, and each of them decodes and verifies by itself.

use std::collections::{BTreeMap, HashSet, VecDeque};
use std::io::{self, Read, Write};
use std::time::{Duration, UNIX_EPOCH};

use ::mcap::parse_record;
use ::mcap::records::{Record, op};
use groundwave_protocol::LINE_BYTES;
use prost::Message as _;

use super::mcap_reader::{Damages, Entries, Entry};
use super::messages::RawBytes;
use super::name::utc;
use super::text::TextReader;
use super::topics::Topic;
use super::when::When;
use super::writer::records::record;
use super::writer::{Attachment, McapWriter};

/// What is decoded from bytes is recorded a moment after them and still belongs to them.
const LAG_NS: u64 = 1_000_000_000;

/// From when to when; the end is not part of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Window {
    /// `None`: from the beginning.
    pub from: Option<When>,
    /// `None`: to the end.
    pub to: Option<When>,
}

/// Why a part could not be cut out.
#[derive(Debug, thiserror::Error)]
pub enum CutError {
    /// A raw capture was to be cut by the clock.
    #[error("no line of it says the day: say --from and --to since its beginning, as 1:30")]
    NoWallTime,
    /// The capture cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// The part cannot be written.
    #[error("{0}")]
    Write(io::Error),
}

/// What has been cut out.
#[derive(Clone, Debug, Default)]
pub struct Part {
    /// Bytes received.
    pub bytes: u64,
    /// Messages; none in a raw capture.
    pub messages: u64,
    /// From the beginning of the whole capture to its last bytes; of a raw one only as far as it had to be read.
    pub whole: Duration,
    /// Why the capture could not be read whole.
    pub problem: Option<String>,
}

/// Cuts a raw capture: lines as they stand in it.
///
/// # Errors
/// Where the clock is asked for and no line says the day, and when reading or writing fails.
pub fn cut_raw(
    source: impl Read,
    window: Window,
    output: &mut impl Write,
) -> Result<Part, CutError> {
    let mut reader = TextReader::new(source);
    let unix = reader.style().map_err(CutError::Read)?.unix();
    let since = |when: Option<When>| match (when, unix) {
        (None, _) => Ok(None),
        (Some(When::Since(since)), _) => Ok(Some(since)),
        (Some(When::Wall(ns)), Some(unix)) => {
            Ok(Some(Duration::from_nanos(ns).saturating_sub(unix)))
        }
        (Some(When::Wall(_)), None) => Err(CutError::NoWallTime),
    };
    let (from, to) = (since(window.from)?.unwrap_or_default(), since(window.to)?);
    let mut part = Part::default();
    while let Some(piece) = reader.next_piece().map_err(CutError::Read)? {
        part.whole = piece.at;
        let is_after = to.is_some_and(|to| piece.at >= to);
        // Where nothing was found, what is there is worth knowing.
        if is_after && part.bytes > 0 {
            break;
        }
        if piece.at >= from && !is_after {
            output.write_all(piece.stored).map_err(CutError::Write)?;
            part.bytes += piece.radio.len() as u64;
        }
    }
    output.flush().map_err(CutError::Write)?;
    Ok(part)
}

/// Cuts an MCAP: the messages of all topics, with every table and attachment. `/raw/rx` and `/raw/tx` begin
/// again at offset 0; the table `cut` says where they began.
///
/// # Errors
/// When reading or writing fails.
pub fn cut_mcap(source: impl Read, window: Window, output: impl Write) -> Result<Part, CutError> {
    let mut entries = Entries::new(source);
    let mut next = entries.next_entry().map_err(CutError::Read)?;
    let mut cutter = Cutter {
        writer: McapWriter::empty(output, &library(next.as_ref())).map_err(CutError::Write)?,
        window,
        start_ns: None,
        place: Place::Before,
        schemas: HashSet::new(),
        channels: HashSet::new(),
        held: Held::default(),
        offsets: BTreeMap::new(),
        ends: BTreeMap::new(),
        in_summary: false,
        damages: Damages::default(),
        part: Part::default(),
    };
    while let Some(entry) = next {
        cutter.take_entry(entry).map_err(CutError::Write)?;
        next = entries.next_entry().map_err(CutError::Read)?;
    }
    let damages = std::mem::take(&mut cutter.damages);
    let mut part = cutter.finish().map_err(CutError::Write)?;
    part.problem = if !damages.is_empty() {
        Some(damages.in_words())
    } else if entries.is_finished() {
        None
    } else {
        Some("the recording was interrupted: its end is missing".to_owned())
    };
    Ok(part)
}

/// What wrote a capture, as its first record says: the channels of a part have the same numbers.
fn library(first: Option<&Entry<'_>>) -> String {
    match first {
        Some(Entry::Other { opcode, body }) => match parse_record(*opcode, body) {
            Ok(Record::Header(header)) => header.library,
            _ => String::new(),
        },
        _ => String::new(),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Way {
    Down,
    Up,
}

enum Content {
    Raw(Way, RawBytes),
    Other(Vec<u8>),
}

struct Message {
    channel: u16,
    /// Received and made, nanoseconds.
    times: (u64, u64),
    content: Content,
}

impl Message {
    /// The bytes received, if it is such.
    const fn received(&self) -> Option<&RawBytes> {
        match &self.content {
            Content::Raw(Way::Down, raw) => Some(raw),
            _ => None,
        }
    }

    const fn received_mut(&mut self) -> Option<&mut RawBytes> {
        match &mut self.content {
            Content::Raw(Way::Down, raw) => Some(raw),
            _ => None,
        }
    }
}

/// The latest messages: from the one with the first byte that may belong to an unfinished line.
#[derive(Default)]
struct Held {
    messages: VecDeque<Message>,
    /// Bytes received that are in `messages`.
    bytes: usize,
    /// Those of them, at the end, that no line feed follows; never a whole line.
    unfinished: usize,
}

impl Held {
    fn push(&mut self, message: Message) {
        if let Some(raw) = message.received() {
            let line_feed = raw.data.iter().rposition(|byte| *byte == b'\n');
            let unfinished = match line_feed {
                Some(place) => raw.data.len() - place - 1,
                None => self.unfinished + raw.data.len(),
            };
            self.unfinished = unfinished.min(LINE_BYTES - 1);
            self.bytes += raw.data.len();
        }
        self.messages.push_back(message);
    }

    /// The oldest message, unless it may hold a byte of an unfinished line.
    fn pop(&mut self) -> Option<Message> {
        let oldest = self.messages.front()?;
        let bytes = oldest.received().map_or(0, |raw| raw.data.len());
        if oldest.received().is_some() && self.bytes - bytes < self.unfinished {
            return None;
        }
        self.bytes -= bytes;
        self.messages.pop_front()
    }

    /// Splits at the unfinished line: what is before it stays here, and what is of it is returned.
    fn split(&mut self) -> Self {
        let mut rest = VecDeque::new();
        let mut missing = self.unfinished;
        for message in self.messages.iter_mut().rev() {
            let (channel, times) = (message.channel, message.times);
            let Some(raw) = message.received_mut() else {
                continue;
            };
            let taken = missing.min(raw.data.len());
            missing -= taken;
            if taken > 0 {
                let data = raw.data.split_off(raw.data.len() - taken);
                let stream_offset = raw.stream_offset.saturating_add(raw.data.len() as u64);
                let raw = RawBytes {
                    stream_offset,
                    data,
                };
                rest.push_front(Message {
                    channel,
                    times,
                    content: Content::Raw(Way::Down, raw),
                });
            }
        }
        Self {
            messages: rest,
            bytes: self.unfinished,
            unfinished: self.unfinished,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    Before,
    Inside,
    After,
}

struct Cutter<W: Write> {
    writer: McapWriter<W>,
    window: Window,
    start_ns: Option<u64>,
    place: Place,
    /// Those that have been copied, by their numbers.
    schemas: HashSet<u16>,
    channels: HashSet<u16>,
    held: Held,
    /// Where each way began in the capture.
    offsets: BTreeMap<Way, u64>,
    /// Where each way has got to.
    ends: BTreeMap<Way, u64>,
    in_summary: bool,
    damages: Damages,
    part: Part,
}

impl Part {
    /// Whether nothing of the capture lies in the window.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.bytes == 0 && self.messages == 0
    }
}

impl<W: Write> Cutter<W> {
    fn take_entry(&mut self, entry: Entry<'_>) -> io::Result<()> {
        let (channel, header, data) = match entry {
            Entry::Damage(damage) => {
                self.damages.push(damage);
                return Ok(());
            }
            Entry::Other { opcode, body } => {
                self.in_summary |= opcode == op::DATA_END;
                if self.in_summary {
                    return Ok(());
                }
                return self.copy_record(opcode, body);
            }
            Entry::Message {
                channel,
                header,
                data,
            } => (channel, header, data),
        };
        let way = match Topic::from_name(&channel.topic) {
            Some(Topic::RawRx) => Some(Way::Down),
            Some(Topic::RawTx) => Some(Way::Up),
            _ => None,
        };
        let content = match way.map(|way| (way, RawBytes::decode(data))) {
            None => Content::Other(data.to_vec()),
            Some((way, Ok(raw))) => {
                let end = self.ends.entry(way).or_insert(0);
                let at = raw.stream_offset;
                if at < *end {
                    let problem = format_args!("{}: the bytes at {at} come twice", channel.topic);
                    self.damages.push(problem);
                    return Ok(());
                }
                *end = at.saturating_add(raw.data.len() as u64);
                Content::Raw(way, raw)
            }
            Some((_, Err(error))) => {
                self.damages
                    .push(format_args!("{}: {error}", channel.topic));
                return Ok(());
            }
        };
        self.take(Message {
            channel: header.channel_id,
            times: (header.log_time, header.publish_time),
            content,
        })
    }

    fn copy_record(&mut self, opcode: u8, body: &[u8]) -> io::Result<()> {
        match opcode {
            op::SCHEMA | op::CHANNEL | op::METADATA | op::ATTACHMENT => {}
            _ => return Ok(()),
        }
        let copy = || {
            let mut bytes = Vec::with_capacity(body.len() + 16);
            record(&mut bytes, opcode, |to| to.extend_from_slice(body));
            bytes
        };
        match parse_record(opcode, body) {
            Ok(Record::Schema { header, .. }) if self.schemas.insert(header.id) => {
                self.writer.add_schema(&copy());
            }
            Ok(Record::Channel(channel)) if self.channels.insert(channel.id) => {
                self.writer.add_channel(&copy());
            }
            Ok(Record::Metadata(table)) => {
                self.writer.write_metadata(&table.name, &table.metadata)?;
            }
            Ok(Record::Attachment { header, data, .. }) => {
                self.writer.attach(&Attachment {
                    name: &header.name,
                    media_type: &header.media_type,
                    time_ns: header.log_time,
                    data: &data,
                })?;
            }
            _ => {}
        }
        Ok(())
    }

    fn take(&mut self, message: Message) -> io::Result<()> {
        let start_ns = *self.start_ns.get_or_insert(message.times.0);
        if message.received().is_some() {
            let passed = Duration::from_nanos(message.times.0.saturating_sub(start_ns));
            self.part.whole = self.part.whole.max(passed);
        }
        let has_come = |when: Option<When>| when.is_some_and(|when| self.has_come(when, &message));
        let is_after = has_come(self.window.to);
        let is_inside = self.window.from.is_none() || has_come(self.window.from);
        match self.place {
            Place::Before if is_after => self.place = Place::After,
            Place::Before if is_inside => {
                self.held = self.held.split();
                self.place = Place::Inside;
            }
            Place::Inside if is_after => self.leave()?,
            _ => {}
        }
        match self.place {
            Place::After => return Ok(()),
            Place::Before => {
                self.held.push(message);
                while self.held.pop().is_some() {}
            }
            Place::Inside => {
                self.held.push(message);
                while let Some(message) = self.held.pop() {
                    self.write(message)?;
                }
            }
        }
        Ok(())
    }

    /// Whether a moment has come with this message. Bytes received say so at once; anything else may have been
    /// decoded from bytes that came before the moment.
    fn has_come(&self, when: When, message: &Message) -> bool {
        let moment_ns = match when {
            When::Wall(ns) => ns,
            When::Since(since) if since.is_zero() => 0,
            When::Since(since) => {
                let start_ns = self.start_ns.unwrap_or(message.times.0);
                start_ns.saturating_add(nanoseconds(since))
            }
        };
        let lag_ns = if message.received().is_some() || moment_ns == 0 {
            0
        } else {
            LAG_NS
        };
        message.times.0 >= moment_ns.saturating_add(lag_ns)
    }

    fn leave(&mut self) -> io::Result<()> {
        self.held.split();
        self.place = Place::After;
        for message in std::mem::take(&mut self.held.messages) {
            self.write(message)?;
        }
        Ok(())
    }

    fn write(&mut self, message: Message) -> io::Result<()> {
        let Message {
            channel,
            times: (log_ns, publish_ns),
            content,
        } = message;
        let data = match content {
            Content::Other(data) => data,
            Content::Raw(_, raw) if raw.data.is_empty() => return Ok(()),
            Content::Raw(way, mut raw) => {
                raw.stream_offset -= *self.offsets.entry(way).or_insert(raw.stream_offset);
                if way == Way::Down {
                    self.part.bytes += raw.data.len() as u64;
                }
                raw.encode_to_vec()
            }
        };
        self.writer
            .copy_message(channel, log_ns, publish_ns, &data)?;
        self.part.messages += 1;
        Ok(())
    }

    fn finish(mut self) -> io::Result<Part> {
        if self.place == Place::Inside {
            for message in std::mem::take(&mut self.held.messages) {
                self.write(message)?;
            }
        }
        let in_words = |when: Option<When>| match when {
            None => "-".to_owned(),
            Some(When::Since(since)) => format!("{} s", since.as_secs_f64()),
            Some(When::Wall(ns)) => utc(UNIX_EPOCH + Duration::from_nanos(ns)),
        };
        let offset = |way| self.offsets.get(&way).unwrap_or(&0).to_string();
        let table = BTreeMap::from([
            ("from".to_owned(), in_words(self.window.from)),
            ("to".to_owned(), in_words(self.window.to)),
            ("rx_offset".to_owned(), offset(Way::Down)),
            ("tx_offset".to_owned(), offset(Way::Up)),
        ]);
        self.writer.write_metadata("cut", &table)?;
        self.writer.finish()?;
        Ok(self.part)
    }
}

fn nanoseconds(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}
