//! What a board keeps in memory that survives a reset: the parameters and the boot counter, each in two copies.
//!
//! A board writes the older copy and never the newer one, so power lost at any moment leaves the old or the new
//! contents. A copy counts only if its checksum is right. Parameters are stored under the keys of their names, so that
//! another version of the program finds those that it knows.

use crate::parameters::{Parameter, Parameters};
use groundwave_protocol::crc;
use groundwave_protocol::parameter::{PARAMETERS_MAX, key};

/// Bytes of a stored parameter: its key and its value.
const ENTRY_BYTES: u16 = 5;

/// Bytes of a checksum.
const CHECK_BYTES: usize = 3;

/// Bytes before the entries: the copy's number and the number of entries.
const HEAD_BYTES: u16 = 2;

/// Room for a copy of the parameters, of any version of the program.
pub const COPY_BYTES: u16 = HEAD_BYTES + PARAMETERS_MAX as u16 * ENTRY_BYTES + CHECK_BYTES as u16;

/// Bytes of a copy of the boot counter.
pub const BOOTS_BYTES: usize = 2 + CHECK_BYTES;

/// Number of a copy from which the next one is counted if there is none.
const FIRST: u8 = 0;

/// Writes a copy of the parameters byte by byte, so that a board need not wait for its memory.
#[derive(Clone, Debug)]
pub struct CopyWriter {
    number: u8,
    place: u16,
    check: u32,
}

impl CopyWriter {
    /// The copy after one with this number.
    #[must_use]
    pub const fn after(number: u8) -> Self {
        Self {
            number: number.wrapping_add(1),
            place: 0,
            check: crc::DOWNLINK_INIT,
        }
    }

    /// Number of this copy.
    #[must_use]
    pub const fn number(&self) -> u8 {
        self.number
    }

    /// The next byte; `None` after the last. The parameters must be the same for each byte of a copy.
    pub fn next_byte(&mut self, parameters: &Parameters) -> Option<u8> {
        let count = Parameter::ALL.len();
        let byte = if let Some(place) = self.place.checked_sub(HEAD_BYTES) {
            if let Some(&parameter) = Parameter::ALL.get(usize::from(place / ENTRY_BYTES)) {
                let [.., a, b, c] = key(parameter.definition().name).to_be_bytes();
                let [d, e] = parameters.get(parameter).to_be_bytes();
                [a, b, c, d, e]
                    .get(usize::from(place % ENTRY_BYTES))
                    .copied()?
            } else {
                let place = usize::from(place) - count * usize::from(ENTRY_BYTES);
                self.place += 1;
                return check_bytes(self.check).get(place).copied();
            }
        } else if self.place == 0 {
            self.number
        } else {
            count as u8
        };
        self.place += 1;
        self.check = crc::update(self.check, &[byte]);
        Some(byte)
    }
}

/// Parameters from a copy, with its number; `None` if its checksum is wrong. Parameters that this version does not know
/// are left out, and values outside the limits, too: those have their defaults.
pub fn read_copy(bytes: impl IntoIterator<Item = u8>) -> Option<(u8, Parameters)> {
    let mut bytes = bytes.into_iter();
    let mut check = crc::DOWNLINK_INIT;
    let mut next = || {
        let byte = bytes.next()?;
        check = crc::update(check, &[byte]);
        Some(byte)
    };
    let number = next()?;
    let count = next().filter(|&count| count <= PARAMETERS_MAX)?;
    let mut parameters = Parameters::DEFAULT;
    for _ in 0..count {
        let key = u32::from_be_bytes([0, next()?, next()?, next()?]);
        let value = i16::from_be_bytes([next()?, next()?]);
        if let Some(parameter) = Parameter::with_key(key) {
            parameters.set(parameter, value);
        }
    }
    let expected = check_bytes(check);
    let stored = [bytes.next()?, bytes.next()?, bytes.next()?];
    (stored == expected).then_some((number, parameters))
}

/// The newer of two copies, and whether it is the second one; a board overwrites the other. Without any copy the
/// parameters have their defaults.
#[must_use]
pub fn newer_copy(
    first: Option<(u8, Parameters)>,
    second: Option<(u8, Parameters)>,
) -> (u8, Parameters, bool) {
    match (first, second) {
        (Some((number, _)), Some((other, parameters))) if is_after(other, number) => {
            (other, parameters, true)
        }
        (None, Some((number, parameters))) => (number, parameters, true),
        (Some((number, parameters)), _) => (number, parameters, false),
        (None, None) => (FIRST, Parameters::DEFAULT, true),
    }
}

/// Whether a number is the later of two that wrap around.
const fn is_after(number: u8, other: u8) -> bool {
    number.wrapping_sub(other) as i8 > 0
}

/// A copy of the boot counter.
#[must_use]
pub fn boots_copy(boots: u16) -> [u8; BOOTS_BYTES] {
    let [high, low] = boots.to_be_bytes();
    let [a, b, c] = check_bytes(crc::update(crc::DOWNLINK_INIT, &[high, low]));
    [high, low, a, b, c]
}

