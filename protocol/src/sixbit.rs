//! Six bits in one printable character.
//!
//! A value `v` from 1 to 63 is sent as `0x20 + v`, and 0 as a backtick, because a space would end the
//! field for `awk`. A flipped bit always changes the value or makes it invalid, so the encoding keeps the
//! Hamming distance of the CRC.

/// The character for the low six bits of `value`.
#[must_use]
pub const fn encode(value: u8) -> u8 {
    match value & 0x3F {
        0 => b'`',
        v => 0x20 + v,
    }
}

/// The value of a character; `None` if it is not a 6-bit character.
#[must_use]
pub const fn decode(character: u8) -> Option<u8> {
    match character {
        b'`' => Some(0),
        0x21..=0x5F => Some(character - 0x20),
        _ => None,
    }
}

/// Writes the low `6 * out.len()` bits of `value`, most significant character first; characters beyond
/// 32 bits are zero.
pub fn encode_into(mut value: u32, out: &mut [u8]) {
    for character in out.iter_mut().rev() {
        *character = encode(value as u8);
        value >>= 6;
    }
}

/// Reads a number, most significant character first, and keeps its low 32 bits; returns `None` if one of the characters is
/// not a 6-bit character.
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
    fn exactly_sixty_four_characters_carry_six_bits() {
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

    /// The checksum's Hamming distance depends on this property.
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
        fn numbers_survive_a_round_trip(value: u32) {
            let mut characters = [0; 6];
            encode_into(value, &mut characters);
            prop_assert_eq!(decode_from(&characters), Some(value));
            let mut four = [0; 4];
            encode_into(value, &mut four);
            prop_assert_eq!(decode_from(&four), Some(value & 0xFF_FFFF));
        }
    }
}
