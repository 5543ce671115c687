//! Tests of finding lines in bytes.

use proptest::prelude::*;

use super::*;
use crate::crc;
use crate::telemetry::{LineType, repaired};

#[rustfmt::skip]
const fn head(line_type: LineType) -> &'static [u8; 74] {
    match line_type {
        LineType::State => b"A42 +123.4 -045.0 273 +06 -12 +00 +12 042 120 61 48 .R..... P--Is..- !5:HS",
        LineType::Status => b"B47 07 12.4 +0120 -0036 003/040 #Q8.Z` 12 155 122 UB.IS..D 004 00    !5:HS",
        LineType::Counters => b"C53 07 000412 004 01.00 `````3`````V*4``,0 133 002 000 0012 0030 G   !5:HS",
        LineType::Text => b"T49 I'm finished with the co-ordinate list                           !5:HS",
        LineType::Parameter => b"P48 01/26 top-speed          +00008 +00012 +00002 +00012 in/s        !5:HS",
        LineType::Song => b"S49 (+$*3$,0$07(``\"(+0                                               !5:HS",
        LineType::Abilities => b"I50 07 3 040 PR.X..... B.S. 00240 2                                  !5:HS",
        LineType::Field => b"F51 1/2 motor-current      2 A                                       !5:HS",
        LineType::Values => b"V52 +00125 -00007 ------ ------ ------ ------ ------ ------ ------   !5:HS",
    }
}

fn sealed(head: &[u8; 74]) -> [u8; LINE_BYTES] {
    let mut line = [0; LINE_BYTES];
    line[..74].copy_from_slice(head);
    line[74..78].copy_from_slice(&crc::characters(crc::update(crc::DOWNLINK_INIT, head)));
    line[78..].copy_from_slice(b"\r\n");
    line
}

/// [`Decoder::take_whole`] relies on this property.
#[test]
fn intact_lines_hold_no_line_feed() {
    for &line_type in LineType::ALL {
        let head = head(line_type);
        let line = sealed(head);
        let read = Line::parse(&line).map(|line| line.body.line_type());
        assert!(is_intact(&line) && read == Ok(line_type), "{line_type:?}");
        for column in 0..head.len() {
            let mut head = *head;
            head[column] = b'\n';
            let line = sealed(&head);
            assert!(is_intact(&line) && Line::parse(&line).is_err(), "{column}");
        }
    }
}

#[test]
fn whole_lines_and_single_bytes_give_the_same_result() {
    let types = LineType::ALL;
    let mut stream = std::vec::Vec::new();
    for (i, &line_type) in types.iter().chain(types).enumerate() {
        let mut line = sealed(head(line_type));
        if i == 2 {
            line[40] ^= 1;
        }
        let noise = if i % 2 == 0 { i } else { 0 };
        stream.extend(std::iter::repeat_n(0, noise).chain(line));
    }
    let mut whole = Decoder::default();
    let mut single = Decoder::default();
    let mut rest = &stream[..];
    while !rest.is_empty() {
        let before = rest;
        let received = whole.next_line(&mut rest);
        let taken = &before[..before.len() - rest.len()];
        let one_by_one = taken
            .iter()
            .filter_map(|&byte| single.lines(&[byte]).next())
            .last();
        assert_eq!(received, one_by_one);
        assert_eq!(whole.counters(), single.counters());
    }
    assert_eq!(whole.counters().lines, 2 * types.len() as u64 - 1);
}

/// A line of every type.
fn lines() -> impl Iterator<Item = [u8; LINE_BYTES]> {
    LineType::ALL.iter().map(|&it| sealed(head(it)))
}

fn flip(line: &mut [u8; LINE_BYTES], bit: usize) {
    line[bit / 8] ^= 1 << (bit % 8);
}

/// Number of bits before CR LF.
const BITS: usize = (LINE_BYTES - 2) * 8;

#[test]
fn each_flipped_bit_is_repaired() {
    for line in lines() {
        assert_eq!(repaired(&line), None, "intact");
        for bit in 0..LINE_BYTES * 8 {
            let mut damaged = line;
            flip(&mut damaged, bit);
            let expected = (bit < BITS).then_some(line);
            assert_eq!(repaired(&damaged), expected, "bit {bit}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4096))]

    #[test]
    fn two_to_four_flipped_bits_are_never_repaired(
        line in prop::sample::select(lines().collect::<std::vec::Vec<_>>()),
        bits in prop::collection::btree_set(0..LINE_BYTES * 8, 2..=4),
    ) {
        let mut damaged = line;
        for &bit in &bits {
            flip(&mut damaged, bit);
        }
        prop_assert_eq!(repaired(&damaged), None);
    }

    /// Random bytes get a line's checksum by one flip in one of 27,000 cases, if their checksum has valid characters at all, and then hold no
    /// fields.
    #[test]
    fn random_bytes_are_not_repaired_to_a_line(mut bytes: [u8; LINE_BYTES], is_printable: bool) {
        if is_printable {
            bytes = bytes.map(|byte| b' ' + byte % 0x40);
        }
        bytes[LINE_BYTES - 2..].copy_from_slice(b"\r\n");
        let read = repaired(&bytes).and_then(|sent| Line::parse(&sent).ok());
        prop_assert_eq!(read, None);
    }
}
