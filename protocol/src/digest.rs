//! Digest of a waypoint list; both ends compare it to know that they hold the same list.

use crate::Waypoint;

/// CRC-32/ISO-HDLC over the count as u16 and each waypoint's X and Y as i16, all little-endian.
///
/// Uses a table of 16 nibbles, because RAM on the microcontroller is short.
#[must_use]
pub fn digest<'a>(waypoints: impl ExactSizeIterator<Item = &'a Waypoint>) -> u32 {
    let count = (waypoints.len() as u16).to_le_bytes();
    let crc = waypoints.fold(update(!0, &count), |crc, waypoint| {
        let crc = update(crc, &waypoint.x_in.to_le_bytes());
        update(crc, &waypoint.y_in.to_le_bytes())
    });
    !crc
}

const NIBBLES: [u32; 16] = {
    let mut table = [0; 16];
    let mut i = 0;
    while i < 16 {
        let mut crc = i as u32;
        let mut bit = 0;
        while bit < 4 {
            crc = if crc & 1 == 0 {
                crc >> 1
            } else {
                crc >> 1 ^ 0xEDB8_8320
            };
            bit += 1;
        }
        table[i] = crc;
        i += 1;
    }
    table
};

fn update(crc: u32, bytes: &[u8]) -> u32 {
    bytes.iter().fold(crc, |crc, &byte| {
        let crc = crc ^ u32::from(byte);
        let crc = crc >> 4 ^ NIBBLES[(crc & 0xF) as usize];
        crc >> 4 ^ NIBBLES[(crc & 0xF) as usize]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digest_is_crc_32_iso_hdlc() {
        // The check value of CRC-32/ISO-HDLC.
        assert_eq!(!update(!0, b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn digest_depends_on_order_and_count() {
        let a = Waypoint { x_in: 1, y_in: 2 };
        let b = Waypoint { x_in: 2, y_in: 1 };
        let digests = [
            digest([].iter()),
            digest([a].iter()),
            digest([a, b].iter()),
            digest([b, a].iter()),
            digest([a, b, b].iter()),
        ];
        for (i, x) in digests.iter().enumerate() {
            assert!(digests[i + 1..].iter().all(|y| x != y));
        }
    }
}
