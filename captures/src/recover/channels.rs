//! Which topic a channel is, also where what declares it is damaged.

use std::collections::BTreeMap;
use std::path::Path;

use super::open;
use crate::CaptureError;
use crate::topics::Topic;
use crate::walk::Step;
use crate::writer::records::{HEAD_BYTES, Reader, op, record};
use crate::writer::{has_fixed_topics, next_record};

/// A message.
pub(super) struct Raw<'a> {
    pub(super) channel_id: u16,
    /// Something says what its channel is.
    pub(super) has_channel: bool,
    pub(super) topic: Option<Topic>,
    pub(super) log_time_ns: u64,
    pub(super) publish_time_ns: u64,
    pub(super) data: &'a [u8],
}

/// Which topic a channel is; of other people's there is only the number.
#[derive(Debug)]
pub(super) struct Topics(BTreeMap<u16, Option<Topic>>);

impl Topics {
    /// Ours always have the same numbers, and need not be readable to be known.
    pub(super) fn of(library: &str) -> Self {
        let ours = Topic::ALL
            .into_iter()
            .map(|topic| (topic as u16 + 1, Some(topic)));
        Self(ours.filter(|_| has_fixed_topics(library)).collect())
    }

    /// Takes what a channel record says.
    pub(super) fn add(&mut self, body: &[u8]) {
        let mut fields = Reader(body);
        if let (Some(id), Some(_), Some(name)) = (fields.u16(), fields.u16(), fields.text()) {
            self.0.insert(id, Topic::from_name(name));
        }
    }

    /// The message that a record outside of chunks is; one without a channel is of no use to anybody.
    pub(super) fn loose<'a>(&self, opcode: u8, record: &'a [u8]) -> Option<Raw<'a>> {
        let body = record.get(HEAD_BYTES..).filter(|_| opcode == op::MESSAGE)?;
        self.message(body).filter(|message| message.has_channel)
    }

    fn message<'a>(&self, body: &'a [u8]) -> Option<Raw<'a>> {
        let mut fields = Reader(body);
        let (channel_id, _sequence) = (fields.u16()?, fields.u32()?);
        let topic = self.0.get(&channel_id);
        Some(Raw {
            channel_id,
            has_channel: topic.is_some(),
            topic: topic.copied().flatten(),
            log_time_ns: fields.u64()?,
            publish_time_ns: fields.u64()?,
            data: fields.0,
        })
    }

    pub(super) fn for_each_message<'a>(
        &mut self,
        content: &'a [u8],
        mut take: impl FnMut(Raw<'a>),
    ) {
        let mut rest = Reader(content);
        while let Some((opcode, body)) = next_record(&mut rest) {
            if opcode == op::CHANNEL {
                self.add(body);
            } else if opcode == op::MESSAGE
                && let Some(message) = self.message(body)
            {
                take(message);
            }
        }
    }
}

pub(super) fn has_channels(content: &[u8]) -> bool {
    let mut rest = Reader(content);
    std::iter::from_fn(|| next_record(&mut rest)).any(|(opcode, _)| opcode == op::CHANNEL)
}

/// Records of schemas and channels.
#[derive(Debug, Default)]
pub(super) struct Declared {
    schemas: Vec<Vec<u8>>,
    channels: Vec<Vec<u8>>,
}

impl Declared {
    /// Those of the summary, which repeats what the chunks have; none where it is not there or damaged.
    pub(super) fn in_summary(path: &Path) -> Result<Self, CaptureError> {
        let mut declared = Self::default();
        let mut walker = open(path)?;
        loop {
            let in_summary = walker.has_data_end();
            let step = walker.next_step().map_err(|error| CaptureError::Read {
                path: path.to_owned(),
                error,
            })?;
            let (opcode, body) = match step {
                None => return Ok(declared),
                Some(Step::Damage(_)) if in_summary => return Ok(Self::default()),
                Some(Step::Record { opcode, body }) if in_summary => (opcode, body),
                Some(_) => continue,
            };
            let records = match opcode {
                op::SCHEMA => &mut declared.schemas,
                op::CHANNEL => &mut declared.channels,
                _ => continue,
            };
            let mut whole = Vec::with_capacity(HEAD_BYTES + body.len());
            record(&mut whole, opcode, |to| to.extend_from_slice(body));
            records.push(whole);
        }
    }

    pub(super) const fn is_empty(&self) -> bool {
        self.channels.is_empty()
    }

    pub(super) fn schemas(&self) -> &[Vec<u8>] {
        &self.schemas
    }

    pub(super) fn channels(&self) -> &[Vec<u8>] {
        &self.channels
    }
}
