//! What holds of a damaged recording, taken over.

use std::io;

use prost::Message;

use super::channels::{Raw, Topics};
use super::fill::Balance;
use crate::composer::Composer;
use crate::journal::{Entry, Kind};
use crate::messages::RawBytes;
use crate::topics::Topic;
use crate::walk::Part;
use crate::writer::Attachment;
use crate::writer::records::{HEAD_BYTES, Reader, op};

/// Writes one thing that holds, and lets the deriver know of it.
pub(super) fn copy<W: io::Write>(
    composer: &mut Composer<W>,
    topics: &mut Topics,
    part: &Part<'_>,
    balance: &mut Balance,
) -> io::Result<()> {
    let (opcode, record) = match part {
        Part::Chunk(chunk) => {
            composer.writer().copy_chunk(chunk)?;
            topics.for_each_message(chunk.content, |message| {
                recall(composer, &message, balance);
            });
            return Ok(());
        }
        Part::Record(opcode, record) => (*opcode, *record),
        Part::Damage(_) => return Ok(()),
    };
    let mut fields = Reader(&record[HEAD_BYTES..]);
    match opcode {
        op::SCHEMA => composer.writer().add_schema(record),
        op::CHANNEL => {
            topics.add(fields.0);
            composer.writer().add_channel(record);
        }
        op::METADATA => match (fields.text(), fields.map()) {
            // What an earlier recovery said is said anew.
            (Some("recovery") | None, _) | (_, None) => {}
            (Some(name), Some(map)) => composer.writer().write_metadata(name, &map)?,
        },
        op::ATTACHMENT => {
            let (Some(time_ns), Some(_), Some(name), Some(media_type), Some(bytes)) = (
                fields.u64(),
                fields.u64(),
                fields.text(),
                fields.text(),
                fields.u64(),
            ) else {
                return Ok(());
            };
            let data = usize::try_from(bytes).ok().and_then(|n| fields.take(n));
            composer.writer().attach(&Attachment {
                name,
                media_type,
                time_ns,
                data: data.unwrap_or_default(),
            })?;
        }
        _ => {
            if let Some(message) = topics.loose(opcode, record) {
                composer.writer().copy_message(
                    message.channel_id,
                    message.log_time_ns,
                    message.publish_time_ns,
                    message.data,
                )?;
                recall(composer, &message, balance);
            }
        }
    }
    Ok(())
}

fn recall<W: io::Write>(composer: &mut Composer<W>, message: &Raw<'_>, balance: &mut Balance) {
    let entry = |kind, offset, data| Entry {
        kind,
        at_ns: message.log_time_ns,
        offset,
        data,
    };
    let entry = match message.topic {
        Some(Topic::RawRx) => RawBytes::decode(message.data)
            .ok()
            .map(|raw| entry(Kind::Rx, raw.stream_offset, raw.data)),
        Some(Topic::RawTx) => RawBytes::decode(message.data)
            .ok()
            .map(|raw| entry(Kind::Tx, raw.stream_offset, raw.data)),
        Some(Topic::Station) => Some(entry(Kind::Event, 0, message.data.to_vec())),
        _ => None,
    };
    if let Some(entry) = entry {
        let have = match entry.kind {
            Kind::Tx => composer.deriver().tx_bytes(),
            _ => composer.deriver().rx_bytes(),
        };
        balance.step(entry.kind, have, entry.offset);
        composer.recall(&entry);
    }
}
