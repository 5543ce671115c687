//! Handmade streams: lines of every type, with and without noise.
#![allow(
    dead_code,
    reason = "each of those who include this needs a part of it"
)]

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::status_codes::{Arm, Bump, Infrared, Layer, LayerMask, LayerState};
use groundwave_protocol::telemetry::{
    Ack, AckLine, Body, CountersLine, Detail, FirmwareVersion, LayerStates, Line, ListPlace,
    Outcome, StateLine, StatusLine, TextLine,
};

/// A small random generator with fixed values.
pub struct Rng(pub u64);

impl Rng {
    pub fn below(&mut self, end: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % end
    }
}

/// The lines of `slots` slots: five lines A, then B, C or T.
pub fn lines(slots: u32) -> Vec<u8> {
    send(slots, false)
}

/// [`lines`] with a line K after every tenth.
pub fn clean(slots: u32) -> Vec<u8> {
    send(slots, true)
}

fn send(slots: u32, with_acks: bool) -> Vec<u8> {
    let mut stream = Vec::new();
    let mut sequence = 0;
    for slot in 0..slots {
        let line = Line {
            sequence,
            body: match (slot % 6, slot / 6 % 3) {
                (5, 0) => Body::Counters(counters(slot)),
                (5, 1) => Body::Status(status(slot)),
                (5, _) => Body::Text(TextLine::new("door, \"left\" ajar")),
                _ => Body::State(state(slot)),
            },
            ack: ack(slot, sequence),
        };
        stream.extend(line.encode());
        sequence = (sequence + 1) % 100;
        if with_acks && slot % 10 == 9 {
            let line = AckLine {
                sequence,
                ack: ack(slot, sequence),
                listens: false,
            };
            stream.extend(line.encode());
            sequence = (sequence + 1) % 100;
        }
    }
    stream
}

/// [`clean`] after a bad radio: flipped bits, lost and added bytes.
pub fn noisy(slots: u32, seed: u64) -> Vec<u8> {
    let mut rng = Rng(seed);
    let mut stream = Vec::new();
    for byte in clean(slots) {
        match rng.below(2000) {
            0 => {}
            1 => stream.extend([byte, rng.below(256) as u8]),
            2..=4 => stream.push(byte ^ 1 << rng.below(8)),
            _ => stream.push(byte),
        }
    }
    stream
}

/// The lines and counters that the live decoder finds in a stream.
pub fn live(stream: &[u8]) -> (Vec<Received>, Counters) {
    let mut decoder = Decoder::default();
    let lines = decoder.lines(stream).collect();
    (lines, *decoder.counters())
}

fn ack(slot: u32, line_sequence: u8) -> Ack {
    Ack {
        boot: 4,
        session: 1,
        sequence: (slot / 20 % 8) as u8,
        outcome: if slot % 40 < 20 {
            Outcome::Done
        } else {
            Outcome::ListIncomplete
        },
        detail: if line_sequence % 3 == 1 {
            Detail::Era { era: 510 }
        } else if slot % 30 < 20 {
            Detail::Idle {
                owner: 789,
                robot_id: 7,
            }
        } else {
            Detail::Staging {
                first_missing: 3,
                tag: 2,
                window: 0b1_0110,
            }
        },
    }
}

fn state(slot: u32) -> StateLine {
    let mut layers = LayerStates::OFF;
    layers.set(Layer::Bumpers, LayerState::Quiet);
    layers.set(Layer::Sonar, LayerState::Raised);
    let bump = if slot % 60 == 20 {
        Bump::LeftCenter
    } else {
        Bump::None
    };
    if bump != Bump::None {
        layers.set(Layer::Bumpers, LayerState::Holds);
    }
    StateLine {
        x_tenths_in: slot as i32 * 35 - 400,
        y_tenths_in: -450,
        theta_deg: (slot * 7 % 360) as u16,
        velocity_in_s: 12,
        rotation_in_s: -6,
        wheel_left_in_s: 9,
        wheel_right_in_s: 15,
        sonar_left_in: (!slot.is_multiple_of(4)).then_some(42),
        sonar_right_in: Some(120),
        photo_left_pct: Some(61),
        bump,
        infrared: Infrared::Right,
        arm: Arm::Stowed,
        layers,
        ..StateLine::BLANK
    }
}

fn status(slot: u32) -> StatusLine {
    StatusLine {
        robot_id: 7,
        battery_dv: 126 - (slot / 100) as u16,
        target_in: (slot % 36 == 11).then_some((120, -36)),
        list: ListPlace {
            driven: 3,
            count: 40,
        },
        digest: 0xCBF4_3926,
        max_count: 12,
        photo_left: Some(155),
        photo_right: None,
        fitted: LayerMask::from_bits(0b1001_1011),
        allowed: LayerMask::from_bits(0b1000_1011),
        boots: 4,
        odometer_resets: 1,
    }
}

fn counters(slot: u32) -> CountersLine {
    let ticks = |share: u32| (slot * 20 / 3 * share / 10 % 4096) as u16;
    CountersLine {
        robot_id: 7,
        uptime_s: 100 + slot / 3,
        boots: 4,
        version: FirmwareVersion { major: 1, minor: 2 },
        ticks_won: [0, ticks(1), 0, 0, ticks(3), 0, 0, 0, ticks(6)],
        frames_heard: 12,
        frames_rejected: 1,
        ticks_late: 0,
        bumps: (slot / 60) as u16,
        failsafe: None,
    }
}
