//! Vectors of lines I, F and V: robots that implement a part of the protocol, or have fields of their own.

use super::lines::vector as line_vector;
use super::samples::{abilities, altered, encode, field, values};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Body, FieldLine, ParameterName, Printable, ValuesLine,
};
use serde_json::Value;

/// Lines I, F and V, good and bad.
pub fn lines() -> Vec<Value> {
    let line = |about: &str, body| line_vector(about, &encode(50, body));
    let i = |about: &str, abilities| line(about, Body::Abilities(abilities));
    let f = |about: &str, field| line(about, Body::Field(field));
    let v = |about: &str, values| line(about, Body::Values(values));
    let mut vectors = vec![
        i(
            "I: level 3, lists of 40, no wheel speeds, two fields",
            abilities(),
        ),
        i(
            "I: everything",
            AbilitiesLine {
                robot_id: 99,
                rate_bytes_per_s: 99_999,
                fields: 9,
                ..AbilitiesLine::FULL
            },
        ),
        i(
            "I: level 1, nothing measured",
            AbilitiesLine {
                robot_id: 1,
                level: 1,
                capacity: 0,
                modes: 0,
                measured: 0,
                rate_bytes_per_s: 30,
                fields: 0,
            },
        ),
        f("F: a current, two digits behind the point", field()),
        f(
            "F: everything as large as it gets",
            FieldLine {
                place: 9,
                count: 9,
                name: ParameterName::new("a-0123456789-bcdef"),
                decimals: 5,
                unit: Printable::new("~ of ~ or ~"),
            },
        ),
        f(
            "F: a single field of one letter, no unit",
            FieldLine {
                place: 1,
                count: 1,
                name: ParameterName::new("z"),
                decimals: 0,
                unit: Printable::new(""),
            },
        ),
        v("V: two fields", values()),
        v("V: no value", ValuesLine::new([])),
        v(
            "V: nine, as large as they get, zero among them",
            ValuesLine::new([99_999, -99_999, 0, 1, -1, 10, -10, 99_999, -99_999].map(Some)),
        ),
    ];
    vectors.extend(bad_lines());
    vectors
}

fn bad_lines() -> Vec<Value> {
    let i = encode(50, Body::Abilities(abilities()));
    let f = encode(51, Body::Field(field()));
    let v = encode(52, Body::Values(values()));
    let bad: [(&[u8], usize, &[u8]); 37] = [
        (&i, 2, b"x0"),
        (&i, 4, b"_"),
        (&i, 5, b"00"),
        (&i, 8, b"0"),
        (&i, 8, b"6"),
        (&i, 9, b"0"),
        (&i, 10, b"301"),
        (&i, 10, b" 40"),
        (&i, 13, b"P"),
        (&i, 14, b"R"),
        (&i, 15, b"r"),
        (&i, 22, b"-"),
        (&i, 23, b"."),
        (&i, 24, b"W"),
        (&i, 27, b" "),
        (&i, 29, b"00029"),
        (&i, 29, b" 0240"),
        (&i, 35, b"-"),
        (&i, 36, b"."),
        (&i, 69, b"."),
        (&i, 70, b" "),
        (&f, 5, b"0/2"),
        (&f, 5, b"3/2"),
        (&f, 6, b"-"),
        (&f, 9, b"M"),
        (&f, 11, b" "),
        (&f, 27, b"."),
        (&f, 28, b"6"),
        (&f, 34, b"\x07"),
        (&f, 41, b"."),
        (&f, 69, b"."),
        (&v, 4, b"0"),
        (&v, 5, b"-00000"),
        (&v, 5, b" 00125"),
        (&v, 12, b"-----0"),
        (&v, 61, b"      "),
        (&v, 67, b"0"),
    ];
    bad.iter()
        .map(|&(line, column, characters)| {
            let about = format!("{} from column {column} on", super::judge::text(characters));
            line_vector(about, &altered(line.to_vec(), column, characters))
        })
        .collect()
}
