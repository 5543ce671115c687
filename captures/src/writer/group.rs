//! Records of a kind, kept for the summary.

use super::next_record;
use super::records::Reader;

/// Records of a kind, for the summary.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) records: Vec<u8>,
    pub(super) count: u32,
}

impl Group {
    pub(super) fn add(&mut self, record: &[u8]) {
        self.records.extend_from_slice(record);
        self.count += 1;
    }

    /// Adds a schema or a channel, unless one of its number is there.
    pub(super) fn add_new(&mut self, record: &[u8]) {
        if !self.ids().any(|id| Some(id) == id_of(record)) {
            self.add(record);
        }
    }

    /// The numbers of the schemas or channels.
    fn ids(&self) -> impl Iterator<Item = u16> + '_ {
        let mut rest = Reader(&self.records);
        std::iter::from_fn(move || {
            let (_, body) = next_record(&mut rest)?;
            Reader(body).u16()
        })
    }
}

fn id_of(record: &[u8]) -> Option<u16> {
    let (_, body) = next_record(&mut Reader(record))?;
    Reader(body).u16()
}
