//! Compares the derived messages of a recording with the messages derived again from its bytes and events.
//!
//! The [`Deriver`] gets the received bytes, sent bytes and events again; its messages wait for the equal messages of the
//! recording.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

use ::mcap::records::MessageHeader;
use prost::Message as _;

use super::Verdict;
use crate::messages::{RawBytes, StationEvent};
use crate::topics::{Deriver, Origin, RAW_RX, Topic, TopicMessage};
use crate::words::counted;

/// Maximum number of derived messages of a topic that wait for the recording's messages.
const WAITING_MAX: usize = 512;

/// Maximum bytes of a topic's messages that wait, unless one alone has more.
const WAITING_BYTES_MAX: usize = 1 << 20;

/// A derived message.
#[derive(Debug, PartialEq, Eq)]
struct Expected {
    times_ns: (u64, u64),
    data: Vec<u8>,
}

#[derive(Debug)]
struct Queue {
    expected: VecDeque<Expected>,
    /// Bytes of these messages.
    bytes: usize,
    /// Number of messages that waited in vain and made room.
    dropped: usize,
    /// Whether the next message of the topic must equal the first of `expected`; after a gap, it may equal a later one.
    is_aligned: bool,
}

/// The messages expected of a recording.
pub(super) struct Derived {
    deriver: Deriver,
    queues: BTreeMap<Topic, Queue>,
    /// Messages that follow from none of the bytes and events before them; they may follow from the end of the recording.
    held: Vec<(Topic, MessageHeader, Vec<u8>)>,
    held_bytes: usize,
    /// Whether the recording is complete from its beginning, so that every message and time must be equal.
    is_exact: bool,
}

impl Derived {
    pub(super) fn new() -> Self {
        Self {
            deriver: Deriver::new(),
            queues: BTreeMap::new(),
            held: Vec::new(),
            held_bytes: 0,
            is_exact: false,
        }
    }

    /// Sets that the recording begins here and was written by this version.
    pub(super) const fn begin(&mut self) {
        self.is_exact = true;
    }

    /// Takes the session's table.
    pub(super) fn take_session(&mut self, table: &BTreeMap<String, String>) {
        self.deriver.take_session(table);
    }

    /// Sets that the recording is a part, whose earlier state is unknown.
    pub(super) fn forget_beginning(&mut self) {
        self.is_exact = false;
        for (topic, queue) in &mut self.queues {
            queue.is_aligned &= topic.origin() != Origin::History;
        }
    }

    /// Takes a gap in the bytes; after it, derived and recorded messages may differ for a while.
    pub(super) fn lose_track(&mut self) {
        self.is_exact = false;
        for queue in self.queues.values_mut() {
            queue.is_aligned = false;
        }
    }

    /// Takes received bytes after `missing` lost bytes.
    pub(super) fn take_received(
        &mut self,
        at_ns: u64,
        missing: u64,
        bytes: &[u8],
        verdict: &mut Verdict,
    ) {
        self.compare_held(verdict);
        let (queues, is_exact) = (&mut self.queues, self.is_exact);
        let mut take = |message: TopicMessage<'_>| {
            expect(queues, is_exact, &message);
            Ok::<(), Infallible>(())
        };
        if missing > 0 {
            let Ok(()) = self.deriver.skip_rx(missing, &mut take);
        }
        let Ok(()) = self.deriver.handle_rx(at_ns, bytes, &mut take);
        let Ok(()) = self.deriver.flush(&mut take);
    }

    /// Takes a message of any other topic: an event of the station, or a derived message.
    pub(super) fn take(
        &mut self,
        topic: Topic,
        header: MessageHeader,
        data: &[u8],
        verdict: &mut Verdict,
    ) {
        let event = match topic {
            Topic::RawRx => return,
            Topic::RawTx => {
                self.compare_held(verdict);
                if let Ok(sent) = RawBytes::decode(data) {
                    let nowhere = |_: TopicMessage<'_>| Ok::<(), Infallible>(());
                    let Ok(()) = self.deriver.handle_tx(header.log_time, &sent.data, nowhere);
                }
                return;
            }
            Topic::Station => StationEvent::decode(data).ok(),
            _ => None,
        };
        let Some(event) = event else {
            let is_expected = !queue(&mut self.queues, topic, self.is_exact)
                .expected
                .is_empty();
            let bytes = self.held_bytes + data.len();
            if is_expected || self.held.len() >= WAITING_MAX || bytes > WAITING_BYTES_MAX {
                return self.compare(topic, header, data, verdict);
            }
            self.held_bytes = bytes;
            return self.held.push((topic, header, data.to_vec()));
        };
        self.compare_held(verdict);
        let (queues, is_exact) = (&mut self.queues, self.is_exact);
        let mut is_itself = true;
        let Ok(()) = self
            .deriver
            .handle_event(header.log_time, &event, |message| {
                // The first is the event itself.
                if !std::mem::take(&mut is_itself) {
                    expect(queues, is_exact, &message);
                }
                Ok::<(), Infallible>(())
            });
    }

    fn compare_held(&mut self, verdict: &mut Verdict) {
        self.held_bytes = 0;
        for (topic, header, data) in std::mem::take(&mut self.held) {
            self.compare(topic, header, &data, verdict);
        }
    }

    fn compare(&mut self, topic: Topic, header: MessageHeader, data: &[u8], verdict: &mut Verdict) {
        let is_exact = self.is_exact;
        let times_ns = (header.log_time, header.publish_time);
        let is_it = |it: &Expected| it.data == data && (!is_exact || it.times_ns == times_ns);
        let queue = queue(&mut self.queues, topic, is_exact);
        if queue.is_aligned && queue.expected.front().is_some_and(is_it) {
            queue.drop_first(1);
            verdict.derived_equal += 1;
            return;
        }
        let found = queue.expected.iter().position(is_it);
        if queue.is_aligned {
            let (name, number) = (topic.name(), header.sequence);
            verdict.fault(format!(
                "{name}: message {number} is not what {} decodes to",
                source(topic)
            ));
            queue.is_aligned = false;
        } else if let Some(place) = found {
            queue.is_aligned = is_exact || topic.origin() != Origin::History;
            queue.drop_first(place + 1);
            verdict.derived_equal += 1;
            return;
        }
        verdict.derived_unchecked += 1;
    }

    /// Takes the end of the recording; reports expected messages that are missing on its topics.
    pub(super) fn finish(mut self, has: impl Fn(Topic) -> bool, verdict: &mut Verdict) {
        let (queues, is_exact) = (&mut self.queues, self.is_exact);
        let Ok(()) = self.deriver.finish(|message| {
            expect(queues, is_exact, &message);
            Ok::<(), Infallible>(())
        });
        self.compare_held(verdict);
        for (topic, queue) in &self.queues {
            let count = queue.dropped + queue.expected.len();
            if queue.is_aligned && count > 0 && has(*topic) {
                let name = topic.name();
                let messages = counted(count as u64, "message");
                let from = source(*topic);
                verdict.fault(format!("{name} lacks {messages} derived from {from}"));
            }
        }
    }
}

