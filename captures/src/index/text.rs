//! Seekable raw text.

use std::borrow::Cow;
use std::io;
use std::ops::Range;
use std::sync::Arc;

use groundwave_protocol::decoder::Decoder;

use super::prefilter::Prefilter;
use super::{Piece, Place, SeekableReader, Source, read_at};
use crate::event::Landmark;
use crate::event::Moment;
use crate::hint;
use crate::pieces::PiecePosition;
use crate::text::{HEAD_BYTES, Style};

/// Number of bytes that are searched at once for the last timestamp.
const TAIL_BYTES: u64 = 4096;

/// Maximum number of bytes at the end that are searched for the last timestamp.
const TAIL_SEARCH_BYTES: u64 = 16 << 20;

/// Distance between the samples for counting days when timestamps have no date, bytes: four minutes of lines.
const DAYS_STEP_BYTES: usize = 64 * 1024;

/// Length of such a sample, bytes; long enough to contain the beginning of a line.
const DAYS_SAMPLE_BYTES: usize = 512;

/// Time before the beginning of a search from which lines are read, to know the state at the beginning.
const READ_BEFORE: Moment = Moment::from_mins(3);

/// Number of samples for estimating the density of lines.
const SAMPLES: u64 = 64;

/// Length of such a sample, bytes: fifty lines.
const SAMPLE_BYTES: usize = 4096;

/// Maximum number of bytes searched for a timestamp.
const STAMP_SEARCH_BYTES: u64 = 1 << 20;

/// Maximum number of pieces searched for a landmark in one call: three hours of lines.
const LANDMARK_SEARCH_PIECES: usize = 32_768;

/// A raw text with random access.
#[derive(Clone)]
pub struct SeekableText {
    source: Arc<dyn Source>,
    size: u64,
    style: Style,
    /// Offsets and times for counting days.
    days: Vec<(u64, Moment)>,
    length: Moment,
    buffer: Box<[u8]>,
    /// Offset in the file of the buffer's beginning.
    buffered_at: u64,
    filled: usize,
    place: Place,
    /// The next piece: its range in the buffer, and its time.
    ahead: Option<(Range<usize>, Moment)>,
    /// The radio's bytes of the piece returned last.
    current: Vec<u8>,
    /// Reason why reading failed; returned once.
    problem: Option<String>,
}

impl SeekableText {
    /// Reads from the beginning.
    ///
    /// # Errors
    /// If reading fails.
    pub fn new(source: Arc<dyn Source>) -> io::Result<Self> {
        let size = source.size()?;
        let mut buffer = vec![0; HEAD_BYTES].into_boxed_slice();
        let head = read_at(&*source, 0, &mut buffer)?;
        let style =
            Style::of(&buffer[..head]).unwrap_or_else(|| Style::of_own_lines(&buffer[..head]));
        let mut reader = Self {
            source,
            size,
            style,
            days: Vec::new(),
            length: style.on_the_wire(size),
            buffer,
            buffered_at: 0,
            filled: head,
            place: Place::default(),
            ahead: None,
            current: Vec::new(),
            problem: None,
        };
        if style.goes_round() {
            reader.count_days()?;
        }
        if style.is_stamped() {
            reader.length = reader.last_time()?;
        }
        Ok(reader)
    }

    fn count_days(&mut self) -> io::Result<()> {
        let mut lines = [0; DAYS_SAMPLE_BYTES];
        let mut last = Moment::ZERO;
        for offset in (0..self.size).step_by(DAYS_STEP_BYTES) {
            let read = read_at(&*self.source, offset, &mut lines)?;
            let mut at = offset;
            for line in lines[..read].split_inclusive(|&byte| byte == b'\n') {
                // The first bytes may be the end of a line.
                let is_whole = at > offset || offset == 0;
                if let Some(said) = self.style.said(line, last).filter(|_| is_whole) {
                    last = said;
                    self.days.push((at, said));
                    break;
                }
                at += line.len() as u64;
            }
        }
        Ok(())
    }

