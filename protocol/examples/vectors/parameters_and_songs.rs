//! Vectors of lines P and S and of the orders for parameters. They were added after version 1 was frozen, so they
//! have separate files.

use super::lines::vector as line_vector;
use super::samples::{altered, encode, parameter, song};
use super::uplink::{EAR, sealed, session, vector as frame_vector};
use groundwave_protocol::command::{Command, Message, Order};
use groundwave_protocol::parameter::key;
use groundwave_protocol::telemetry::{
    Body, Note, ParameterLine, ParameterName, Printable, SONG_NOTES, SongLine,
};
use serde_json::Value;

/// Lines P and S, good and bad.
pub fn lines() -> Vec<Value> {
    let p = |about: &str, line| line_vector(about, &encode(48, Body::Parameter(line)));
    let s = |about: &str, notes: &[Note]| {
        let line = SongLine::new(notes.iter().copied());
        line_vector(about, &encode(49, Body::Song(line)))
    };
    let note = |hz, ticks| Note { hz, ticks };
    let mut vectors = vec![
        p("P: top speed, slower than what is kept", parameter()),
        p(
            "P: everything as large as it gets",
            ParameterLine {
                place: 99,
                count: 99,
                name: ParameterName::new("a-0123456789-bcdef"),
                value: 99_999,
                kept: -99_999,
                least: -99_999,
                most: 99_999,
                unit: Printable::new("~ of ~ or ~"),
            },
        ),
        p(
            "P: a single parameter of one letter, no unit, all zero",
            ParameterLine {
                place: 1,
                count: 1,
                name: ParameterName::new("z"),
                value: 0,
                kept: 0,
                least: 0,
                most: 0,
                unit: Printable::new(""),
            },
        ),
        p(
            "P: a value beyond its own limits is said all the same",
            ParameterLine {
                value: -3,
                unit: Printable::new("0 or 1"),
                ..parameter()
            },
        ),
        line_vector(
            "S: a rising call and its answer",
            &encode(49, Body::Song(song())),
        ),
        s("S: no note", &[]),
        s("S: one short rest", &[note(0, 1)]),
        s(
            "S: as many notes as there can be, as high and long as they get",
            &[note(4095, 63); SONG_NOTES],
        ),
    ];
    vectors.extend(bad_lines());
    vectors
}

fn bad_lines() -> Vec<Value> {
    let p = encode(48, Body::Parameter(parameter()));
    let s = encode(49, Body::Song(SongLine::new([Note { hz: 523, ticks: 4 }])));
    let bad: [(&[u8], usize, &[u8]); 31] = [
        (&p, 2, b" 8"),
        (&p, 4, b"_"),
        (&p, 5, b"00/26"),
        (&p, 5, b"27/26"),
        (&p, 5, b"01-26"),
        (&p, 5, b" 1/26"),
        (&p, 10, b"t"),
        (&p, 11, b"T"),
        (&p, 14, b" "),
        (&p, 14, b"_"),
        (&p, 11, b"                  "),
        (&p, 29, b"0"),
        (&p, 30, b"000008"),
        (&p, 30, b"-00000"),
        (&p, 30, b"------"),
        (&p, 37, b"+ 0012"),
        (&p, 44, b"  0002"),
        (&p, 51, b"+0001x"),
        (&p, 57, b"i"),
        (&p, 61, b"\x07"),
        (&p, 69, b"."),
        (&p, 70, b" "),
        (&s, 4, b"_"),
        (&s, 5, b"a"),
        (&s, 7, b"`"),
        (&s, 6, b" "),
        (&s, 8, b"!!`"),
        (&s, 10, b"!"),
        (&s, 11, b"!!!"),
        (&s, 68, b"!"),
        (&s, 74, b"a"),
    ];
    bad.iter()
        .map(|&(line, column, characters)| {
            let about = format!("{} from column {column} on", super::judge::text(characters));
            line_vector(about, &altered(line.to_vec(), column, characters))
        })
        .collect()
}

/// The orders for parameters, good and bad.
pub fn frames() -> Vec<Value> {
    let key = key("top-speed");
    let set = |value| Order::SetParameter { key, value };
    let orders = [
        ("top-speed to 8", set(8)),
        ("top-speed to -1", set(-1)),
        ("the most that line P can say", set(99_999)),
        ("the least that line P can say", set(-99_999)),
        ("the most that 18 bits hold", set(131_071)),
        ("the least that 18 bits hold", set(-131_072)),
        ("key 0, value 0", Order::SetParameter { key: 0, value: 0 }),
        ("say top-speed", Order::ReadParameter { key }),
        (
            "say the largest key",
            Order::ReadParameter { key: 0xFF_FFFF },
        ),
        ("say them all", Order::ReadParameters { place: 0 }),
        ("say the first", Order::ReadParameters { place: 1 }),
        (
            "say one that no robot has",
            Order::ReadParameters { place: 4095 },
        ),
        ("keep them", Order::KeepParameters),
    ];
    let mut vectors: Vec<_> = (1..)
        .zip(orders)
        .map(|(sequence, (about, order))| {
            let command = Message::Command(Command { sequence, order });
            frame_vector(about, EAR, command.encode(session()).as_bytes())
        })
        .collect();
    let unreadable: [(&str, &[u8]); 9] = [
        ("no key", b"C!V"),
        ("half a key", b"C!V``"),
        ("half a value", b"C!V`````"),
        ("a value too long", b"C!V````````"),
        ("a space in a key", b"C!V` ``"),
        ("no place", b"C!N"),
        ("half a place", b"C!N!"),
        ("a place too long", b"C!N`!!"),
        ("keep takes no argument", b"C!K!"),
    ];
    vectors.extend(
        unreadable
            .iter()
            .map(|(about, content)| frame_vector(*about, EAR, &sealed(session(), content))),
    );
    vectors
}
