//! What came in and is in no finished recording: the newest minutes of it.

use std::collections::VecDeque;
use std::time::Duration;

use groundwave_protocol::LINE_BYTES;

use crate::capture::journal::{Entry, Kind};

/// However long it may be: ten hours of a radio at 2400 baud.
const BYTES_MAX: usize = 8 * 1024 * 1024;

/// What an entry takes besides its bytes.
const ENTRY_BYTES: usize = size_of::<Entry>();

/// The newest entries, oldest first.
#[derive(Debug)]
pub(super) struct History {
    entries: VecDeque<Entry>,
    bytes: usize,
    length_ns: u64,
}

impl History {
    pub(super) fn new(length: Duration) -> Self {
        Self {
            entries: VecDeque::new(),
            bytes: 0,
            length_ns: u64::try_from(length.as_nanos()).unwrap_or(u64::MAX),
        }
    }

    /// Remembers something, and forgets what is too old for it.
    pub(super) fn push(&mut self, entry: Entry) {
        let newest_ns = entry.at_ns;
        if !self.join(&entry) {
            self.bytes += entry.data.len() + ENTRY_BYTES;
            self.entries.push_back(entry);
        }
        self.trim(newest_ns);
    }

    fn trim(&mut self, newest_ns: u64) {
        while let Some(oldest) = self.entries.front() {
            let is_old = newest_ns.saturating_sub(oldest.at_ns) > self.length_ns;
            if !is_old && self.bytes <= BYTES_MAX {
                break;
            }
            self.bytes -= oldest.data.len() + ENTRY_BYTES;
            self.entries.pop_front();
        }
    }

    /// A port hands over single bytes: those of a line share an entry, which has the time of the last.
    fn join(&mut self, entry: &Entry) -> bool {
        let Some(last) = self.entries.back_mut().filter(|last| {
            last.kind == entry.kind
                && matches!(entry.kind, Kind::Rx)
                && last.data.len() + entry.data.len() <= LINE_BYTES
                && !last.data.ends_with(b"\n")
        }) else {
            return false;
        };
        last.data.extend_from_slice(&entry.data);
        last.at_ns = entry.at_ns;
        self.bytes += entry.data.len();
        true
    }

    /// When the oldest of it came in.
    pub(super) fn first_ns(&self) -> Option<u64> {
        self.entries.front().map(|entry| entry.at_ns)
    }

    /// Everything, oldest first.
    pub(super) fn entries(&self) -> Vec<Entry> {
        self.entries.iter().cloned().collect()
    }

    /// Takes everything away; nothing is remembered then.
    pub(super) fn take(&mut self) -> Self {
        let empty = Self {
            entries: VecDeque::new(),
            bytes: 0,
            length_ns: self.length_ns,
        };
        std::mem::replace(self, empty)
    }

    /// Puts what was taken away before what has come in since.
    pub(super) fn put_back(&mut self, mut taken: Self) {
        taken.entries.append(&mut self.entries);
        taken.bytes += self.bytes;
        if let Some(newest_ns) = taken.entries.back().map(|entry| entry.at_ns) {
            taken.trim(newest_ns);
        }
        *self = taken;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const S_NS: u64 = 1_000_000_000;

    fn rx(at_ns: u64, data: &[u8]) -> Entry {
        Entry {
            kind: Kind::Rx,
            at_ns,
            offset: 0,
            data: data.to_vec(),
        }
    }

    #[test]
    fn the_newest_minutes_are_kept() {
        let mut history = History::new(Duration::from_mins(10));
        for second in 0..3600 {
            history.push(rx(second * S_NS, b"line\n"));
        }
        let entries = history.entries();
        assert_eq!(entries.len(), 601);
        assert_eq!(entries[0].at_ns, 2999 * S_NS);
        let taken = history.take();
        assert_eq!((history.entries(), history.bytes), (Vec::new(), 0));
        history.push(rx(3600 * S_NS, b"line\n"));
        history.put_back(taken);
        assert_eq!(history.entries()[..600], entries[1..]);
        assert_eq!(history.entries().len(), 601);
        assert_eq!(history.bytes, 601 * (5 + ENTRY_BYTES));
    }

    #[test]
    fn single_bytes_share_an_entry_up_to_the_end_of_the_line() {
        let mut history = History::new(Duration::from_mins(10));
        for (at_ns, byte) in (0..).zip(b"one\ntwo\n") {
            history.push(rx(at_ns, &[*byte]));
        }
        assert_eq!(history.entries(), [rx(3, b"one\n"), rx(7, b"two\n")]);
    }

    #[test]
    fn it_is_bounded_however_much_comes_in() {
        let mut history = History::new(Duration::from_mins(10));
        for _ in 0..5000 {
            history.push(rx(0, &[0; 4096]));
        }
        let bytes: usize = history.entries().iter().map(|entry| entry.data.len()).sum();
        assert!(bytes <= BYTES_MAX && bytes > BYTES_MAX / 2, "{bytes}");
    }
}
