//! The side-car of a recording: everything that goes into it, as it came and at once.
//!
//! Each read of the radio, each write to it and each event of the station is one entry, written in one
//! call before anything else looks at it, so that a killed program has lost nothing. An entry has its
//! time, its place in its stream and a checksum, and a damaged one costs itself alone. A recording that
//! has been finished holds the same, and its journal goes; one that was interrupted is made whole from
//! it.
//!
//! An entry: `1E` hex; a letter, the kind; 32 bits, the bytes of data; 64 bits, nanoseconds since 1970;
//! 64 bits, bytes of its stream before it; the data; 32 bits, the CRC-32 of everything after `1E`.
//! Numbers are little-endian.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::{Path, PathBuf};

use prost::Message;

use super::error::create;
use super::recover::claim;
use super::topics::StationEvent;
use super::{CaptureError, Existing};

const MARK: u8 = 0x1E;
/// What every journal begins with: the mark and the kind of its first entry.
pub(super) const BEGIN: [u8; 2] = [MARK, Kind::Session as u8];

const HEAD_BYTES: usize = 22;
const CRC_BYTES: usize = 4;

/// A longer entry is not believed.
const DATA_BYTES_MAX: usize = 1024 * 1024;

const BUFFER_BYTES: usize = 256 * 1024;

/// What an entry holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// What the recording says about itself: JSON, always the first entry.
    Session = b's',
    /// Bytes received.
    Rx = b'r',
    /// Bytes sent.
    Tx = b't',
    /// A [`StationEvent`].
    Event = b'e',
}

impl Kind {
    const ALL: [Self; 4] = [Self::Session, Self::Rx, Self::Tx, Self::Event];

    fn from_letter(letter: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == letter)
    }
}

/// An entry as it was read; its data may still be where it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry<D = Vec<u8>> {
    /// What it holds.
    pub kind: Kind,
    /// Nanoseconds since 1970.
    pub at_ns: u64,
    /// Bytes of its stream before it; zero for what is no stream.
    pub offset: u64,
    /// The bytes, or the message.
    pub data: D,
}

impl Entry {
    /// An event as an entry.
    #[must_use]
    pub fn of_event(at_ns: u64, event: &StationEvent) -> Self {
        Self {
            kind: Kind::Event,
            at_ns,
            offset: 0,
            data: event.encode_to_vec(),
        }
    }
}

impl<D: AsRef<[u8]>> Entry<D> {
    /// Bytes of its stream up to its end.
    #[must_use]
    pub fn end(&self) -> u64 {
        let bytes = self.data.as_ref().len() as u64;
        self.offset.saturating_add(bytes)
    }

    /// The event that it holds, if it is one.
    #[must_use]
    pub fn event(&self) -> Option<StationEvent> {
        let data = self.data.as_ref();
        match self.kind {
            Kind::Event => StationEvent::decode(data).ok(),
            Kind::Session | Kind::Rx | Kind::Tx => None,
        }
    }
}

/// Writes a journal, each entry in one call and without a buffer.
#[derive(Debug)]
pub struct JournalWriter {
    path: PathBuf,
    file: File,
    bytes: u64,
    rx_bytes: u64,
    tx_bytes: u64,
    problem: Option<CaptureError>,
    /// The latest, whether it could be written or not.
    entry: Vec<u8>,
}

impl JournalWriter {
    /// Creates the file, and keeps others from taking it for one that nobody writes any more.
    ///
    /// # Errors
    /// When it exists or cannot be made.
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, CaptureError> {
        let path = path.into();
        let file = create(&path, Existing::Refuse, false)?;
        claim(&file);
        Ok(Self {
            file,
            path,
            bytes: 0,
            rx_bytes: 0,
            tx_bytes: 0,
            problem: None,
            entry: Vec::new(),
        })
    }

    /// Says what the recording is; the first entry.
    pub fn session(&mut self, at_ns: u64, json: &[u8]) {
        self.append(Kind::Session, at_ns, 0, json);
    }

    /// Writes bytes just read from the radio.
    pub fn rx(&mut self, at_ns: u64, bytes: &[u8]) {
        self.append(Kind::Rx, at_ns, self.rx_bytes, bytes);
        self.rx_bytes += bytes.len() as u64;
    }

    /// Writes bytes that go to the radio.
    pub fn tx(&mut self, at_ns: u64, bytes: &[u8]) {
        self.append(Kind::Tx, at_ns, self.tx_bytes, bytes);
        self.tx_bytes += bytes.len() as u64;
    }

    /// Writes an entry that belongs to no stream, such as an event.
    pub fn entry(&mut self, entry: &Entry) {
        self.append(entry.kind, entry.at_ns, 0, &entry.data);
    }

    /// The latest entry as it stands in the file, or would if nothing had gone wrong: for [`entries`].
    pub(super) fn latest(&self) -> &[u8] {
        &self.entry
    }

