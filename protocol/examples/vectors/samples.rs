//! A sample line of each type.

use groundwave_protocol::crc;
use groundwave_protocol::status_codes::{Infrared, Layer, LayerMask, LayerState};
use groundwave_protocol::telemetry::{
    AbilitiesLine, Ack, AckLine, Body, CountersLine, Detail, FieldLine, FirmwareVersion,
    LayerStates, Line, ListPlace, Note, Outcome, ParameterLine, ParameterName, Printable, SongLine,
    StateLine, StatusLine, TextLine, ValuesLine,
};

pub const ACK: Ack = Ack {
    boot: 4,
    session: 2,
    sequence: 5,
    outcome: Outcome::Done,
    detail: Detail::Idle {
        owner: 0x2A5,
        robot_id: 7,
    },
};

pub const STAGING: Ack = Ack {
    detail: Detail::Staging {
        first_missing: 3,
        tag: 1,
        window: 0b1010_0101,
    },
    ..ACK
};

pub fn encode(sequence: u8, body: Body) -> Vec<u8> {
    let line = Line {
        sequence,
        body,
        ack: ACK,
    };
    line.encode().to_vec()
}

pub fn acknowledge(sequence: u8, ack: Ack) -> Vec<u8> {
    let line = AckLine {
        sequence,
        ack,
        listens: false,
    };
    line.encode().to_vec()
}

/// The line G with the same content.
pub fn go_ahead(sequence: u8, ack: Ack) -> Vec<u8> {
    let line = AckLine {
        sequence,
        ack,
        listens: true,
    };
    line.encode().to_vec()
}

pub fn state() -> StateLine {
    let mut layers = LayerStates::OFF;
    for (layer, state) in [
        (Layer::Bumpers, LayerState::Quiet),
        (Layer::Rotation, LayerState::Quiet),
        (Layer::Infrared, LayerState::Holds),
        (Layer::Sonar, LayerState::Raised),
        (Layer::DeadReckoning, LayerState::Raised),
    ] {
        layers.set(layer, state);
    }
    StateLine {
        x_tenths_in: 1234,
        y_tenths_in: -450,
        theta_deg: 273,
        velocity_in_s: 6,
        rotation_in_s: -12,
        wheel_left_in_s: 0,
        wheel_right_in_s: 12,
        sonar_left_in: Some(42),
        sonar_right_in: Some(120),
        photo_left_pct: Some(61),
        photo_right_pct: Some(48),
        infrared: Infrared::Right,
        layers,
        ..StateLine::BLANK
    }
}

pub fn status() -> StatusLine {
    StatusLine {
        robot_id: 7,
        battery_dv: 124,
        target_in: Some((120, -36)),
        list: ListPlace {
            driven: 3,
            count: 40,
        },
        digest: 0x1234_5678,
        max_count: 12,
        photo_left: Some(155),
        photo_right: Some(122),
        fitted: LayerMask::from_bits(0b1001_1011),
        allowed: LayerMask::from_bits(0b1000_1011),
        boots: 4,
        odometer_resets: 0,
    }
}

pub fn counters() -> CountersLine {
    CountersLine {
        robot_id: 7,
        uptime_s: 412,
        boots: 4,
        version: FirmwareVersion { major: 1, minor: 0 },
        ticks_won: [0, 210, 0, 733, 1250, 0, 0, 0, 3905],
        frames_heard: 133,
        frames_rejected: 2,
        ticks_late: 0,
        bumps: 12,
        failsafe: None,
    }
}

pub fn text(sequence: u8, words: &str) -> Vec<u8> {
    encode(sequence, Body::Text(TextLine::new(words)))
}

pub fn parameter() -> ParameterLine {
    ParameterLine {
        place: 1,
        count: 26,
        name: ParameterName::new("top-speed"),
        value: 8,
        kept: 12,
        least: 2,
        most: 12,
        unit: Printable::new("in/s"),
    }
}

pub fn song() -> SongLine {
    let notes = [(523, 4), (659, 4), (784, 4), (1047, 8), (0, 2), (523, 16)];
    SongLine::new(notes.map(|(hz, ticks)| Note { hz, ticks }))
}

pub fn abilities() -> AbilitiesLine {
    AbilitiesLine {
        robot_id: 7,
        level: 3,
        capacity: 40,
        modes: 0b1011,
        measured: 0b0101,
        rate_bytes_per_s: 240,
        fields: 2,
    }
}

pub fn field() -> FieldLine {
    FieldLine {
        place: 1,
        count: 2,
        name: ParameterName::new("motor-current"),
        decimals: 2,
        unit: Printable::new("A"),
    }
}

pub fn values() -> ValuesLine {
    ValuesLine::new([Some(125), Some(-7)])
}

/// Overwrites columns of a line and computes its checksum again.
pub fn altered(mut line: Vec<u8>, column: usize, characters: &[u8]) -> Vec<u8> {
    line[column - 1..column - 1 + characters.len()].copy_from_slice(characters);
    let content = line.len() - 6;
    let remainder = crc::update(crc::DOWNLINK_INIT, &line[..content]);
    line[content..content + 4].copy_from_slice(&crc::characters(remainder));
    line
}
