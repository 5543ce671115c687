//! Reads the radio's bytes and the station's events of a recording in order.

use std::collections::BTreeMap;
use std::io::{self, Read};

use ::mcap::records::{Record, op};
use prost::Message as _;

use super::mcap_reader::{Channels, Entries, Entry};
use super::messages::{RawBytes, StationEvent};
use super::record::parse;
use super::repair::Position;
use super::session::Session;
use super::station_event::EVENT_BYTES_MAX;
use super::topics::{RAW_RX, Topic};

/// Maximum plausible gap in the received bytes: 50 days of a 2400-baud radio.
const GAP_BYTES_MAX: u64 = 1 << 30;

/// Maximum length of a piece of received bytes; longer messages are returned in parts, to keep each step through a capture short.
const PIECE_BYTES_MAX: usize = 256;

/// Maximum number of entries read for one piece; after that, an empty piece is returned, to keep each step short.
const QUIET_ENTRIES_MAX: usize = 64;

/// Maximum accepted length of a message of received or sent bytes. A recorder writes one for each read, which has a few KiB; replays hold several
/// copies of a message.
const RAW_BYTES_MAX: usize = 2 << 20;

/// A part of a capture.
#[derive(Clone, Debug, PartialEq)]
pub enum Piece<'a> {
    /// Bytes from the radio; empty in a long part without received bytes.
    Received(&'a [u8]),
    /// Bytes to the radio.
    Sent(&'a [u8]),
    /// An event of the station.
    Event(Box<StationEvent>),
    /// Number of received bytes that are missing from the capture.
    Missing(u64),
    /// Offset in the stream of received bytes that are repeated; they are skipped.
    Repeated(u64),
    /// Description of a part that cannot be read.
    Damaged(String),
}

/// A piece that was read ahead.
enum Ahead {
    Received(RawBytes),
    /// The remaining received bytes of the current message.
    Rest,
    Nothing,
    Sent(RawBytes),
    Event(Box<StationEvent>),
    Damaged(String),
}

/// Position at which reading the pieces can continue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PiecePosition {
    position: Position,
    /// Number of received bytes before the position; `None` if unknown.
    stream: Option<u64>,
}

impl PiecePosition {
    /// The beginning of a recording.
    pub(crate) const BEGINNING: Self = Self {
        position: Position {
            offset: 0,
            record: 0,
        },
        stream: Some(0),
    };

    /// Position of a chunk, or of a record outside of chunks, at an offset of the file.
    pub(crate) const fn of_record(offset: u64) -> Self {
        Self {
            position: Position { offset, record: 0 },
            stream: None,
        }
    }

    /// Offset of the file at which reading continues.
    pub(crate) const fn offset(&self) -> u64 {
        self.position.offset
    }

    /// Position after the last piece.
    pub(crate) const END: Self = Self::of_record(u64::MAX);
}

/// Reads the pieces of a recording.
pub(crate) struct Pieces<R> {
    entries: Entries<R>,
    session: BTreeMap<String, String>,
    /// Log time of the first message, nanoseconds.
    first_ns: Option<u64>,
    last_ns: u64,
    /// The next piece and its log time, nanoseconds.
    ahead: Option<(u64, Ahead)>,
    place: PiecePosition,
    /// Number of bytes of `current` already returned.
    given: usize,
    /// Stream offset at which to continue in the first bytes read; earlier bytes were returned before.
    resumes_at: Option<u64>,
    /// Offset of the stream if the latest gap turns out to be a damaged offset.
    without_gap: Option<u64>,
    current: RawBytes,
}

impl<R: Read> Pieces<R> {
    /// Reads from the beginning of `source`.
    pub(crate) fn new(source: R) -> Self {
        Self::of(Entries::new(source), PiecePosition::BEGINNING)
    }

    /// Reads from the beginning of `source`, whose channels are known.
    pub(crate) fn of_channels(source: R, channels: Channels) -> Self {
        let entries = Entries::of_channels(source, channels);
        Self::of(entries, PiecePosition::BEGINNING)
    }