    /// Estimates the time of the piece at an offset; never later than its real time.
    fn about(&self, offset: u64) -> Moment {
        let after = self.days.partition_point(|(from, _)| *from <= offset);
        let day = after.checked_sub(1).and_then(|n| self.days.get(n));
        day.map_or(Moment::ZERO, |(_, at)| *at)
    }

    /// The last time in the capture, searched from its end.
    fn last_time(&self) -> io::Result<Moment> {
        let mut bytes = [0; TAIL_BYTES as usize];
        let earliest = self.size.saturating_sub(TAIL_SEARCH_BYTES);
        let mut end = self.size;
        while end > earliest {
            let from = end.saturating_sub(TAIL_BYTES);
            let part = &mut bytes[..(end - from) as usize];
            let read = read_at(&*self.source, from, part)?;
            let about = self.about(from);
            // The first bytes may be the end of a line; they are read with the part before.
            let lines = part[..read].split_inclusive(|&byte| byte == b'\n');
            let lines = lines.skip(usize::from(from > 0));
            let times = lines.filter_map(|line| self.style.said_until(line, about));
            if let Some(last) = times.last() {
                return Ok(last);
            }
            if from == 0 {
                break;
            }
            end = from + self.style.reach() as u64;
        }
        Ok(self.about(earliest))
    }

    /// At least `wanted` bytes from an offset; fewer only at the end of the file.
    fn fill(&mut self, offset: u64, wanted: usize) -> &[u8] {
        let end = self.buffered_at + self.filled as u64;
        let wanted_end = (offset + wanted as u64).min(self.size);
        if offset < self.buffered_at || wanted_end > end {
            self.buffered_at = offset;
            self.filled = match read_at(&*self.source, offset, &mut self.buffer) {
                Ok(read) => read,
                Err(error) => {
                    let text = format!("reading the capture failed: {}", hint::words(&error));
                    self.problem = Some(text);
                    self.size = offset;
                    0
                }
            };
            // The file was truncated while it was read.
            if self.filled < wanted {
                self.size = self.size.min(offset + self.filled as u64);
            }
        }
        let from = (offset - self.buffered_at) as usize;
        self.buffer.get(from..self.filled).unwrap_or_default()
    }

    fn look_ahead(&mut self) -> Option<&(Range<usize>, Moment)> {
        if self.ahead.is_none() && self.problem.is_none() {
            let (offset, last, style) = (self.place.position.offset(), self.place.at, self.style);
            let bytes = self.fill(offset, style.reach());
            let length = style.piece_bytes(bytes);
            if length > 0 {
                let at = style.time(&bytes[..length], offset + length as u64, last);
                let from = (offset - self.buffered_at) as usize;
                self.ahead = Some((from..from + length, at));
            }
        }
        self.ahead.as_ref()
    }

