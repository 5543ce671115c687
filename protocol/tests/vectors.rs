//! The golden vectors in `vectors/` against the code. Only the generator `examples/vectors` writes vectors.

#[path = "../examples/vectors/main.rs"]
mod generator;

use generator::FILES;
use generator::conversation::Robot;
use generator::judge::{self, Ear};
use groundwave_protocol::command::{FrameType, OrderType};
use groundwave_protocol::telemetry::{AckLine, LineType, Outcome};
use groundwave_protocol::{Waypoint, crc, digest::digest};
use serde_json::{Map, Value};

fn read(name: &str) -> Vec<Value> {
    let path = format!("{}/vectors/{name}.jsonl", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("cannot read {path}: {e}"));
    text.lines()
        .map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e} in {line}")))
        .collect()
}

fn string<'a>(vector: &'a Value, name: &str) -> &'a str {
    vector[name]
        .as_str()
        .unwrap_or_else(|| panic!("no {name} in {vector}"))
}

fn number(vector: &Value, name: &str) -> u32 {
    let number = vector[name].as_u64().and_then(|n| n.try_into().ok());
    number.unwrap_or_else(|| panic!("no {name} in {vector}"))
}

fn without(vector: &Value, names: &[&str]) -> Value {
    let fields: Map<_, _> = vector
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(name, _)| !names.contains(&name.as_str()))
        .map(|(name, value)| (name.clone(), value.clone()))
        .collect();
    Value::Object(fields)
}

/// The vectors of a kind, from all its files.
fn read_all(kind: &str) -> Vec<Value> {
    let is_of_kind = |name: &&str| name.split('-').next() == Some(kind);
    let names = FILES.iter().map(|(name, ..)| *name).filter(is_of_kind);
    names.flat_map(read).collect()
}

#[test]
fn files_match_the_generator() {
    for (name, make, _) in FILES {
        let (written, generated) = (read(name), make());
        for (n, (written, generated)) in written.iter().zip(&generated).enumerate() {
            assert_eq!(written, generated, "{name}.jsonl, line {}", n + 1);
        }
        assert_eq!(written.len(), generated.len(), "{name}.jsonl");
    }
}

#[test]
fn lines_match_their_vectors() {
    for vector in read_all("lines") {
        let judged = judge::line(string(&vector, "line").as_bytes());
        assert_eq!(judged, without(&vector, &["about", "line"]), "{vector}");
    }
}

#[test]
fn streams_match_their_vectors() {
    for vector in read_all("streams") {
        let bytes: Vec<u8> = string(&vector, "bytes")
            .as_bytes()
            .chunks(2)
            .map(|pair| {
                let pair = str::from_utf8(pair).unwrap_or_default();
                u8::from_str_radix(pair, 16).unwrap_or_else(|e| panic!("{e} in {vector}"))
            })
            .collect();
        let judged = judge::stream(&bytes);
        assert_eq!(judged, without(&vector, &["about", "bytes"]), "{vector}");
    }
}

#[test]
fn checksums_match_their_vectors() {
    for vector in read_all("checksums") {
        let init = u32::from_str_radix(string(&vector, "init"), 16).unwrap_or_default();
        let remainder = crc::update(init, string(&vector, "text").as_bytes());
        assert_eq!(format!("{remainder:06x}"), string(&vector, "remainder"));
        let characters = crc::characters(remainder);
        assert_eq!(judge::text(&characters), string(&vector, "characters"));
    }
}

#[test]
fn frames_match_their_vectors() {
    for vector in read_all("frames") {
        let ear = Ear {
            robot_id: number(&vector, "robot_id") as u8,
            boot: number(&vector, "boot") as u8,
            session: number(&vector, "session") as u8,
            owner: number(&vector, "owner") as u16,
            era: vector["era"].as_u64().unwrap_or_default() as u16,
        };
        let judged = ear.hear(string(&vector, "frame").as_bytes());
        let given = [
            "about", "frame", "robot_id", "boot", "session", "owner", "era",
        ];
        assert_eq!(judged, without(&vector, &given), "{vector}");
    }
}

#[test]
fn digests_match_their_vectors() {
    for vector in read_all("digests") {
        let coordinate = |value: &Value| value.as_i64().and_then(|v| v.try_into().ok());
        let waypoints: Option<Vec<_>> = vector["waypoints"]
            .as_array()
            .into_iter()
            .flatten()
            .map(|w| Waypoint::new(coordinate(&w[0])?, coordinate(&w[1])?))
            .collect();
        let Some(waypoints) = waypoints else {
            panic!("no waypoints in {vector}");
        };
        assert_eq!(digest(waypoints.iter()), number(&vector, "digest"));
    }
}

