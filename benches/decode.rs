//! Speed of decoding captures, lines per second, compared with the `nmea` crate on sentences of the same length.
//!
//! `cargo bench --bench decode`

#[path = "../tests/streams/mod.rs"]
mod streams;

use std::hint::black_box;
use std::io::{self, Cursor};

use divan::Bencher;
use divan::counter::ItemsCount;
use groundwave::capture::Capture;
use groundwave::capture::decode::{Format, decode};
use groundwave::capture::info::Info;
use groundwave_protocol::decoder::Decoder;

/// Number of line slots in the stream: most of an hour.
const SLOTS: u32 = 10_000;

/// Size of a read from a disk, bytes.
const READ_BYTES: usize = 64 * 1024;

fn main() {
    divan::main();
}

/// Decodes every line of a stream, as the station does.
fn decode_lines(stream: &[u8], read_bytes: usize) -> u64 {
    let mut decoder = Decoder::default();
    for read in stream.chunks(read_bytes) {
        for received in decoder.lines(read) {
            black_box(&received);
        }
    }
    decoder.counters().lines
}

fn bench_decoder(bencher: Bencher, stream: &[u8], read_bytes: usize) {
    let lines = decode_lines(stream, read_bytes);
    bencher
        .counter(ItemsCount::new(lines))
        .bench(|| decode_lines(black_box(stream), read_bytes));
}

/// A raw capture, clean, in large reads.
#[divan::bench]
fn decoder(bencher: Bencher) {
    bench_decoder(bencher, &streams::lines(SLOTS), READ_BYTES);
}

/// A raw capture of a bad radio.
#[divan::bench]
fn decoder_noisy(bencher: Bencher) {
    bench_decoder(bencher, &streams::noisy(SLOTS, 1), READ_BYTES);
}

/// Reads of 16 ms each, as a serial port delivers them.
#[divan::bench]
fn decoder_in_clumps(bencher: Bencher) {
    bench_decoder(bencher, &streams::lines(SLOTS), 4);
}

/// Valid GGA sentences of 80 bytes, CR LF included.
fn sentences(count: u32) -> Vec<u8> {
    let mut stream = Vec::new();
    for i in 0..count {
        let (hour, minute, second) = (i / 3600 % 24, i / 60 % 60, i % 60);
        let body = format!(
            "GPGGA,{hour:02}{minute:02}{second:02}.000,5321.{:06},N,00630.{:06},W,1,08,01.03,061.7,M,055.2,M,,",
            i * 37 % 1_000_000,
            i * 91 % 1_000_000,
        );
        let checksum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        let sentence = format!("${body}*{checksum:02X}\r\n");
        assert_eq!(sentence.len(), 80, "{sentence}");
        stream.extend(sentence.bytes());
    }
    stream
}

/// The reference: the `nmea` crate on each sentence of the stream.
#[divan::bench]
fn nmea(bencher: Bencher) {
    let stream = sentences(SLOTS);
    bencher.counter(ItemsCount::new(SLOTS)).bench(|| {
        for sentence in black_box(&stream[..]).split_inclusive(|&byte| byte == b'\n') {
            let parsed = nmea::parse_bytes(sentence);
            assert!(parsed.is_ok());
            let _ = black_box(&parsed);
        }
    });
}

fn bench_capture(bencher: Bencher, read: impl Fn(&mut Capture) + Sync) {
    let stream = streams::lines(SLOTS);
    bencher
        .counter(ItemsCount::new(decode_lines(&stream, READ_BYTES)))
        .with_inputs(|| Box::new(Cursor::new(stream.clone())))
        .bench_values(|stream| {
            if let Ok(mut capture) = Capture::read("bench", stream) {
                read(&mut capture);
            }
        });
}

/// `groundwave info` on a raw capture.
#[divan::bench]
fn info(bencher: Bencher) {
    bench_capture(bencher, |capture| {
        black_box(Info::read(capture));
    });
}

/// `groundwave export --to jsonl` on a raw capture.
#[divan::bench(args = ["jsonl", "csv"])]
fn decode_to(bencher: Bencher, format: &str) {
    let format = match format {
        "csv" => Format::Csv,
        _ => Format::Jsonl,
    };
    bench_capture(bencher, |capture| {
        let _ = black_box(decode(capture, &[], format, &mut io::sink()));
    });
}
