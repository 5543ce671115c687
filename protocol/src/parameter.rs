//! What both ends know of parameters without sharing a table: a name's key, and what fits on the wire.

use crate::crc;

/// Most characters of a name: lower case letters, digits and hyphens.
pub const NAME_BYTES: usize = 18;

/// Most characters of a unit.
pub const UNIT_BYTES: usize = 11;

/// Most parameters a robot can have: two digits count them.
pub const PARAMETERS_MAX: u8 = 99;

/// Farthest from zero that line P can say.
pub const VALUE_MAX: i32 = 99_999;

/// What stands for a name in an order, 24 bits: its checksum, from the same start as a line's. The ground needs
/// no table, and the numbering of another version or robot can never set the wrong parameter.
#[must_use]
pub fn key(name: &str) -> u32 {
    crc::update(crc::DOWNLINK_INIT, name.as_bytes())
}

/// Whether a name can be said in line P.
#[must_use]
pub fn is_name(name: &str) -> bool {
    (1..=NAME_BYTES).contains(&name.len()) && name.bytes().all(is_name_byte)
}

pub(crate) const fn is_name_byte(byte: u8) -> bool {
    matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_short_and_plain() {
        for good in ["a", "top-speed", "ir-count-most", "abcdefghijklmnopqr"] {
            assert!(is_name(good), "{good}");
        }
        for bad in ["", "Top", "a b", "a_b", "caf\u{e9}", "abcdefghijklmnopqrs"] {
            assert!(!is_name(bad), "{bad}");
        }
    }

    #[test]
    fn a_key_is_the_checksum_of_the_name() {
        assert_eq!(key("123456789"), 0x74_A079);
        assert_ne!(key("top-speed"), key("top-speee"));
    }
}
