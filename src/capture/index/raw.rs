//! Raw captures from any place.

use std::io;
use std::ops::Range;
use std::sync::Arc;

use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};

use super::stamps::{STAMP_BYTES_MAX, Stamps};
use super::{Piece, Place, Source, Tape, read_at};
use crate::capture::raw::on_the_wire;
use crate::event::Moment;

const BUFFER_BYTES: usize = 64 * 1024;

/// Of so much at the beginning it is judged whether lines are stamped.
const HEAD_BYTES: usize = 16 * 1024;

/// The longest line with a stamp; what is longer is taken apart.
const STAMPED_BYTES_MAX: usize = STAMP_BYTES_MAX + LINE_BYTES;

/// The last stamp is looked for in so much of the end.
const TAIL_BYTES: u64 = 4096;

/// A raw capture.
///
/// Its pieces are its lines, noise or not, or 80 bytes without a line feed. Where most lines begin with a
/// time that is when they happened, and lines with the same time follow each other at 2400 baud; else the
/// times are those of a 2400-baud radio that never paused.
#[derive(Clone)]
pub struct RawTape {
    source: Arc<dyn Source>,
    size: u64,
    stamps: Option<Stamps>,
    length: Moment,
    buffer: Box<[u8]>,
    /// Where in the file the buffer begins.
    buffered_at: u64,
    filled: usize,
    place: Place,
    /// The next piece: where it is in the buffer, and when it happened.
    ahead: Option<(Range<usize>, Moment)>,
    /// Reading failed: what is told once.
    problem: Option<String>,
}

impl RawTape {
    /// A capture from its beginning.
    ///
    /// # Errors
    /// When reading fails.
    pub fn new(source: Arc<dyn Source>) -> io::Result<Self> {
        let size = source.size()?;
        let mut buffer = vec![0; BUFFER_BYTES].into_boxed_slice();
        let head = read_at(&*source, 0, &mut buffer[..HEAD_BYTES])?;
        let is_longer_than_a_day = size > 86_400 * u64::from(BYTES_PER_S);
        let mut tape = Self {
            stamps: Stamps::of(&buffer[..head], is_longer_than_a_day),
            source,
            size,
            length: on_the_wire(size),
            buffer,
            buffered_at: 0,
            filled: head,
            place: Place::default(),
            ahead: None,
            problem: None,
        };
        if let Some(stamps) = tape.stamps {
            tape.length = tape.last_stamp(stamps)?;
        }
        Ok(tape)
    }

    fn last_stamp(&mut self, stamps: Stamps) -> io::Result<Moment> {
        let mut tail = [0; TAIL_BYTES as usize];
        let from = self.size.saturating_sub(TAIL_BYTES);
        let read = read_at(&*self.source, from, &mut tail)?;
        let lines = tail[..read].split_inclusive(|&byte| byte == b'\n');
        let last = lines.filter_map(|line| stamps.read(line)).next_back();
        Ok(last.map_or(Moment::ZERO, |(at, resolution)| at + resolution))
    }

    /// Makes the buffer hold what there is from an offset on, so many bytes at least.
    fn fill(&mut self, offset: u64, wanted: usize) -> &[u8] {
        let end = self.buffered_at + self.filled as u64;
        let wanted_end = (offset + wanted as u64).min(self.size);
        if offset < self.buffered_at || wanted_end > end {
            self.buffered_at = offset;
            self.filled = match read_at(&*self.source, offset, &mut self.buffer) {
                Ok(read) => read,
                Err(error) => {
                    let text = format!("the capture cannot be read on: {error}");
                    self.problem = Some(text);
                    self.size = offset;
                    0
                }
            };
            // Cut off while it is read: what is gone is not waited for.
            if self.filled < wanted {
                self.size = self.size.min(offset + self.filled as u64);
            }
        }
        let from = (offset - self.buffered_at) as usize;
        self.buffer.get(from..self.filled).unwrap_or_default()
    }

