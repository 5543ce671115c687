//! A line of every type, and ways to damage it.
#![allow(dead_code, reason = "an example uses a part of it")]

use std::fs;

use groundwave_protocol::crc;
use groundwave_protocol::decoder::Received;
use groundwave_protocol::telemetry::{AckLine, LineType};
use serde_json::Value;

/// First seed of the sampled flips, fixed so that a failure repeats.
pub fn seed() -> u64 {
    0x1998_0804
}

/// A small random generator, `SplitMix64`.
pub struct Rng(pub u64);

impl Rng {
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

    /// Distinct numbers below a limit.
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
    pub name: String,
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

    /// Computes the checksum again.
    pub fn seal(&mut self) {
        let content = self.bytes.len() - 6;
        let remainder = crc::update(crc::DOWNLINK_INIT, &self.bytes[..content]);
        self.bytes[content..content + 4].copy_from_slice(&crc::characters(remainder));
    }
}

/// The bytes of a line.
pub fn bytes_of(received: &Received) -> Vec<u8> {
    match received {
        Received::Line(_, bytes) => bytes.to_vec(),
        Received::Ack(line) => line.encode().to_vec(),
    }
}

/// The first line of each type among the golden vectors.
pub fn samples() -> Vec<Sample> {
    let types = LineType::ALL.iter().map(|line_type| line_type.letter());
    types.chain(AckLine::LETTERS).map(sample).collect()
}

/// The golden vectors of lines, from all their files.
pub fn vectors() -> Vec<Value> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/vectors");
    let files = fs::read_dir(folder).unwrap_or_else(|e| panic!("cannot read {folder}: {e}"));
    let mut paths: Vec<_> = files.flatten().map(|file| file.path()).collect();
    paths.sort();
    paths
        .iter()
        .filter(|path| {
            path.file_name()
                .is_some_and(|name| name.as_encoded_bytes().starts_with(b"lines"))
        })
        .flat_map(fs::read_to_string)
        .flat_map(|text| text.lines().map(serde_json::from_str).collect::<Vec<_>>())
        .flatten()
        .collect()
}

/// The first line with this letter among the golden vectors.
pub fn sample(letter: u8) -> Sample {
    let letter = char::from(letter);
    let line = vectors()
        .into_iter()
        .find(|vector| vector["fields"]["type"] == letter.to_string())
        .and_then(|vector| Some(vector["line"].as_str()?.to_owned()));
    let mut sample = Sample {
        name: format!("line {letter}"),
        bytes: line.unwrap_or_else(|| panic!("no line {letter}")).into(),
    };
    // Other tests compare the checksums of the vectors.
    sample.seal();
    sample
}
