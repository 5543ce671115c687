//! Recognizes the usual mistakes in a checksum.

use groundwave_protocol::crc::{self, CHARACTERS, DOWNLINK_INIT};
use groundwave_protocol::sixbit;
use groundwave_protocol::telemetry::ACK_LINE_BYTES;

use super::kind::{self, Kind};

/// Number of columns that the checksum of a long line covers.
const LONG: usize = 74;

/// Number of columns that the checksum of lines K and G covers.
const SHORT: usize = ACK_LINE_BYTES - 2 - CHARACTERS;

const POLYNOMIAL: u32 = 0x7B_01BD;

/// The mistake that explains the checksum of `line` (without CR LF), and its column; `None` if no known mistake does.
pub(super) fn mistake(line: &[u8]) -> Option<(usize, &'static Kind)> {
    let covered = match line {
        [b'K' | b'G', ..] if line.len() >= SHORT + CHARACTERS && line.len() < LONG => SHORT,
        _ => LONG,
    };
    let (covered, found) = line.split_at_checked(covered)?;
    if let [high, middle, low] = *found {
        let remainder = crc::update(DOWNLINK_INIT, covered);
        let orders = [[0, high, middle, low], [0, low, middle, high]];
        if orders.map(u32::from_be_bytes).contains(&remainder) {
            return Some((covered.len() + 1, kind::CRC_BINARY));
        }
    }
    if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
        return None;
    }
    let kind = match found.try_into() {
        Ok(found) => cause(covered, found)?,
        // Longer than four characters.
        Err(_) => in_digits(covered, found)?,
    };
    Some((covered.len() + 1, kind))
}

/// Recognizes a checksum written in digits.
fn in_digits(covered: &[u8], found: &[u8]) -> Option<&'static Kind> {
    let found = str::from_utf8(found).ok()?;
    let found = found.strip_prefix('*').unwrap_or(found);
    let value = u32::from_str_radix(found, 16).ok()?;
    let is = |value_of: u32| value_of == value;
    let ccitt = |start| shifted(16, 0x1021, start, covered);
    match found.len() {
        6 if is(crc::update(DOWNLINK_INIT, covered)) => Some(kind::CRC_HEX),
        4 if is(ccitt(0xFFFF)) || is(ccitt(0)) => Some(kind::CRC_16),
        2..=4 if is(exclusive_or(covered)) || is(sum(covered)) => Some(kind::CRC_XOR),
        _ => None,
    }
}

