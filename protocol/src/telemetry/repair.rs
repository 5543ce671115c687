//! Repair of a line with one flipped bit.

use crate::{LINE_BYTES, crc, sixbit};

/// Number of bytes under the checksum.
const CHECKED: usize = LINE_BYTES - crc::CHARACTERS - 2;

/// The line as it was sent, if exactly one of the bits before its CR LF was flipped; `None` for any other damage of up to four bits, and for
/// an intact line. Lines differ in at least six bits, so no other line is as close.
pub(crate) fn repaired(line: &[u8; LINE_BYTES]) -> Option<[u8; LINE_BYTES]> {
    let mut sent = *line;
    let (content, end) = sent.split_at_mut(CHECKED);
    let (characters, line_end) = end.split_at_mut(crc::CHARACTERS);
    if line_end != b"\r\n" {
        return None;
    }
    let remainder = crc::update(crc::DOWNLINK_INIT, content);
    let computed = crc::characters(remainder);
    let differences = characters.iter().zip(computed).map(|(a, b)| a ^ b);
    if differences.map(u8::count_ones).sum::<u32>() == 1 {
        characters.copy_from_slice(&computed);
        return Some(sent);
    }
    let checksum = sixbit::decode_from(characters)?;
    let (from_end, bit) = crc::flipped_bit(remainder ^ checksum, CHECKED)?;
    content[CHECKED - 1 - from_end] ^= 1 << bit;
    Some(sent)
}
