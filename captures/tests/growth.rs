//! The readers of captures allocate in proportion to a capture's length, and need no more memory for a longer one. Counts
//! of allocations are the same on every machine.

use std::io;
use std::path::Path;

use allocation_counter::{AllocationInfo, measure};
use groundwave_captures::convert::convert_raw;
use groundwave_captures::decode::{Format, decode};
use groundwave_captures::info::Info;
use groundwave_captures::source::Capture;
use groundwave_captures::verify::{verify_mcap, verify_raw};

/// Number of bytes of the shorter capture; the longer one has four times as many.
const BYTES: usize = 1_600_000;
const FACTOR: u64 = 4;

/// A buffer more or less.
const ROUNDING_BYTES: u64 = 1 << 20;

/// Memory of any reader, bytes.
const MEMORY_BYTES: u64 = 64 << 20;

/// Lines of the robot, lines of two bytes, line feeds, and no line.
const PIECES: [&[u8]; 4] = [include_bytes!("../house-noisy.txt"), b"1\n2\n", b"\n", b"x"];

/// A piece repeated. Of the file of a test, nothing is freed.
fn capture(piece: &[u8], bytes: usize) -> &'static [u8] {
    piece.repeat(bytes / piece.len()).leak()
}

fn open(bytes: &'static [u8]) -> Capture {
    Capture::read(Path::new("a"), Box::new(bytes)).expect("a capture")
}

/// Checks the allocations of a reader for a capture and for one that is four times as long.
fn check(what: &str, captures: [&'static [u8]; 2], read: impl Fn(&'static [u8])) {
    let [short, long] = captures.map(|bytes| measure(|| read(bytes)));
    let AllocationInfo {
        count_total,
        bytes_total,
        bytes_max,
        ..
    } = long;
    let about = format!("{what}: {short:?}, then {long:?}");
    assert!(count_total <= FACTOR * short.count_total + 1000, "{about}");
    assert!(
        bytes_total <= FACTOR * short.bytes_total + ROUNDING_BYTES,
        "{about}"
    );
    // The index of a recording takes some bytes for each chunk.
    assert!(bytes_max <= short.bytes_max + (1 << 20), "{about}");
    assert!(bytes_max <= MEMORY_BYTES, "{about}");
}

fn export(bytes: &'static [u8], format: Format) {
    decode(&mut open(bytes), &[], format, &mut io::sink()).expect("an export");
}

#[test]
fn allocations_grow_no_faster_than_a_capture() {
    for (number, piece) in PIECES.into_iter().enumerate() {
        let raw = [BYTES, FACTOR as usize * BYTES].map(|bytes| capture(piece, bytes));
        let mcap = raw.map(|bytes| {
            let mut file = Vec::new();
            convert_raw(bytes, None, &mut file).unwrap();
            &*file.leak()
        });
        for (form, captures) in [("text", raw), ("MCAP", mcap)] {
            let what = |verb| format!("{verb} of {form} {number}");
            check(&what("info"), captures, |it| {
                assert_eq!(Info::read(&mut open(it)).problem, None);
            });
            check(&what("CSV"), captures, |it| export(it, Format::Csv));
            check(&what("JSON"), captures, |it| export(it, Format::Jsonl));
        }
        check(&format!("verify of text {number}"), raw, |it| {
            verify_raw(it).unwrap();
        });
        check(&format!("verify of MCAP {number}"), mcap, |it| {
            verify_mcap(it, None).unwrap();
        });
        check(&format!("conversion of text {number}"), raw, |it| {
            convert_raw(it, None, io::sink()).unwrap();
        });
    }
}
