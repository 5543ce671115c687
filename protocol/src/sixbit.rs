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
