//! Classifies bytes without an intact line.
//!
//! Consecutive lines share most of their text. Sampled at a wrong rate, they still share most of the garbage, while
//! noise does not repeat. The share of repeated four-byte sequences therefore distinguishes a wrong rate from noise, for
//! all rates and all receivers. Printable bytes mean the right rate and a bad channel. If the radio is slower than the
//! port, no bit differs from both of its neighbours.

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::Decoder;
use groundwave_protocol::telemetry::{ACK_LINE_BYTES, AckLine, LineType};

use crate::event::{LineRate, Reception};

/// Minimum number of bytes for a judgement.
pub const BYTES_MIN: usize = 128;

/// Length of the byte sequences that are compared, bytes. In noise, one in a million such sequences repeats by chance.
const RUN: usize = 4;

/// Minimum share of repeated sequences for bytes with structure. Measured: structure has 1.4 % and more between 300 and
/// 19200 baud; noise up to 0.7 %, unless it changes more slowly than the baud rate. The ignored test
/// `looks_of_everything` prints all these figures.
const REPEATS_MIN: f64 = 0.01;

/// Minimum share of printable bytes for the right rate. Measured: wrong rates have up to 52 %, noise up to 41 %,
/// damaged lines 33 % to 100 %. The minimum comes from a receiver that takes a broken stop bit for a start bit and loses
/// synchronization.
const PRINTABLE_MIN: f64 = 0.6;

/// Maximum share of bytes with a bit that differs from both neighbours, for a radio that is slower than the port. Measured: 0 % if it is slower, 53 %
/// and more if it is faster.
const ALONE_MAX: f64 = 0.1;

/// Shares of the bytes that have a feature, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looks {
    /// Share of printable bytes and line ends.
    pub printable: f64,
    /// Share of bytes that begin a repeated sequence.
    pub repeats: f64,
    /// Share of bytes with a bit that differs from both neighbours.
    pub alone: f64,
}

impl Looks {
    /// The features of bytes.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let share = |count: usize| count as f64 / bytes.len().max(1) as f64;
        let printable = |byte: &&u8| matches!(byte, b' '..=b'~' | b'\r' | b'\n');
        Self {
            printable: share(bytes.iter().filter(printable).count()),
            repeats: share(repeats(bytes)),
            alone: share(bytes.iter().filter(|byte| has_bit_alone(**byte)).count()),
        }
    }
}

/// Classifies bytes without an intact line; `None` if there are too few.
#[must_use]
pub fn judge(bytes: &[u8]) -> Option<Reception> {
    if bytes.len() < BYTES_MIN {
        return None;
    }
    let looks = Looks::of(bytes);
    Some(if looks.printable >= PRINTABLE_MIN {
        Reception::Damaged
    } else if looks.repeats < REPEATS_MIN {
        Reception::Noise
    } else if looks.alone < ALONE_MAX {
        Reception::WrongRate(LineRate::Slower)
    } else {
        Reception::WrongRate(LineRate::Faster)
    })
}

/// Number of repeated sequences.
fn repeats(bytes: &[u8]) -> usize {
    let mut runs: Vec<&[u8]> = bytes.windows(RUN).collect();
    runs.sort_unstable();
    let seen = runs.len();
    runs.dedup();
    seen - runs.len()
}

/// Whether a bit of the byte differs from both of its neighbours.
const fn has_bit_alone(byte: u8) -> bool {
    let changes = (byte ^ (byte >> 1)) & 0x7F;
    changes & (changes >> 1) != 0
}

/// Number of bytes that [`judge`] is calibrated for.
const JUDGED: usize = 1024;

/// First bytes of files that hold no lines as they are, and their descriptions.
const SIGNATURES: [(&[u8], &str); 6] = [
    (b"\x1F\x8B", "it is compressed by gzip; unpack it first"),
    (
        b"\x28\xB5\x2F\xFD",
        "it is compressed by zstd; unpack it first",
    ),
    (b"PK\x03\x04", "it is a zip archive; unpack it first"),
    (b"\x89PNG", "it is a picture"),
    (b"\xFF\xD8\xFF", "it is a picture"),
    (b"\x7FELF", "it is a program"),
];

