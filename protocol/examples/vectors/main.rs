//! Writes the golden vectors to `vectors/`. A change of the vectors is a change of the protocol; review it before you
//! commit it. `tests/vectors.rs` fails while code and vectors differ.
//!
//! New vectors go into a new file: write a module that makes them, and add a row in [`FILES`] and a row in SPEC.md section 15.

mod abilities;
pub(crate) mod conversation;
mod describe;
pub(crate) mod judge;
mod levels;
mod lines;
mod parameters_and_songs;
mod samples;
mod sessions;
mod streams;
pub(crate) mod transcript;
mod uplink;

use serde_json::Value;

/// A file: name, function that makes the vectors, and the CRC remainder of a final file (one that never changes again).
/// A file `KIND-N` contains more vectors of a kind; every check of the kind reads it, too.
pub type File = (&'static str, fn() -> Vec<Value>, Option<u32>);

/// All files.
pub const FILES: [File; 18] = [
    ("lines", lines::lines, Some(0x04_f606)),
    ("streams", streams::streams, Some(0x4e_ae2f)),
    ("checksums", streams::checksums, Some(0x63_11c8)),
    ("frames", uplink::frames, Some(0x2f_a611)),
    ("digests", uplink::digests, Some(0x06_81a3)),
    ("conversation", conversation::conversation, Some(0xc7_2bdc)),
    ("lines-2", parameters_and_songs::lines, None),
    ("frames-2", parameters_and_songs::frames, None),
    ("lines-3", sessions::lines, None),
    ("frames-3", sessions::frames, None),
    ("conversation-2", conversation::sessions, None),
    ("lines-4", levels::lines, None),
    ("lines-5", abilities::lines, None),
    ("level-1", || transcript::level(1), None),
    ("level-2", || transcript::level(2), None),
    ("level-3", || transcript::level(3), None),
    ("level-4", || transcript::level(4), None),
    ("level-5", || transcript::level(5), None),
];

#[allow(dead_code, reason = "the test that uses this file does not write")]
fn main() -> std::io::Result<()> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/vectors");
    std::fs::create_dir_all(folder)?;
    for (name, make, _) in FILES {
        let vectors = make();
        let lines: Vec<_> = vectors.iter().map(|vector| format!("{vector}\n")).collect();
        std::fs::write(format!("{folder}/{name}.jsonl"), lines.concat())?;
        println!("{name}.jsonl: {} vectors", vectors.len());
    }
    Ok(())
}
