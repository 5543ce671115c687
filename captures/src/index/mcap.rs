//! Seekable MCAP recordings.

use std::collections::BTreeMap;
use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use ::mcap::MAGIC;
use ::mcap::records::{Record, op};
use groundwave_lines::Recognizer;

use super::chunk_table::ChunkTable;
use super::{Place, SeekableReader, Source, read_at};
use crate::CaptureError;
use crate::event::{Landmark, Moment, Truth};
use crate::hint;
use crate::mcap_reader::{Channels, Entries, Entry};
use crate::own_lines::recognizer;
use crate::pieces::{Piece, PiecePosition, Pieces, has_received};
use crate::record::{HEAD_BYTES, parse};
use crate::repair::Position;
use crate::session::Session;

/// Length of the footer and the end mark of a finished file, bytes.
const END_BYTES: usize = HEAD_BYTES + 20 + MAGIC.len();

/// Length of the record before the summary, bytes. The summary's checksum covers it.
const DATA_END_BYTES: u64 = HEAD_BYTES as u64 + 4;

/// Maximum accepted length of a record that an index refers to, bytes.
const INDEXED_BYTES_MAX: u64 = 1024 * 1024;

/// Distance between entries of the chunk table for a file without a summary, bytes.
const SPACING_BYTES: u64 = 64 * 1024;

/// A recording with random access.
pub struct SeekableRecording {
    source: Arc<dyn Source>,
    table: Arc<ChunkTable>,
    start_ns: u64,
    end_ns: u64,
    truth: Option<Truth>,
    baud: Option<u32>,
    own: Recognizer,
    has_times: bool,
    pieces: Pieces<SourceReader>,
    at: Moment,
    /// Whether the end has been reached and its reason returned.
    is_over: bool,
}

impl SeekableRecording {
    /// Opens a recording at its beginning.
    ///
    /// # Errors
    /// If it cannot be read or has no channel of received bytes.
    pub fn new(source: Arc<dyn Source>, name: &Path) -> Result<Self, CaptureError> {
        let read_error = |error| CaptureError::Read {
            path: name.to_owned(),
            error,
        };
        let read = read_summary(&source).map_err(read_error)?;
        let contents = match read {
            Some(contents) => contents,
            None => read_through(&source).map_err(read_error)?,
        };
        let mut pieces =
            pieces(&source, PiecePosition::BEGINNING, contents.channels).map_err(read_error)?;
        // A damaged beginning may contain no message.
        let first_ns = pieces.next_ns().map_err(read_error)?;
        if !has_received(pieces.channels()) {
            return Err(CaptureError::NoRawBytes(name.to_owned()));
        }
        let start_ns = pieces.first_ns().or(first_ns).unwrap_or(0);
        Ok(Self {
            source,
            table: Arc::new(contents.table),
            start_ns,
            end_ns: contents.end_ns.max(start_ns),
            truth: contents.truth,
            baud: contents.baud,
            own: contents.own,
            has_times: !contents.has_estimated_times,
            pieces,
            at: Moment::ZERO,
            is_over: false,
        })
    }

    /// Log time of the next piece, nanoseconds. At the end, an error, with a reason unless the recording is finished.
    fn next_ns(&mut self) -> Result<u64, Option<String>> {
        match self.pieces.next_ns() {
            _ if self.is_over => Err(None),
            Ok(Some(at_ns)) => Ok(at_ns),
            Ok(None) if self.pieces.is_finished() => Err(None),
            Ok(None) => Err(Some(
                "the recording was interrupted: the file ends in the middle".to_owned(),
            )),
            Err(error) => Err(Some(format!(
                "reading the capture failed: {}",
                hint::words(&error)
            ))),
        }
    }

    fn since_start(&self, log_time_ns: u64) -> Moment {
        let at = Moment::from_nanos(log_time_ns.saturating_sub(self.start_ns));
        at.max(self.at)
    }
}

impl SeekableReader for SeekableRecording {
    fn next_at(&mut self) -> Option<Moment> {
        match self.next_ns() {
            Ok(at_ns) => Some(self.since_start(at_ns)),
            Err(reason) => reason.map(|_| self.at),
        }
    }

