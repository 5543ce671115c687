//! Records of an MCAP as bytes: <https://mcap.dev/spec>.

use std::collections::BTreeMap;

/// What the first byte of a record says.
pub(crate) use ::mcap::records::op;

/// Opcode and length.
pub(crate) const HEAD_BYTES: usize = 9;

/// Appends a record to `to`; `fill` writes what it says.
pub(crate) fn record(to: &mut Vec<u8>, opcode: u8, fill: impl FnOnce(&mut Vec<u8>)) {
    to.push(opcode);
    let length_at = to.len();
    to.extend([0; 8]);
    let start = to.len();
    fill(to);
    let length = (to.len() - start) as u64;
    to[length_at..start].copy_from_slice(&length.to_le_bytes());
}

/// The fields of a record, in the order of the specification.
pub(crate) trait Fields {
    fn u16(&mut self, value: u16);
    fn u32(&mut self, value: u32);
    fn u64(&mut self, value: u64);
    /// A length of 32 bits and the bytes.
    fn bytes(&mut self, value: &[u8]);
    fn text(&mut self, value: &str) {
        self.bytes(value.as_bytes());
    }
    fn map(&mut self, map: &BTreeMap<String, String>);
}

impl Fields for Vec<u8> {
    fn u16(&mut self, value: u16) {
        self.extend(value.to_le_bytes());
    }

    fn u32(&mut self, value: u32) {
        self.extend(value.to_le_bytes());
    }

    fn u64(&mut self, value: u64) {
        self.extend(value.to_le_bytes());
    }

    fn bytes(&mut self, value: &[u8]) {
        self.u32(value.len() as u32);
        self.extend(value);
    }

    fn map(&mut self, map: &BTreeMap<String, String>) {
        let bytes = map.iter().map(|(key, value)| 8 + key.len() + value.len());
        self.u32(bytes.sum::<usize>() as u32);
        for (key, value) in map {
            self.text(key);
            self.text(value);
        }
    }
}

/// Reads fields from the front of a record; `None` where it is too short or makes no sense.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reader<'a>(pub(crate) &'a [u8]);

impl<'a> Reader<'a> {
    pub(crate) fn take(&mut self, length: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(head)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.array::<1>().map(|[byte]| byte)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    pub(crate) fn bytes(&mut self) -> Option<&'a [u8]> {
        let length = self.u32()?;
        self.take(length as usize)
    }

    pub(crate) fn text(&mut self) -> Option<&'a str> {
        std::str::from_utf8(self.bytes()?).ok()
    }

    pub(crate) fn map(&mut self) -> Option<BTreeMap<String, String>> {
        let mut rest = Reader(self.bytes()?);
        let mut map = BTreeMap::new();
        while !rest.0.is_empty() {
            map.insert(rest.text()?.to_owned(), rest.text()?.to_owned());
        }
        Some(map)
    }
}
