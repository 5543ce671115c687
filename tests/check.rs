//! `groundwave check` reports planted mistakes, and none for a correct robot.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Duration;

use crate::check_send::FAULTS;

#[cfg(unix)]
use crate::common::c_robot::CSimulation;
use crate::common::{CoSimulation, Robot, is_nightly, on_all_cores, owner, seeds};
use crate::programs::{expect, scratch};
use crate::streams::Rng;
use groundwave::capture::diagnosis::kind;
use groundwave::capture::diagnosis::{Diagnosis, Finding};
use groundwave::conformance::rule;
use groundwave::event::{Event, NoticeCode};
use groundwave::request::Request;
use groundwave::station::Station;
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::Config;
use groundwave_protocol::crc::{self, DOWNLINK_INIT};
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::{Ack, Detail, Outcome};
use sr04_firmware::board::Duplex;
use sr04_sim::{SimulationConfig, World};

const A: &str = "A42 +123.4 -045.0 273 +06 -12 +00 +12 042 120 61 48 .R--... P--Is..d ";
const B: &str = "B47 07 12.4 +0120 -0036 003/040 `2-%9X 12 155 122 UB.I-..D 004 00    ";
const C: &str = "C53 07 000412 004 01.00 ``#2``+=3B``````]! 133 002 000 0012 ---- -   ";
const T: &str = "T49 I'm finished with the co-ordinate list                           ";
const P: &str = "P48 01/26 top-speed          +00008 +00012 +00002 +00012 in/s        ";
const S: &str = "S49 (+$*3$,0$07(``\"(+0                                               ";

const I: &str = "I50 07 5 300 PRHXUWGFC BWSI 00240 2                                  ";
const F: &str = "F50 1/2 motor-current      2 A                                       ";
const V: &str = "V50 +00125 -00007 ------ ------ ------ ------ ------ ------ ------   ";

/// A correct robot's lines: five lines A and one other in turn.
const ORDER: &[u8] = b"AAAAABAAAAACAAAAATAAAAAPAAAAASAAAAAIAAAAAFAAAAAV";

/// Lines of a stream.
const LINES: usize = 300;

/// A line that has not been sent.
struct Draft {
    /// Number of lines before this line.
    n: usize,
    letter: u8,
    sequence: u8,
    ack: Ack,
    /// The line up to the acknowledgement, including the sequence number.
    head: Vec<u8>,
    /// The whole line with its checksum.
    bytes: Vec<u8>,
}

impl Draft {
    fn new(n: usize, letter: u8) -> Self {
        let sequence = u8::try_from(n % 100).unwrap();
        let text = match letter {
            b'A' => A,
            b'B' => B,
            b'C' => C,
            b'T' => T,
            b'P' => P,
            b'S' => S,
            b'I' => I,
            b'F' => F,
            b'V' => V,
            _ => "K00",
        };
        let idle = Detail::Idle {
            owner: 677,
            robot_id: 7,
        };
        let era = Detail::Era { era: 510 };
        let mut draft = Self {
            n,
            letter,
            sequence,
            ack: Ack {
                boot: 4,
                session: 2,
                sequence: 5,
                outcome: Outcome::Done,
                detail: if sequence % 3 == 1 { era } else { idle },
            },
            head: text.as_bytes().to_vec(),
            bytes: Vec::new(),
        };
        if letter == b'C' {
            draft.put(8, format!("{:06}", 400 + n / 3).as_bytes());
        }
        draft
    }

    fn put(&mut self, column: usize, text: &[u8]) {
        self.head[column - 1..column - 1 + text.len()].copy_from_slice(text);
    }

    /// Writes the acknowledgement; returns the bytes that the checksum covers.
    fn covered(&mut self) -> Vec<u8> {
        let digits = format!("{:02}", self.sequence);
        if self
            .head
            .get(1..3)
            .is_some_and(|it| it.iter().all(u8::is_ascii_digit))
        {
            self.put(2, digits.as_bytes());
        }
        if self.head.len() < 70 {
            let ack = self.ack.encode();
            self.head.extend(ack);
        }
        self.head.clone()
    }

    fn seal(mut self, remainder: impl Fn(&[u8]) -> Vec<u8>) -> Self {
        let covered = self.covered();
        self.bytes = [&covered[..], &remainder(&covered), b"\r\n"].concat();
        self
    }
}

fn right(covered: &[u8]) -> Vec<u8> {
    crc::characters(crc::update(DOWNLINK_INIT, covered)).to_vec()
}