    /// Continues reading at a place, with the channels known there; `source` begins at its offset.
    pub(crate) fn resume(source: R, place: PiecePosition, channels: Channels) -> io::Result<Self> {
        let entries = Entries::resume(source, place.position, channels)?;
        Ok(Self::of(entries, place))
    }

    const fn of(entries: Entries<R>, place: PiecePosition) -> Self {
        Self {
            entries,
            session: BTreeMap::new(),
            first_ns: None,
            last_ns: 0,
            ahead: None,
            place,
            given: 0,
            resumes_at: place.stream,
            without_gap: None,
            current: RawBytes {
                stream_offset: 0,
                data: Vec::new(),
            },
        }
    }

    /// Log time of the next piece, nanoseconds; `None` at the end.
    pub(crate) fn next_ns(&mut self) -> io::Result<Option<u64>> {
        let mut quiet = 0;
        while self.ahead.is_none() {
            let Some(entry) = self.entries.next_entry()? else {
                break;
            };
            self.ahead = match entry {
                Entry::Damage(damage) => {
                    let at_ns = damage
                        .times_ns
                        .map_or(self.last_ns, |(first_ns, _)| first_ns);
                    Some((at_ns, Ahead::Damaged(damage.to_string())))
                }
                Entry::Other { opcode, body } => {
                    if opcode == op::METADATA
                        && let Some(Record::Metadata(table)) = parse(opcode, body)
                        && table.name == Session::TABLE
                    {
                        self.session = table.metadata;
                    }
                    None
                }
                Entry::Message {
                    channel,
                    header,
                    data,
                } => {
                    self.first_ns.get_or_insert(header.log_time);
                    self.last_ns = header.log_time;
                    let ahead = channel.ours.and_then(|topic| decode(topic, data));
                    ahead.map(|ahead| (header.log_time, ahead))
                }
            };
            quiet += 1;
            if self.ahead.is_none() && quiet >= QUIET_ENTRIES_MAX && self.first_ns.is_some() {
                self.ahead = Some((self.last_ns, Ahead::Nothing));
            }
        }
        Ok(self.ahead.as_ref().map(|(at_ns, _)| *at_ns))
    }

    /// The next piece and its log time, nanoseconds; `None` at the end.
    pub(crate) fn next_piece(&mut self) -> io::Result<Option<(u64, Piece<'_>)>> {
        self.next_ns()?;
        let Some((at_ns, ahead)) = self.ahead.take() else {
            return Ok(None);
        };
        let piece = match ahead {
            Ahead::Received(raw) => {
                let given = self.given_before(&raw);
                let missing = match given {
                    0 => self.missing_before(&raw),
                    _ => Some(0),
                };
                if let Some(missing @ 1..) = missing {
                    self.place.stream = Some(raw.stream_offset);
                    self.ahead = Some((at_ns, Ahead::Received(raw)));
                    return Ok(Some((at_ns, Piece::Missing(missing))));
                }
                self.current = raw;
                let offset = self.current.stream_offset;
                if missing == Some(0) {
                    self.given = given;
                    return Ok(Some((at_ns, self.next_part(at_ns))));
                }
                if offset < self.place.stream.unwrap_or(0) {
                    Piece::Repeated(offset)
                } else {
                    let damage = format!("{RAW_RX}: the offset {offset} is implausible");
                    Piece::Damaged(damage)
                }
            }
            Ahead::Rest => return Ok(Some((at_ns, self.next_part(at_ns)))),
            Ahead::Nothing => Piece::Received(&[]),
            Ahead::Sent(raw) => {
                self.current = raw;
                Piece::Sent(&self.current.data)
            }
            Ahead::Event(event) => Piece::Event(event),
            Ahead::Damaged(damage) => Piece::Damaged(damage),
        };
        self.place.position = self.entries.position();
        Ok(Some((at_ns, piece)))
    }

