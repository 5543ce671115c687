//! A pool of good lines of all types.

use crate::damage::{Rng, Sample, bytes_of, vectors};
use groundwave_protocol::LINE_BYTES;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::sixbit;
use groundwave_protocol::telemetry::{
    ACK_LINE_BYTES, Ack, AckLine, Body, Line, LineType, Note, ParameterLine, SEQUENCE_MODULUS,
    SONG_NOTES, SongLine, StateLine, TextLine,
};
use serde_json::Value;

/// Number of lines of each type.
const LINES_OF_A_TYPE: usize = 2048;

/// A good line.
pub struct Sent {
    bytes: [u8; LINE_BYTES],
    length: usize,
}

pub struct Pool(Vec<Sent>);

impl Pool {
    /// Lines of all types in equal numbers: bodies of the golden vectors with varied sequences,
    /// acknowledgements, poses, speeds and texts.
    pub fn new(rng: &mut Rng) -> Self {
        let bodies = bodies();
        let mut lines = Vec::new();
        for line_type in LineType::ALL {
            let of_type: Vec<&Body> = bodies
                .iter()
                .filter(|body| body.line_type() == *line_type)
                .collect();
            for _ in 0..LINES_OF_A_TYPE {
                let line = Line {
                    sequence: rng.below(SEQUENCE_MODULUS.into()) as u8,
                    body: varied(of_type[rng.below(of_type.len())], rng),
                    ack: ack(rng),
                };
                lines.push(Sent::new(&line.encode()));
            }
        }
        for _ in 0..LINES_OF_A_TYPE {
            let line = AckLine {
                sequence: rng.below(SEQUENCE_MODULUS.into()) as u8,
                ack: ack(rng),
                listens: rng.next() & 1 == 1,
            };
            lines.push(Sent::new(&line.encode()));
        }
        Self(lines)
    }

    pub fn draw(&self, rng: &mut Rng) -> &Sent {
        &self.0[rng.below(self.0.len())]
    }
}

/// The bodies of the good lines among the golden vectors.
fn bodies() -> Vec<Body> {
    let body = |vector: Value| {
        let line = vector["line"].as_str()?.as_bytes();
        match Decoder::default().lines(line).next() {
            Some(Received::Line(line, _)) => Some(line.body),
            _ => None,
        }
    };
    vectors().into_iter().filter_map(body).collect()
}

fn varied(body: &Body, rng: &mut Rng) -> Body {
    match body {
        Body::State(state) => Body::State(StateLine {
            x_tenths_in: rng.below(19_999) as i32 - 9999,
            y_tenths_in: rng.below(19_999) as i32 - 9999,
            theta_deg: rng.below(360) as u16,
            velocity_in_s: rng.below(25) as i8 - 12,
            wheel_left_in_s: rng.below(25) as i8 - 12,
            wheel_right_in_s: rng.below(25) as i8 - 12,
            ..*state
        }),
        Body::Text(_) => {
            let words: String = (0..rng.below(65))
                .map(|_| char::from(b' ' + rng.below(95) as u8))
                .collect();
            Body::Text(TextLine::new(&words))
        }
        Body::Song(_) => {
            let notes = (0..=rng.below(SONG_NOTES)).map(|_| Note {
                hz: rng.below(4096) as u16,
                ticks: 1 + rng.below(63) as u8,
            });
            Body::Song(SongLine::new(notes))
        }
        Body::Parameter(parameter) => Body::Parameter(ParameterLine {
            value: rng.below(199_999) as i32 - 99_999,
            kept: rng.below(199_999) as i32 - 99_999,
            ..*parameter
        }),
        Body::Status(_)
        | Body::Counters(_)
        | Body::Abilities(_)
        | Body::Field(_)
        | Body::Values(_) => *body,
    }
}

fn ack(rng: &mut Rng) -> Ack {
    let characters = [(); 5].map(|()| sixbit::encode(rng.below(64) as u8));
    Ack::decode(characters).unwrap_or_default()
}

impl Sent {
    fn new(line: &[u8]) -> Self {
        let mut bytes = [0; LINE_BYTES];
        bytes[..line.len()].copy_from_slice(line);
        Self {
            bytes,
            length: line.len(),
        }
    }

    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Whether `received` is this line.
    pub fn is(&self, received: &Received) -> bool {
        bytes_of(received) == self.as_bytes()
    }

    /// Number of bits that differ; `None` if the length differs.
    pub fn flips_to(&self, damaged: &[u8]) -> Option<u32> {
        let pairs = self.as_bytes().iter().zip(damaged);
        (damaged.len() == self.length).then(|| pairs.map(|(a, b)| (a ^ b).count_ones()).sum())
    }

    /// Whether the end of these bytes would be a readable line with a new checksum.
    pub fn is_readable_when_sealed(bytes: &[u8]) -> bool {
        [LINE_BYTES, ACK_LINE_BYTES].into_iter().any(|length| {
            bytes.len().checked_sub(length).is_some_and(|start| {
                let mut line = Sample {
                    name: String::new(),
                    bytes: bytes[start..].to_vec(),
                };
                line.seal();
                Decoder::default().lines(&line.bytes).next().is_some()
            })
        })
    }
}
