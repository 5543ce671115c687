//! CRC-24 with Koopman polynomial 0xBD80DE (0x7B01BD in normal notation), most significant bit first.
//!
//! The Hamming distance is 6 up to 2026 data bits: the CRC detects up to five flipped bits in every line and frame.
//! A 24-bit remainder fills four 6-bit characters exactly.

const POLYNOMIAL: u32 = 0x7B_01BD;

/// Initial remainder of a line.
pub const DOWNLINK_INIT: u32 = 0xFF_FFFF;

/// Number of characters of the remainder on the wire.
pub const CHARACTERS: usize = 4;

const fn step(mut remainder: u32, bits: u32) -> u32 {
    let mut i = 0;
    while i < bits {
        remainder = if remainder & 0x80_0000 == 0 {
            remainder << 1
        } else {
            remainder << 1 ^ POLYNOMIAL
        };
        i += 1;
    }
    remainder & 0xFF_FFFF
}

/// Implementation with a table of 16 nibbles: 64 bytes of a microcontroller's RAM.
#[cfg(target_os = "none")]
mod engine {
    use super::step;

    const NIBBLES: [u32; 16] = {
        let mut table = [0; 16];
        let mut i = 0;
        while i < 16 {
            table[i] = step((i as u32) << 20, 4);
            i += 1;
        }
        table
    };

    pub fn update(mut remainder: u32, bytes: &[u8]) -> u32 {
        for &byte in bytes {
            for nibble in [byte >> 4, byte & 0xF] {
                let index = (remainder >> 20) as u8 ^ nibble;
                remainder = (remainder << 4 & 0xFF_FFFF) ^ NIBBLES[usize::from(index & 0xF)];
            }
        }
        remainder
    }
}

/// Implementation with eight tables, which takes eight bytes per step, because the speed of decoding long captures depends on it.
#[cfg(not(target_os = "none"))]
mod engine {
    use super::step;

    const SLICES: usize = 8;

    static TABLES: [[u32; 256]; SLICES] = {
        let mut tables = [[0; 256]; SLICES];
        let mut byte = 0;
        while byte < 256 {
            let mut remainder = step((byte as u32) << 16, 8);
            let mut slice = 0;
            while slice < SLICES {
                tables[slice][byte] = remainder;
                remainder = step(remainder, 8);
                slice += 1;
            }
            byte += 1;
        }
        tables
    };

    pub fn update(mut remainder: u32, bytes: &[u8]) -> u32 {
        let (blocks, rest) = bytes.as_chunks::<SLICES>();
        for b in blocks {
            let head = [
                b[0] ^ (remainder >> 16) as u8,
                b[1] ^ (remainder >> 8) as u8,
                b[2] ^ remainder as u8,
            ];
            remainder = TABLES[7][usize::from(head[0])]
                ^ TABLES[6][usize::from(head[1])]
                ^ TABLES[5][usize::from(head[2])]
                ^ TABLES[4][usize::from(b[3])]
                ^ TABLES[3][usize::from(b[4])]
                ^ TABLES[2][usize::from(b[5])]
                ^ TABLES[1][usize::from(b[6])]
                ^ TABLES[0][usize::from(b[7])];
        }
        for &byte in rest {
            let index = (remainder >> 16) as u8 ^ byte;
            remainder = (remainder << 8 & 0xFF_FFFF) ^ TABLES[0][usize::from(index)];
        }
        remainder
    }
}

/// The remainder after further bytes.
#[must_use]
pub fn update(remainder: u32, bytes: &[u8]) -> u32 {
    engine::update(remainder, bytes)
}

/// The one flipped bit among `bytes` bytes that changes the remainder by `difference`: the place of its byte from the end, and its place in
/// the byte from the least significant bit. `None` if no single bit does.
#[must_use]
pub fn flipped_bit(difference: u32, bytes: usize) -> Option<(usize, u32)> {
    let mut change = POLYNOMIAL;
    for from_end in 0..bytes {
        for bit in 0..8 {
            if change == difference {
                return Some((from_end, bit));
            }
            change = step(change, 1);
        }
    }
    None
}

/// The remainder as characters on the wire, most significant character first.
#[must_use]
pub fn characters(remainder: u32) -> [u8; CHARACTERS] {
    let mut out = [0; CHARACTERS];
    crate::sixbit::encode_into(remainder, &mut out);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bit_by_bit(init: u32, bytes: &[u8]) -> u32 {
        bytes
            .iter()
            .fold(init, |r, &byte| step(r ^ u32::from(byte) << 16, 8))
    }

    #[test]
    fn the_tables_agree_with_long_division_at_every_length() {
        let bytes: [u8; 100] = core::array::from_fn(|i| (i * 37 + 11) as u8);
        for length in 0..bytes.len() {
            assert_eq!(
                update(DOWNLINK_INIT, &bytes[..length]),
                bit_by_bit(DOWNLINK_INIT, &bytes[..length]),
                "{length} bytes"
            );
        }
    }

    /// Koopman's notation omits the constant term instead of the leading term. The values were computed independently of
    /// this code, bit by bit.
    #[test]
    fn checksum_has_the_polynomial_0xbd80de() {
        assert_eq!(0xBD_80DE << 1 & 0xFF_FFFF | 1, POLYNOMIAL);
        assert_eq!(update(DOWNLINK_INIT, b"123456789"), 0x74_A079);
        assert_eq!(update(0, b"123456789"), 0x5E_B034);
    }

    #[test]
    fn a_remainder_continues_across_any_split() {
        let bytes = *b"A42 +123.4 -045.0 273 +06 -12";
        let whole = update(DOWNLINK_INIT, &bytes);
        for split in 0..bytes.len() {
            let (head, tail) = bytes.split_at(split);
            assert_eq!(update(update(DOWNLINK_INIT, head), tail), whole);
        }
    }
}
