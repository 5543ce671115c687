//! The decoder on clean, noisy and damaged streams.

use crate::damage::{self, Rng, Sample, sample, samples};
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::{Ack, AckLine, Body, Line, TextLine};
use proptest::prelude::*;

/// The lines and counters of a stream fed in one piece.
fn decode(stream: &[u8]) -> (Vec<Received>, Counters) {
    decode_chunks([stream])
}

fn decode_chunks<'a>(chunks: impl IntoIterator<Item = &'a [u8]>) -> (Vec<Received>, Counters) {
    let mut decoder = Decoder::default();
    let mut found = Vec::new();
    for chunk in chunks {
        found.extend(decoder.lines(chunk));
    }
    let counters = *decoder.counters();
    balance(&counters);
    (found, counters)
}

/// Checks that each byte belongs to an intact line or is noise.
fn balance(c: &Counters) {
    let intact = c.lines * 80 + c.ack_lines * 14;
    assert_eq!(intact + c.noise_bytes, c.bytes, "{c:?}");
}

fn text(sequence: u8, words: &str) -> Vec<u8> {
    with_boot(sequence, 1, words)
}

fn with_boot(sequence: u8, boot: u8, words: &str) -> Vec<u8> {
    let line = Line {
        sequence,
        body: Body::Text(TextLine::new(words)),
        ack: Ack {
            boot,
            ..Ack::default()
        },
    };
    line.encode().to_vec()
}

fn knocked(sequence: u8) -> Vec<u8> {
    let ack = Ack {
        boot: 1,
        ..Ack::default()
    };
    AckLine {
        sequence,
        ack,
        listens: sequence % 2 == 1,
    }
    .encode()
    .to_vec()
}

/// A stream of lines, damaged lines and noise.
pub(crate) fn noisy_stream() -> impl Strategy<Value = Vec<u8>> {
    let line = || prop::sample::select(samples());
    let piece = prop_oneof![
        5 => line().prop_map(|s| s.bytes),
        1 => (line(), 0..80_usize).prop_map(|(s, n)| s.bytes[..n.min(s.bytes.len())].to_vec()),
        1 => (line(), 0..80_usize).prop_map(|(s, n)| s.bytes[n.min(s.bytes.len())..].to_vec()),
        2 => (line(), 0..640_usize).prop_map(|(s, bit)| s.flipped(&[bit % s.bits()])),
        1 => prop::collection::vec(any::<u8>(), 0..100),
        1 => prop::collection::vec(prop::sample::select(&b"\r\nAK0 "[..]), 0..30),
    ];
    prop::collection::vec(piece, 0..12).prop_map(|pieces| pieces.concat())
}

proptest! {
    #[test]
    fn chunking_does_not_change_the_result(
        stream in noisy_stream(),
        cuts in prop::collection::vec(1..120_usize, 1..60),
    ) {
        let whole = decode(&stream);
        prop_assert_eq!(&decode_chunks(stream.chunks(1)), &whole);
        let mut rest = &stream[..];
        let mut chunks = Vec::new();
        for cut in cuts {
            let (chunk, after) = rest.split_at(cut.min(rest.len()));
            chunks.push(chunk);
            rest = after;
        }
        chunks.push(rest);
        prop_assert_eq!(&decode_chunks(chunks), &whole);
    }

    #[test]
    fn line_feeds_end_a_line_or_are_rejected_for_one_reason(stream in noisy_stream()) {
        let (found, c) = decode(&stream);
        let line_feeds = stream.split(|&b| b == b'\n').count() as u64 - 1;
        let rejected = c.crc_rejected + c.shape_rejected + c.field_rejected;
        prop_assert_eq!(c.lines + c.ack_lines + rejected, line_feeds);
        prop_assert_eq!(c.lines + c.ack_lines, found.len() as u64);
    }

    #[test]
    fn a_good_line_is_found_after_any_noise(
        before in noisy_stream(), line in prop::sample::select(samples()),
    ) {
        let (earlier, _) = decode(&before);
        let (found, _) = decode(&[&before[..], &line.bytes].concat());
        prop_assert_eq!(found.len(), earlier.len() + 1);
        prop_assert_eq!(found.last().map(damage::bytes_of), Some(line.bytes));
    }
}

#[test]
fn a_good_line_inside_a_corrupt_one_is_found() {
    for line in samples() {
        for around in samples() {
            for at in 1..around.bytes.len() - 2 {
                let (head, tail) = around.bytes.split_at(at);
                let stream = [head, &line.bytes, tail].concat();
                let (found, counters) = decode(&stream);
                assert_eq!(found.len(), 1, "{} in {} at {at}", line.name, around.name);
                assert_eq!(damage::bytes_of(&found[0]), line.bytes);
                assert_eq!(counters.noise_bytes, around.bytes.len() as u64);
            }
        }
    }
}

