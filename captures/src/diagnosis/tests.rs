use super::*;
use groundwave_protocol::crc;
use groundwave_protocol::telemetry::{Ack, Body, Detail, Line as WireLine, StateLine};

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

#[test]
fn one_wrong_checksum_may_be_the_radios() {
    let line = with_remainder(A, crc::update(0, A));
    assert_eq!(diagnosed(vec![line.clone()]).findings(), []);
    let findings = diagnosed(vec![line; 3]).findings();
    assert_eq!(findings.len(), 1, "{findings:?}");
    assert_eq!((findings[0].kind.code, findings[0].count), ("crc-start", 3));
}

/// Lines after one that may be another robot's are still examined as what they are.
#[test]
fn damaged_lines_after_an_undecided_one_are_examined() {
    let undecided = WireLine {
        sequence: 9,
        body: Body::State(StateLine::BLANK),
        ack: Ack {
            boot: 1,
            detail: Detail::Era { era: 5 },
            ..Ack::default()
        },
    };
    let mut lines = vec![sealed(C), undecided.encode().to_vec()];
    lines.extend(vec![with_remainder(A, crc::update(0, A)); 3]);
    let diagnosis = diagnosed(lines);
    assert_eq!(diagnosis.undecided_lines().count(), 1);
    let findings = diagnosis.findings();
    let start = findings.iter().find(|it| it.kind.code == "crc-start");
    assert_eq!(start.map(|it| it.count), Some(3), "{findings:?}");
}

#[test]
fn a_checksum_of_the_line_before_is_stale() {
    let of =
        |head: &[u8], before: &[u8]| with_remainder(head, crc::update(crc::DOWNLINK_INIT, before));
    let lines = (0..12).map(|n| if n % 2 == 0 { of(A, B) } else { of(B, A) });
    let findings = diagnosed(lines).findings();
    let stale = findings.iter().find(|it| it.kind.code == "crc-stale");
    assert_eq!(stale.map(|it| it.count), Some(6), "{findings:?}");
}

#[test]
fn the_level_follows_the_lines() {
    assert_eq!(diagnosed([]).level(), 0);
    assert_eq!(diagnosed([sealed(A)]).level(), 2);
    assert_eq!(diagnosed([sealed(A), sealed(B)]).level(), 3);
    assert_eq!(diagnosed([sealed(A), sealed(C)]).level(), 4);
}

/// A half-duplex radio may swallow the line before line 00 without a byte of noise, at the same number or at others.
#[test]
fn a_few_swallowed_lines_are_no_early_restart() {
    let line = |sequence: u64| {
        let mut head = *A;
        head[1..3].copy_from_slice(format!("{sequence:02}").as_bytes());
        sealed(&head)
    };
    let findings = |rounds: u64, swallowed: &[u64]| {
        let lines = (0..rounds * 100).filter(|n| !swallowed.contains(n));
        let findings = diagnosed(lines.map(|n| line(n % 100))).findings();
        let codes = findings.into_iter().map(|finding| finding.kind.code);
        codes
            .filter(|code| ["sequence-wrap", "boot-same"].contains(code))
            .collect::<Vec<_>>()
    };
    assert_eq!(findings(100, &[4999, 9899]), [""; 0], "at 99 twice");
    assert_eq!(
        findings(100, &[4999, 9898, 9899]),
        [""; 0],
        "at 99 and at 98"
    );
    let each: Vec<u64> = (0..5).map(|round| round * 100 + 99).collect();
    assert_eq!(findings(5, &each), ["sequence-wrap"]);
}
