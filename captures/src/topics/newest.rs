//! The newest of many things, each encoded once however often it is told.

use std::collections::VecDeque;

use crate::protobuf::Protobuf;

/// The newest so many messages of a repeated field, as they stand in the message that holds them.
#[derive(Debug, Default)]
pub(super) struct Newest {
    encoded: VecDeque<u8>,
    count: usize,
    /// The one that is added; kept for its memory.
    scratch: Vec<u8>,
}

impl Newest {
    /// Adds a message of less than 128 bytes, and forgets the oldest of more than `most`.
    pub(super) fn push(&mut self, most: usize, tag: u32, fill: impl FnOnce(&mut Vec<u8>)) {
        if self.count == most {
            // A key and a length, a byte each.
            let oldest = self
                .encoded
                .get(1)
                .map_or(0, |&length| 2 + usize::from(length));
            self.encoded.drain(..oldest);
            self.count -= 1;
        }
        self.scratch.clear();
        self.scratch.message(tag, fill);
        self.encoded.extend(&self.scratch);
        self.count += 1;
    }

    pub(super) const fn count(&self) -> usize {
        self.count
    }

    pub(super) fn clear(&mut self) {
        self.encoded.clear();
        self.count = 0;
    }

    /// Appends all of them.
    pub(super) fn encode(&self, to: &mut Vec<u8>) {
        let (older, newer) = self.encoded.as_slices();
        to.extend_from_slice(older);
        to.extend_from_slice(newer);
    }
}
