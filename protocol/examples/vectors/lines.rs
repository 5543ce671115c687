//! Vectors of single lines.

use super::judge;
use super::samples::{
    ACK, STAGING, acknowledge, altered, counters, encode, go_ahead, state, status, text,
};
use groundwave_protocol::failsafe::Failsafe;
use groundwave_protocol::status_codes::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerMask, LayerState, Link, Mode, Power,
};
use groundwave_protocol::telemetry::{
    Ack, Body, CountersLine, Detail, FirmwareVersion, HOLDERS, LayerStates, ListPlace, StateLine,
    StatusLine,
};
use serde_json::Value;

pub fn vector(about: impl Into<String>, line: &[u8]) -> Value {
    let mut vector = judge::line(line);
    vector["about"] = Value::from(about.into());
    vector["line"] = Value::from(judge::text(line));
    vector
}

/// Each line type with all letters and limits, then lines to reject.
pub fn lines() -> Vec<Value> {
    let mut vectors = valid_states();
    vectors.extend(valid_others());
    vectors.extend(letters());
    vectors.extend(bad_fields());
    vectors.extend(damaged());
    vectors
}

fn valid_states() -> Vec<Value> {
    let state_of = |about, sequence, line| vector(about, &encode(sequence, Body::State(line)));
    vec![
        state_of("A: infrared turns the robot left", 42, state()),
        state_of(
            "A: everything at zero or not there",
            0,
            StateLine {
                infrared: Infrared::Right,
                ..StateLine::BLANK
            },
        ),
        state_of(
            "A: everything as large as it gets",
            99,
            StateLine {
                x_tenths_in: 999_990,
                y_tenths_in: -999_990,
                theta_deg: 359,
                velocity_in_s: 99,
                rotation_in_s: -99,
                wheel_left_in_s: 99,
                wheel_right_in_s: -99,
                sonar_left_in: Some(999),
                sonar_right_in: Some(0),
                photo_left_pct: Some(99),
                photo_right_pct: Some(0),
                drive: Drive::OutOfRange,
                ..state()
            },
        ),
        state_of(
            "A: the last position in tenths and the first in whole inches",
            1,
            StateLine {
                x_tenths_in: -9999,
                y_tenths_in: 10_000,
                ..state()
            },
        ),
        state_of(
            "A: a tenth of an inch either way",
            2,
            StateLine {
                x_tenths_in: -1,
                y_tenths_in: 1,
                ..state()
            },
        ),
    ]
}

fn valid_others() -> Vec<Value> {
    [status_lines(), counters_lines(), text_and_short_lines()].concat()
}

fn status_lines() -> Vec<Value> {
    let b = |about, line| vector(about, &encode(47, Body::Status(line)));
    vec![
        b("B: third of forty waypoints reached", status()),
        b(
            "B: no target, no list, nothing fitted but the bumpers, and they are not allowed",
            StatusLine {
                target_in: None,
                list: ListPlace::default(),
                digest: 0,
                photo_left: None,
                photo_right: None,
                fitted: LayerMask::from_bits(0b10),
                allowed: LayerMask::NONE,
                ..status()
            },
        ),
        b(
            "B: going home, everything else as large as it gets",
            StatusLine {
                robot_id: 99,
                battery_dv: 999,
                target_in: Some((0, 0)),
                list: ListPlace {
                    driven: 300,
                    count: 300,
                },
                digest: u32::MAX,
                max_count: 99,
                photo_left: Some(255),
                photo_right: Some(0),
                fitted: LayerMask::ALL,
                allowed: LayerMask::ALL,
                boots: 999,
                odometer_resets: 99,
            },
        ),
        b(
            "B: the farthest target",
            StatusLine {
                target_in: Some((-9999, 9999)),
                ..status()
            },
        ),
    ]
}

