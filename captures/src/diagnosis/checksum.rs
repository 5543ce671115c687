//! The usual mistakes in a checksum.

use groundwave_protocol::crc::{self, CHARACTERS, DOWNLINK_INIT};

/// Columns that the checksum covers.
const COVERED: usize = 74;

/// First column of the checksum.
pub(super) const COLUMN: usize = COVERED + 1;

const POLYNOMIAL: u32 = 0x7B_01BD;

/// The mistake that explains the checksum of an 80-byte line without its line feed; `None` if none does.
pub(super) fn mistake(line: &[u8]) -> Option<(Option<usize>, String)> {
    let line = line.strip_suffix(b"\r")?;
    let (covered, found) = line.split_at_checked(COVERED)?;
    let found: [u8; CHARACTERS] = found.try_into().ok()?;
    if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
        return None;
    }
    let cause = cause(covered, found)?;
    Some((
        Some(COLUMN),
        format!(
            "line {}: the checksum {cause}; SPEC.md section 4 has worked examples",
            char::from(line[0])
        ),
    ))
}

fn cause(covered: &[u8], found: [u8; CHARACTERS]) -> Option<&'static str> {
    let right = crc::update(DOWNLINK_INIT, covered);
    let hex16 = |value: u32| {
        [format!("{value:04X}"), format!("{value:04x}")]
            .iter()
            .any(|digits| digits.as_bytes() == found)
    };
    if found.map(|byte| if byte == b' ' { b'`' } else { byte }) == crc::characters(right) {
        return Some("has a space for the value 0; 0 travels as a backtick");
    }
    let mut reversed = crc::characters(right);
    reversed.reverse();
    let with_lf = [b"\n", covered].concat();
    let with_next = [covered, &found[..1]].concat();
    let remainders = [
        (crc::update(0, covered), "starts from 0 instead of 0xFFFFFF"),
        (right ^ 0xFF_FFFF, "is inverted at the end; it must not be"),
        (
            crc::update(DOWNLINK_INIT, &with_lf),
            "counts in the LF of the line before",
        ),
        (
            crc::update(DOWNLINK_INIT, &covered[1..]),
            "leaves out column 1",
        ),
        (
            crc::update(DOWNLINK_INIT, &covered[..COVERED - 1]),
            "ends at column 73 instead of 74",
        ),
        (
            crc::update(DOWNLINK_INIT, &covered[..69]),
            "leaves out the acknowledgement",
        ),
        (
            crc::update(DOWNLINK_INIT, &with_next),
            "covers column 75, one too many",
        ),
        (
            reflected(covered),
            "is reflected; the most significant bit comes first",
        ),
        (
            shifted(24, 0xBD_80DE, DOWNLINK_INIT, covered),
            "takes Koopman's 0xBD80DE for the polynomial, which is 0x7B01BD",
        ),
        (
            shifted(24, 0x86_4CFB, 0xB7_04CE, covered),
            "is that of OpenPGP; the polynomial is 0x7B01BD",
        ),
        (
            shifted(24, 0x86_4CFB, DOWNLINK_INIT, covered),
            "has the polynomial 0x864CFB instead of 0x7B01BD",
        ),
        (
            shifted(16, 0x1021, 0xFFFF, covered),
            "is CRC-16/CCITT instead of CRC-24",
        ),
        (
            shifted(16, 0x1021, 0, covered),
            "is CRC-16/XMODEM instead of CRC-24",
        ),
    ];
    if found == reversed {
        return Some("has its characters in reverse; the most significant comes first");
    }
    let fits = |&&(value, _): &&(u32, _)| crc::characters(value) == found;
    if let Some(&(_, cause)) = remainders.iter().find(fits) {
        return Some(cause);
    }
    let xor = covered.iter().fold(0, |sum, &byte| sum ^ byte);
    [
        (
            shifted(16, 0x1021, 0xFFFF, covered),
            "is CRC-16/CCITT in hexadecimal instead of CRC-24 in 6-bit characters",
        ),
        (
            shifted(16, 0x1021, 0, covered),
            "is CRC-16/XMODEM in hexadecimal instead of CRC-24 in 6-bit characters",
        ),
        (
            u32::from(xor),
            "is an exclusive or in hexadecimal instead of CRC-24 in 6-bit characters",
        ),
    ]
    .into_iter()
    .find_map(|(value, cause)| hex16(value).then_some(cause))
}

/// Whether all bytes are hexadecimal digits.
pub(super) fn is_hex(bytes: &[u8]) -> bool {
    bytes.iter().all(u8::is_ascii_hexdigit)
}

/// A CRC of up to 24 bits, most significant bit first.
pub(super) fn shifted(bits: u32, polynomial: u32, start: u32, bytes: &[u8]) -> u32 {
    let (top, mask) = (1 << (bits - 1), (1 << bits) - 1);
    bytes.iter().fold(start, |remainder, &byte| {
        let remainder = remainder ^ u32::from(byte) << (bits - 8);
        (0..8).fold(remainder, |r, _| {
            let carry = if r & top == 0 { 0 } else { polynomial };
            (r << 1 ^ carry) & mask
        })
    })
}

/// The checksum with the least significant bit first.
pub(super) fn reflected(bytes: &[u8]) -> u32 {
    let polynomial = POLYNOMIAL.reverse_bits() >> 8;
    bytes.iter().fold(DOWNLINK_INIT, |remainder, &byte| {
        (0..8).fold(remainder ^ u32::from(byte), |r, _| {
            let carry = if r & 1 == 0 { 0 } else { polynomial };
            r >> 1 ^ carry
        })
    })
}