/// The boot counter from a copy; `None` if its checksum is wrong.
#[must_use]
pub fn read_boots(copy: [u8; BOOTS_BYTES]) -> Option<u16> {
    let [high, low, ..] = copy;
    let boots = u16::from_be_bytes([high, low]);
    (copy == boots_copy(boots)).then_some(boots)
}

/// The boot counter from two copies, 0 without any, and whether it is from the second one.
#[must_use]
pub fn newer_boots(first: Option<u16>, second: Option<u16>) -> (u16, bool) {
    match (first, second) {
        (Some(first), Some(second)) if second.wrapping_sub(first) as i16 > 0 => (second, true),
        (None, Some(second)) => (second, true),
        (Some(first), _) => (first, false),
        (None, None) => (0, true),
    }
}

/// A blank memory has all bits set: its checksum must be wrong, so the remainder is inverted.
fn check_bytes(check: u32) -> [u8; CHECK_BYTES] {
    let [.., a, b, c] = (!check).to_be_bytes();
    [a, b, c]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn copy_after(number: u8, parameters: &Parameters) -> Vec<u8> {
        let mut writer = CopyWriter::after(number);
        std::iter::from_fn(|| writer.next_byte(parameters)).collect()
    }

    fn with_top_speed(value: i16) -> Parameters {
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::TopSpeed, value));
        parameters
    }

    #[test]
    fn a_copy_restores_every_parameter() {
        let mut parameters = with_top_speed(7);
        assert!(parameters.set(Parameter::Square, -321));
        let copy = copy_after(u8::MAX, &parameters);
        assert!(copy.len() <= usize::from(COPY_BYTES));
        assert_eq!(read_copy(copy), Some((0, parameters)));
    }

    #[test]
    fn power_lost_at_any_byte_leaves_the_old_or_the_new_parameters() {
        let blank = std::vec![0xFF; usize::from(COPY_BYTES)];
        let (mut copies, mut kept) = ([blank.clone(), blank], Parameters::DEFAULT);
        let newest = |copies: &[Vec<u8>; 2]| {
            let [first, second] = copies
                .each_ref()
                .map(|copy| read_copy(copy.iter().copied()));
            newer_copy(first, second)
        };
        for value in [2, 3, 4, 5] {
            let next = with_top_speed(value);
            let (number, found, is_second) = newest(&copies);
            assert_eq!(found, kept);
            let written = copy_after(number, &next);
            for (place, &byte) in written.iter().enumerate() {
                // A byte that was being written may have any value.
                for damaged in [0, !byte, byte ^ 0x10, byte ^ 1, u8::MAX] {
                    copies[usize::from(!is_second)][place] = damaged;
                    let (_, found, _) = newest(&copies);
                    assert!(found == kept || found == next, "byte {place}: {damaged}");
                }
                copies[usize::from(!is_second)][place] = byte;
                let (_, found, _) = newest(&copies);
                let is_whole = place + 1 == written.len();
                assert!(
                    found == if is_whole { next.clone() } else { kept.clone() } || found == next,
                    "byte {place} of {value}"
                );
            }
            kept = next;
        }
    }

    #[test]
    fn power_lost_at_any_byte_leaves_the_old_or_the_new_boot_counter() {
        let mut copies = [[0xFF; BOOTS_BYTES]; 2];
        let newest = |copies: [[u8; BOOTS_BYTES]; 2]| {
            let [first, second] = copies.map(read_boots);
            newer_boots(first, second)
        };
        assert_eq!(newest(copies).0, 0, "a blank memory");
        for boots in (1..4).chain([u16::MAX, 0, 1]) {
            let (before, is_second) = newest(copies);
            for (place, byte) in boots_copy(boots).into_iter().enumerate() {
                // A byte that was being written may have any value.
                for damaged in (0..=u8::MAX).chain([byte]) {
                    copies[usize::from(!is_second)][place] = damaged;
                    let found = newest(copies).0;
                    assert!(found == before || found == boots, "{found} at {place}");
                }
            }
            if boots == u16::MAX {
                copies = [boots_copy(boots), boots_copy(boots - 1)];
            }
            assert_eq!(newest(copies).0, boots);
        }
    }

    #[test]
    fn unknown_keys_and_values_out_of_range_are_left_out() {
        let entry = |name: &str, value: i16| {
            let [_, key @ ..] = key(name).to_be_bytes();
            [&key[..], &value.to_be_bytes()].concat()
        };
        let entries = [
            entry("top-speed", 99),
            entry("warp-speed", 3),
            entry("square", -300),
        ];
        let mut copy = [&[7, 3][..], &entries.concat()].concat();
        let check = crc::update(crc::DOWNLINK_INIT, &copy);
        copy.extend(check_bytes(check));
        let mut expected = Parameters::DEFAULT;
        assert!(expected.set(Parameter::Square, -300));
        assert_eq!(read_copy(copy.clone()), Some((7, expected)));
        for place in 0..copy.len() {
            let mut damaged = copy.clone();
            damaged[place] ^= 0x10;
            assert_eq!(read_copy(damaged), None, "byte {place}");
        }
        assert_eq!(read_copy([0xFF; COPY_BYTES as usize]), None, "blank");
        assert_eq!(read_copy([0; COPY_BYTES as usize]), None, "all zero");
    }
}
