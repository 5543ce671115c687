//! The messages of one chunk that say what happened.

use std::collections::BTreeMap;
use std::ops::Range;

use ::mcap::records::Record;

use crate::topics::{self, RAW_RX, RAW_TX};
use crate::unpacker::{Problem, Unpacker};
use crate::writer::next_record;
use crate::writer::records::{HEAD_BYTES, Reader, op};

const UPLINK: &str = topics::Topic::Uplink.name();
const LOG: &str = topics::Topic::Log.name();
const TELEMETRY: &str = topics::Topic::Telemetry.name();

/// The largest chunk that is believed.
pub(super) const CHUNK_BYTES_MAX: u64 = 64 * 1024 * 1024;

/// A message of a chunk.
#[derive(Clone, Debug)]
pub(super) enum Item {
    /// A message of one of our topics: which, and where its bytes are.
    Message(Topic, Range<usize>),
    /// The chunk, or what follows it, cannot be read.
    Damage(String),
}

/// The topics that say what happened, and one that is only counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Received,
    Sent,
    Uplink,
    Log,
    Telemetry,
}

/// The messages of one chunk.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    pub(super) offset: u64,
    /// Where the record after it begins; `None` where nothing can follow.
    pub(super) next: Option<u64>,
    /// Log time of its first message, of whatever topic.
    pub(super) first_ns: Option<u64>,
    pub(super) items: Vec<(u64, Item)>,
    /// What the chunk holds; the items say where in it they are.
    pub(super) bytes: Vec<u8>,
}

pub(super) fn take_channel(topics: &mut BTreeMap<u16, Topic>, body: &[u8]) {
    let Ok(Record::Channel(channel)) = ::mcap::parse_record(op::CHANNEL, body) else {
        return;
    };
    let topic = match channel.topic.as_str() {
        RAW_RX => Topic::Received,
        RAW_TX => Topic::Sent,
        UPLINK => Topic::Uplink,
        LOG => Topic::Log,
        TELEMETRY => Topic::Telemetry,
        _ => return,
    };
    topics.insert(channel.id, topic);
}

/// Takes the messages of our topics out of a record, a chunk whose checksum holds or a message.
pub(super) fn unpack(
    unpacker: &mut Unpacker,
    topics: &mut BTreeMap<u16, Topic>,
    record: &[u8],
    block: &mut Block,
) -> Result<(), Problem> {
    if record.first() == Some(&op::CHUNK) {
        let body = record.get(HEAD_BYTES..).unwrap_or_default();
        unpacker
            .unpack(body, CHUNK_BYTES_MAX as usize, &mut block.bytes)
            .map_err(|(problem, _)| problem)?;
    } else {
        block.bytes.extend_from_slice(record);
    }
    let mut rest = Reader(&block.bytes);
    while !rest.0.is_empty() {
        let (opcode, body) = next_record(&mut rest).ok_or(NONSENSE)?;
        let end = block.bytes.len() - rest.0.len();
        match opcode {
            op::CHANNEL => take_channel(topics, body),
            op::MESSAGE => {
                let message = MessageHead::read(body).ok_or(NONSENSE)?;
                block.first_ns.get_or_insert(message.log_time_ns);
                let topic = topics.get(&message.channel_id);
                if let Some(topic) = topic.filter(|topic| **topic != Topic::Telemetry) {
                    let range = end - message.data_bytes..end;
                    block
                        .items
                        .push((message.log_time_ns, Item::Message(*topic, range)));
                }
            }
            _ => {}
        }
    }
    Ok(())
}

const NONSENSE: &str = "the inside of a chunk makes no sense";

/// What is said before the data of a message.
struct MessageHead {
    channel_id: u16,
    log_time_ns: u64,
    data_bytes: usize,
}

impl MessageHead {
    fn read(body: &[u8]) -> Option<Self> {
        let mut fields = Reader(body);
        let (channel_id, _sequence) = (fields.u16()?, fields.u32()?);
        let (log_time_ns, _publish_time_ns) = (fields.u64()?, fields.u64()?);
        Some(Self {
            channel_id,
            log_time_ns,
            data_bytes: fields.0.len(),
        })
    }
}
