//! Writes the golden vectors to `vectors/`. A change there is a change of the protocol: review it before you
//! commit it. `tests/vectors.rs` fails while code and vectors differ.

mod conversation;
mod describe;
mod judge;
mod lines;
mod parameters;
mod samples;
mod sessions;
mod streams;
mod uplink;

use serde_json::Value;

fn main() -> std::io::Result<()> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/vectors");
    std::fs::create_dir_all(folder)?;
    for (name, vectors) in all() {
        let lines: Vec<_> = vectors.iter().map(|vector| format!("{vector}\n")).collect();
        std::fs::write(format!("{folder}/{name}.jsonl"), lines.concat())?;
        println!("{name}.jsonl: {} vectors", vectors.len());
    }
    Ok(())
}

/// The files by name.
fn all() -> [(&'static str, Vec<Value>); 11] {
    [
        ("lines", lines::lines()),
        ("streams", streams::streams()),
        ("checksums", streams::checksums()),
        ("frames", uplink::frames()),
        ("digests", uplink::digests()),
        ("conversation", conversation::conversation()),
        ("lines-2", parameters::lines()),
        ("frames-2", parameters::frames()),
        ("lines-3", sessions::lines()),
        ("frames-3", sessions::frames()),
        ("conversation-2", conversation::sessions()),
    ]
}