impl Queue {
    fn push(&mut self, message: Expected) {
        self.bytes += message.data.len();
        self.expected.push_back(message);
        while self.expected.len() > WAITING_MAX
            || self.bytes > WAITING_BYTES_MAX && self.expected.len() > 1
        {
            self.drop_first(1);
            self.dropped += 1;
        }
    }

    fn drop_first(&mut self, count: usize) {
        let dropped = self.expected.drain(..count);
        self.bytes -= dropped.map(|it| it.data.len()).sum::<usize>();
    }
}

/// The topic from which the messages of this one are derived.
const fn source(topic: Topic) -> &'static str {
    match topic.origin() {
        Origin::Event => Topic::Station.name(),
        Origin::Line | Origin::History | Origin::Recorded => RAW_RX,
    }
}

fn queue(queues: &mut BTreeMap<Topic, Queue>, topic: Topic, is_exact: bool) -> &mut Queue {
    queues.entry(topic).or_insert_with(|| Queue {
        expected: VecDeque::new(),
        bytes: 0,
        dropped: 0,
        is_aligned: is_exact || topic.origin() != Origin::History,
    })
}

fn expect(queues: &mut BTreeMap<Topic, Queue>, is_exact: bool, message: &TopicMessage<'_>) {
    if matches!(message.topic, Topic::RawRx | Topic::RawTx) {
        return;
    }
    queue(queues, message.topic, is_exact).push(Expected {
        times_ns: (message.log_time_ns, message.publish_time_ns),
        data: message.data.to_vec(),
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Form;

    #[test]
    fn messages_held_for_the_end_take_bounded_memory() {
        let (mut derived, mut verdict) = (Derived::new(), Verdict::new(Form::Mcap));
        for sequence in 0..10 {
            let header = MessageHeader {
                channel_id: 6,
                sequence,
                log_time: 0,
                publish_time: 0,
            };
            derived.take(Topic::Pose, header, &vec![0; 400_000], &mut verdict);
            let bytes: usize = derived.held.iter().map(|(.., data)| data.len()).sum();
            assert_eq!(bytes, derived.held_bytes);
            assert!(bytes <= WAITING_BYTES_MAX, "{bytes}");
        }
    }

    #[test]
    fn messages_that_wait_in_vain_are_counted_and_take_bounded_memory() {
        let mut queues = BTreeMap::new();
        for (length, count) in [(1, 2000), (100_000, 100), (3 << 20, 2)] {
            let queue = queue(&mut queues, Topic::Telemetry, false);
            let before = queue.dropped + queue.expected.len();
            for _ in 0..count {
                queue.push(Expected {
                    times_ns: (0, 0),
                    data: vec![0; length],
                });
                let bytes: usize = queue.expected.iter().map(|it| it.data.len()).sum();
                assert_eq!(queue.bytes, bytes);
                assert!(bytes <= WAITING_BYTES_MAX.max(length), "{bytes}");
                assert!(queue.expected.len() <= WAITING_MAX);
            }
            assert_eq!(queue.dropped + queue.expected.len(), before + count);
        }
    }
}