/// Flips bits of a line and appends a good line; if the line feed is damaged, both form one line. Checks that only the good line is
/// found, and that the checksum rejects the other before its fields are read.
fn judge(line: &Sample, bits: &[usize], next: &[u8], context: &str) {
    let (found, counters) = decode(&[&line.flipped(bits), next].concat());
    let found: Vec<_> = found.iter().map(damage::bytes_of).collect();
    assert_eq!(found, [next], "{} bits {bits:?} {context}", line.name);
    assert_eq!(
        counters.field_rejected, 0,
        "{} bits {bits:?} {context}",
        line.name
    );
}

/// Tests all 8 bits of all 80 (or 14) bytes, including CR and LF.
#[test]
fn every_flip_of_one_or_two_bits_is_rejected() {
    let next = text(7, "the line after it");
    for line in samples() {
        for first in 0..line.bits() {
            judge(&line, &[first], &next, "");
            for second in first + 1..line.bits() {
                judge(&line, &[first, second], &next, "");
            }
        }
    }
}

#[test]
fn flips_of_three_to_five_bits_are_rejected() {
    let seed = damage::seed();
    let context = format!("seed {seed}");
    let mut rng = Rng(seed);
    let next = text(7, "the line after it");
    for line in samples() {
        for _ in 0..300_000 {
            let count = 3 + rng.below(3);
            let bits = rng.different(count, line.bits());
            judge(&line, &bits, &next, &context);
        }
    }
}

#[test]
fn noise_gives_no_line() {
    let seed = damage::seed();
    let mut rng = Rng(seed);
    let mut decoder = Decoder::default();
    let mut noise = vec![0; 1 << 16];
    for round in 0..256 {
        // Plain noise, noise full of line ends, and noise in the characters of a line.
        let alphabet: &[u8] = match round % 4 {
            0 => b"\r\n",
            1 => b"\r\n\r\n\r\n\r\nABCKT+-.0123456789 !LRD",
            _ => &[],
        };
        for byte in &mut noise {
            *byte = match alphabet.len() {
                0 => rng.next() as u8,
                n => alphabet[rng.below(n)],
            };
        }
        assert_eq!(decoder.lines(&noise).next(), None, "seed {seed}");
    }
    balance(decoder.counters());
    assert_eq!(decoder.counters().noise_bytes, 256 << 16);
}

#[test]
fn unreadable_lines_are_counted_and_blamed_by_column() {
    for (letter, column, blamed) in [(b'A', 1, 1), (b'A', 19, 19), (b'K', 1, 1), (b'K', 2, 2)] {
        let mut line = sample(letter);
        line.bytes[column - 1] = b'z';
        line.seal();
        let mut decoder = Decoder::default();
        assert_eq!(decoder.lines(&line.bytes).next(), None);
        let is_ack_line_of_no_type = letter == b'K' && column == 1;
        // Fourteen bytes that do not begin with K or G are not tried at all.
        let counters = decoder.counters();
        assert_eq!(counters.field_rejected, u64::from(!is_ack_line_of_no_type));
        assert_eq!(counters.shape_rejected, u64::from(is_ack_line_of_no_type));
        let said = decoder.last_field_error().map(|e| e.column);
        assert_eq!(said, (!is_ack_line_of_no_type).then_some(blamed));
        balance(counters);
    }
}

#[test]
fn rejected_line_feeds_are_counted_by_reason() {
    let good = text(1, "good");
    let mut bad_crc = good.clone();
    bad_crc[10] ^= 1;
    let mut bad_ack_line = knocked(2);
    bad_ack_line[4] ^= 1;
    for (stream, reason) in [
        (bad_crc, "crc"),
        (bad_ack_line, "crc"),
        (b"\n".to_vec(), "shape"),
        (good[1..].to_vec(), "shape"),
        (b"K".repeat(79).into_iter().chain(*b"\n").collect(), "shape"),
    ] {
        let (found, c) = decode(&stream);
        assert_eq!(found, []);
        let expected = if reason == "crc" { (1, 0) } else { (0, 1) };
        assert_eq!(
            (c.crc_rejected, c.shape_rejected),
            expected,
            "{}",
            stream.escape_ascii()
        );
    }
}

fn lost(lines: &[Vec<u8>]) -> u64 {
    let (found, counters) = decode(&lines.concat());
    assert_eq!(found.len(), lines.len());
    counters.lines_lost
}

