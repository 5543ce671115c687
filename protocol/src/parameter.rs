//! Parameters: the key of a name, and the limits of names and values on the wire.

use crate::crc;

/// Maximum length of a name, characters; each is a lower case letter, a digit or a hyphen.
pub const NAME_BYTES: usize = 18;

/// Maximum length of a unit, characters.
pub const UNIT_BYTES: usize = 11;

/// Maximum number of parameters of a robot; line P has two digits for the number.
pub const PARAMETERS_MAX: u8 = 99;

/// Maximum magnitude of a value in line P.
pub const VALUE_MAX: i32 = 99_999;

/// The 24-bit key that stands for a name in an order: its checksum from [`crc::DOWNLINK_INIT`]. Unlike a number,
/// it means the same parameter on every robot and in every version.
#[must_use]
pub fn key(name: &str) -> u32 {
    crc::update(crc::DOWNLINK_INIT, name.as_bytes())
}

/// Whether `name` is a valid name of a parameter.
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
    fn names_have_1_to_18_letters_digits_or_hyphens() {
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
