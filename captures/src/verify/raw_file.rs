//! Whether a raw text holds the same bytes as a recording.

use std::io::{self, Read};

use groundwave_protocol::LINE_BYTES;

use super::{Comparison, Verdict};
use crate::messages::RawBytes;
use crate::text::TextReader;

/// Number of equal bytes below which a file that the operator did not name counts as another capture. Sessions of one robot begin
/// with equal lines: it starts at (0, 0) and reports its version and its abilities.
const UNRELATED_BYTES: u64 = 16 * LINE_BYTES as u64;

/// A raw text to compare with the received bytes of a recording.
pub struct RawCopy {
    /// The text.
    pub source: Box<dyn Read>,
    /// Whether the operator named the file. Otherwise it was found beside the recording, and may be another capture.
    pub is_named: bool,
}

/// Compares a raw text with the received bytes of a recording.
pub(super) struct RawFile {
    source: RadioBytes,
    is_named: bool,
    offset: u64,
    /// Result up to the offset.
    result: Comparison,
}

impl RawFile {
    pub(super) fn new(copy: RawCopy) -> Self {
        let source = RadioBytes {
            reader: TextReader::new(copy.source),
            unread: Vec::new(),
        };
        Self {
            source,
            is_named: copy.is_named,
            offset: 0,
            result: Comparison::Same,
        }
    }

    /// Compares the next received bytes; the first difference is a fault.
    pub(super) fn compare(&mut self, raw: &RawBytes, verdict: &mut Verdict) -> io::Result<()> {
        if self.result != Comparison::Same {
            return Ok(());
        }
        let skipped = raw.stream_offset.saturating_sub(self.offset);
        io::copy(&mut self.source.by_ref().take(skipped), &mut io::sink())?;
        let length = raw.data.len() as u64;
        let mut theirs = Vec::with_capacity(raw.data.len());
        self.source.by_ref().take(length).read_to_end(&mut theirs)?;
        self.offset = raw.stream_offset.saturating_add(length);
        if theirs != raw.data {
            let equal = theirs.iter().zip(&raw.data).take_while(|(a, b)| a == b);
            let byte = raw.stream_offset.saturating_add(equal.count() as u64);
            if byte < UNRELATED_BYTES && !self.is_named {
                self.result = Comparison::OtherCapture;
                return Ok(());
            }
            verdict.fault(format!("the raw file differs from byte {byte} on"));
            self.result = Comparison::Different;
        }
        Ok(())
    }

    /// The result; remaining bytes are a fault.
    pub(super) fn finish(mut self, verdict: &mut Verdict) -> io::Result<Comparison> {
        if self.result == Comparison::Same {
            let more = io::copy(&mut self.source, &mut io::sink())?;
            if more > 0 {
                verdict.fault(format!("the raw file has {more} more bytes"));
                self.result = Comparison::Different;
            }
        }
        Ok(self.result)
    }
}

/// The radio's bytes in a raw text, as a stream.
struct RadioBytes {
    reader: TextReader<Box<dyn Read>>,
    unread: Vec<u8>,
}

impl Read for RadioBytes {
    fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
        if self.unread.is_empty()
            && let Some(piece) = self.reader.next_piece()?
        {
            self.unread.extend_from_slice(piece.radio);
        }
        let length = self.unread.len().min(to.len());
        to[..length].copy_from_slice(&self.unread[..length]);
        self.unread.drain(..length);
        Ok(length)
    }
}