    fn next_piece(&mut self) -> Option<Piece<'_>> {
        match self.next_ns() {
            Ok(at_ns) => self.at = self.since_start(at_ns),
            Err(reason) => {
                self.is_over = true;
                return reason.map(Piece::Damaged);
            }
        }
        let (_, piece) = self.pieces.next_piece().ok()??;
        Some(piece)
    }

    fn place(&self) -> Place {
        let position = if self.is_over {
            PiecePosition::END
        } else {
            self.pieces.place()
        };
        Place {
            position,
            at: self.at,
        }
    }

    fn seek(&mut self, place: Place) {
        let channels = self.pieces.channels().clone();
        self.at = place.at;
        self.is_over = place.position == PiecePosition::END;
        if !self.is_over {
            match pieces(&self.source, place.position, channels) {
                Ok(pieces) => self.pieces = pieces,
                Err(_) => self.is_over = true,
            }
        }
    }

    fn find(&mut self, at: Moment) -> Place {
        let wanted_ns = self.start_ns.saturating_add(at.as_nanos() as u64);
        let beginning = Place {
            position: PiecePosition::BEGINNING,
            at: Moment::ZERO,
        };
        let entry = self.table.before(wanted_ns);
        entry
            .filter(|entry| entry.start_ns > self.start_ns)
            .map_or(beginning, |entry| Place {
                position: PiecePosition::of_record(entry.offset),
                at: Moment::from_nanos(entry.start_ns - self.start_ns),
            })
    }

    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)> {
        let entry = self.table.of_line(number)?;
        let record = indexed(&*self.source, entry.lines_at).ok()??;
        let body = record.get(HEAD_BYTES..)?;
        let Some(Record::MessageIndex(index)) = parse(op::MESSAGE_INDEX, body) else {
            return None;
        };
        let mut times_ns: Vec<u64> = index.records.iter().map(|entry| entry.log_time).collect();
        times_ns.sort_unstable();
        let before = entry.before.lines;
        let at_ns = *times_ns.get(usize::try_from(number - before - 1).ok()?)?;
        let earlier = times_ns.partition_point(|time_ns| *time_ns < at_ns) as u64;
        let at = Moment::from_nanos(at_ns.saturating_sub(self.start_ns));
        Some((at, before + earlier))
    }

    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool {
        let ns = |at: Moment| self.start_ns.saturating_add(at.as_nanos() as u64);
        self.table.may_hold(landmark, ns(from), ns(until))
    }

    fn length(&self) -> Moment {
        Moment::from_nanos(self.end_ns - self.start_ns)
    }

    fn reopen(&self) -> Box<dyn SeekableReader + Send> {
        let source = Arc::clone(&self.source);
        let channels = self.pieces.channels().clone();
        let mut reader = Self {
            pieces: Pieces::of_channels(SourceReader::new(&source, 0), channels),
            source,
            table: Arc::clone(&self.table),
            truth: self.truth.clone(),
            own: self.own.clone(),
            ..*self
        };
        reader.seek(self.place());
        Box::new(reader)
    }

    fn truth(&self) -> Option<Truth> {
        self.truth.clone()
    }

    fn baud(&self) -> Option<u32> {
        self.baud
    }

    fn own_lines(&self) -> Recognizer {
        self.own.clone()
    }

    fn has_times(&self) -> bool {
        self.has_times
    }

    fn unix(&self) -> Option<Moment> {
        Some(Moment::from_nanos(self.start_ns))
    }
}

/// Facts about a recording that are read before its messages.
#[derive(Default)]
struct Contents {
    table: ChunkTable,
    channels: Channels,
    end_ns: u64,
    truth: Option<Truth>,
    baud: Option<u32>,
    own: Recognizer,
    has_estimated_times: bool,
}

impl Contents {
    fn take_session(&mut self, session: &BTreeMap<String, String>) {
        let truth = session.get(Session::TRUTH);
        self.truth = truth.and_then(|truth| serde_json::from_str(truth).ok());
        let baud = session.get(Session::BAUD);
        self.baud = baud.and_then(|baud| baud.parse().ok());
        self.own = recognizer(Some(session));
        self.has_estimated_times = !Session::has_times(session);
    }

    fn take_metadata(&mut self, body: &[u8]) {
        if let Some(Record::Metadata(table)) = parse(op::METADATA, body)
            && table.name == Session::TABLE
        {
            self.take_session(&table.metadata);
        }
    }
}