fn cause(covered: &[u8], found: [u8; CHARACTERS]) -> Option<&'static Kind> {
    let right = crc::update(DOWNLINK_INIT, covered);
    if found.map(|byte| if byte == b' ' { b'`' } else { byte }) == crc::characters(right) {
        return Some(kind::CRC_ZERO);
    }
    let mut reversed = crc::characters(right);
    reversed.reverse();
    if found == reversed {
        return Some(kind::CRC_ORDER);
    }
    if [base64, from_digit_0]
        .map(|code| code(right))
        .contains(&found)
    {
        return Some(kind::CRC_CHARACTERS);
    }
    let from_start = |bytes: &[u8]| crc::update(DOWNLINK_INIT, bytes);
    let length = covered.len();
    let blank_ack = [&covered[..length - 5], b"     "].concat();
    let zero_ack = [&covered[..length - 5], b"`````"].concat();
    let with_sequence = |sequence: u32| {
        let digits = format!("{:02}", sequence % 100);
        from_start(&[&covered[..1], digits.as_bytes(), &covered[3..]].concat())
    };
    let sequence = str::from_utf8(&covered[1..3]).ok();
    let sequence: u32 = sequence.and_then(|it| it.parse().ok()).unwrap_or(0);
    let remainders = [
        (crc::update(0, covered), kind::CRC_START),
        (right ^ 0xFF_FFFF, kind::CRC_INVERTED),
        (right.swap_bytes() >> 8, kind::CRC_BYTES),
        (from_start(&[b"\n", covered].concat()), kind::CRC_LINE_FEED),
        (
            from_start(&[b"\r\n", covered].concat()),
            kind::CRC_LINE_FEED,
        ),
        (from_start(&covered[1..]), kind::CRC_COLUMNS),
        (from_start(&covered[3..]), kind::CRC_COLUMNS),
        (from_start(&covered[..length - 1]), kind::CRC_COLUMNS),
        (from_start(&covered[..length - 5]), kind::CRC_COLUMNS),
        (
            from_start(&[covered, &found[..1]].concat()),
            kind::CRC_COLUMNS,
        ),
        (from_start(&[covered, b"\r\n"].concat()), kind::CRC_COLUMNS),
        (from_start(&[covered, b"\0"].concat()), kind::CRC_COLUMNS),
        (from_start(&blank_ack), kind::CRC_STALE),
        (from_start(&zero_ack), kind::CRC_STALE),
        (with_sequence(sequence + 99), kind::CRC_STALE),
        (with_sequence(0), kind::CRC_STALE),
        (reflected(POLYNOMIAL, covered), kind::CRC_REFLECTED),
        (
            shifted(24, 0xBD_80DE, DOWNLINK_INIT, covered),
            kind::CRC_POLYNOMIAL,
        ),
        // OpenPGP's polynomial, with its start and with ours; BLE's; FlexRay's; OS-9's.
        (
            shifted(24, 0x86_4CFB, 0xB7_04CE, covered),
            kind::CRC_POLYNOMIAL,
        ),
        (
            shifted(24, 0x86_4CFB, DOWNLINK_INIT, covered),
            kind::CRC_POLYNOMIAL,
        ),
        (
            shifted(24, 0x00_065B, DOWNLINK_INIT, covered),
            kind::CRC_POLYNOMIAL,
        ),
        (
            shifted(24, 0x5D_6DCB, DOWNLINK_INIT, covered),
            kind::CRC_POLYNOMIAL,
        ),
        (
            shifted(24, 0x80_0063, DOWNLINK_INIT, covered),
            kind::CRC_POLYNOMIAL,
        ),
        (shifted(16, 0x1021, 0xFFFF, covered), kind::CRC_16),
        (shifted(16, 0x1021, 0, covered), kind::CRC_16),
        (shifted(16, 0x8005, 0xFFFF, covered), kind::CRC_16),
        (exclusive_or(covered), kind::CRC_XOR),
        (sum(covered), kind::CRC_XOR),
    ];
    let fits = |(value, _): &&(u32, _)| crc::characters(*value) == found;
    let kind = remainders.iter().find(fits).map(|&(_, kind)| kind);
    kind.or_else(|| in_digits(covered, &found))
}

/// The characters of Base64.
fn base64(remainder: u32) -> [u8; CHARACTERS] {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array::from_fn(|n| ALPHABET[(remainder >> (18 - 6 * n)) as usize & 63])
}

/// The characters from `0` on.
fn from_digit_0(remainder: u32) -> [u8; CHARACTERS] {
    std::array::from_fn(|n| b'0' + (remainder >> (18 - 6 * n)) as u8 % 64)
}

/// How a checksum differs from the right one of a line without CR LF; `None` if it is not in 6-bit characters.
pub(super) fn difference(line: &[u8]) -> Option<u32> {
    let (covered, found) = line.split_at_checked(LONG)?;
    let mut value = 0;
    for &byte in found {
        value = value << 6 | u32::from(sixbit::decode(byte)?);
    }
    Some(value ^ crc::update(DOWNLINK_INIT, covered))
}

/// The exclusive-or of the bytes.
fn exclusive_or(bytes: &[u8]) -> u32 {
    u32::from(bytes.iter().fold(0, |sum, byte| sum ^ byte))
}

/// The sum of the bytes, 8 bits.
fn sum(bytes: &[u8]) -> u32 {
    u32::from(bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte)))
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

/// A CRC of 24 bits with the least significant bit first.
pub(super) fn reflected(polynomial: u32, bytes: &[u8]) -> u32 {
    let polynomial = polynomial.reverse_bits() >> 8;
    bytes.iter().fold(DOWNLINK_INIT, |remainder, &byte| {
        (0..8).fold(remainder ^ u32::from(byte), |r, _| {
            let carry = if r & 1 == 0 { 0 } else { polynomial };
            r >> 1 ^ carry
        })
    })
}
