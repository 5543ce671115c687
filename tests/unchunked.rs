//! Recordings of other writers, whose messages stand outside of chunks.
#![expect(clippy::unwrap_used, reason = "a test stops where something is wrong")]

mod recordings;
mod streams;

use std::fs;
use std::io::Cursor;

use groundwave::capture::recover::{Outcome, recover};
use recordings::{concatenated, finished, messages};
use tempfile::TempDir;

/// The same messages as others write them without chunks.
fn unchunked(recording: &[u8]) -> Vec<u8> {
    let mut output = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().use_chunks(false);
    let mut writer = options.create(&mut output).unwrap();
    for message in mcap::MessageStream::new(recording).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    output.into_inner()
}

/// The same recording, every second chunk of which has become what is in it; without an end.
fn mixed(recording: &[u8]) -> Vec<u8> {
    let mut output = mcap::MAGIC.to_vec();
    let mut at = output.len();
    let mut chunks = 0;
    loop {
        let (opcode, length) = (recording[at], &recording[at + 1..at + 9]);
        let length = usize::try_from(u64::from_le_bytes(length.try_into().unwrap())).unwrap();
        let (record, body) = (&recording[at..at + 9 + length], at + 9);
        at += record.len();
        match opcode {
            mcap::records::op::DATA_END => return output,
            mcap::records::op::MESSAGE_INDEX => continue,
            mcap::records::op::CHUNK => chunks += 1,
            _ => {}
        }
        if opcode == mcap::records::op::CHUNK && chunks % 2 == 0 {
            // Two times, size, checksum, "zstd" and the length of what follows.
            let content = &recording[body + 8 + 8 + 8 + 4 + 8 + 8..at];
            output.extend(zstd::decode_all(content).unwrap());
        } else {
            output.extend(record);
        }
    }
}

#[test]
fn messages_without_chunks_are_whole_and_a_cut_costs_what_was_behind_it() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let whole = finished(folder.path(), &stream);
    let all = messages(&whole);
    let count = all.values().map(Vec::len).sum::<usize>() as u64;
    let bytes = unchunked(&fs::read(&whole).unwrap());
    let path = folder.path().join("unchunked.mcap");
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Whole);
    assert_eq!(
        (recovery.messages, recovery.rx_bytes),
        (count, stream.len() as u64)
    );
    for tenths in 3..10 {
        let cut = bytes.len() * tenths / 10;
        fs::write(&path, &bytes[..cut]).unwrap();
        let before = mcap::MessageStream::new_with_options(
            &bytes[..cut],
            mcap::read::Options::IgnoreEndMagic.into(),
        )
        .unwrap()
        .map_while(Result::ok)
        .count() as u64;
        let recovery = recover(&path).unwrap();
        assert_eq!(recovery.messages, before, "{tenths} tenths");
        for (topic, saved) in messages(&path) {
            assert!(all[&topic].starts_with(&saved), "{topic}, {tenths} tenths");
        }
        assert!(stream.starts_with(&concatenated(&path)));
    }
}

#[test]
fn messages_between_chunks_are_kept_in_their_order() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let whole = finished(folder.path(), &stream);
    let all = messages(&whole);
    let bytes = mixed(&fs::read(&whole).unwrap());
    let path = folder.path().join("mixed.mcap");
    fs::write(&path, bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert!(recovery.rx_missing.is_empty(), "{recovery:?}");
    assert!(messages(&path) == all);
    assert_eq!(concatenated(&path), stream);
}