/// Describes the beginning of a file without an intact line, as text for display.
#[must_use]
pub fn words(bytes: &[u8]) -> &'static str {
    if bytes.is_empty() {
        return "it is empty";
    }
    if let Some((_, kind)) = SIGNATURES
        .iter()
        .find(|(start, _)| bytes.starts_with(start))
    {
        return kind;
    }
    if let [[0xFF, 0xFE] | [0xFE, 0xFF], text @ ..] = bytes.as_chunks().0
        && text.iter().filter(|pair| pair.contains(&0)).count() > text.len() / 2
    {
        return "it is UTF-16 text, as PowerShell's `>` writes; convert it to ASCII, or record with `groundwave record`";
    }
    if bytes.len() >= BYTES_MIN && bytes.iter().all(|byte| *byte == bytes[0]) {
        return "all of its bytes are the same";
    }
    let seven_bits: Vec<u8> = bytes.iter().map(|byte| byte & 0x7F).collect();
    if seven_bits != bytes && Decoder::default().lines(&seven_bits).next().is_some() {
        return "its lines are intact but for the highest bit of each byte: the radio or the port sends a parity bit; set it to 8N1";
    }
    let mut decoder = Decoder::default();
    decoder.lines(bytes).for_each(drop);
    if decoder.counters().field_rejected > 0 {
        return "its lines are from another version of the protocol";
    }
    let lines = || {
        bytes
            .split(|&byte| byte == b'\n')
            .map(<[u8]>::trim_ascii_end)
    };
    let most = |is: fn(&[u8]) -> bool| {
        let written = lines().filter(|line| !line.is_empty());
        2 * written.clone().filter(|line| is(line)).count() > written.count()
    };
    if most(is_nmea) {
        return "it holds NMEA sentences, as from a satellite receiver";
    }
    if most(is_shaped) {
        return "its lines look like a robot's, but every checksum is wrong: the text was changed, or another program wrote it";
    }
    match judge(&bytes[..bytes.len().min(JUDGED)]) {
        Some(Reception::Noise) => "it holds noise",
        Some(Reception::WrongRate(_)) => {
            "its bytes look like those of a radio at another baud rate"
        }
        None if Looks::of(bytes).printable < PRINTABLE_MIN => "it is too short to classify",
        _ => "it holds other text",
    }
}

/// Whether a line is an NMEA sentence: `$GPGGA,...*47`.
fn is_nmea(line: &[u8]) -> bool {
    matches!(line, [b'$' | b'!', b'A'..=b'Z', ..]) && line.contains(&b',')
}

/// Whether a text without its line end ends in the shape of a robot's line.
fn is_shaped(line: &[u8]) -> bool {
    let ends_in = |bytes: usize, is_letter: fn(u8) -> bool| {
        let start = line.len().checked_sub(bytes - 2);
        matches!(
            start.map(|start| &line[start..]),
            Some([letter, b'0'..=b'9', b'0'..=b'9', ..]) if is_letter(*letter)
        )
    };
    ends_in(LINE_BYTES, |letter| LineType::from_letter(letter).is_some())
        || line.len() == ACK_LINE_BYTES - 2 && ends_in(ACK_LINE_BYTES, AckLine::begins_with)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_without_a_line_is_named_by_its_content() {
        let sample = include_str!("../house-clean.txt");
        let wrong = sample.replace('.', ",");
        let stamped = wrong.replace("\nA", "\n12:00:01 A");
        let nmea = "$GPGGA,092750.000,5321.6802,N,00630.3372,W,1,8,1.03,61.7,M*76\r\n".repeat(9);
        let utf16: Vec<u8> = std::iter::once(0xFEFF)
            .chain(sample.encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        let with_parity = |byte: u8| byte | ((byte.count_ones() as u8 & 1) << 7);
        let parity: Vec<u8> = sample.bytes().map(with_parity).collect();
        let mut state = 1_u32;
        let noise: Vec<u8> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .take(4096)
        .collect();
        for (bytes, kind) in [
            (&b""[..], "empty"),
            (wrong.as_bytes(), "checksum is wrong"),
            (wrong.replace("\r\n", "\n").as_bytes(), "checksum is wrong"),
            (stamped.as_bytes(), "checksum is wrong"),
            (nmea.as_bytes(), "NMEA"),
            (&utf16, "UTF-16"),
            (&parity, "8N1"),
            (&[0; 4096], "the same"),
            (b"\x1F\x8B\x08\0\0\0\0\0", "gzip"),
            (b"Dear diary,\ntoday", "other text"),
            (&noise, "noise"),
            (&noise[..20], "too short"),
        ] {
            let words = words(bytes);
            assert!(words.contains(kind), "{kind}: {words}");
        }
    }
}
