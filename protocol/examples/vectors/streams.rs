//! Vectors of streams and checksums.

use super::judge;
use super::samples::{ACK, acknowledge, altered, encode, state, text};
use groundwave_protocol::crc;
use groundwave_protocol::telemetry::{Ack, Body, Line, TextLine};
use serde_json::{Value, json};

fn stream(about: &str, bytes: &[u8]) -> Value {
    let mut vector = judge::stream(bytes);
    vector["about"] = Value::from(about);
    let hex: Vec<_> = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    vector["bytes"] = Value::from(hex.concat());
    vector
}

fn line(sequence: u8) -> Vec<u8> {
    text(sequence, "")
}

fn knock(sequence: u8) -> Vec<u8> {
    acknowledge(sequence, ACK)
}

/// A line sent after a reboot.
fn rebooted(sequence: u8) -> Vec<u8> {
    let line = Line {
        sequence,
        body: Body::Text(TextLine::new("reset")),
        ack: Ack { boot: 5, ..ACK },
    };
    line.encode().to_vec()
}

/// A line with some bits of one column flipped.
fn spoilt(mut line: Vec<u8>, column: usize, bits: u8) -> Vec<u8> {
    line[column - 1] ^= bits;
    line
}

/// Streams, with the lines found and the counters.
pub fn streams() -> Vec<Value> {
    let mut streams = damaged_streams();
    streams.extend(counted_streams());
    streams
}

fn damaged_streams() -> Vec<Value> {
    let half = line(5)[..40].to_vec();
    let rest = line(5)[40..].to_vec();
    let noise: Vec<u8> = (0..=255).collect();
    let mut broken = line(6);
    broken[30] = b'\n';
    [
        ("nothing", vec![]),
        ("two lines", vec![line(5), line(6)]),
        ("the beginning was missed", vec![rest.clone(), line(6)]),
        ("not complete yet", vec![line(5), line(6)[..79].to_vec()]),
        (
            "noise before a line, a line feed among it",
            vec![noise.clone(), line(5)],
        ),
        (
            "a line with a flipped bit between two good ones",
            vec![line(5), spoilt(line(6), 21, 4), line(7)],
        ),
        (
            "a line whose line feed is damaged",
            vec![line(5), spoilt(line(6), 80, 0x40), line(7)],
        ),
        (
            "a line with a line feed in the middle",
            vec![line(5), broken, line(7)],
        ),
        (
            "a line begins again in the middle of itself",
            vec![half.clone(), line(5), line(6)],
        ),
        (
            "a good line inside another one",
            vec![half.clone(), line(6), rest, line(7)],
        ),
        (
            "an acknowledgement line in the ruins of a long one",
            vec![half, knock(6), line(7)],
        ),
        (
            "an acknowledgement line at the end of 80 bytes of noise",
            vec![line(5), vec![b'x'; 66], knock(6), line(7)],
        ),
        (
            "a spoilt acknowledgement line",
            vec![line(5), spoilt(knock(6), 5, 2), line(7)],
        ),
        (
            "an intact line that cannot be read, then a good one",
            vec![altered(line(5), 4, b"x"), line(6)],
        ),
        (
            "the sequence of a line that cannot be read counts for nothing",
            vec![line(5), altered(line(20), 4, b"x"), line(6)],
        ),
        (
            "an acknowledgement in 80 bytes is no line",
            vec![altered(line(5), 1, b"K"), line(6)],
        ),
        ("bytes of another speed", vec![noise.clone(), noise]),
    ]
    .map(|(about, pieces)| stream(about, &pieces.concat()))
    .into()
}

fn counted_streams() -> Vec<Value> {
    [
        (
            "acknowledgement lines between long ones",
            vec![line(5), knock(6), line(7), knock(8)],
        ),
        ("the sequence wraps", vec![line(98), line(99), line(0)]),
        ("three lines lost across the wrap", vec![line(98), line(2)]),
        ("a line comes twice", vec![line(5), line(5), line(6)]),
        (
            "a line comes late",
            vec![line(5), line(7), line(6), line(8)],
        ),
        (
            "a line comes late and twice",
            vec![line(5), line(7), line(6), line(6), line(8)],
        ),
        ("five behind is late", vec![line(50), line(45)]),
        ("six behind is a gap", vec![line(50), line(44)]),
        (
            "a reboot begins a new count",
            vec![line(50), rebooted(3), rebooted(5)],
        ),
        (
            "what was lost before a reboot stays lost",
            vec![line(50), line(53), rebooted(3), rebooted(5)],
        ),
    ]
    .map(|(about, pieces)| stream(about, &pieces.concat()))
    .into()
}

/// Checksums: initial remainder, bytes, remainder and its characters.
pub fn checksums() -> Vec<Value> {
    let line = encode(42, Body::State(state()));
    [
        (crc::DOWNLINK_INIT, ""),
        (crc::DOWNLINK_INIT, "123456789"),
        (0, "123456789"),
        (crc::DOWNLINK_INIT, "A"),
        (crc::DOWNLINK_INIT, "K43"),
        (7 << 16, "X"),
        (0, "X"),
        (crc::DOWNLINK_INIT, &judge::text(&line[..74])),
    ]
    .iter()
    .map(|&(init, text)| {
        let remainder = crc::update(init, text.as_bytes());
        json!({
            "init": format!("{init:06x}"),
            "text": text,
            "remainder": format!("{remainder:06x}"),
            "characters": judge::text(&crc::characters(remainder)),
        })
    })
    .collect()
}
