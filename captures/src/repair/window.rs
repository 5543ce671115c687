//! Reading ahead in a source.

use std::io::{self, Read};

/// Number of bytes read at a time.
const READ_BYTES: usize = 256 << 10;

/// The unread part of a source; it begins with a record.
pub(super) struct Window<R> {
    source: R,
    bytes: Vec<u8>,
    start: usize,
    /// Offset in the file of the byte at `start`.
    pub(super) offset: u64,
    has_ended: bool,
}

impl<R: Read> Window<R> {
    pub(super) const fn new(source: R) -> Self {
        Self {
            source,
            bytes: Vec::new(),
            start: 0,
            offset: 0,
            has_ended: false,
        }
    }

    /// At least `wanted` unread bytes; fewer only at the end of the source.
    pub(super) fn fill(&mut self, wanted: usize) -> io::Result<&[u8]> {
        while self.bytes.len() - self.start < wanted && !self.has_ended {
            self.bytes.drain(..self.start);
            self.start = 0;
            // In proportion to what is moved, so that moving takes linear time.
            let missing = wanted - self.bytes.len();
            let missing = missing.max(READ_BYTES).max(self.bytes.len() / 4) as u64;
            let mut source = self.source.by_ref().take(missing);
            self.has_ended = source.read_to_end(&mut self.bytes)? == 0;
        }
        Ok(&self.bytes[self.start..])
    }

    /// Drops bytes at the beginning.
    pub(super) const fn advance(&mut self, bytes: usize) {
        self.start += bytes;
        self.offset += bytes as u64;
    }
}