/// Reads the summary of a finished file; returns `None` if there is none or it lists no chunks.
fn read_summary(source: &Arc<dyn Source>) -> io::Result<Option<Contents>> {
    let size = source.size()?;
    let mut end = [0; END_BYTES];
    let Some(end_at) = size.checked_sub(END_BYTES as u64) else {
        return Ok(None);
    };
    read_at(&**source, end_at, &mut end)?;
    let (footer, magic) = end.split_at(END_BYTES - MAGIC.len());
    let summary_at = match parse(op::FOOTER, &footer[HEAD_BYTES..]) {
        Some(Record::Footer(it)) if footer[0] == op::FOOTER && magic == MAGIC => it.summary_start,
        _ => 0,
    };
    let Some(from) = summary_at
        .checked_sub(DATA_END_BYTES)
        .filter(|_| summary_at < end_at)
    else {
        return Ok(None);
    };
    let position = Position {
        offset: from,
        record: 0,
    };
    let reader = SourceReader::new(source, from);
    let mut entries = Entries::resume(reader, position, Channels::new())?;
    let mut contents = Contents::default();
    while let Some(entry) = entries.next_entry()? {
        let Entry::Other { opcode, body } = entry else {
            continue;
        };
        if opcode == op::CHANNEL
            && let Some(id) = body.first_chunk()
        {
            let id = u16::from_le_bytes(*id);
            if let Some(channel) = entries.channels().get(&id) {
                contents.table.know(id, channel);
            }
            continue;
        }
        if !matches!(opcode, op::CHUNK_INDEX | op::METADATA_INDEX) {
            continue;
        }
        match parse(opcode, body) {
            Some(Record::ChunkIndex(index)) if index.chunk_start_offset < from => {
                contents.end_ns = contents.end_ns.max(index.message_end_time);
                contents.table.add(&index);
            }
            Some(Record::MetadataIndex(index)) if index.name == Session::TABLE => {
                if let Some(record) = indexed(&**source, index.offset)? {
                    contents.take_metadata(record.get(HEAD_BYTES..).unwrap_or_default());
                }
            }
            _ => {}
        }
    }
    contents.channels = entries.channels().clone();
    Ok(contents.table.last().is_some().then_some(contents))
}

/// Reads a file without a summary from its beginning to its end.
fn read_through(source: &Arc<dyn Source>) -> io::Result<Contents> {
    let mut pieces = Pieces::new(SourceReader::new(source, 0));
    let mut contents = Contents::default();
    while let Some(at_ns) = pieces.next_ns()? {
        let offset = pieces.part_offset();
        let last = contents.table.last();
        if last.is_none_or(|last| offset >= last.offset + SPACING_BYTES) {
            contents.table.add_uncounted(at_ns, offset);
        }
        pieces.next_piece()?;
    }
    contents.end_ns = pieces.last_ns();
    contents.channels = pieces.channels().clone();
    contents.take_session(pieces.session());
    Ok(contents)
}

/// The record at an offset of the file, with its head; `None` if it is too long or cut off.
fn indexed(source: &dyn Source, offset: u64) -> io::Result<Option<Vec<u8>>> {
    let mut head = [0; HEAD_BYTES];
    if read_at(source, offset, &mut head)? < HEAD_BYTES {
        return Ok(None);
    }
    let Some((_, length)) = crate::record::head(&head) else {
        return Ok(None);
    };
    if length as u64 > INDEXED_BYTES_MAX {
        return Ok(None);
    }
    let mut record = vec![0; HEAD_BYTES + length];
    let read = read_at(source, offset, &mut record)?;
    Ok((read == record.len()).then_some(record))
}

/// Reads pieces, beginning at a position.
fn pieces(
    source: &Arc<dyn Source>,
    place: PiecePosition,
    channels: Channels,
) -> io::Result<Pieces<SourceReader>> {
    Pieces::resume(SourceReader::new(source, place.offset()), place, channels)
}

/// Reads a source, beginning at an offset.
struct SourceReader {
    source: Arc<dyn Source>,
    offset: u64,
}

impl SourceReader {
    fn new(source: &Arc<dyn Source>, offset: u64) -> Self {
        Self {
            source: Arc::clone(source),
            offset,
        }
    }
}

impl Read for SourceReader {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        let read = self.source.read_at(self.offset, to)?;
        self.offset += read as u64;
        Ok(read)
    }
}
