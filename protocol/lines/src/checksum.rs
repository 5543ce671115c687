//! Checksums at the end of a line, after `*`, as hexadecimal digits.

use crc::{CRC_8_SMBUS, CRC_16_IBM_3740, Crc};
use serde::{Deserialize, Serialize};

/// The checksum of each line: `LINE*HEX`. It does not cover a leading `$` or `!`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Checksum {
    /// Lines have no checksum.
    #[default]
    None,
    /// Exclusive or of all bytes, two digits, as in NMEA 0183.
    Xor,
    /// Polynomial 0x07, start 0, two digits, as on the SM bus.
    Crc8,
    /// Polynomial 0x1021, start 0xFFFF, four digits (CCITT-FALSE).
    #[serde(rename = "crc16-ccitt")]
    Crc16Ccitt,
}

const CRC8: Crc<u8> = Crc::<u8>::new(&CRC_8_SMBUS);
const CRC16: Crc<u16> = Crc::<u16>::new(&CRC_16_IBM_3740);

impl Checksum {
    /// The line without its checksum; `None` if the checksum is missing or wrong.
    pub(crate) fn strip(self, line: &str) -> Option<&str> {
        if self == Self::None {
            return Some(line);
        }
        let (content, hex) = line.rsplit_once('*')?;
        let content = content.strip_prefix(['$', '!']).unwrap_or(content);
        let (digits, expected) = self.of(content.as_bytes());
        let is_right = hex.len() == digits && u16::from_str_radix(hex, 16) == Ok(expected);
        is_right.then_some(content)
    }

    /// Number of hexadecimal digits and value.
    fn of(self, bytes: &[u8]) -> (usize, u16) {
        match self {
            Self::None => (0, 0),
            Self::Xor => (2, bytes.iter().fold(0, |sum, byte| sum ^ byte).into()),
            Self::Crc8 => (2, CRC8.checksum(bytes).into()),
            Self::Crc16Ccitt => (4, CRC16.checksum(bytes)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_values_of_the_catalogue_are_met() {
        // XOR of "123456789" by hand; the others are the check values of the CRC catalogue.
        for (checksum, hex) in [
            (Checksum::Xor, "31"),
            (Checksum::Crc8, "F4"),
            (Checksum::Crc16Ccitt, "29B1"),
        ] {
            assert_eq!(
                checksum.strip(&format!("123456789*{hex}")),
                Some("123456789")
            );
            assert_eq!(
                checksum.strip(&format!("$123456789*{}", hex.to_lowercase())),
                Some("123456789")
            );
            for wrong in [
                "123456789*00",
                "123456789",
                "*",
                "123456789*+1",
                "923456789*29B1",
                "",
            ] {
                assert_eq!(checksum.strip(wrong), None, "{checksum:?} {wrong}");
            }
        }
        assert_eq!(Checksum::None.strip("a*b"), Some("a*b"));
    }
}
