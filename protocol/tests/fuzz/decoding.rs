//! The decoder of the downlink and the receiver of the uplink.

use crate::damage::{Sample, samples};
use groundwave_protocol::command::Key;
use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::receiver::Receiver;
use std::sync::LazyLock;

const ROBOT_ID: u8 = 7;

/// A stream with whole, cut and damaged lines; random bytes would hardly contain any.
pub fn sown(input: &[u8]) -> Vec<u8> {
    static LINES: LazyLock<Vec<Sample>> = LazyLock::new(samples);
    let lines = &*LINES;
    let mut stream = Vec::new();
    let mut input = input.iter().map(|&byte| usize::from(byte));
    while let Some(byte) = input.next() {
        let line = &lines[byte % lines.len()];
        let mut number =
            || input.next().unwrap_or_default() << 8 | input.next().unwrap_or_default();
        match byte / 32 {
            0..4 => stream.push(byte as u8),
            4..6 => stream.extend(&line.bytes),
            6 => stream.extend(&line.bytes[..number() % line.bytes.len()]),
            _ => stream.extend(line.flipped(&[number() % line.bits()])),
        }
    }
    stream
}

/// Any chunking of a stream gives the same intact lines, and the counters add up.
pub fn decoder(stream: &[u8]) {
    let (whole, counters) = decode(stream.chunks(stream.len().max(1)));
    let size = usize::from(stream.first().copied().unwrap_or_default()) + 1;
    assert_eq!(decode(stream.chunks(1)), (whole.clone(), counters));
    assert_eq!(decode(stream.chunks(size)), (whole.clone(), counters));
    for received in &whole {
        let bytes = match received {
            Received::Line(line, bytes) => {
                assert_eq!(&line.encode(), bytes, "written otherwise than it was read");
                bytes.to_vec()
            }
            Received::Ack(line) => line.encode().to_vec(),
        };
        assert!(stream.windows(bytes.len()).any(|part| part == bytes));
    }
    let c = counters;
    assert_eq!(c.bytes, stream.len() as u64);
    assert_eq!(c.lines * 80 + c.ack_lines * 14 + c.noise_bytes, c.bytes);
    let line_feeds = stream.split(|&byte| byte == b'\n').count() as u64 - 1;
    let rejected = c.crc_rejected + c.shape_rejected + c.field_rejected;
    assert_eq!(c.lines + c.ack_lines + rejected, line_feeds);
}

fn decode<'a>(chunks: impl Iterator<Item = &'a [u8]>) -> (Vec<Received>, Counters) {
    let mut decoder = Decoder::default();
    let mut found = Vec::new();
    for mut chunk in chunks {
        while !chunk.is_empty() {
            let before = chunk.len();
            found.extend(decoder.next_line(&mut chunk));
            assert!(chunk.len() < before, "the decoder does not move on");
        }
    }
    (found, *decoder.counters())
}

/// Each run of bytes is a frame or is rejected for one reason, and encoding a message gives its frame.
pub fn receiver(stream: &[u8]) {
    for key in [None, Some(Key::session(ROBOT_ID, 1, 1, 0x2A5))] {
        let mut receiver = Receiver::default();
        let mut heard = 0;
        for &byte in stream {
            if receiver.handle_byte(byte, ROBOT_ID, key).is_some() {
                assert_eq!(byte, b'\n', "a frame ends with a line feed");
                heard += 1;
            }
        }
        let counters = receiver.counters();
        assert_eq!(counters.frames, heard);
        let ended = &stream[..stream.iter().rposition(|&b| b == b'\n').unwrap_or(0)];
        let runs = ended.split(|&b| b == b'\n').filter(|run| !run.is_empty());
        assert_eq!(
            usize::from(counters.frames + counters.rejected()),
            runs.count()
        );
    }
}