    /// Nothing here fails: after an error nothing more is written, and [`Self::problem`] tells.
    fn append(&mut self, kind: Kind, at_ns: u64, offset: u64, data: &[u8]) {
        let entry = &mut self.entry;
        entry.clear();
        entry.push(MARK);
        entry.push(kind as u8);
        entry.extend((data.len() as u32).to_le_bytes());
        entry.extend(at_ns.to_le_bytes());
        entry.extend(offset.to_le_bytes());
        entry.extend(data);
        let crc = crc32fast::hash(&entry[1..]);
        entry.extend(crc.to_le_bytes());
        if self.problem.is_some() {
            return;
        }
        match self.file.write_all(entry) {
            Ok(()) => self.bytes += entry.len() as u64,
            Err(error) => {
                self.problem = Some(CaptureError::Write {
                    path: self.path.clone(),
                    error,
                });
            }
        }
    }

    /// Bytes received and written since the beginning, or meant to be.
    #[must_use]
    pub const fn rx_bytes(&self) -> u64 {
        self.rx_bytes
    }

    /// Bytes sent and written since the beginning, or meant to be.
    #[must_use]
    pub const fn tx_bytes(&self) -> u64 {
        self.tx_bytes
    }

    /// Bytes in the file.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Why writing has ended, if it has.
    #[must_use]
    pub fn problem(&self) -> Option<String> {
        self.problem.as_ref().map(ToString::to_string)
    }

    pub(super) const fn has_failed(&self) -> bool {
        self.problem.is_some()
    }

    #[cfg(test)]
    pub(super) fn fail(&mut self) {
        self.problem = Some(CaptureError::Write {
            path: self.path.clone(),
            error: io::ErrorKind::StorageFull.into(),
        });
    }

    pub(super) fn take_problem(&mut self) -> Option<CaptureError> {
        self.problem.take()
    }

    /// The file, for whoever makes the disk keep it.
    ///
    /// # Errors
    /// When the system has no handle left.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }
}

/// Bytes of a journal that are of no use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Waste {
    /// Bytes that belong to no entry, all of them.
    pub bytes: u64,
    /// How many of them stand behind the last entry.
    pub tail_bytes: u64,
    /// Those behind it are the beginning of an entry: the program was ended while it wrote.
    pub is_cut: bool,
}

impl Waste {
    /// Something of it was not what it should be, and nobody can say what it held.
    #[must_use]
    pub const fn has_damage(&self) -> bool {
        self.bytes > self.tail_bytes || (self.tail_bytes > 0 && !self.is_cut)
    }
}

/// Reads a journal, and steps over what is damaged.
pub struct JournalReader<R> {
    source: R,
    buffer: Vec<u8>,
    start: usize,
    has_ended: bool,
    waste: Waste,
}

impl JournalReader<BufReader<File>> {
    /// Opens a journal.
    ///
    /// # Errors
    /// When the file cannot be opened.
    pub fn open(path: &Path) -> io::Result<Self> {
        Ok(Self::new(BufReader::with_capacity(
            BUFFER_BYTES,
            File::open(path)?,
        )))
    }
}

impl<R: Read> JournalReader<R> {
    /// A reader from the beginning of a journal.
    pub const fn new(source: R) -> Self {
        Self {
            source,
            buffer: Vec::new(),
            start: 0,
            has_ended: false,
            waste: Waste {
                bytes: 0,
                tail_bytes: 0,
                is_cut: false,
            },
        }
    }

    /// Bytes that belong to no entry, up to the entry read last.
    #[must_use]
    pub const fn waste(&self) -> Waste {
        self.waste
    }

    /// The next entry; `None` at the end.
    ///
    /// # Errors
    /// When reading fails.
    pub fn next_entry(&mut self) -> io::Result<Option<Entry>> {
        loop {
            self.fill(HEAD_BYTES + CRC_BYTES)?;
            let rest = &self.buffer[self.start..];
            if rest.is_empty() {
                return Ok(None);
            }
            if let Some(length) = claimed_bytes(rest) {
                self.fill(length)?;
                let rest = &self.buffer[self.start..];
                if let Some(entry) = rest.get(..length).and_then(parse) {
                    self.start += length;
                    self.waste.tail_bytes = 0;
                    return Ok(Some(entry));
                }
            }
            if self.waste.tail_bytes == 0 {
                self.waste.is_cut = is_cut(&self.buffer[self.start..]);
            }
            self.waste.bytes += 1;
            self.waste.tail_bytes += 1;
            self.start += 1;
        }
    }