    /// The next part of the received bytes. Until the last part, reading continues in the same record.
    fn next_part(&mut self, at_ns: u64) -> Piece<'_> {
        let from = self.given;
        self.given = self.current.data.len().min(from + PIECE_BYTES_MAX);
        let end = self.current.stream_offset.saturating_add(self.given as u64);
        self.place.stream = Some(end);
        if self.given < self.current.data.len() {
            self.ahead = Some((at_ns, Ahead::Rest));
        } else {
            self.place.position = self.entries.position();
        }
        Piece::Received(&self.current.data[from..self.given])
    }

    /// Number of bytes of the first record after a position that were returned before.
    fn given_before(&mut self, raw: &RawBytes) -> usize {
        let given = self
            .resumes_at
            .take()
            .and_then(|at| at.checked_sub(raw.stream_offset));
        let given = given.and_then(|given| usize::try_from(given).ok());
        given.filter(|given| *given < raw.data.len()).unwrap_or(0)
    }

    /// Number of bytes missing before `raw`; `None` if `raw` is repeated or its offset is damaged.
    fn missing_before(&mut self, raw: &RawBytes) -> Option<u64> {
        let offset = raw.stream_offset;
        let Some(expected) = self.place.stream else {
            return Some(0);
        };
        if self.without_gap.take_if(|it| *it == offset).is_some() {
            return Some(0);
        }
        let missing = offset
            .checked_sub(expected)
            .filter(|missing| *missing <= GAP_BYTES_MAX)?;
        if missing > 0 {
            self.without_gap = Some(expected.saturating_add(raw.data.len() as u64));
        }
        Some(missing)
    }

    /// Position of the next piece.
    pub(crate) const fn place(&self) -> PiecePosition {
        self.place
    }

    /// Metadata of the session found so far: link, start, software.
    pub(crate) const fn session(&self) -> &BTreeMap<String, String> {
        &self.session
    }

    /// Log time of the first message read, nanoseconds.
    pub(crate) const fn first_ns(&self) -> Option<u64> {
        self.first_ns
    }

    /// Log time of the last message read, nanoseconds.
    pub(crate) const fn last_ns(&self) -> u64 {
        self.last_ns
    }

    /// The channels found so far.
    pub(crate) const fn channels(&self) -> &Channels {
        self.entries.channels()
    }

    /// Offset in the file of the next piece's record, or of its chunk; valid after [`Self::next_ns`].
    pub(crate) const fn part_offset(&self) -> u64 {
        self.entries.part_offset()
    }

    /// Whether the file has its end mark; known at the end.
    pub(crate) fn is_finished(&self) -> bool {
        self.entries.is_finished()
    }
}

/// Whether there is a channel of received bytes.
pub(crate) fn has_received(channels: &Channels) -> bool {
    channels
        .values()
        .any(|channel| channel.ours == Some(Topic::RawRx))
}

/// The piece in a message; `None` on derived topics.
fn decode(topic: Topic, data: &[u8]) -> Option<Ahead> {
    let bytes_max = match topic {
        Topic::RawRx | Topic::RawTx => RAW_BYTES_MAX,
        Topic::Station => EVENT_BYTES_MAX,
        _ => return None,
    };
    if data.len() > bytes_max {
        let problem = format!(
            "a message has {} bytes; {bytes_max} are allowed",
            data.len()
        );
        return Some(Ahead::Damaged(format!("{}: {problem}", topic.name())));
    }
    let decoded = match topic {
        Topic::RawRx => RawBytes::decode(data).map(Ahead::Received),
        Topic::RawTx => RawBytes::decode(data).map(Ahead::Sent),
        _ => StationEvent::decode(data).map(|event| Ahead::Event(Box::new(event))),
    };
    Some(decoded.unwrap_or_else(|error| Ahead::Damaged(format!("{}: {error}", topic.name()))))
}
