//! Repaired lines A: for the estimate alone.

use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::{Arrival, Counters, Decoder, Received};
use groundwave_protocol::telemetry::{Ack, AckLine, Body, Detail, Line};
use proptest::prelude::*;

use crate::damage::{Sample, sample, samples};
use crate::decoder::noisy_stream;

/// What arrives in a stream that arrives in pieces of `bytes`, and the counters.
fn arrivals(stream: &[u8], bytes: usize) -> (Vec<Arrival>, Counters) {
    let mut decoder = Decoder::default();
    let mut all = Vec::new();
    for mut piece in stream.chunks(bytes) {
        while let Some(arrival) = decoder.next_arrival(&mut piece) {
            all.push(arrival);
        }
    }
    (all, *decoder.counters())
}

fn own_lines(stream: &[u8]) -> (Vec<Received>, Counters) {
    let mut decoder = Decoder::default();
    let mut rest = stream;
    let lines = std::iter::from_fn(|| decoder.next_own_line(&mut rest)).collect();
    (lines, *decoder.counters())
}

/// An acknowledgement without an id.
fn ack(boot: u8) -> Ack {
    Ack {
        boot,
        detail: Detail::Era { era: 1 },
        ..Ack::default()
    }
}

/// A line with another sequence and acknowledgement.
fn line(letter: u8, sequence: u8, ack: Ack) -> Line {
    let sample: [u8; LINE_BYTES] = sample(letter).bytes.try_into().expect("80 bytes");
    let line = Line::parse(&sample).expect("a line");
    Line {
        sequence,
        ack,
        ..line
    }
}

fn flipped(line: &Line, bits: &[usize]) -> Vec<u8> {
    let bytes = line.encode().to_vec();
    let name = String::new();
    Sample { name, bytes }.flipped(bits)
}

/// The repaired lines in a stream.
fn repaired(pieces: &[Vec<u8>]) -> Vec<Line> {
    let (all, _) = arrivals(&pieces.concat(), 7);
    let repaired = all.iter().filter_map(|arrival| match arrival {
        Arrival::Repaired(line) => Some(*line),
        Arrival::Line(_) => None,
    });
    repaired.collect()
}

/// A stream of lines of all types in sequence, many of them with flipped bits.
fn damaged_stream() -> impl Strategy<Value = Vec<u8>> {
    let letter = prop::sample::select(&b"AAAABCT"[..]);
    let bits = prop::collection::btree_set(0..LINE_BYTES * 8, 0..3);
    prop::collection::vec((letter, bits), 1..30).prop_map(|lines| {
        let lines = lines.into_iter().enumerate().map(|(n, (letter, bits))| {
            let bits: Vec<_> = bits.into_iter().collect();
            flipped(&line(letter, n as u8, ack(1)), &bits)
        });
        lines.flatten().collect()
    })
}

proptest! {
    #[test]
    fn repair_changes_no_line_and_no_counter(
        stream in prop_oneof![noisy_stream(), damaged_stream()],
        bytes in 1..200_usize,
    ) {
        let (all, counters) = arrivals(&stream, bytes);
        let lines: Vec<_> = all.iter().filter_map(|arrival| match arrival {
            Arrival::Line(received) => Some(*received),
            Arrival::Repaired(_) => None,
        }).collect();
        prop_assert_eq!((lines, counters), own_lines(&stream));
        prop_assert_eq!(all, arrivals(&stream, 1).0);
    }
}

#[test]
fn each_flipped_bit_of_a_line_a_is_repaired_and_damage_of_two_to_four_is_not() {
    let before = line(b'C', 41, ack(1)).encode().to_vec();
    let sent = line(b'A', 42, ack(1));
    for bit in 0..(LINE_BYTES - 2) * 8 {
        let stream = [before.clone(), flipped(&sent, &[bit])];
        assert_eq!(repaired(&stream), [sent], "bit {bit}");
        for more in 1..4 {
            let bits: Vec<_> = (0..=more).map(|n| (bit + 101 * n) % 624).collect();
            let stream = [before.clone(), flipped(&sent, &bits)];
            assert_eq!(repaired(&stream), [], "bits {bits:?}");
        }
    }
}

#[test]
fn only_lines_a_are_repaired() {
    for sample in samples() {
        let before = line(b'C', 41, ack(1)).encode().to_vec();
        if sample.bytes.len() != LINE_BYTES {
            continue;
        }
        let letter = sample.bytes[0];
        let damaged = flipped(&line(letter, 42, ack(1)), &[77]);
        let count = usize::from(letter == b'A');
        assert_eq!(repaired(&[before, damaged]).len(), count, "{}", sample.name);
    }
}

/// A line that another robot may have sent, or the followed one earlier, could lead the estimate elsewhere.
#[test]
fn a_line_that_may_be_of_another_robot_or_boot_is_not_repaired() {
    let before = |sequence| line(b'C', sequence, ack(1)).encode().to_vec();
    let damaged = |sequence, ack| flipped(&line(b'A', sequence, ack), &[77]);
    let count = |pieces: &[Vec<u8>]| repaired(pieces).len();
    assert_eq!(count(&[before(41), damaged(42, ack(1))]), 1);
    assert_eq!(
        count(&[before(97), damaged(6, ack(1))]),
        1,
        "8 lines are lost"
    );
    assert_eq!(
        count(&[before(97), damaged(7, ack(1))]),
        0,
        "9 lines are lost"
    );
    assert_eq!(count(&[before(42), damaged(42, ack(1))]), 0, "repeated");
    assert_eq!(count(&[before(43), damaged(42, ack(1))]), 0, "late");
    assert_eq!(count(&[before(41), damaged(42, ack(2))]), 0, "another boot");
    assert_eq!(count(&[damaged(42, ack(1))]), 0, "no line before");
    let with_id = |robot_id| Ack {
        detail: Detail::Idle { owner: 0, robot_id },
        ..ack(1)
    };
    let Body::Counters(counters) = line(b'C', 41, ack(1)).body else {
        panic!("line C");
    };
    let own = counters.robot_id;
    assert_eq!(count(&[before(41), damaged(42, with_id(own))]), 1);
    assert_eq!(count(&[before(41), damaged(42, with_id(own + 1))]), 0);
    let other = AckLine {
        sequence: 7,
        ack: with_id(own + 1),
        listens: false,
    };
    let other = other.encode().to_vec();
    assert_eq!(count(&[before(41), other, damaged(42, ack(1))]), 0, "two");
    // The next line decides about this one.
    let undecided = line(b'A', 70, ack(1)).encode().to_vec();
    assert_eq!(count(&[before(41), undecided, damaged(43, ack(1))]), 0);
}
