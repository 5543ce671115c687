//! Protobuf on its way out, in one pass.
//!
//! A derived encoder goes through a message once for the length of each of its levels and once more to write it. What
//! every line leads to is written here as it will stand, and the length of a part is put before it when it is known.

/// Wire types.
const VARINT: u32 = 0;
const I64: u32 = 1;
const LEN: u32 = 2;

/// Longest varint of 32 bits.
const VARINT_BYTES_MAX: usize = 5;

/// Appends fields, each after its tag.
pub(super) trait Protobuf {
    fn uint32(&mut self, tag: u32, value: u32);
    /// Also enumerations, none of which has negative numbers here.
    fn int32(&mut self, tag: u32, value: i32);
    fn sint32(&mut self, tag: u32, value: i32);
    fn uint64(&mut self, tag: u32, value: u64);
    fn double(&mut self, tag: u32, value: f64);
    fn bytes(&mut self, tag: u32, value: &[u8]);
    fn string(&mut self, tag: u32, value: &str) {
        self.bytes(tag, value.as_bytes());
    }
    /// A message within the message; `fill` writes its fields.
    fn message(&mut self, tag: u32, fill: impl FnOnce(&mut Self));

    /// A field that is absent where it is zero.
    fn nonzero(&mut self, tag: u32, value: f64) {
        if value != 0.0 {
            self.double(tag, value);
        }
    }
}

impl Protobuf for Vec<u8> {
    fn uint32(&mut self, tag: u32, value: u32) {
        key(self, tag, VARINT);
        varint(self, value.into());
    }

    fn int32(&mut self, tag: u32, value: i32) {
        key(self, tag, VARINT);
        varint(self, i64::from(value) as u64);
    }

    fn sint32(&mut self, tag: u32, value: i32) {
        self.uint32(tag, (value << 1 ^ value >> 31) as u32);
    }

    fn uint64(&mut self, tag: u32, value: u64) {
        key(self, tag, VARINT);
        varint(self, value);
    }

    fn double(&mut self, tag: u32, value: f64) {
        key(self, tag, I64);
        self.extend_from_slice(&value.to_le_bytes());
    }

    fn bytes(&mut self, tag: u32, value: &[u8]) {
        key(self, tag, LEN);
        varint(self, value.len() as u64);
        self.extend_from_slice(value);
    }

    fn message(&mut self, tag: u32, fill: impl FnOnce(&mut Self)) {
        key(self, tag, LEN);
        // Nearly all are short enough for a length of one byte.
        let start = self.len() + 1;
        self.push(0);
        fill(self);
        let length = self.len() - start;
        if length < 0x80 {
            self[start - 1] = length as u8;
        } else {
            let mut long = Vec::with_capacity(VARINT_BYTES_MAX);
            varint(&mut long, length as u64);
            self.splice(start - 1..start, long);
        }
    }
}

#[inline]
fn key(to: &mut Vec<u8>, tag: u32, wire_type: u32) {
    varint(to, u64::from(tag << 3 | wire_type));
}

#[inline]
fn varint(to: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        to.push(value as u8 | 0x80);
        value >>= 7;
    }
    to.push(value as u8);
}