fn counters_lines() -> Vec<Value> {
    let c = |about, line| vector(about, &encode(53, Body::Counters(line)));
    let failsafe = |silence_s, mode| CountersLine {
        failsafe: Some(Failsafe { silence_s, mode }),
        ..counters()
    };
    vec![
        c("C: a robot that prowls, mostly", counters()),
        c(
            "C: everything as large as it gets",
            CountersLine {
                robot_id: 99,
                uptime_s: 999_999,
                boots: 999,
                version: FirmwareVersion {
                    major: 99,
                    minor: 99,
                },
                ticks_won: [4095; HOLDERS],
                frames_heard: 999,
                frames_rejected: 999,
                ticks_late: 999,
                bumps: 9999,
                failsafe: Some(Failsafe {
                    silence_s: 4095,
                    mode: Mode::Forage,
                }),
            },
        ),
        c(
            "C: the ticks won tell all nine holders apart",
            CountersLine {
                ticks_won: [1, 2, 3, 4, 5, 6, 7, 8, 64],
                ..counters()
            },
        ),
        c(
            "C: home after half a minute of silence",
            failsafe(30, Mode::GoHome),
        ),
        c(
            "C: stop after the shortest silence",
            failsafe(10, Mode::Stop),
        ),
    ]
}

fn text_and_short_lines() -> Vec<Value> {
    let just_booted = Ack {
        detail: Detail::Idle {
            owner: 0,
            robot_id: 7,
        },
        ..Ack::default()
    };
    vec![
        vector(
            "T: a line of text",
            &text(49, "I'm finished with the co-ordinate list"),
        ),
        vector("T: nothing", &text(50, "")),
        vector(
            "T: every printable character, in two lines",
            &text(
                51,
                " !\"#$%&'()*+,-./0123456789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_",
            ),
        ),
        vector(
            "T: the second of them",
            &text(52, "`abcdefghijklmnopqrstuvwxyz{|}~"),
        ),
        vector("K: nothing staged", &acknowledge(43, ACK)),
        vector("K: the fourth block is missing", &acknowledge(44, STAGING)),
        vector("K: just booted", &acknowledge(0, just_booted)),
        vector("G: nothing staged", &go_ahead(43, ACK)),
        vector("G: the fourth block is missing", &go_ahead(44, STAGING)),
    ]
}

/// Every letter of every flag, every mode, and every state of every layer.
fn letters() -> Vec<Value> {
    let mut lines = Vec::new();
    lines.extend(Bump::ALL.iter().map(|&bump| StateLine { bump, ..state() }));
    lines.extend(Infrared::ALL.iter().map(|&infrared| StateLine {
        infrared,
        ..state()
    }));
    lines.extend(
        Cliff::ALL
            .iter()
            .map(|&cliff| StateLine { cliff, ..state() }),
    );
    lines.extend(Arm::ALL.iter().map(|&arm| StateLine { arm, ..state() }));
    lines.extend(
        Drive::ALL
            .iter()
            .map(|&drive| StateLine { drive, ..state() }),
    );
    lines.extend(
        Power::ALL
            .iter()
            .map(|&power| StateLine { power, ..state() }),
    );
    lines.extend(Link::ALL.iter().map(|&link| StateLine { link, ..state() }));
    lines.extend(Mode::ALL.iter().map(|&mode| StateLine { mode, ..state() }));
    for layer in Layer::ALL.into_iter().skip(1) {
        for &one in LayerState::ALL {
            let mut layers = LayerStates::OFF;
            layers.set(layer, one);
            lines.push(StateLine { layers, ..state() });
        }
    }
    (0..)
        .zip(lines)
        .map(|(n, line)| vector("A: letters", &encode(n % 100, Body::State(line))))
        .collect()
}