    fn look_ahead(&mut self) -> Option<&(Range<usize>, Moment)> {
        if self.ahead.is_none() && self.problem.is_none() {
            let offset = self.place.offset;
            let reach = if self.stamps.is_some() {
                STAMPED_BYTES_MAX
            } else {
                LINE_BYTES
            };
            let (stamps, last) = (self.stamps, self.place.at);
            let bytes = self.fill(offset, reach);
            let reach = bytes.len().min(reach);
            let line_feed = bytes[..reach].iter().position(|&byte| byte == b'\n');
            let length = line_feed.map_or(reach, |at| at + 1);
            if length > 0 {
                let wire = on_the_wire(length as u64);
                let at = match stamps {
                    None => on_the_wire(offset + length as u64),
                    Some(stamps) => match stamps.read(&bytes[..length]) {
                        Some((stamp, _)) if stamp > last => stamp,
                        Some((stamp, resolution)) => {
                            let latest = stamp + resolution * 9 / 10;
                            last.max(latest.min(last + wire))
                        }
                        None => last,
                    },
                };
                let from = (offset - self.buffered_at) as usize;
                self.ahead = Some((from..from + length, at));
            }
        }
        self.ahead.as_ref()
    }

    /// The beginning of the line in which an offset lies; the offset itself, where no line is.
    fn line_start(&mut self, offset: u64) -> u64 {
        const REACH: u64 = 4 * STAMPED_BYTES_MAX as u64;
        let from = offset.saturating_sub(REACH);
        if from == 0 && offset == 0 {
            return 0;
        }
        let length = (offset - from) as usize;
        let bytes = self.fill(from, length);
        let bytes = &bytes[..bytes.len().min(length)];
        match bytes.iter().rposition(|&byte| byte == b'\n') {
            Some(at) => from + at as u64 + 1,
            None if from == 0 => 0,
            None => offset,
        }
    }

    /// The stamp of the first line with one at an offset or after it, and where the line begins.
    fn stamp_after(&mut self, mut offset: u64, until: u64) -> Option<(Moment, u64)> {
        let stamps = self.stamps?;
        while offset < until {
            let bytes = self.fill(offset, STAMPED_BYTES_MAX);
            let reach = bytes.len().min(STAMPED_BYTES_MAX);
            let line_feed = bytes[..reach].iter().position(|&byte| byte == b'\n');
            let length = line_feed.map_or(reach, |at| at + 1);
            if length == 0 {
                return None;
            }
            if let Some((at, _)) = stamps.read(&bytes[..length]) {
                return Some((at, offset));
            }
            offset += length as u64;
        }
        None
    }

    /// The last line whose stamp is before a moment.
    fn find_stamp(&mut self, at: Moment) -> Place {
        let (mut low, mut high) = (0, self.size);
        let mut found = Place::default();
        while low < high {
            let middle = self.line_start(low + (high - low) / 2).max(low);
            match self.stamp_after(middle, high) {
                Some((stamp, offset)) if stamp < at => {
                    found = Place {
                        offset,
                        at: Moment::ZERO,
                        ..Place::default()
                    };
                    // The line after it, whatever it is.
                    low = offset + 1;
                    let line = self.fill(offset, STAMPED_BYTES_MAX);
                    let line_feed = line.iter().position(|&byte| byte == b'\n');
                    low += line_feed.unwrap_or_default() as u64;
                }
                _ => high = middle,
            }
        }
        found
    }
}

impl Tape for RawTape {
    fn next_at(&mut self) -> Option<Moment> {
        let last = self.place.at;
        let ahead = self.look_ahead().map(|(_, at)| *at);
        ahead.or_else(|| self.problem.is_some().then_some(last))
    }

    fn next_piece(&mut self) -> Option<Piece<'_>> {
        self.look_ahead();
        if let Some(problem) = self.problem.take() {
            return Some(Piece::Damaged(problem));
        }
        let (range, at) = self.ahead.take()?;
        self.place.offset += range.len() as u64;
        self.place.at = at;
        Some(Piece::Received(&self.buffer[range]))
    }

    fn place(&self) -> Place {
        self.place
    }

    fn go(&mut self, place: Place) {
        if place != self.place {
            self.place = place;
            self.ahead = None;
        }
    }

    fn find(&mut self, at: Moment) -> Place {
        self.ahead = None;
        if self.stamps.is_some() {
            return self.find_stamp(at);
        }
        let byte = (at.as_secs_f64() * f64::from(BYTES_PER_S)) as u64;
        let offset = self.line_start(byte.min(self.size));
        Place {
            offset,
            at: on_the_wire(offset),
            ..Place::default()
        }
    }

    fn length(&self) -> Moment {
        self.length
    }

    fn again(&self) -> Box<dyn Tape + Send> {
        Box::new(self.clone())
    }

    fn unix(&self) -> Option<Moment> {
        self.stamps.and_then(|stamps| stamps.unix())
    }
}
