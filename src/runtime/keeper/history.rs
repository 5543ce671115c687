//! The newest observations, for a recording that begins late.

use std::collections::VecDeque;
use std::time::Duration;

use groundwave_protocol::LINE_BYTES;
use prost::Message as _;

use crate::capture::Observation;
use crate::capture::topics::StationEvent;

/// Maximum memory of the history, bytes: ten hours of a radio at 2400 baud.
const BYTES_MAX: usize = 8 * 1024 * 1024;

/// Memory of an observation without its data, bytes.
const ENTRY_BYTES: usize = size_of::<(u64, Observation)>();

/// Observations that are not in a finished recording, with their times in nanoseconds since 1970.
#[derive(Debug)]
pub(super) struct History {
    entries: VecDeque<(u64, Observation)>,
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

    /// Adds an observation, and drops those that are too old.
    pub(super) fn push(&mut self, at_ns: u64, observation: Observation) {
        if !self.join(at_ns, &observation) {
            self.bytes += bytes(&observation);
            self.entries.push_back((at_ns, observation));
        }
        self.trim(at_ns);
    }

    fn trim(&mut self, newest_ns: u64) {
        while let Some((at_ns, oldest)) = self.entries.front() {
            let is_old = newest_ns.saturating_sub(*at_ns) > self.length_ns;
            if !is_old && self.bytes <= BYTES_MAX {
                break;
            }
            self.bytes -= bytes(oldest);
            self.entries.pop_front();
        }
    }

    /// Joins bytes to their line, because a port may deliver single bytes. The line gets the time of its last byte.
    fn join(&mut self, at_ns: u64, observation: &Observation) -> bool {
        let (Some((last_ns, Observation::Received(last))), Observation::Received(raw)) =
            (self.entries.back_mut(), observation)
        else {
            return false;
        };
        if last.data.len() + raw.data.len() > LINE_BYTES || last.data.ends_with(b"\n") {
            return false;
        }
        last.data.extend_from_slice(&raw.data);
        *last_ns = at_ns;
        self.bytes += raw.data.len();
        true
    }

    /// Time of the oldest observation, nanoseconds.
    pub(super) fn first_ns(&self) -> Option<u64> {
        self.entries.front().map(|(at_ns, _)| *at_ns)
    }

    /// Every observation, oldest first.
    pub(super) fn observations(&mut self) -> &[(u64, Observation)] {
        self.entries.make_contiguous()
    }

    /// Removes all observations and returns them.
    pub(super) fn take(&mut self) -> Self {
        let empty = Self {
            entries: VecDeque::new(),
            bytes: 0,
            length_ns: self.length_ns,
        };
        std::mem::replace(self, empty)
    }

    /// Puts removed observations back before newer ones.
    pub(super) fn put_back(&mut self, mut taken: Self) {
        taken.entries.append(&mut self.entries);
        taken.bytes += self.bytes;
        if let Some((newest_ns, _)) = taken.entries.back() {
            taken.trim(*newest_ns);
        }
        *self = taken;
    }
}

fn bytes(observation: &Observation) -> usize {
    let data = match observation {
        Observation::Received(raw) | Observation::Sent(raw) => raw.data.len(),
        Observation::Event(event) => size_of::<StationEvent>() + event.encoded_len(),
    };
    data + ENTRY_BYTES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::messages::RawBytes;
    use crate::event::{Level, NoticeCode};

    const S_NS: u64 = 1_000_000_000;

    fn push(history: &mut History, at_ns: u64, data: &[u8]) {
        history.push(at_ns, received(data));
    }

    fn received(data: &[u8]) -> Observation {
        Observation::Received(RawBytes {
            stream_offset: 0,
            data: data.to_vec(),
        })
    }

    #[test]
    fn the_newest_minutes_are_kept() {
        let mut history = History::new(Duration::from_mins(10));
        for second in 0..3600 {
            push(&mut history, second * S_NS, b"line\n");
        }
        let entries = history.observations().to_vec();
        assert_eq!(entries.len(), 601);
        assert_eq!(entries[0].0, 2999 * S_NS);
        let taken = history.take();
        assert!(history.observations().is_empty());
        assert_eq!(history.bytes, 0);
        push(&mut history, 3600 * S_NS, b"line\n");
        history.put_back(taken);
        assert_eq!(history.observations()[..600], entries[1..]);
        assert_eq!(history.observations().len(), 601);
        assert_eq!(history.bytes, 601 * (5 + ENTRY_BYTES));
    }

    #[test]
    fn single_bytes_share_an_entry_up_to_the_end_of_the_line() {
        let mut history = History::new(Duration::from_mins(10));
        for (at_ns, byte) in (0..).zip(b"one\ntwo\n") {
            push(&mut history, at_ns, &[*byte]);
        }
        let lines = [(3, received(b"one\n")), (7, received(b"two\n"))];
        assert_eq!(history.observations(), lines);
    }

    #[test]
    fn it_is_bounded_however_much_comes_in() {
        let mut history = History::new(Duration::from_mins(10));
        for _ in 0..5000 {
            push(&mut history, 0, &[0; 4096]);
        }
        let bytes = history.observations().len() * 4096;
        assert!(bytes <= BYTES_MAX && bytes > BYTES_MAX / 2, "{bytes}");
    }

    #[test]
    fn the_text_of_events_counts() {
        let mut history = History::new(Duration::from_mins(10));
        let text = "x".repeat(4096);
        let event = StationEvent::notice(NoticeCode::Other, Level::Info, text.as_str());
        for _ in 0..5000 {
            history.push(0, Observation::Event(Box::new(event.clone())));
        }
        let bytes = history.observations().len() * text.len();
        assert!(bytes <= BYTES_MAX && bytes > BYTES_MAX / 2, "{bytes}");
    }
}