    /// Offset at which the line around an offset begins; the offset itself if there is no line.
    fn line_start(&mut self, offset: u64) -> u64 {
        let from = offset.saturating_sub(4 * self.style.reach() as u64);
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

    /// Time and offset of the first line with a timestamp at or shortly after an offset.
    fn time_after(&mut self, mut offset: u64, until: u64) -> Option<(Moment, u64)> {
        let style = self.style;
        let until = until.min(offset.saturating_add(STAMP_SEARCH_BYTES));
        while offset < until {
            let about = self.about(offset);
            let bytes = self.fill(offset, style.reach());
            let length = style.piece_bytes(bytes);
            if length == 0 {
                return None;
            }
            if let Some(at) = style.said(&bytes[..length], about) {
                return Some((at, offset));
            }
            offset += length as u64;
        }
        None
    }

    /// Estimated offset of line `number`, by evenly spaced samples.
    fn about_offset(&self, number: u64) -> Option<u64> {
        let step = (self.size / SAMPLES).max(SAMPLE_BYTES as u64);
        let mut left = number.saturating_sub(1) as f64;
        for from in (0..self.size).step_by(usize::try_from(step).ok()?) {
            let lines_per_byte = self.lines_per_byte(from);
            let lines = lines_per_byte * step.min(self.size - from) as f64;
            if left < lines {
                return Some(from + (left / lines_per_byte) as u64);
            }
            left -= lines;
        }
        None
    }

    /// Intact lines per byte in the sample at an offset.
    fn lines_per_byte(&self, offset: u64) -> f64 {
        let mut bytes = [0; SAMPLE_BYTES];
        let read = read_at(&*self.source, offset, &mut bytes).unwrap_or_default();
        let mut rest = &bytes[..read];
        let mut decoder = Decoder::default();
        let mut looked_at = 0;
        // The sample may begin and end inside a line.
        let mut is_whole = offset == 0;
        while rest.len() >= self.style.reach() {
            let (piece, after) = rest.split_at(self.style.piece_bytes(rest));
            rest = after;
            if is_whole {
                decoder.lines(&self.style.radio(piece)).for_each(drop);
                looked_at += piece.len();
            }
            is_whole = true;
        }
        decoder.counters().lines as f64 / looked_at.max(1) as f64
    }

    /// The last line with a timestamp before a moment.
    fn find_time(&mut self, at: Moment) -> Place {
        let (mut low, mut high) = (0, self.size);
        let mut found = Place::default();
        while low < high {
            let middle = self.line_start(low + (high - low) / 2).max(low);
            match self.time_after(middle, high) {
                Some((said, offset)) if said < at => {
                    found = Place {
                        position: PiecePosition::of_record(offset),
                        // A position before the line, so that the line's own timestamp counts.
                        at: said.saturating_sub(Moment::from_nanos(1)),
                    };
                    // Continue after the line.
                    let style = self.style;
                    low = offset + style.piece_bytes(self.fill(offset, style.reach())) as u64;
                }
                _ => high = middle,
            }
        }
        found
    }
}

impl SeekableReader for SeekableText {
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
        let offset = self.place.position.offset() + range.len() as u64;
        self.place.position = PiecePosition::of_record(offset);
        self.place.at = at;
        match self.style.radio(&self.buffer[range]) {
            Cow::Borrowed(bytes) => Some(Piece::Received(bytes)),
            Cow::Owned(bytes) => {
                self.current = bytes;
                Some(Piece::Received(&self.current))
            }
        }
    }

    fn place(&self) -> Place {
        self.place
    }

    fn seek(&mut self, place: Place) {
        if place != self.place {
            self.place = place;
            self.ahead = None;
        }
    }

    fn find(&mut self, at: Moment) -> Place {
        self.ahead = None;
        if self.style.is_stamped() {
            return self.find_time(at);
        }
        let (mut low, mut high) = (0, self.size);
        while low < high {
            let middle = low + (high - low) / 2;
            if self.style.on_the_wire(middle) < at {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        let offset = self.line_start(low.saturating_sub(1));
        Place {
            position: PiecePosition::of_record(offset),
            at: self.style.on_the_wire(offset),
        }
    }

    fn about_line(&mut self, number: u64) -> Option<(Moment, u64)> {
        self.ahead = None;
        let offset = self.about_offset(number)?;
        let from = self.line_start(offset);
        let at = if self.style.is_stamped() {
            self.time_after(from, self.size)?.0
        } else {
            // The previous line ended at this time.
            self.style.on_the_wire(from) + Moment::from_nanos(1)
        };
        Some((at, number.saturating_sub(1)))
    }

    fn may_hold(&mut self, landmark: Landmark, from: Moment, until: Moment) -> bool {
        let Some(mut prefilter) = Prefilter::of(landmark) else {
            return true;
        };
        let mut ahead = self.clone();
        let place = ahead.find(from.saturating_sub(READ_BEFORE));
        ahead.seek(place);
        for _ in 0..LANDMARK_SEARCH_PIECES {
            let Some(at) = ahead.next_at() else {
                break;
            };
            if at > until {
                return false;
            }
            let Some(Piece::Received(bytes)) = ahead.next_piece() else {
                return true;
            };
            if prefilter.may_hold(bytes) && at >= from {
                return true;
            }
        }
        // Reading finds the end, and distant landmarks.
        true
    }

    fn length(&self) -> Moment {
        self.length
    }

    fn reopen(&self) -> Box<dyn SeekableReader + Send> {
        Box::new(self.clone())
    }

    fn has_times(&self) -> bool {
        self.style.is_stamped()
    }

    fn unix(&self) -> Option<Moment> {
        self.style.unix()
    }
}