#[test]
fn lost_lines_are_counted_from_the_sequence() {
    let line = |sequence| text(sequence, "");
    assert_eq!(lost(&[line(5), line(6), line(7)]), 0);
    assert_eq!(lost(&[line(5), knocked(6), line(7)]), 0);
    assert_eq!(lost(&[line(5), line(8), line(9)]), 2);
    assert_eq!(lost(&[line(98), line(99), line(0), line(1)]), 0);
    assert_eq!(lost(&[line(98), line(2)]), 3);
    assert_eq!(lost(&[line(0), line(94)]), 93);
}

#[test]
fn a_late_or_repeated_line_is_not_a_gap_of_a_hundred() {
    let line = |sequence| text(sequence, "");
    assert_eq!(lost(&[line(5), line(5), line(6)]), 0);
    assert_eq!(lost(&[line(5), line(6), line(5), line(7)]), 0);
    // The late line counted as lost for a while.
    assert_eq!(lost(&[line(5), line(7), line(6), line(8)]), 0);
    assert_eq!(lost(&[line(5), line(7), line(6), line(6), line(8)]), 0);
    assert_eq!(lost(&[line(99), line(1), line(0), line(2)]), 0);
    assert_eq!(lost(&[line(5), line(9), line(6), line(10)]), 2);
    // Lines before the first received line never count as lost.
    assert_eq!(lost(&[line(5), line(3), line(6)]), 0);
    assert_eq!(lost(&[line(5), line(10), line(5), line(11)]), 4);
}

#[test]
fn a_reboot_begins_a_new_count() {
    let line = |sequence, boot| with_boot(sequence, boot, "");
    assert_eq!(lost(&[line(50, 1), line(0, 2), line(1, 2)]), 0);
    assert_eq!(lost(&[line(50, 1), line(3, 2), line(5, 2)]), 1);
    assert_eq!(lost(&[line(50, 7), line(51, 0), line(52, 0)]), 0);
}

fn a_line(bytes: &[u8]) -> Line {
    Line::parse(bytes.first_chunk().expect("80 bytes")).expect("an intact line")
}

/// A line C with an uptime, always with the same boot counters.
fn counters_at(sequence: u8, uptime_s: u32) -> Vec<u8> {
    let mut line = a_line(&sample(b'C').bytes);
    let Body::Counters(counters) = &mut line.body else {
        panic!("it is a line C");
    };
    counters.uptime_s = uptime_s;
    line.sequence = sequence;
    line.encode().to_vec()
}

/// In two appended captures, the boot counters may agree while the uptime runs backward.
#[test]
fn an_uptime_that_runs_backwards_is_a_reboot_and_not_a_loss() {
    let line = |sequence| {
        let mut line = a_line(&counters_at(0, 0));
        line.body = Body::Text(TextLine::new("here"));
        line.sequence = sequence;
        line.encode().to_vec()
    };
    let seen = |lines: &[Vec<u8>]| {
        let (_, counters) = decode(&lines.concat());
        (counters.lines_lost, counters.restarts)
    };
    let before = [counters_at(40, 100), line(41), line(43)];
    let joined = |after: &[Vec<u8>]| seen(&[&before, after].concat());
    // 42 is lost before the restart, 1 after it.
    assert_eq!(joined(&[line(0), line(2), counters_at(3, 4)]), (2, 1));
    assert_eq!(joined(&[line(0), line(2), counters_at(3, 104)]), (58, 0));
    // A late line within the step subtracts only itself.
    assert_eq!(
        joined(&[line(4), line(3), counters_at(5, 4), line(8)]),
        (1 + 2, 1)
    );
    // Late lines of the gap are not subtracted.
    assert_eq!(joined(&[counters_at(3, 4), line(1), line(4)]), (1, 1));
    let far = [counters_at(3, 999_999), line(6), counters_at(7, 3)];
    assert_eq!(seen(&far), (2, 0), "the uptime goes round");
}

/// Two halves do not make a line.
#[test]
fn lines_sent_while_the_link_is_interrupted_are_lost_and_missing_bytes_are_not() {
    let line = |sequence| {
        let text = TextLine::new("here");
        let body = Body::Text(text);
        Line {
            sequence,
            body,
            ack: Ack::default(),
        }
        .encode()
    };
    for (is_link, lost) in [(true, 53), (false, 0)] {
        let mut decoder = Decoder::default();
        assert_eq!(decoder.lines(&line(7)).count(), 1);
        assert_eq!(decoder.lines(&line(8)[..40]).count(), 0);
        if is_link {
            decoder.interrupt();
        } else {
            decoder.skip();
        }
        assert_eq!(decoder.lines(&line(60)[40..]).count(), 0);
        assert_eq!(decoder.lines(&line(61)).count(), 1);
        assert_eq!(decoder.counters().lines_lost, lost);
        // The rest of a line is a damaged line.
        assert_eq!(decoder.counters().lost().min, lost.saturating_sub(1));
    }
}