    /// Has so many bytes at hand, unless the file ends before.
    fn fill(&mut self, bytes: usize) -> io::Result<()> {
        if self.start > BUFFER_BYTES {
            self.buffer.drain(..self.start);
            self.start = 0;
        }
        while !self.has_ended && self.buffer.len() - self.start < bytes {
            let before = self.buffer.len();
            self.buffer.resize(before + BUFFER_BYTES, 0);
            let read = self.source.read(&mut self.buffer[before..]);
            self.buffer.truncate(before + *read.as_ref().unwrap_or(&0));
            match read {
                Ok(0) => self.has_ended = true,
                Ok(_) => {}
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// How long the entry would be that begins here.
fn claimed_bytes(from: &[u8]) -> Option<usize> {
    let head = from.get(..HEAD_BYTES).filter(|head| head[0] == MARK)?;
    Kind::from_letter(head[1])?;
    let data_bytes = u32::from_le_bytes(head[2..6].try_into().ok()?) as usize;
    (data_bytes <= DATA_BYTES_MAX).then_some(HEAD_BYTES + data_bytes + CRC_BYTES)
}

/// Whether this, up to the end of the journal, can be the beginning of an entry.
fn is_cut(rest: &[u8]) -> bool {
    if let Some(bytes) = claimed_bytes(rest) {
        return bytes > rest.len();
    }
    let has_kind = rest.get(1).is_none_or(|l| Kind::from_letter(*l).is_some());
    rest.len() < HEAD_BYTES && rest.first() == Some(&MARK) && has_kind
}

fn parse(entry: &[u8]) -> Option<Entry> {
    let (said, crc) = entry.split_last_chunk::<CRC_BYTES>()?;
    if crc32fast::hash(&said[1..]) != u32::from_le_bytes(*crc) {
        return None;
    }
    let Entry {
        kind,
        at_ns,
        offset,
        data,
    } = fields(said)?;
    Some(Entry {
        kind,
        at_ns,
        offset,
        data: data.to_vec(),
    })
}

/// An entry without its checksum.
fn fields(said: &[u8]) -> Option<Entry<&[u8]>> {
    Some(Entry {
        kind: Kind::from_letter(*said.get(1)?)?,
        at_ns: u64::from_le_bytes(said.get(6..14)?.try_into().ok()?),
        offset: u64::from_le_bytes(said.get(14..HEAD_BYTES)?.try_into().ok()?),
        data: said.get(HEAD_BYTES..)?,
    })
}

/// Entries one after the other that never left the memory, so that nothing can have happened to them.
pub(super) fn entries(mut rest: &[u8]) -> impl Iterator<Item = Entry<&[u8]>> {
    std::iter::from_fn(move || {
        let (entry, later) = rest.split_at_checked(claimed_bytes(rest)?)?;
        rest = later;
        fields(entry.get(..entry.len() - CRC_BYTES)?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(reads: &[&[u8]]) -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let mut writer = JournalWriter::create(&path).unwrap();
        writer.session(1, b"{}");
        for (at_ns, read) in (2..).zip(reads) {
            writer.rx(at_ns, read);
        }
        assert_eq!(writer.problem(), None);
        std::fs::read(path).unwrap()
    }

    fn received(bytes: &[u8]) -> (Vec<(u64, Vec<u8>)>, u64) {
        let mut reader = JournalReader::new(bytes);
        let mut received = Vec::new();
        while let Some(entry) = reader.next_entry().unwrap() {
            if entry.kind == Kind::Rx {
                received.push((entry.offset, entry.data));
            }
        }
        (received, reader.waste().bytes)
    }

    #[test]
    fn what_was_written_is_read() {
        let bytes = journal(&[b"one", b"", b"\x1Er\x03\0\0\0", b"four"]);
        let (received, damaged) = received(&bytes);
        assert_eq!(damaged, 0);
        let offsets: Vec<u64> = received.iter().map(|entry| entry.0).collect();
        assert_eq!(offsets, [0, 3, 3, 9]);
        let stream: Vec<u8> = received.into_iter().flat_map(|entry| entry.1).collect();
        assert_eq!(stream, b"one\x1Er\x03\0\0\0four");
    }

    #[test]
    fn damage_costs_the_entry_that_has_it() {
        let reads: Vec<Vec<u8>> = (0..20_u8).map(|n| vec![n; 30]).collect();
        let reads: Vec<&[u8]> = reads.iter().map(Vec::as_slice).collect();
        let whole = journal(&reads);
        for byte in 0..whole.len() {
            let mut bad = whole.clone();
            bad[byte] ^= 1 << (byte % 8);
            let (entries, damaged) = received(&bad);
            assert!(entries.len() >= 19, "byte {byte}");
            assert!(damaged > 0, "byte {byte}");
            for (offset, data) in entries {
                assert_eq!(data, reads[offset as usize / 30], "byte {byte}");
            }
        }
        for length in 0..whole.len() {
            let (entries, _) = received(&whole[..length]);
            assert!(entries.len() * 56 <= length);
        }
    }
}
