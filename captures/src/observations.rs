//! Reads the observations of a finished, unfinished or damaged recording; all other messages are derived from them.

use std::borrow::Cow;
use std::io::{self, Read};

use ::mcap::Attachment;
use ::mcap::records::{Metadata, Record, op};
use prost::Message as _;

use super::layout;
use super::mcap_reader::{Channels, Entries, Entry};
use super::messages::RawBytes;
use super::record::parse;
use super::repair::Damage;
use super::session::{RECOVERY, ROBOT};
use super::topics::{StationEvent, Topic};

/// Maximum number of tables and attachments that are read; the writer of a copy holds an index of all of them. A recorder writes fewer than ten.
const EXTRAS_MAX: usize = 1000;

/// A recorded item that cannot be derived.
#[derive(Clone, Debug, PartialEq)]
pub enum Observation {
    /// Bytes from the radio.
    Received(RawBytes),
    /// Bytes to the radio.
    Sent(RawBytes),
    /// An event of the station.
    Event(Box<StationEvent>),
}

impl RawBytes {
    /// Received bytes whose offset in the stream is not known yet.
    #[must_use]
    pub fn unplaced(bytes: &[u8]) -> Self {
        Self {
            stream_offset: 0,
            data: bytes.to_vec(),
        }
    }

    /// The bytes after the first `have` bytes of the stream, and the number of bytes missing before them; `None` when all are
    /// known already.
    pub(crate) fn after(&self, have: u64) -> Option<(u64, &[u8])> {
        let known = usize::try_from(have.saturating_sub(self.stream_offset)).ok()?;
        let bytes = self.data.get(known..).filter(|bytes| !bytes.is_empty())?;
        Some((self.stream_offset.saturating_sub(have), bytes))
    }
}

/// An item of a recording from which the recording can be rebuilt.
#[derive(Debug)]
pub(crate) enum Item {
    /// Name of the library that wrote the file.
    Library(String),
    /// A metadata table.
    Table(Metadata),
    /// An attached file.
    Attachment(Attachment<'static>),
    /// An observation and its time, nanoseconds since 1970.
    Observation {
        at_ns: u64,
        observation: Observation,
    },
    /// A part of the file that was skipped.
    Damage(Damage),
}

/// Reads the items of a recording in file order.
pub(crate) struct Observations<R> {
    entries: Entries<R>,
    has_ended: bool,
    has_bad_end: bool,
    nameless: u64,
    /// Number of tables and attachments, without and with a name that the writer of a copy writes again.
    extras: [usize; 2],
}

impl<R: Read> Observations<R> {
    /// Reads an MCAP from its beginning.
    pub(crate) fn new(source: R) -> Self {
        Self::with_channels(source, Channels::new())
    }

    /// Reads an MCAP from its beginning, with the channels found in an earlier pass.
    pub(crate) fn with_channels(source: R, channels: Channels) -> Self {
        Self {
            entries: Entries::of_channels(source, channels),
            has_ended: false,
            has_bad_end: false,
            nameless: 0,
            extras: [0; 2],
        }
    }

    /// All channels; complete only after the last observation.
    pub(crate) fn channels(&self) -> Channels {
        self.entries.channels().clone()
    }

