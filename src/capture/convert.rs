//! Raw captures as MCAP, with every topic that a recording has.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};

use super::block_writer::{BlockWriter, Times};
use super::raw::RawReader;
use super::topics::{Deriver, Topic};

/// Why a capture was not converted.
#[derive(Debug, thiserror::Error)]
pub enum ConvertError {
    /// The capture cannot be read.
    #[error("{0}")]
    Read(io::Error),
    /// The result cannot be written.
    #[error("{0}")]
    Write(io::Error),
}

/// What was converted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Converted {
    /// Bytes of the radio.
    pub bytes: u64,
    /// Intact lines among them.
    pub lines: u64,
}

/// Writes a raw capture as MCAP, as if it had been recorded from `start_ns` since 1970 on, from a radio at
/// 2400 baud that never paused. `notes` is what the capture says about itself.
///
/// # Errors
/// When reading or writing fails.
pub fn convert_raw(
    source: impl Read,
    start_ns: u64,
    notes: &BTreeMap<String, String>,
    output: impl Write,
) -> Result<Converted, ConvertError> {
    let mut reader = RawReader::new(source);
    let mut writer = BlockWriter::new(output).map_err(ConvertError::Write)?;
    register(&mut writer).map_err(ConvertError::Write)?;
    writer
        .write_metadata("session", notes)
        .map_err(ConvertError::Write)?;
    let mut deriver = Deriver::new();
    let mut at_ns = start_ns;
    while let Some(chunk) = reader.next_chunk().map_err(ConvertError::Read)? {
        at_ns = start_ns.saturating_add(u64::try_from(chunk.at.as_nanos()).unwrap_or(u64::MAX));
        let mut write = |message: super::topics::TopicMessage<'_>| {
            let times = Times {
                log: message.log_time_ns,
                publish: message.publish_time_ns,
            };
            let channel = message.topic as u16;
            writer.write(channel, times, |to| to.extend_from_slice(message.data))
        };
        deriver
            .handle_rx(at_ns, chunk.bytes, &mut write)
            .map_err(ConvertError::Write)?;
        if let Some((robot_id, version)) = deriver.take_robot() {
            let version = format!("{}.{:02}", version.major, version.minor);
            let table = BTreeMap::from([
                ("robot_id".to_owned(), robot_id.to_string()),
                ("firmware_version".to_owned(), version),
            ]);
            writer
                .write_metadata("robot", &table)
                .map_err(ConvertError::Write)?;
        }
    }
    deriver
        .finish(|message| {
            let times = Times {
                log: at_ns,
                publish: message.publish_time_ns,
            };
            let channel = message.topic as u16;
            writer.write(channel, times, |to| to.extend_from_slice(message.data))
        })
        .map_err(ConvertError::Write)?;
    writer.finish().map_err(ConvertError::Write)?;
    let counters = deriver.counters();
    Ok(Converted {
        bytes: counters.bytes,
        lines: counters.lines + counters.ack_lines,
    })
}

/// Every topic there is, under the number it has everywhere, and the types of their messages.
fn register<W: Write>(writer: &mut BlockWriter<W>) -> io::Result<()> {
    let mut known = BTreeMap::new();
    for topic in Topic::ALL {
        let schema = topic.schema();
        let id = match known.get(&schema.name) {
            Some(id) => *id,
            None => writer.add_schema(&schema.name, "protobuf", &schema.descriptors)?,
        };
        known.insert(schema.name, id);
        writer.add_channel(id, topic.name(), "protobuf", &BTreeMap::new())?;
    }
    Ok(())
}
