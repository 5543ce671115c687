use super::checksum::{reflected, shifted};
use super::*;
use groundwave_protocol::crc;

const A: &[u8; 74] = b"A42 +123.4 -045.0 273 +06 -12 +00 +12 042 120 61 48 .R--... P--Is..d BH5*'";
const B: &[u8; 74] = b"B47 07 12.4 +0120 -0036 003/040 `2-%9X 12 155 122 UB.I-..D 004 00    BH5*'";
const C: &[u8; 74] = b"C53 07 000412 004 01.00 ``#2``+=3B``````]! 133 002 000 0012 ---- -   BH5*'";

fn with_remainder(head: &[u8], remainder: u32) -> Vec<u8> {
    [head, &crc::characters(remainder), b"\r\n"].concat()
}

fn sealed(head: &[u8; 74]) -> Vec<u8> {
    with_remainder(head, crc::update(crc::DOWNLINK_INIT, head))
}

fn diagnosed(lines: impl IntoIterator<Item = Vec<u8>>) -> Diagnosis {
    let mut diagnosis = Diagnosis::default();
    lines.into_iter().for_each(|line| diagnosis.take(&line));
    diagnosis
}

/// Puts `text` at a column of a line, with a right checksum, and expects the column and the words.
fn blames(head: &[u8; 74], column: usize, text: &[u8], words: &str) {
    let mut head = *head;
    head[column - 1..column - 1 + text.len()].copy_from_slice(text);
    let findings = diagnosed([sealed(&head)]).findings();
    let [finding] = &findings[..] else {
        panic!("{column}: {findings:?}");
    };
    assert!(finding.cause.contains(words), "{finding:?}");
    assert!(finding.column.is_some_and(|it| it >= column), "{finding:?}");
}

#[test]
fn a_wrong_field_is_named_with_its_form() {
    blames(A, 5, b" 123.4", "X: expected +123.4");
    blames(A, 12, b"-000.0", "Y: expected");
    blames(A, 19, b"360", "theta: expected 000 to 359");
    blames(A, 23, b"006", "requested speed: expected a sign");
    blames(A, 31, b"-00", "left wheel: expected a sign");
    blames(A, 39, b" 42", "left sonar: expected three digits");
    blames(A, 50, b" 8", "right photocell");
    blames(A, 53, b"x", "bumper: expected one of");
    blames(A, 58, b"?", "power: expected");
    blames(A, 61, b"p", "mode: expected");
    blames(A, 62, b"BT", "layers: ");
    blames(A, 4, b"_", "expected a space");
    blames(A, 2, b" 7", "sequence: expected two digits");
    blames(A, 70, b" ", "acknowledgement: expected");
    blames(A, 1, b"Z", "type: expected");
    blames(B, 5, b"00", "robot id: expected 01 to 99");
    blames(B, 8, b" 9.1", "battery: expected");
    blames(B, 25, b"041/040", "waypoints: expected");
    blames(B, 43, b"256", "left photocell: expected 000 to 255");
    blames(C, 19, b"1.000", "version: expected");
    blames(C, 61, b"0005", "failsafe silence: expected");
}

#[test]
fn a_wrong_checksum_is_traced_to_its_cause() {
    let right = crc::update(crc::DOWNLINK_INIT, A);
    let cases = [
        (crc::update(0, A), "starts from 0"),
        (right ^ 0xFF_FFFF, "inverted"),
        (reflected(A), "reflected"),
        (
            crc::update(crc::DOWNLINK_INIT, &[b"\n", &A[..]].concat()),
            "LF of the line before",
        ),
        (
            crc::update(crc::DOWNLINK_INIT, &A[1..]),
            "leaves out column 1",
        ),
        (crc::update(crc::DOWNLINK_INIT, &A[..73]), "column 73"),
        (crc::update(crc::DOWNLINK_INIT, &A[..69]), "acknowledgement"),
        (shifted(24, 0xBD_80DE, 0xFF_FFFF, A), "Koopman"),
        (shifted(24, 0x86_4CFB, 0xB7_04CE, A), "OpenPGP"),
        (shifted(16, 0x1021, 0xFFFF, A), "CCITT"),
        (shifted(16, 0x1021, 0, A), "XMODEM"),
    ];
    for (remainder, words) in cases {
        let lines = vec![with_remainder(A, remainder); 3];
        let findings = diagnosed(lines.clone()).findings();
        assert_eq!(findings.len(), 1, "{words}: {findings:?}");
        assert!(findings[0].cause.contains(words), "{words}: {findings:?}");
        assert_eq!((findings[0].column, findings[0].count), (Some(75), 3));
        // Once, the radio may have done it.
        assert!(diagnosed(lines.into_iter().take(1)).findings().is_empty());
    }
    let hex = format!("{:04X}", shifted(16, 0x1021, 0xFFFF, A));
    let line = [&A[..], hex.as_bytes(), b"\r\n"].concat();
    let findings = diagnosed(vec![line; 3]).findings();
    assert!(findings[0].cause.contains("in hexadecimal"), "{findings:?}");
}

#[test]
fn a_wrong_end_or_length_is_named() {
    let good = sealed(A);
    let lf_alone = [&good[..78], b"\n"].concat();
    let short = [&good[..60], &good[61..]].concat();
    let hex = [&A[..], b"9402b9", b"\r\n"].concat();
    for (line, words) in [
        (lf_alone, "LF alone"),
        (short, "has 79 bytes"),
        (hex, "hexadecimal"),
    ] {
        let findings = diagnosed(vec![line; 3]).findings();
        assert_eq!(findings.len(), 1, "{words}: {findings:?}");
        assert!(findings[0].cause.contains(words), "{findings:?}");
    }
}

fn numbered(step: usize) -> impl Iterator<Item = Vec<u8>> {
    (0..50).map(move |n| {
        let mut head = *A;
        head[1..3].copy_from_slice(format!("{:02}", n * step % 100).as_bytes());
        sealed(&head)
    })
}

#[test]
fn a_sequence_that_stands_still_or_jumps_is_named() {
    for (step, words) in [(0, "stands still"), (2, "jumps")] {
        let findings = diagnosed(numbered(step)).findings();
        assert!(findings[0].cause.contains(words), "{findings:?}");
    }
    assert_eq!(diagnosed(numbered(1)).findings(), []);
}

#[test]
fn damage_by_the_radio_is_no_mistake_of_the_robot() {
    let mut state = 1_u64;
    let mut random = move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        state >> 33
    };
    let mut diagnosis = Diagnosis::default();
    for line in (0..400).flat_map(|_| numbered(1).collect::<Vec<_>>()) {
        let mut line = line;
        for byte in &mut line {
            for bit in 0..8 {
                if random() % 1000 == 0 {
                    *byte ^= 1 << bit;
                }
            }
        }
        diagnosis.take(&line);
    }
    assert_eq!(diagnosis.findings(), []);
    assert!(diagnosis.counters().damaged.total() > 1000);
}

#[test]
fn the_level_follows_the_lines() {
    assert_eq!(diagnosed([]).level(), 0);
    assert_eq!(diagnosed([sealed(A)]).level(), 2);
    assert_eq!(diagnosed([sealed(A), sealed(B)]).level(), 3);
    assert_eq!(diagnosed([sealed(A), sealed(C)]).level(), 4);
}