    /// The next item; `None` at the end of the data section.
    ///
    /// # Errors
    /// If the source cannot be read.
    pub(crate) fn next_item(&mut self) -> io::Result<Option<Item>> {
        while let Some(entry) = self.entries.next_entry()? {
            let item = match entry {
                // The summary only repeats parts of the data section.
                Entry::Damage(damage) => {
                    self.has_bad_end |= self.has_ended;
                    (!self.has_ended).then_some(Item::Damage(damage))
                }
                Entry::Other {
                    opcode: op::MESSAGE,
                    ..
                } => {
                    self.nameless += 1;
                    None
                }
                Entry::Other { opcode, body } => {
                    self.has_ended |= matches!(opcode, op::DATA_END | op::FOOTER);
                    (!self.has_ended).then(|| other(opcode, body)).flatten()
                }
                Entry::Message {
                    channel,
                    header,
                    data,
                } => observation(Topic::from_name(&channel.topic), data).map(|observation| {
                    Item::Observation {
                        at_ns: header.log_time,
                        observation,
                    }
                }),
            };
            let Some(item) = item else {
                continue;
            };
            let name = match &item {
                Item::Table(table) => &table.name,
                Item::Attachment(attachment) => &attachment.name,
                _ => return Ok(Some(item)),
            };
            let is_written_again = [ROBOT, RECOVERY, layout::NAME].contains(&&**name);
            let count = &mut self.extras[usize::from(is_written_again)];
            *count += 1;
            if *count <= EXTRAS_MAX {
                return Ok(Some(item));
            }
            if *count == EXTRAS_MAX + 1 && !is_written_again {
                return Ok(Some(Item::Damage(Damage {
                    offset: self.entries.part_offset(),
                    bytes: 0,
                    problem:
                        "there are more than 1,000 tables and attachments; the others are left out"
                            .into(),
                    times_ns: None,
                })));
            }
        }
        Ok(None)
    }

    /// Whether the summary is damaged; known at the end.
    pub(crate) const fn has_bad_end(&self) -> bool {
        self.has_bad_end
    }

    /// Number of messages of unknown channels; complete at the end.
    pub(crate) const fn nameless(&self) -> u64 {
        self.nameless
    }

    /// Whether the file ends in the middle of a record; known at the end.
    pub(crate) const fn is_torn(&self) -> bool {
        self.entries.is_torn()
    }

    /// Whether the data section is complete; known at the end.
    pub(crate) const fn has_ended(&self) -> bool {
        self.has_ended
    }
}

fn observation(topic: Option<Topic>, data: &[u8]) -> Option<Observation> {
    match topic? {
        Topic::RawRx => RawBytes::decode(data).ok().map(Observation::Received),
        Topic::RawTx => RawBytes::decode(data).ok().map(Observation::Sent),
        Topic::Station => StationEvent::decode(data)
            .ok()
            .map(|event| Observation::Event(Box::new(event))),
        _ => None,
    }
}

fn other(opcode: u8, body: &[u8]) -> Option<Item> {
    match parse(opcode, body)? {
        Record::Header(header) => Some(Item::Library(header.library)),
        Record::Metadata(table) => Some(Item::Table(table)),
        Record::Attachment { header, data, .. } => Some(Item::Attachment(Attachment {
            log_time: header.log_time,
            create_time: header.create_time,
            name: header.name,
            media_type: header.media_type,
            data: Cow::Owned(data.into_owned()),
        })),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// A copy of a capture has an index of its attachments, so their number is bounded; that some are left out is said once.
    #[test]
    fn attachments_are_bounded() {
        let mut file = Cursor::new(Vec::new());
        let mut writer = ::mcap::Writer::new(&mut file).unwrap();
        for _ in 0..EXTRAS_MAX + 5 {
            let attachment = Attachment {
                log_time: 0,
                create_time: 0,
                name: "notes".to_owned(),
                media_type: "text/plain".to_owned(),
                data: Cow::Borrowed(b"text"),
            };
            writer.attach(&attachment).unwrap();
        }
        writer.finish().unwrap();
        drop(writer);
        let mut observations = Observations::new(&file.get_ref()[..]);
        let (mut attachments, mut problems) = (0, Vec::new());
        while let Some(item) = observations.next_item().unwrap() {
            match item {
                Item::Attachment(_) => attachments += 1,
                Item::Damage(damage) => problems.push(damage.to_string()),
                _ => {}
            }
        }
        assert_eq!(attachments, EXTRAS_MAX);
        assert!(
            problems.len() == 1 && problems[0].contains("left out"),
            "{problems:?}"
        );
    }
}
