//! A line of every type, and ways to spoil it.
#![allow(dead_code, reason = "each test binary uses its own part")]

use groundwave_protocol::crc;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::letters::{
    Arm, Bump, Cliff, Drive, Infrared, Layer, LayerMask, LayerState, Link, Mode, Power,
};
use groundwave_protocol::telemetry::{
    Ack, AckLine, Body, CountersLine, Detail, FirmwareVersion, LayerStates, Line, ListPlace,
    Outcome, StateLine, StatusLine, TextLine,
};

/// Where the sampled flips begin. Fixed, so that a failure repeats; change it to look elsewhere.
pub fn seed() -> u64 {
    0x1998_0804
}

/// `SplitMix64`.
pub struct Dice(pub u64);

impl Dice {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit as u64) as usize
    }

    /// Different numbers below a limit.
    pub fn different(&mut self, count: usize, limit: usize) -> Vec<usize> {
        let mut chosen = Vec::new();
        while chosen.len() < count {
            let next = self.below(limit);
            if !chosen.contains(&next) {
                chosen.push(next);
            }
        }
        chosen
    }
}

/// An intact line.
#[derive(Clone, Debug)]
pub struct Sample {
    pub name: &'static str,
    pub bytes: Vec<u8>,
}

impl Sample {
    pub fn bits(&self) -> usize {
        self.bytes.len() * 8
    }

    pub fn flipped(&self, bits: &[usize]) -> Vec<u8> {
        let mut bytes = self.bytes.clone();
        for bit in bits {
            bytes[bit / 8] ^= 1 << (bit % 8);
        }
        bytes
    }

    /// Makes the checksum right again.
    pub fn seal(&mut self) {
        let content = self.bytes.len() - 6;
        let remainder = crc::update(crc::DOWNLINK_INIT, &self.bytes[..content]);
        self.bytes[content..content + 4].copy_from_slice(&crc::characters(remainder));
    }
}

/// The bytes a line was read from.
pub fn bytes_of(received: &Received) -> Vec<u8> {
    match received {
        Received::Line(_, bytes) => bytes.to_vec(),
        Received::Ack(line) => line.encode().to_vec(),
    }
}

/// One line of each type.
pub fn samples() -> Vec<Sample> {
    let ack = Ack {
        boot: 4,
        session: 2,
        sequence: 5,
        outcome: Outcome::NotFitted,
        detail: Detail::Idle {
            owner: 0x2A5,
            robot_id: 7,
        },
    };
    let staging = Ack {
        outcome: Outcome::Done,
        detail: Detail::Staging {
            first_missing: 3,
            tag: 1,
            window: 0b1010_0101,
        },
        ..ack
    };
    let line = |name, sequence, body| Sample {
        name,
        bytes: Line {
            sequence,
            body,
            ack,
        }
        .encode()
        .to_vec(),
    };
    vec![
        line("line A", 42, Body::State(state())),
        line("line B", 47, Body::Status(status())),
        line("line C", 53, Body::Counters(counters())),
        line(
            "line T",
            49,
            Body::Text(TextLine::new("I'm finished with the co-ordinate list")),
        ),
        Sample {
            name: "line K",
            bytes: AckLine {
                sequence: 43,
                ack: staging,
            }
            .encode()
            .to_vec(),
        },
    ]
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
        bump: Bump::None,
        infrared: Infrared::Right,
        cliff: Cliff::NotFitted,
        arm: Arm::NotFitted,
        drive: Drive::Ok,
        power: Power::Ok,
        link: Link::Ok,
        mode: Mode::Prowl,
        layers,
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
    }
}