/// The place of a planted mistake.
enum Plant {
    /// The text at a column of the lines of a type, with a correct checksum. If its length differs from the field's, the rest moves.
    Field(u8, usize, &'static [u8], usize),
    /// The checksum.
    Checksum(fn(&[u8]) -> Vec<u8>),
    /// The finished bytes.
    Bytes(fn(Vec<u8>) -> Vec<u8>),
    /// Sequence number or acknowledgement, and fields that depend on the line's number.
    Draft(fn(&mut Draft)),
    /// The order of the lines.
    Order(&'static [u8]),
}

use Plant::{Bytes, Checksum, Field, Order};

/// A mistake, its place, and the type, column and code that must be reported.
struct Row(&'static str, Plant, &'static str, usize, &'static str);

/// A mistake in a field that keeps its length.
const fn field(letter: u8, column: usize, text: &'static [u8]) -> Plant {
    Field(letter, column, text, text.len())
}

fn crc_of(bits: u32, polynomial: u32, start: u32, bytes: &[u8]) -> u32 {
    let (top, mask) = (1 << (bits - 1), (1 << bits) - 1);
    bytes.iter().fold(start, |remainder, &byte| {
        (0..8).fold(remainder ^ u32::from(byte) << (bits - 8), |r, _| {
            (r << 1 ^ if r & top == 0 { 0 } else { polynomial }) & mask
        })
    })
}

fn reflected(bytes: &[u8]) -> u32 {
    let polynomial = 0x7B_01BD_u32.reverse_bits() >> 8;
    bytes.iter().fold(DOWNLINK_INIT, |remainder, &byte| {
        (0..8).fold(remainder ^ u32::from(byte), |r, _| {
            r >> 1 ^ if r & 1 == 0 { 0 } else { polynomial }
        })
    })
}

fn sent(remainder: u32) -> Vec<u8> {
    crc::characters(remainder).to_vec()
}

/// The right remainder in other characters.
fn coded(covered: &[u8], alphabet: &[u8; 64]) -> Vec<u8> {
    let remainder = crc::update(DOWNLINK_INIT, covered);
    let sixes = (0..4).map(|n| remainder >> (18 - 6 * n) & 63);
    sixes.map(|six| alphabet[six as usize]).collect()
}

fn from_start(bytes: &[u8]) -> Vec<u8> {
    sent(crc::update(DOWNLINK_INIT, bytes))
}

#[rustfmt::skip]
const ROWS: &[Row] = &[
    // Fields of line A.
    Row("X with a space for the plus", field(b'A', 5, b" 123.4"), "A", 5, "missing-sign"),
    Row("X with a decimal comma", field(b'A', 5, b"+123,4"), "A", 5, "decimal-point"),
    Row("X from a division by 0", field(b'A', 5, b"   nan"), "A", 5, "not-a-number"),
    Row("Y of minus zero", field(b'A', 12, b"-000.0"), "A", 12, "negative-zero"),
    Row("theta of 360", field(b'A', 19, b"360"), "A", 19, "range"),
    Row("theta with a sign", field(b'A', 19, b"-90"), "A", 19, "extra-sign"),
    Row("theta padded with spaces", field(b'A', 19, b"  7"), "A", 19, "padding"),
    Row("speed without a sign", field(b'A', 23, b"008"), "A", 23, "missing-sign"),
    Row("rotation padded with spaces", field(b'A', 27, b" +6"), "A", 27, "padding"),
    Row("left wheel of minus zero", field(b'A', 31, b"-00"), "A", 31, "negative-zero"),
    Row("sonar padded with spaces", field(b'A', 39, b" 42"), "A", 39, "padding"),
    Row("speed as hyphens", field(b'A', 23, b"---"), "A", 23, "hyphens"),
    Row("bumper with a letter of its own", field(b'A', 53, b"x"), "A", 53, "letter"),
    Row("mode in lower case", field(b'A', 61, b"p"), "A", 61, "letter-case"),
    Row("two layers in upper case", field(b'A', 62, b"B-I"), "A", 64, "two-holders"),
    Row("a layer with the letter of another one", field(b'A', 66, b"m"), "A", 66, "letter"),
    Row("an underscore between two fields", field(b'A', 4, b"_"), "A", 4, "column"),
    Row("sequence padded with a space", field(b'A', 2, b" 7"), "A", 2, "padding"),
    Row("X with `%+d.%d`: too short", Field(b'A', 5, b"+12.4", 6), "A", 5, "length"),
    Row("speed with `%+d`: too short", Field(b'A', 23, b"+6", 3), "A", 23, "length"),
    Row("theta with four digits", Field(b'A', 19, b"0273", 3), "A", 22, "length"),
    Row("X with two decimals", field(b'A', 5, b"+12.34"), "A", 5, "decimal-point"),
    Row("X of 999 in whole inches", field(b'A', 5, b"+00999"), "A", 5, "range"),
    Row("theta in radians", field(b'A', 19, b"1.6"), "A", 19, "decimal-point"),
    Row("speed with a decimal", field(b'A', 23, b"6.0"), "A", 23, "missing-sign"),
    Row("left wheel at the left of its columns", field(b'A', 31, b"-7 "), "A", 31, "padding"),
    Row("sonar with a decimal", field(b'A', 39, b"9.5"), "A", 39, "decimal-point"),
    Row("sonar of -1 for no echo", field(b'A', 39, b"-01"), "A", 39, "extra-sign"),
    Row("photocell of 100 %", Field(b'A', 47, b"100", 2), "A", 49, "length"),
    Row("infrared as a count", field(b'A', 54, b"2"), "A", 54, "letter"),
    Row("layers in the reverse order", field(b'A', 62, b"d.lsi-b"), "A", 62, "letter"),
    Row("a tab between two fields", field(b'A', 4, b"\t"), "A", 4, "column"),
    Row("the acknowledgement in lower case", field(b'A', 70, b"abcde"), "A", 70, "six-bit"),
    Row("the acknowledgement of spaces", field(b'A', 70, b"     "), "A", 70, "six-bit-zero"),
    // The other lines.
    Row("layers of line B from layer 1 on", field(b'B', 51, b"BTISLMDU"), "B", 51, "letter"),
    Row("the digest's bytes in the other order, of an empty list", field(b'B', 25, b"000/000 #_$ME!"), "B", 33, "digest-empty"),
    Row("version of three parts", field(b'C', 19, b"1.0.0"), "C", 19, "decimal-point"),
    Row("an uptime that stands still", field(b'C', 8, b"000400"), "C", 8, "uptime"),
    Row("uptime in minutes", Plant::Draft(|it| if it.letter == b'C' { let text = format!("{:06}", it.n / 180); it.put(8, text.as_bytes()); }), "C", 8, "uptime"),
    Row("uptime in tenths of a second", Plant::Draft(|it| if it.letter == b'C' { let text = format!("{:06}", it.n * 10 / 3); it.put(8, text.as_bytes()); }), "C", 8, "uptime"),
    Row("level 0 in line I", field(b'I', 8, b"0"), "I", 8, "range"),
    Row("capacity padded with spaces", field(b'I', 10, b"  8"), "I", 10, "padding"),
    Row("modes of line I in another order", field(b'I', 14, b"PXRHUWGFC"), "I", 15, "letter"),
    Row("a rate of 24 bytes/s", field(b'I', 29, b"00024"), "I", 29, "range"),
    Row("level 1 of a robot that hears", field(b'I', 8, b"1"), "I", 8, "abilities"),
    Row("a mode that line I lacks", field(b'I', 14, b"."), "A", 61, "abilities"),
    Row("sonars that line I lacks", field(b'I', 26, b"."), "A", 39, "abilities"),
    Row("a battery that line I lacks", field(b'I', 24, b"."), "B", 8, "abilities"),
    Row("more waypoints than line I states", field(b'I', 10, b"030"), "B", 29, "abilities"),
    Row("more fields than line I states", field(b'I', 35, b"1"), "F", 7, "abilities"),
    Row("another robot id in line I only", field(b'I', 5, b"08"), "I", 5, "id-disagrees"),
    Row("no line I at level 3", Order(b"AAAAAB"), "A", 1, "abilities-missing"),
    Row("six decimals of a field", field(b'F', 28, b"6"), "F", 28, "range"),
    Row("a field beyond their number", field(b'F', 5, b"3/2"), "F", 5, "pair"),
    Row("a value with a decimal point", field(b'V', 5, b"+01.25"), "V", 5, "decimal-point"),
    Row("a value that is missing as spaces", field(b'V', 12, b"      "), "V", 12, "padding"),
    Row("robot id 0", field(b'B', 5, b"00"), "B", 5, "range"),
    Row("battery padded with a space", field(b'B', 8, b" 9.1"), "B", 8, "padding"),
    Row("target X alone as hyphens", field(b'B', 13, b"-----"), "B", 19, "pair"),
    Row("more waypoints reached than there are", field(b'B', 25, b"041/040"), "B", 25, "pair"),
    Row("digest with a space for 0", field(b'B', 33, b" "), "B", 33, "six-bit-zero"),
    Row("digest in Base64", field(b'B', 33, b"`axq9X"), "B", 33, "six-bit"),
    Row("photocell above 255", field(b'B', 43, b"256"), "B", 43, "range"),
    Row("an allowed layer in lower case", field(b'B', 51, b"u"), "B", 51, "letter-case"),
    Row("the digest 0 of an empty list", field(b'B', 25, b"000/000 ``````"), "B", 33, "digest-empty"),
    Row("version without leading zero", field(b'C', 19, b" 1.00"), "C", 19, "padding"),
    Row("ticks won with a lower-case letter", field(b'C', 25, b"`a"), "C", 25, "six-bit"),
    Row("failsafe of 5 s", field(b'C', 61, b"0005"), "C", 61, "range"),
    Row("uptime in milliseconds", Plant::Draft(|it| if it.letter == b'C' { let text = format!("{:06}", it.n * 333 % 1_000_000); it.put(8, text.as_bytes()); }), "C", 8, "uptime"),
    Row("a tab in a text", field(b'T', 8, b"\t"), "T", 8, "field"),
    Row("a parameter's name with a capital", field(b'P', 11, b"Top-speed"), "P", 11, "letter-case"),
    Row("a parameter's value without a sign", field(b'P', 30, b"000008"), "P", 30, "missing-sign"),
    Row("a note with a space for 0", field(b'S', 5, b"( $"), "S", 5, "six-bit-zero"),
    Row("a line of a type of its own", field(b'T', 1, b"Z"), "Z", 1, "line-type"),
    // The checksum.
    Row("CRC from 0", Checksum(|it| sent(crc::update(0, it))), "A", 75, "crc-start"),
    Row("CRC inverted at the end", Checksum(|it| sent(crc::update(DOWNLINK_INIT, it) ^ 0xFF_FFFF)), "A", 75, "crc-inverted"),
    Row("CRC reflected", Checksum(|it| sent(reflected(it))), "A", 75, "crc-reflected"),
    Row("Koopman's notation as polynomial", Checksum(|it| sent(crc_of(24, 0xBD_80DE, DOWNLINK_INIT, it))), "A", 75, "crc-polynomial"),
    Row("CRC-24 of OpenPGP", Checksum(|it| sent(crc_of(24, 0x86_4CFB, 0xB7_04CE, it))), "A", 75, "crc-polynomial"),
    Row("CRC-16/CCITT in 6-bit characters", Checksum(|it| sent(crc_of(16, 0x1021, 0xFFFF, it))), "A", 75, "crc-16"),
    Row("CRC-16/CCITT in hexadecimal", Checksum(|it| format!("{:04x}", crc_of(16, 0x1021, 0xFFFF, it)).into()), "A", 75, "crc-16"),
    Row("the right CRC in hexadecimal", Checksum(|it| format!("{:06x}", crc::update(DOWNLINK_INIT, it)).into()), "A", 75, "crc-hex"),
    Row("NMEA's exclusive-or", Checksum(|it| format!("*{:02X}", it.iter().fold(0, |sum, byte| sum ^ byte)).into()), "A", 75, "crc-xor"),
    Row("spaces for 0 in the checksum", Checksum(|it| right(it).iter().map(|it| if *it == b'`' { b' ' } else { *it }).collect()), "A", 75, "crc-zero"),
    Row("the checksum's characters reversed", Checksum(|it| right(it).into_iter().rev().collect()), "A", 75, "crc-order"),
    Row("the LF before counted in", Checksum(|it| from_start(&[b"\n", it].concat())), "A", 75, "crc-line-feed"),
    Row("column 1 left out", Checksum(|it| from_start(&it[1..])), "A", 75, "crc-columns"),
    Row("one column too few", Checksum(|it| from_start(&it[..it.len() - 1])), "A", 75, "crc-columns"),
    Row("the acknowledgement left out", Checksum(|it| from_start(&it[..it.len() - 5])), "A", 75, "crc-columns"),
    Row("the acknowledgement written after the checksum", Checksum(|it| from_start(&[&it[..it.len() - 5], b"     "].concat())), "A", 75, "crc-stale"),
    Row("CRC before the sequence was written", Checksum(|it| from_start(&[&it[..1], b"00", &it[3..]].concat())), "A", 75, "crc-stale"),
    Row("CRC from OpenPGP's start", Checksum(|it| sent(crc::update(0xB7_04CE, it))), "A", 75, "crc-constant"),
    Row("CRC in Base64", Checksum(|it| coded(it, b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/")), "A", 75, "crc-characters"),
    Row("CRC in characters from 0 on", Checksum(|it| coded(it, &std::array::from_fn(|n| b'0' + n as u8))), "A", 75, "crc-characters"),
    Row("CRC in three bytes", Checksum(|it| crc::update(DOWNLINK_INIT, it).to_be_bytes()[1..].to_vec()), "A", 75, "crc-binary"),
    Row("a table of the CRC with an error", Checksum(|it| sent(it.iter().fold(DOWNLINK_INIT, |r, &byte| {
        crc::update(r, &[byte]) ^ if (r >> 16) as u8 ^ byte < 0x10 { 0x10 } else { 0 }
    }))), "A", 75, "crc-unknown"),
    // The line's end.
    Row("LF for CR LF", Bytes(|it| [&it[..it.len() - 2], b"\n"].concat()), "A", 79, "line-end"),
    Row("LF CR for CR LF", Bytes(|it| [&it[..it.len() - 2], b"\n\r"].concat()), "A", 79, "line-end"),
    Row("CR for CR LF", Bytes(|it| it[..it.len() - 1].to_vec()), "A", 80, "line-end"),
    Row("CR LF printed with println", Bytes(|it| [&it[..it.len() - 1], b"\r\n"].concat()), "A", 80, "line-end"),
    Row("a space before CR LF", Bytes(|it| [&it[..it.len() - 2], b" \r\n"].concat()), "A", 79, "line-end"),
    Row("no line end", Bytes(|it| it[..it.len() - 2].to_vec()), "A", 79, "line-end"),
    Row("a NUL after each line", Bytes(|it| [&it[..], b"\0"].concat()), "\0", 0, "between-lines"),
    Row("an empty line after each line", Bytes(|it| [&it[..], b"\r\n"].concat()), "", 0, "between-lines"),
    Row("a text of the program after each line", Bytes(|it| [&it[..], b"debug: ", &it[1..3], b"\r\n"].concat()), "d", 0, "between-lines"),
    // Lines together.
    Row("a sequence that stands still", Plant::Draft(|it| it.sequence = 7), "A", 2, "sequence-stuck"),
    Row("a sequence that counts by 2", Plant::Draft(|it| it.sequence = (it.n * 2 % 100).try_into().unwrap()), "A", 2, "sequence-jump"),
    Row("a sequence for each type of line", Plant::Draft(|it| {
        let before = (0..it.n).filter(|n| ORDER[n % ORDER.len()] == it.letter).count();
        it.sequence = (before % 100).try_into().unwrap();
    }), "A", 2, "sequence-per-type"),
    Row("a sequence to 63", Plant::Draft(|it| it.sequence = (it.n % 64).try_into().unwrap()), "A", 2, "sequence-wrap"),
    Row("a reset every 31 and 37 lines without counting boots", Plant::Draft(|it| {
        let n = it.n % 68;
        it.sequence = if n < 31 { n } else { n - 31 }.try_into().unwrap();
        if it.n > 136 { it.sequence = (it.n - 136) as u8 % 100; }
    }), "A", 2, "boot-same"),
    Row("uptime from 0 under the same boots", Plant::Draft(|it| if it.letter == b'C' { let text = format!("{:06}", it.n % 60); it.put(8, text.as_bytes()); }), "C", 15, "boot-same"),
    Row("a boot counter that counts sessions", Plant::Draft(|it| it.ack.boot = ((it.n / 20 + 4) % 8).try_into().unwrap()), "A", 70, "boot-changes"),
    Row("boots 005 in line B only", field(b'B', 60, b"005"), "B", 60, "boot-disagrees"),
    Row("another robot id in line C only", field(b'C', 5, b"08"), "C", 5, "id-disagrees"),
    Row("robot id 0 in the acknowledgement", Plant::Draft(|it| if let Detail::Idle { robot_id, .. } = &mut it.ack.detail { *robot_id = 0; }), "A", 70, "id-zero"),
    Row("the acknowledgement without the era", Plant::Draft(|it| it.ack.detail = Detail::Idle { owner: 677, robot_id: 7 }), "A", 70, "era-missing"),
    Row("the era in every line", Plant::Draft(|it| it.ack.detail = Detail::Era { era: 510 }), "A", 70, "era-twice"),
    Row("cannot hear, in lines A only", Plant::Draft(|it| if it.letter == b'A' {
        it.ack = Ack { boot: 4, session: 0, sequence: 0, outcome: Outcome::Done, detail: Detail::CannotHear { robot_id: 7 } };
    }), "B", 70, "hearing"),
    Row("20 lines a second by the uptime, at 115200 baud", Plant::Draft(|it| match it.letter {
        b'C' => it.put(8, format!("{:06}", 400 + it.n / 20).as_bytes()),
        b'I' => it.put(29, b"11520"),
        _ => {}
    }), "C", 8, "line-rate"),
    Row("lines B, C and T in a row", Order(b"AAABCTAAA"), "C", 1, "no-state"),
    Row("one line B in 20", Order(b"CAAAAABAAAAAAAAAAAAAAAAAAAA"), "A", 1, "only-state"),
];

/// The bytes of a robot with a mistake.
fn stream(plant: Option<&Plant>) -> Vec<u8> {
    let order = match plant {
        Some(Order(order)) => order,
        _ => ORDER,
    };
    let mut bytes = Vec::new();
    for n in 0..LINES {
        let mut draft = Draft::new(n, order[n % order.len()]);
        bytes.extend(match plant {
            Some(&Field(letter, column, text, length)) => {
                if draft.letter == letter {
                    draft.covered();
                    draft
                        .head
                        .splice(column - 1..column - 1 + length, text.iter().copied());
                }
                draft.seal(right).bytes
            }
            Some(Checksum(of)) => draft.seal(of).bytes,
            Some(Bytes(change)) => change(draft.seal(right).bytes),
            Some(Plant::Draft(change)) => {
                change(&mut draft);
                draft.seal(right).bytes
            }
            Some(Order(_)) | None => draft.seal(right).bytes,
        });
    }
    bytes
}

fn findings(bytes: &[u8]) -> Vec<Finding> {
    let mut diagnosis = Diagnosis::default();
    // Any pieces give the same.
    bytes.chunks(7).for_each(|piece| diagnosis.take(piece));
    diagnosis.findings()
}

/// The findings, by type of line, column and code.
fn named(finding: &Finding) -> (String, usize, &'static str) {
    let line = String::from_utf8_lossy(&finding.line);
    let letter = line.trim_start().chars().next();
    let letter = letter.map_or_else(String::new, String::from);
    (letter, finding.column.unwrap_or(0), finding.kind.code)
}

#[test]
fn a_correct_robot_has_no_mistake() {
    assert_eq!(findings(&stream(None)), []);
}

/// The receiver's clock shows a rate that lines without an uptime do not show.
#[test]
fn more_than_12_lines_a_second_are_a_mistake() {
    let listen = |lines_per_s: u32| {
        let mut diagnosis = Diagnosis::default();
        for (n, line) in stream(None)
            .split_inclusive(|&byte| byte == b'\n')
            .enumerate()
        {
            diagnosis.take(line);
            diagnosis.take_time(Duration::from_secs(n as u64) / lines_per_s);
        }
        diagnosis.findings().iter().map(named).collect::<Vec<_>>()
    };
    assert_eq!(listen(12), []);
    let found = listen(24);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].1, found[0].2), (1, "line-rate"));
}

/// The sequence jumps where the radio lost lines without a trace; the jumps are not reported as mistakes of the robot.
#[test]
fn lines_lost_without_a_trace_are_no_mistake() {
    for lost_pct in [20, 50, 70, 80] {
        for seed in 0..20 {
            let mut rng = Rng(seed);
            let bytes = stream(None);
            let mut diagnosis = Diagnosis::default();
            for line in bytes.split_inclusive(|&byte| byte == b'\n') {
                if rng.below(100) >= lost_pct {
                    diagnosis.take(line);
                }
                let found: Vec<_> = diagnosis.findings().iter().map(named).collect();
                assert_eq!(found, [], "{lost_pct} % lost, seed {seed}");
            }
        }
    }
}

/// Each mistake is the first one reported, with type, column and likely cause, and most are the only one. docs/check.md has the table; to
/// regenerate it, set `GROUNDWAVE_WRITE`.
#[test]
fn planted_mistakes_are_named_by_line_column_and_cause() {
    let mut wrong = String::new();
    let mut table = String::new();
    for Row(about, plant, letter, column, code) in ROWS {
        let found = findings(&stream(Some(plant)));
        let names: Vec<_> = found.iter().map(named).collect();
        let expected = ((*letter).to_owned(), *column, *code);
        if names.iter().filter(|it| **it == expected).count() != 1 || names[0].2 != *code {
            let _ = writeln!(wrong, "{about}: expected {expected:?}, found {names:?}");
        }
        if let Some(finding) = found.iter().find(|it| named(it) == expected) {
            let place = finding.place.replace('|', "\\|").replace('`', "&#96;");
            let _ = writeln!(
                table,
                "| {about} | {place} | {} | `{code}` |",
                finding.kind.cause
            );
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/check.md");
    let text = page_with(&table);
    if std::env::var_os("GROUNDWAVE_WRITE").is_some() {
        fs::write(&page, &text).unwrap();
    }
    let written = fs::read_to_string(&page).unwrap().replace("\r\n", "\n");
    assert!(
        written == text,
        "docs/check.md is not what the mistakes give; set GROUNDWAVE_WRITE=1 and run this test"
    );
}

fn page_with(table: &str) -> String {
    let mut page = "\
# The mistakes that `groundwave check` finds

`groundwave check FILE` reads a capture, `groundwave check LINK` listens to a robot. A finding names line and column, the content, the form expected, the likely
cause, the remedy and the section of [SPEC.md](../protocol/SPEC.md). Codes are stable; `--json` prints them. Damage by the radio is not reported as a mistake.
The dashboard logs a mistake as soon as it is certain; `info`, `verify` and `export` to tables tell it in one line.
`groundwave check LINK --send` also tries the rules for frames and names each that the robot breaks.

Four mistakes show under conditions. More than 12 lines per second show by the uptime of line C, and on a link by the clock, too. An acknowledgement that is taken too
early looks like a link with latency; only lines K tell the two apart, so the rule `ack-fresh` is tried at level 4 or more in full duplex, on links with less than 0.1 s of
latency. A sequence that restarts too early shows if it does so more than once in 20 rounds, because a half-duplex radio may swallow the line before a line 00. Whether a stored
parameter survives the loss of power is not tried.

## Codes

| code | section | likely cause | remedy |
|---|---|---|---|
"
    .to_owned();
    for kind in kind::ALL {
        let remedy = kind.remedy;
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {remedy} |",
            kind.code, kind.section, kind.cause
        );
    }
    page += "
## Rules tried by `--send`

| code | level | section | rule | likely cause of a breach | remedy |
|---|---|---|---|---|---|
";
    for rule in rule::ALL {
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} | {} | {} |",
            rule.code, rule.level, rule.section, rule.rule, rule.cause, rule.remedy
        );
    }
    page += "
## Planted faults of a receiver

`tests/check_send.rs` plants each fault in the C library and expects this rule first. A correct robot, simulated or in C, keeps every rule, over radios with bit errors, too.

| fault | level | rule |
|---|---|---|
";
    for (about, level, _, code) in FAULTS {
        let _ = writeln!(page, "| {about} | {level} | `{code}` |");
    }
    page + "
## Planted mistakes

`tests/check.rs` plants each mistake in a correct robot and expects this answer. It also writes this page.

| mistake | named | likely cause | code |
|---|---|---|---|
" + table
}

/// The station's notices of mistakes.
fn notices(events: impl IntoIterator<Item = Event>) -> Vec<String> {
    let mistakes = events.into_iter().filter_map(|event| match event {
        Event::Notice(notice) if notice.code == NoticeCode::RobotMistake => Some(notice.text),
        _ => None,
    });
    mistakes.collect()
}

/// A correct robot executes commands over radios with bit errors; no mistake is reported at any time.
#[test]
fn bit_errors_of_a_radio_are_not_mistakes_of_a_correct_robot() {
    let hours = if is_nightly() { 24.0 } else { 0.5 };
    for (channel, seed, hours) in [
        ("ber=1e-3", 5, hours),
        ("ber=5e-3,burst=80", 6, hours / 5.0),
        ("half-duplex,ber=3e-3", 126, hours / 5.0),
        ("ber=1e-2", 119, hours / 5.0),
    ] {
        let level = listen(CoSimulation::new("house", seed, channel), hours);
        assert!(channel == "ber=1e-2" || level >= 4, "{channel}: {level}");
    }
}

/// The same of the robot in C, at each level and duplex.
#[cfg(unix)]
#[test]
fn a_radio_with_bit_errors_makes_no_mistake_of_a_c_robot() {
    let half = Duplex::Half { patience_bytes: 16 };
    let robots = [1, 2, 3, 4, 5].map(|level| (level, Duplex::Full));
    let robots = [&robots[..], &[(5, half)]].concat();
    let hours = if is_nightly() { 24.0 } else { 0.1 };
    on_all_cores(0..robots.len() as u64, |n| {
        let (level, duplex) = robots[n as usize];
        let world = World::built_in("open-room").expect("it comes with the program");
        let mut config = SimulationConfig::new(world, seeds(1).start + n);
        let channel = match duplex {
            Duplex::Full => "ber=1e-3",
            Duplex::Half { .. } => "half-duplex,ber=1e-3",
        };
        config.channel = channel.parse().expect("a channel");
        config.duplex = duplex;
        let robot = CSimulation::at_level(level, &config);
        let co = CoSimulation::of(robot, &config, Config::new(owner(config.seed)));
        assert_eq!(listen(co, hours), level);
    });
}

/// Listens to a robot that takes a command in 97 s; returns the level that its lines show.
fn listen<R: Robot>(mut co: CoSimulation<R>, hours: f64) -> u8 {
    let mut diagnosis = Diagnosis::default();
    let end = Duration::from_secs_f64(hours * 3600.0);
    let mut next = Duration::from_mins(1);
    let mut count = 0;
    while co.now() < end {
        co.step_telling(&mut |byte| diagnosis.take(&[byte]));
        let named = notices(co.events.drain(..).map(|(_, event)| event));
        assert_eq!(named, [] as [&str; 0], "{}", co.context());
        if co.now() >= next {
            next += Duration::from_secs(97);
            count += 1;
            co.request(match count % 4 {
                0 => Request::Stop,
                1 => Request::Mode(Mode::Prowl),
                2 => Request::Route(vec![
                    Waypoint {
                        x_in: 5,
                        y_in: count
                    };
                    9
                ]),
                _ => Request::Mode(Mode::Reactive),
            });
        }
    }
    assert_eq!(diagnosis.findings(), [], "{}", co.context());
    let damaged = diagnosis.counters().damaged.total();
    assert!(
        damaged > (hours * 1000.0) as u64,
        "{damaged}: {}",
        co.context()
    );
    diagnosis.level()
}

/// The mistake in a capture of a robot, wherever it is read; each kind is reported once while it is received.
#[test]
fn a_mistake_is_reported_wherever_lines_are_read() {
    let folder = scratch("mistakes");
    let file = folder.join("own.txt");
    let path = file.to_str().unwrap();
    let plant = field(b'B', 13, b" 0120");
    fs::write(&file, stream(Some(&plant))).unwrap();
    let place = "line B, column 13";
    let (info, _) = expect(0, &["info", path]);
    let mistakes = info.lines().find(|line| line.starts_with("mistakes "));
    assert!(mistakes.is_some_and(|line| line.contains(place)), "{info}");
    let (info, _) = expect(0, &["info", "--json", path]);
    let info: serde_json::Value = serde_json::from_str(&info).unwrap();
    assert_eq!(info["mistakes"][0]["code"], "missing-sign");
    assert_eq!(info["mistakes"][0]["column"], 13);
    let (verdict, _) = expect(1, &["verify", path]);
    assert!(verdict.contains("NOT GOOD"), "{verdict}");
    assert!(
        verdict.contains(&format!("wrong      the robot's {place}")),
        "{verdict}"
    );
    let (_, told) = expect(0, &["export", path, "--to", "csv", "-o", "-"]);
    assert!(
        told.contains(&format!("mistakes of the robot: {place}")),
        "{told}"
    );

    let mut station = Station::new(Config::new(1), true);
    let mut named = Vec::new();
    for (n, piece) in stream(Some(&plant)).chunks(16).enumerate() {
        station.handle_bytes(Duration::from_millis(66 * n as u64), piece);
        named.extend(notices(std::iter::from_fn(|| station.poll_event())));
    }
    assert_eq!(named.len(), 1, "{named:?}");
    assert!(named[0].contains(place), "{named:?}");

    // Without an intact line, it is the reason.
    let plant = Checksum(|it| sent(crc::update(0, it)));
    fs::write(&file, stream(Some(&plant))).unwrap();
    for arguments in [
        &["info", path][..],
        &["verify", path],
        &["export", path, "--to", "csv", "-o", "-"],
    ] {
        let (_, error) = expect(2, arguments);
        let reason = "column 75: the checksum starts from 0";
        assert!(error.contains(reason), "{arguments:?}: {error}");
    }
}
