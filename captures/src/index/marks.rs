//! Where the chunks of a recording begin, and how much lies before them, in bounded memory.

use super::chunk_index::Counts;
use crate::event::Landmark;

/// Chunks that are kept; of more, every other is forgotten.
const MARKS_MAX: usize = 4096;

/// Where a chunk begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    /// Log time of its first message.
    pub(super) start_ns: u64,
    /// Byte in the file.
    pub(super) offset: u64,
    /// Messages of the chunks before it.
    pub(super) before: Counts,
}

/// Chunks in the order of the file, which is that of their times.
#[derive(Clone, Debug)]
pub(super) struct Marks {
    kept: Vec<Mark>,
    /// Of so many chunks one is kept.
    stride: u64,
    /// Chunks seen so far.
    chunks: u64,
    /// Their messages.
    counts: Counts,
    /// Each has said how many messages of which topic it holds.
    are_counted: bool,
}

impl Default for Marks {
    fn default() -> Self {
        Self {
            kept: Vec::new(),
            stride: 1,
            chunks: 0,
            counts: Counts::ZERO,
            are_counted: true,
        }
    }
}

impl Marks {
    /// Takes the next chunk and what it says of the number of its messages.
    pub(super) fn add(&mut self, start_ns: u64, offset: u64, counts: Option<Counts>) {
        if self.chunks.is_multiple_of(self.stride) {
            self.kept.push(Mark {
                start_ns,
                offset,
                before: self.counts,
            });
        }
        self.are_counted &= counts.is_some();
        self.counts.add(counts.unwrap_or(Counts::ZERO));
        self.chunks += 1;
        if self.kept.len() > MARKS_MAX {
            let mut keep = false;
            self.kept.retain(|_| {
                keep = !keep;
                keep
            });
            self.stride *= 2;
        }
    }

    pub(super) fn first(&self) -> Option<&Mark> {
        self.kept.first()
    }

    /// The last that begins before a log time, and the one after that.
    pub(super) fn around(&self, at_ns: u64) -> (Option<&Mark>, Option<&Mark>) {
        let after = self.kept.partition_point(|mark| mark.start_ns < at_ns);
        let before = after.checked_sub(1).and_then(|n| self.kept.get(n));
        (before, self.kept.get(after))
    }

    /// The last before which there are fewer lines than a number; `None` where nobody counted them, or there are not so many.
    pub(super) fn before_line(&self, number: u64) -> Option<&Mark> {
        let is_there = self.are_counted && self.counts.lines >= number;
        let fewer = |mark: &Mark| mark.before.lines < number;
        let after = self.kept.partition_point(fewer);
        self.kept.get(after.checked_sub(1).filter(|_| is_there)?)
    }

    /// Whether there may be a landmark of a kind from one log time until another.
    pub(super) fn may_hold(&self, landmark: Landmark, from_ns: u64, until_ns: u64) -> bool {
        let count = |counts: Counts| match landmark {
            // The recorder tells of each in a message.
            Landmark::Bump => counts.logs,
            Landmark::Command => counts.uplinks,
            // Not of every one of these.
            Landmark::Line | Landmark::Alarm | Landmark::Behaviour | Landmark::Marker => None,
        };
        let later = self.kept.partition_point(|mark| mark.start_ns <= until_ns);
        // What is said of the end is not relied on.
        let Some(after) = self.kept.get(later).filter(|_| self.are_counted) else {
            return true;
        };
        let (before, _) = self.around(from_ns);
        let before = before.map_or(Counts::ZERO, |mark| mark.before);
        match (count(before), count(after.before)) {
            (Some(before), Some(after)) => after > before,
            _ => true,
        }
    }
}
