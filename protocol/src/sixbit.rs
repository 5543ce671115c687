//! Six bits in one printable character.
//!
//! A value `v` from 1 to 63 travels as `0x20 + v`; 0 travels as a backtick, because a space inside a
//! field would end it for `awk`. One flipped bit always changes the value or makes it invalid, so the
//! Hamming distance of the CRC survives the encoding.

/// The character of the low six bits of `value`.
#[must_use]
pub const fn encode(value: u8) -> u8 {
    match value & 0x3F {
        0 => b'`',
        v => 0x20 + v,
    }
}

/// The six bits of a character; `None` when it carries none.
#[must_use]
pub const fn decode(character: u8) -> Option<u8> {
    match character {
        b'`' => Some(0),
        0x21..=0x5F => Some(character - 0x20),
        _ => None,
    }
}

/// Writes the low `6 * out.len()` bits of `value`, most significant character first; beyond 32 bits
/// the leading characters say zero.
pub fn encode_into(mut value: u32, out: &mut [u8]) {
    for character in out.iter_mut().rev() {
        *character = encode(value as u8);
        value >>= 6;
    }
}

/// Reads a number, most significant character first; of more than 32 bits the lowest 32 remain.
#[must_use]
pub fn decode_from(characters: &[u8]) -> Option<u32> {
    characters
        .iter()
        .try_fold(0, |value: u32, &c| Some(value << 6 | u32::from(decode(c)?)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn sixty_four_characters_carry_six_bits_and_no_other_does() {
        let mut carried = [0; 64];
        for character in 0..=255 {
            if let Some(value) = decode(character) {
                assert_eq!(encode(value), character);
                carried[usize::from(value)] += 1;
            }
        }
        assert_eq!(carried, [1; 64]);
        for refused in [b' ', b'a', b'~', 0x7F, 0, b'\n', b'\r', 0x80, 0xFF] {
            assert_eq!(decode(refused), None);
        }
    }

    /// Otherwise the checksum's Hamming distance would not survive the encoding.
    #[test]
    fn characters_differ_in_at_least_as_many_bits_as_their_values() {
        for a in 0..64_u8 {
            for b in 0..64_u8 {
                let on_the_wire = (encode(a) ^ encode(b)).count_ones();
                assert!(on_the_wire >= (a ^ b).count_ones(), "{a} and {b}");
            }
        }
    }

    proptest! {
        #[test]
        fn numbers_survive(value: u32) {
            let mut characters = [0; 6];
            encode_into(value, &mut characters);
            prop_assert_eq!(decode_from(&characters), Some(value));
            let mut four = [0; 4];
            encode_into(value, &mut four);
            prop_assert_eq!(decode_from(&four), Some(value & 0xFF_FFFF));
        }
    }
}