#[test]
fn acknowledgements_match_the_conversation() {
    let mut robot = Robot::boot(0);
    for step in read_all("conversation") {
        let judged = if step["boots"].is_null() {
            let outcome = step["outcome"].as_u64().unwrap_or_default() as usize;
            let frame = string(&step, "frame").as_bytes();
            robot.hear(frame, Outcome::ALL[outcome])
        } else {
            robot = Robot::boot(number(&step, "boots") as u16);
            let given = without(&step, &["about", "ack", "ack_characters"]);
            robot.acknowledge(given)
        };
        assert_eq!(judged, without(&step, &["about"]), "{step}");
    }
}

/// Detects a missing kind of vector.
#[test]
fn both_verdicts_of_every_kind_are_in_the_files() {
    let count = |name, field: &str, value: &str| {
        let wanted = |v: &&Value| v[field] == value || value == "*" && !v[field].is_null();
        read(name).iter().filter(wanted).count()
    };
    for (name, field, value, least) in [
        ("lines", "fields", "*", 60),
        ("lines", "error", "field", 70),
        ("lines", "error", "crc", 5),
        ("lines", "error", "shape", 2),
        ("lines-2", "fields", "*", 8),
        ("lines-2", "error", "field", 30),
        ("frames-2", "message", "*", 20),
        ("lines-3", "fields", "*", 4),
        ("frames-3", "message", "*", 4),
        ("frames-3", "error", "unreadable", 3),
        ("conversation-2", "action", "stop", 4),
        ("frames", "message", "*", 30),
        ("frames", "error", "crc", 8),
        ("frames", "error", "too_long", 1),
        ("frames", "error", "unreadable", 15),
        ("conversation", "action", "not heard", 2),
        ("conversation", "action", "execute", 5),
        ("conversation", "action", "list replaced", 2),
    ] {
        let found = count(name, field, value);
        assert!(found >= least, "{name}: {found} with {field} {value}");
    }
}

fn known_orders() -> impl Iterator<Item = &'static OrderType> {
    let all = OrderType::ALL.iter();
    all.filter(|order_type| **order_type != OrderType::Unknown)
}

#[test]
fn every_type_of_line_frame_and_order_has_a_vector() {
    let lines = read_all("lines");
    for line_type in LineType::ALL {
        let letter = char::from(line_type.letter()).to_string();
        let is_it = |v: &Value| v["fields"]["type"] == letter;
        assert!(lines.iter().any(is_it), "{line_type:?}");
    }
    let frames = read_all("frames");
    let has = |field: &str, letter: u8| {
        let letter = char::from(letter).to_string();
        frames.iter().any(|v| v["message"][field] == letter)
    };
    for frame_type in FrameType::ALL {
        assert!(has("type", frame_type.letter()), "{frame_type:?}");
    }
    for order_type in known_orders() {
        assert!(has("order", order_type.letter()), "{order_type:?}");
    }
}

#[test]
fn specification_lists_the_letters_in_use() {
    let list = |letters: Vec<u8>| {
        let mut letters: Vec<String> = letters.into_iter().map(|b| char::from(b).into()).collect();
        letters.sort();
        letters.join(", ")
    };
    let lines = LineType::ALL.iter().map(|line_type| line_type.letter());
    let frames = FrameType::ALL.iter().map(|frame_type| frame_type.letter());
    let orders = known_orders();
    let listed = format!(
        "Line types in use: {}. Frame types: {}. Orders: {}.",
        list(lines.chain(AckLine::LETTERS).collect()),
        list(frames.collect()),
        list(orders.map(|order_type| order_type.letter()).collect()),
    );
    assert!(include_str!("../SPEC.md").contains(&listed), "{listed}");
}

/// The files of version 1 are final and never change. New vectors go into new files.
#[test]
fn final_files_stay_as_they_are() {
    for (name, _, remainder) in FILES {
        let path = format!("{}/vectors/{name}.jsonl", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read(&path).unwrap_or_else(|e| panic!("cannot read {path}: {e}"));
        let found = crc::update(crc::DOWNLINK_INIT, &text);
        assert_eq!(remainder.unwrap_or(found), found, "{name}: {found:06x}");
    }
}