/// Number of lines with a valid checksum and an unreadable field.
fn bad_fields() -> Vec<Value> {
    let a = encode(42, Body::State(state()));
    let b = encode(47, Body::Status(status()));
    let c = encode(53, Body::Counters(counters()));
    let t = text(49, "good");
    let k = acknowledge(43, ACK);
    let g = go_ahead(43, ACK);
    let bad: [(&[u8], usize, &[u8]); 83] = [
        (&a, 1, b"Z"),
        (&a, 1, b"a"),
        (&a, 1, b"K"),
        (&a, 1, b"G"),
        (&a, 2, b" 2"),
        (&a, 2, b"4-"),
        (&a, 4, b"_"),
        (&a, 5, b"-000.0"),
        (&a, 5, b"+00012"),
        (&a, 5, b"+00999"),
        (&a, 5, b" 123.4"),
        (&a, 5, b"+12.34"),
        (&a, 5, b"+123.x"),
        (&a, 5, b"+ 12.3"),
        (&a, 12, b"-00000"),
        (&a, 12, b"------"),
        (&a, 19, b"360"),
        (&a, 19, b" 12"),
        (&a, 23, b"-00"),
        (&a, 27, b" 12"),
        (&a, 31, b"012"),
        (&a, 35, b"---"),
        (&a, 39, b"--1"),
        (&a, 43, b"-12"),
        (&a, 47, b"-1"),
        (&a, 50, b" 1"),
        (&a, 53, b"X"),
        (&a, 54, b"r"),
        (&a, 55, b"J"),
        (&a, 56, b"A"),
        (&a, 57, b"-"),
        (&a, 58, b"L"),
        (&a, 59, b"l"),
        (&a, 59, b">"),
        (&a, 60, b"."),
        (&a, 61, b"p"),
        (&a, 62, b"T"),
        (&a, 68, b"m"),
        (&a, 62, b"B-I"),
        (&a, 69, b"."),
        (&a, 70, b" "),
        (&a, 74, b"a"),
        (&b, 5, b"00"),
        (&b, 8, b"12,4"),
        (&b, 8, b" 9.4"),
        (&b, 13, b"-0000"),
        (&b, 13, b"-----"),
        (&b, 19, b"-----"),
        (&b, 25, b"041/040"),
        (&b, 25, b"003 040"),
        (&b, 33, b"$"),
        (&b, 38, b" "),
        (&b, 40, b"1x"),
        (&b, 43, b"256"),
        (&b, 47, b"-12"),
        (&b, 51, b"B"),
        (&b, 52, b"b"),
        (&b, 60, b"-04"),
        (&b, 64, b" 0"),
        (&b, 66, b"0"),
        (&c, 5, b"00"),
        (&c, 8, b"-00412"),
        (&c, 15, b"  4"),
        (&c, 19, b"01-00"),
        (&c, 25, b" `"),
        (&c, 41, b"`a"),
        (&c, 44, b"1.3"),
        (&c, 56, b"00 2"),
        (&c, 60, b"0"),
        (&c, 61, b"0009 X"),
        (&c, 61, b"0030 -"),
        (&c, 61, b"0030 U"),
        (&c, 61, b"0030 x"),
        (&c, 61, b"---- X"),
        (&c, 61, b"4096 X"),
        (&c, 67, b"0"),
        (&t, 4, b"x"),
        (&t, 30, b"\x07"),
        (&t, 68, b"\x7F"),
        (&t, 69, b"x"),
        (&k, 2, b" 3"),
        (&k, 4, b"a"),
        (&g, 2, b" 3"),
    ];
    bad.iter()
        .map(|&(line, column, characters)| {
            let about = format!("{} from column {column} on", judge::text(characters));
            vector(about, &altered(line.to_vec(), column, characters))
        })
        .collect()
}

/// Damaged lines.
fn damaged() -> Vec<Value> {
    let line = encode(42, Body::State(state()));
    let ack_line = acknowledge(43, ACK);
    let change = |line: &[u8], column: usize, character: u8| {
        let mut line = line.to_vec();
        line[column - 1] = character;
        line
    };
    let shorter = [&line[..10], &line[11..]].concat();
    let longer = [&line[..10], &line[9..]].concat();
    vec![
        vector("one bit of the first column", &change(&line, 1, b'C')),
        vector("one bit of X", &change(&line, 6, b'0')),
        vector(
            "one bit of the acknowledgement",
            &change(&line, 70, line[69] ^ 1),
        ),
        vector("one bit of the checksum", &change(&line, 78, line[77] ^ 1)),
        vector("a space in the checksum", &change(&line, 78, b' ')),
        vector("no carriage return", &change(&line, 79, b' ')),
        vector("a byte is missing", &shorter),
        vector("a byte too many", &longer),
        vector(
            "one bit of an acknowledgement line",
            &change(&ack_line, 5, ack_line[4] ^ 2),
        ),
        vector(
            "an acknowledgement line without its K",
            &change(&ack_line, 1, b'A'),
        ),
        vector(
            "an acknowledgement line that begins with G instead",
            &change(&ack_line, 1, b'G'),
        ),
    ]
}
