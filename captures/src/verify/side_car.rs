//! Whether what lies beside a recording holds the same bytes.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

use super::Verdict;
use crate::journal::{JournalReader, Kind};
use crate::messages::RawBytes;
use crate::text::TextReader;

/// A file with the bytes that a topic of the recording should have.
pub(super) struct SideCar {
    /// What to call it.
    name: &'static str,
    source: Box<dyn Read>,
    offset: u64,
    is_equal: bool,
}

impl SideCar {
    /// A raw capture, however it is stored.
    pub(super) fn raw(source: Box<dyn Read>) -> Self {
        let reader = TextReader::new(source);
        Self::new("the raw file", Box::new(Stream(Vec::new(), reader)))
    }

    /// One way of a journal.
    pub(super) fn journal(path: &Path, way: Kind) -> io::Result<Self> {
        let name = match way {
            Kind::Tx => "the journal of what was sent",
            _ => "the journal",
        };
        let entries = JournalReader::open(path)?;
        let entries = OneWay {
            entries,
            way,
            end: 0,
        };
        Ok(Self::new(name, Box::new(Stream(Vec::new(), entries))))
    }

    fn new(name: &'static str, source: Box<dyn Read>) -> Self {
        Self {
            name,
            source,
            offset: 0,
            is_equal: true,
        }
    }

    /// The same bytes must stand in it; what differs is told once.
    pub(super) fn compare(&mut self, raw: &RawBytes, verdict: &mut Verdict) -> io::Result<()> {
        if !self.is_equal {
            return Ok(());
        }
        let skipped = raw.stream_offset.saturating_sub(self.offset);
        io::copy(&mut self.source.by_ref().take(skipped), &mut io::sink())?;
        let length = raw.data.len() as u64;
        let mut theirs = Vec::with_capacity(raw.data.len());
        self.source.by_ref().take(length).read_to_end(&mut theirs)?;
        self.offset = raw.stream_offset + length;
        if theirs != raw.data {
            let equal = theirs.iter().zip(&raw.data).take_while(|(a, b)| a == b);
            let byte = raw.stream_offset + equal.count() as u64;
            verdict.fault(format!("{} differs from byte {byte} on", self.name));
            self.is_equal = false;
        }
        Ok(())
    }

    /// Nothing more may stand in it; says whether all was equal.
    pub(super) fn finish(mut self, verdict: &mut Verdict) -> io::Result<bool> {
        if self.is_equal {
            let more = io::copy(&mut self.source, &mut io::sink())?;
            if more > 0 {
                verdict.fault(format!("{} holds {more} bytes more", self.name));
                self.is_equal = false;
            }
        }
        Ok(self.is_equal)
    }
}

/// Gives out bytes in pieces.
trait Pieces {
    /// The next ones, none at the end.
    fn next(&mut self, to: &mut Vec<u8>) -> io::Result<()>;
}

impl<R: Read> Pieces for TextReader<R> {
    fn next(&mut self, to: &mut Vec<u8>) -> io::Result<()> {
        if let Some(piece) = self.next_piece()? {
            to.extend_from_slice(piece.radio);
        }
        Ok(())
    }
}

/// One way of a journal as a stream; what it does not have is zeros.
struct OneWay {
    entries: JournalReader<BufReader<File>>,
    way: Kind,
    end: u64,
}

impl Pieces for OneWay {
    fn next(&mut self, to: &mut Vec<u8>) -> io::Result<()> {
        while let Some(entry) = self.entries.next_entry()? {
            if entry.kind == self.way && !entry.data.is_empty() {
                let missing = entry.offset.saturating_sub(self.end);
                to.resize(usize::try_from(missing).unwrap_or(0), 0);
                to.extend_from_slice(&entry.data);
                self.end = entry.offset + entry.data.len() as u64;
                break;
            }
        }
        Ok(())
    }
}

/// Pieces as a stream of bytes, newest piece last.
struct Stream<P>(Vec<u8>, P);

impl<P: Pieces> Read for Stream<P> {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        if self.0.is_empty() {
            self.1.next(&mut self.0)?;
        }
        let length = self.0.len().min(to.len());
        to[..length].copy_from_slice(&self.0[..length]);
        self.0.drain(..length);
        Ok(length)
    }
}
