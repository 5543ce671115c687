//! Strategies and checks shared by the tests of all lines.

use super::{Ack, Body, Detail, FieldError, Line, Outcome};
use crate::LINE_BYTES;
use proptest::prelude::*;

pub(super) fn detail() -> impl Strategy<Value = Detail> {
    prop_oneof![
        (0..1024_u16, 0..128_u8).prop_map(|(owner, robot_id)| Detail::Idle { owner, robot_id }),
        (0..0x4000_u16).prop_map(|era| Detail::Era { era }),
        (0..0x8000_u16).prop_map(|receipt| Detail::Stopped { receipt }),
        (0..128_u8).prop_map(|robot_id| Detail::CannotHear { robot_id }),
        (0..=75_u8, 0..4_u8, any::<u8>()).prop_map(|(first_missing, tag, window)| {
            Detail::Staging {
                first_missing,
                tag,
                window,
            }
        }),
    ]
}

pub(super) fn ack() -> impl Strategy<Value = Ack> {
    let outcome = prop::sample::select(&Outcome::ALL[..]);
    (0..8_u8, 0..8_u8, 0..8_u8, outcome, detail()).prop_map(
        |(boot, session, sequence, outcome, detail)| Ack {
            boot,
            session,
            sequence,
            outcome,
            detail,
        },
    )
}

fn line(body: Body) -> Line {
    Line {
        sequence: 42,
        body,
        ack: Ack::default(),
    }
}

/// Encodes and parses a body.
pub(super) fn read_back(body: Body) -> Body {
    let bytes = line(body).encode();
    let read = Line::parse(&bytes).unwrap_or_else(|e| panic!("{e:?} in {}", show(&bytes)));
    assert_eq!((read.sequence, read.ack), (42, Ack::default()));
    assert_eq!(read.encode(), bytes, "encoding changed");
    read.body
}

/// The column in the error after `characters` overwrote a part of a good line.
pub(super) fn blamed(body: Body, column: usize, characters: &[u8]) -> Option<u8> {
    let mut bytes = line(body).encode();
    bytes[column - 1..column - 1 + characters.len()].copy_from_slice(characters);
    Line::parse(&bytes)
        .err()
        .map(|FieldError { column }| column)
}

/// Overwrites some columns of a good line and checks that a line that still parses encodes to the same bytes.
pub(super) fn has_one_form(body: Body, edits: &[(usize, u8)]) {
    let mut bytes = line(body).encode();
    for &(column, character) in edits {
        bytes[column - 1] = character;
    }
    if let Ok(read) = Line::parse(&bytes) {
        let again = read.encode();
        assert_eq!(show(&again[..74]), show(&bytes[..74]));
    }
}

/// Characters to put into the columns under the checksum.
pub(super) fn edits() -> impl Strategy<Value = std::vec::Vec<(usize, u8)>> {
    let character = prop_oneof![
        prop::sample::select(&b"+-.0123459/` BLTrR"[..]),
        b' '..=b'~',
        any::<u8>()
    ];
    prop::collection::vec((1..=74_usize, character), 1..5)
}

fn show(bytes: &[u8]) -> std::string::String {
    std::format!("{}", bytes.escape_ascii())
}

#[test]
fn a_line_of_no_known_type_is_refused_at_column_1() {
    let bytes = [b'Z'; LINE_BYTES];
    assert_eq!(Line::parse(&bytes), Err(FieldError { column: 1 }));
}

#[test]
fn sequence_and_acknowledgement_are_checked_in_every_line() {
    let body = Body::Text(super::TextLine::new("good"));
    for (column, characters, column_blamed) in [
        (2, &b"a2"[..], 2),
        (2, b" 2", 2),
        (2, b"+2", 2),
        (3, b"-", 2),
        (70, b" ", 70),
        (74, b"a", 70),
    ] {
        assert_eq!(blamed(body, column, characters), Some(column_blamed));
    }
}
