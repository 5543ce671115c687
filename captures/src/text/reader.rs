//! Reads raw text from its beginning.

use std::borrow::Cow;
use std::io::{self, Read};

use groundwave_protocol::telemetry::ACK_LINE_BYTES;

use super::{HEAD_BYTES, Style};
use crate::event::Moment;

/// A line or noise up to a line feed, or 80 bytes without a line feed. Lines shorter than 14 bytes may be joined.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece<'a> {
    /// Time since the capture began.
    pub at: Moment,
    /// Bytes as the radio delivered them.
    pub radio: &'a [u8],
    /// Bytes as stored in the file.
    pub stored: &'a [u8],
}

/// Reads pieces. The pieces do not depend on how the bytes arrive. The first piece is returned once the style is known.
pub struct TextReader<R> {
    source: R,
    buffer: Box<[u8]>,
    /// Range of the bytes read but not yet returned.
    unread: std::ops::Range<usize>,
    has_ended: bool,
    style: Option<Style>,
    offset: u64,
    last: Moment,
    /// The radio's bytes of the latest piece, if they differ from the file's.
    radio: Vec<u8>,
}

impl<R: Read> TextReader<R> {
    /// A reader from the beginning of `source`.
    pub fn new(source: R) -> Self {
        Self {
            source,
            buffer: vec![0; HEAD_BYTES].into(),
            unread: 0..0,
            has_ended: false,
            style: None,
            offset: 0,
            last: Moment::ZERO,
            radio: Vec::new(),
        }
    }

    /// Style of the text.
    ///
    /// # Errors
    /// If reading fails.
    pub fn style(&mut self) -> io::Result<Style> {
        let mut judged = 0;
        loop {
            if let Some(style) = self.style {
                return Ok(style);
            }
            let unread = &self.buffer[self.unread.clone()];
            // Each further line is considered.
            if unread[judged..].contains(&b'\n') {
                self.style = Style::of(unread);
            }
            judged = unread.len();
            if self.style.is_none() {
                if self.has_ended || judged == self.buffer.len() {
                    self.style = Some(Style::of_own_lines(unread));
                } else {
                    self.fill()?;
                }
            }
        }
    }

    /// Style of the text; `None` while it is unknown.
    #[must_use]
    pub const fn judged(&self) -> Option<Style> {
        self.style
    }

    /// The next piece.
    ///
    /// # Errors
    /// If reading fails.
    pub fn next_piece(&mut self) -> io::Result<Option<Piece<'_>>> {
        let style = self.style()?;
        let length = loop {
            let unread = &self.buffer[self.unread.clone()];
            let length = style.piece_bytes(unread);
            let is_whole = length == style.reach() || unread[..length].ends_with(b"\n");
            // Until then, another short line can still be joined.
            let is_complete = length >= ACK_LINE_BYTES || unread.len() >= ACK_LINE_BYTES;
            if is_whole && is_complete || self.has_ended {
                break length;
            }
            self.fill()?;
        };
        if length == 0 {
            return Ok(None);
        }
        let start = self.unread.start;
        self.unread.start += length;
        self.offset += length as u64;
        let stored = &self.buffer[start..start + length];
        self.last = style.time(stored, self.offset, self.last);
        let radio = match style.radio(stored) {
            Cow::Borrowed(radio) => radio,
            Cow::Owned(radio) => {
                self.radio = radio;
                &self.radio
            }
        };
        Ok(Some(Piece {
            at: self.last,
            radio,
            stored,
        }))
    }

    fn fill(&mut self) -> io::Result<()> {
        self.buffer.copy_within(self.unread.clone(), 0);
        self.unread = 0..self.unread.len();
        let read = loop {
            match self.source.read(&mut self.buffer[self.unread.end..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read?,
            }
        };
        self.unread.end += read;
        self.has_ended = read == 0;
        Ok(())
    }
}
