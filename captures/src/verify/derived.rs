//! Whether the topics of a recording are what follows from its bytes and events.
//!
//! Everything that was received, sent and told goes through the [`Deriver`] again, and what it says is held until the
//! recording says the same.

use std::collections::{BTreeMap, VecDeque};
use std::convert::Infallible;

use ::mcap::records::MessageHeader;
use prost::Message as _;

use super::Verdict;
use crate::messages::{RawBytes, StationEvent};
use crate::topics::{Deriver, RAW_RX, Topic, TopicMessage};

/// Derived messages of a topic that may wait for those of the recording.
const WAITING_MAX: usize = 4096;

/// A message that follows from what came before.
#[derive(Debug, PartialEq, Eq)]
struct Expected {
    times_ns: (u64, u64),
    data: Vec<u8>,
}

#[derive(Debug)]
struct Queue {
    expected: VecDeque<Expected>,
    /// The next message of the topic must be the first of `expected`. Where something is missing it may be another.
    is_aligned: bool,
}

/// What is to be expected of a recording.
pub(super) struct Derived {
    deriver: Deriver,
    queues: BTreeMap<Topic, Queue>,
    /// Everything from the beginning is here: what depends on it must be equal too, and so must all times.
    is_exact: bool,
}

impl Derived {
    pub(super) fn new() -> Self {
        Self {
            deriver: Deriver::new(),
            queues: BTreeMap::new(),
            is_exact: false,
        }
    }

    /// Nothing came before what comes now, and this version told what follows.
    pub(super) const fn begin(&mut self) {
        self.is_exact = true;
    }

    /// What came before is not known: this is a part.
    pub(super) fn forget_beginning(&mut self) {
        self.is_exact = false;
        for (topic, queue) in &mut self.queues {
            queue.is_aligned &= is_of_one_line(*topic);
        }
    }

    /// Something is missing: derived messages without one of the recording, and the other way round, are to be expected.
    pub(super) fn lose_track(&mut self) {
        self.is_exact = false;
        for queue in self.queues.values_mut() {
            queue.is_aligned = false;
        }
    }

    /// Takes bytes received, after so many that are missing.
    pub(super) fn take_received(&mut self, at_ns: u64, missing: u64, bytes: &[u8]) {
        let (queues, is_exact) = (&mut self.queues, self.is_exact);
        let mut take = |message: TopicMessage<'_>| {
            expect(queues, is_exact, &message);
            Ok::<(), Infallible>(())
        };
        if missing > 0 {
            let Ok(()) = self.deriver.skip_rx(missing, &mut take);
        }
        let Ok(()) = self.deriver.handle_rx(at_ns, bytes, &mut take);
        let Ok(()) = self.deriver.finish(&mut take);
    }

    /// Takes a message of any other topic: what the station has told, or what follows.
    pub(super) fn take(
        &mut self,
        topic: Topic,
        header: MessageHeader,
        data: &[u8],
        verdict: &mut Verdict,
    ) {
        let event = match topic {
            Topic::RawRx | Topic::Map => return,
            Topic::RawTx => {
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
            return self.compare(topic, header, data, verdict);
        };
        let (queues, is_exact) = (&mut self.queues, self.is_exact);
        let mut is_itself = true;
        let Ok(()) = self
            .deriver
            .handle_event(header.log_time, &event, |message| {
                // The first is the event as it was told.
                if !std::mem::take(&mut is_itself) {
                    expect(queues, is_exact, &message);
                }
                Ok::<(), Infallible>(())
            });
    }

    fn compare(&mut self, topic: Topic, header: MessageHeader, data: &[u8], verdict: &mut Verdict) {
        let is_exact = self.is_exact;
        let queue = queue(&mut self.queues, topic, is_exact);
        let times_ns = (header.log_time, header.publish_time);
        let is_it = |it: &Expected| it.data == data && (!is_exact || it.times_ns == times_ns);
        if queue.is_aligned && queue.expected.front().is_some_and(is_it) {
            queue.expected.pop_front();
            verdict.derived_equal += 1;
            return;
        }
        let found = queue.expected.iter().position(is_it);
        if queue.is_aligned {
            let (name, number) = (topic.name(), header.sequence);
            verdict.fault(format!(
                "{name}: message {number} is not what {RAW_RX} decodes to"
            ));
            queue.is_aligned = false;
        } else if let Some(place) = found {
            queue.expected.drain(..=place);
            queue.is_aligned = is_exact || is_of_one_line(topic);
            verdict.derived_equal += 1;
            return;
        }
        verdict.derived_unchecked += 1;
    }

    /// What was expected and did not come, of the topics that the recording has.
    pub(super) fn finish(&self, has: impl Fn(Topic) -> bool, verdict: &mut Verdict) {
        for (topic, queue) in &self.queues {
            let count = queue.expected.len();
            if queue.is_aligned && count > 0 && has(*topic) {
                let name = topic.name();
                verdict.fault(format!(
                    "{count} messages that follow from {RAW_RX} are not on {name}"
                ));
            }
        }
    }
}

/// Whether a message follows from one line alone, and not from what came before it.
const fn is_of_one_line(topic: Topic) -> bool {
    matches!(
        topic,
        Topic::Telemetry | Topic::Tf | Topic::Pose | Topic::Sonar
    )
}

fn queue(queues: &mut BTreeMap<Topic, Queue>, topic: Topic, is_exact: bool) -> &mut Queue {
    queues.entry(topic).or_insert_with(|| Queue {
        expected: VecDeque::new(),
        is_aligned: is_exact || is_of_one_line(topic),
    })
}

fn expect(queues: &mut BTreeMap<Topic, Queue>, is_exact: bool, message: &TopicMessage<'_>) {
    if matches!(message.topic, Topic::RawRx | Topic::RawTx) {
        return;
    }
    let queue = queue(queues, message.topic, is_exact);
    queue.expected.push_back(Expected {
        times_ns: (message.log_time_ns, message.publish_time_ns),
        data: message.data.to_vec(),
    });
    if queue.expected.len() > WAITING_MAX {
        // Of a topic that is there the end tells that it lacks so many.
        queue.expected.pop_front();
    }
}
