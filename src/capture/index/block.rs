//! The messages of one chunk that say what happened.

use std::collections::BTreeMap;
use std::ops::Range;

use ::mcap::McapError;
use ::mcap::records::{Record, op};
use ::mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::capture::topics::{self, RAW_RX, RAW_TX};

const UPLINK: &str = topics::Topic::Uplink.name();
const LOG: &str = topics::Topic::Log.name();

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

/// The topics that say what happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Topic {
    Received,
    Sent,
    Uplink,
    Log,
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
        _ => return,
    };
    topics.insert(channel.id, topic);
}

/// Takes the messages of our topics out of a record, with every checksum checked.
pub(super) fn unpack(
    topics: &mut BTreeMap<u16, Topic>,
    record: &[u8],
    block: &mut Block,
) -> Result<(), McapError> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(CHUNK_BYTES_MAX as usize);
    let mut reader = LinearReader::new_with_options(options);
    let mut unread = record;
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let length = wanted.min(unread.len());
                reader.insert(wanted)[..length].copy_from_slice(&unread[..length]);
                reader.notify_read(length);
                unread = &unread[length..];
            }
            LinearReadEvent::Record { opcode, data } => match opcode {
                op::CHANNEL => take_channel(topics, data),
                op::MESSAGE => {
                    let Record::Message { header, data } = ::mcap::parse_record(opcode, data)?
                    else {
                        continue;
                    };
                    block.first_ns.get_or_insert(header.log_time);
                    if let Some(topic) = topics.get(&header.channel_id) {
                        let from = block.bytes.len();
                        block.bytes.extend_from_slice(&data);
                        let range = from..block.bytes.len();
                        block
                            .items
                            .push((header.log_time, Item::Message(*topic, range)));
                    }
                }
                _ => {}
            },
        }
    }
    Ok(())
}
