//! Recordings by other writers: messages outside of chunks, chunks with another compression, two recordings merged.

use crate::streams;
use std::fs;
use std::io::Cursor;
use std::time::Duration;

use crate::recordings::{chunks, concatenated, finished, messages};
use groundwave::capture::Capture;
use groundwave::capture::cut::{Window, cut_mcap};
use groundwave::capture::recover::{Outcome, recover};
use groundwave::capture::when::When;
use mcap::records::op;
use tempfile::TempDir;

/// The same messages without chunks.
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

/// The records of the data section without indexes; `change` returns the replacement of each chunk.
fn changed(recording: &[u8], mut change: impl FnMut(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut output = mcap::MAGIC.to_vec();
    let mut at = output.len();
    loop {
        let length = u64::from_le_bytes(recording[at + 1..at + 9].try_into().unwrap());
        let record = &recording[at..at + 9 + usize::try_from(length).unwrap()];
        at += record.len();
        match record[0] {
            op::DATA_END => return output,
            op::MESSAGE_INDEX => {}
            op::CHUNK => output.extend(change(record)),
            _ => output.extend(record),
        }
    }
}

/// Offset of the compression in a chunk: after two times, the size and the checksum.
const COMPRESSION_AT: usize = 9 + 8 + 8 + 8 + 4;

/// The recording with every second chunk replaced by its records.
fn mixed(recording: &[u8]) -> Vec<u8> {
    let mut chunks = 0;
    changed(recording, |chunk| {
        chunks += 1;
        if chunks % 2 == 1 {
            return chunk.to_vec();
        }
        let (_zstd_and_length, content) = chunk[COMPRESSION_AT..].split_at(8 + 8);
        zstd::decode_all(content).unwrap()
    })
}

/// The recording with LZ4 compression declared in every chunk.
fn lz4(recording: &[u8]) -> Vec<u8> {
    changed(recording, |chunk| {
        let length = chunk.len() as u64 - 9 - 1;
        let (head, rest) = (&chunk[9..COMPRESSION_AT], &chunk[COMPRESSION_AT + 8..]);
        let length = length.to_le_bytes();
        [&[op::CHUNK], &length[..], head, &[3, 0, 0, 0], b"lz4", rest].concat()
    })
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
        assert!(recovery.messages >= before, "{tenths} tenths");
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

#[test]
fn another_compression_is_not_called_damage() {
    let folder = TempDir::new().unwrap();
    let whole = finished(folder.path(), &streams::clean(60));
    let bytes = lz4(&fs::read(&whole).unwrap());
    let path = folder.path().join("lz4.mcap");
    fs::write(&path, &bytes).unwrap();
    let error = recover(&path).unwrap_err().to_string();
    assert!(error.contains("mcap compress"), "{error}");
    assert!(fs::read(&path).unwrap() == bytes, "it is left as it was");
    let mut capture = Capture::open(&path).unwrap();
    let error = loop {
        match capture.next_chunk() {
            Ok(Some(_)) => {}
            Ok(None) => panic!("nothing is said"),
            Err(error) => break error.to_string(),
        }
    };
    assert!(
        error.contains("mcap compress") && !error.contains("damaged"),
        "{error}"
    );
}

/// The same messages in chunks of another writer, which declares channels in the first chunk that needs them, under
/// other numbers than ours.
fn rewritten(recording: &[u8], library: &str) -> Vec<u8> {
    let mut output = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new()
        .library(library)
        .chunk_size(Some(16 << 10));
    let mut writer = options.create(&mut output).unwrap();
    for message in mcap::MessageStream::new(recording).unwrap() {
        writer.write(&message.unwrap()).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    output.into_inner()
}

/// A message with a damaged channel number is skipped; others are kept.
#[test]
fn a_message_of_no_channel_is_left_out() {
    let folder = TempDir::new().unwrap();
    let whole = fs::read(finished(folder.path(), &streams::clean(60))).unwrap();
    let mut bytes = unchunked(&whole);
    let count = mcap::MessageStream::new(&bytes).unwrap().count() as u64;
    let mut at = mcap::MAGIC.len();
    let mut messages_left = 100;
    while messages_left > 0 {
        messages_left -= u64::from(bytes[at] == op::MESSAGE);
        if messages_left > 0 {
            let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
            at += 9 + usize::try_from(length).unwrap();
        }
    }
    bytes[at + 10] ^= 0x40;
    let path = folder.path().join("unchunked.mcap");
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert!(recovery.messages + 1 >= count, "{recovery:?}");
    assert!(recovery.original.is_some());
    messages(&path);
}

/// The summary repeats the channels of the first chunk.
#[test]
fn channels_of_a_damaged_chunk_are_taken_from_the_summary() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let whole = fs::read(finished(folder.path(), &stream)).unwrap();
    let all = messages(&folder.path().join("finished.mcap"));
    let path = folder.path().join("rewritten.mcap");
    let mut bytes = rewritten(&whole, "another");
    fs::write(&path, &bytes).unwrap();
    let (start, length) = chunks(&path)[0];
    bytes[start + length / 2] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert!(recovery.rx_bytes > stream.len() as u64 / 2, "{recovery:?}");
    let bytes_missing: u64 = recovery.rx_missing.iter().map(|m| m.bytes).sum();
    assert_eq!(recovery.rx_bytes + bytes_missing, stream.len() as u64);
    let saved = messages(&path);
    for topic in ["/telemetry", "/tf", "/pose", "/sonar", "/raw/tx"] {
        assert!(all[topic].ends_with(&saved[topic]), "{topic}");
    }
    assert!(stream.ends_with(&concatenated(&path)));
}

/// Messages on channels that are no longer declared are skipped and counted.
#[test]
fn messages_without_a_channel_are_reported() {
    let folder = TempDir::new().unwrap();
    let whole = fs::read(finished(folder.path(), &streams::clean(300))).unwrap();
    let path = folder.path().join("rewritten.mcap");
    let mut bytes = rewritten(&whole, "another");
    fs::write(&path, &bytes).unwrap();
    let chunks = chunks(&path);
    let (start, length) = chunks[0];
    bytes[start + length / 2] ^= 1;
    let (start, length) = chunks.last().unwrap();
    bytes.truncate(start + length);
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Partly);
    assert!(recovery.nameless > 100, "{recovery:?}");
    assert!(fs::read(recovery.original.unwrap()).unwrap() == bytes);
}

/// Topics have the same channel numbers in every version of Groundwave.
#[test]
fn channels_of_another_version_need_not_be_readable() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let path = finished(folder.path(), &stream);
    let mut bytes = fs::read(&path).unwrap();
    let chunks = chunks(&path);
    let version = b"groundwave 0.";
    let at = bytes.windows(version.len()).position(|it| it == version);
    bytes[at.unwrap() + version.len()] = b'0';
    bytes[chunks[0].0 + chunks[0].1 / 2] ^= 1;
    let (start, length) = chunks.last().unwrap();
    bytes.truncate(start + length);
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert!(recovery.rx_bytes > stream.len() as u64 / 2, "{recovery:?}");
    assert!(stream.ends_with(&concatenated(&path)));
}

/// A file without its first bytes is read as a recording of ours.
#[test]
fn a_file_without_its_beginning_is_taken_for_ours() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let path = finished(folder.path(), &stream);
    let mut bytes = fs::read(&path).unwrap();
    let chunks = chunks(&path);
    bytes[..chunks[1].0 - 1].fill(0);
    let (start, length) = chunks.last().unwrap();
    bytes.truncate(start + length);
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    assert!(recovery.rx_bytes > stream.len() as u64 / 2, "{recovery:?}");
    assert!(stream.ends_with(&concatenated(&path)));
}

/// The messages of a recording and of another one that began ten seconds later, in order of time, as `mcap merge`
/// writes them.
fn merged(recording: &[u8]) -> Vec<u8> {
    let once = mcap::MessageStream::new(recording).unwrap();
    let mut all: Vec<mcap::Message<'_>> = once.map(Result::unwrap).collect();
    let later = all.clone().into_iter().map(|mut message| {
        message.log_time += 10_000_000_000;
        message
    });
    all.extend(later.collect::<Vec<_>>());
    all.sort_by_key(|message| message.log_time);
    let mut output = Cursor::new(Vec::new());
    let options = mcap::WriteOptions::new().chunk_size(Some(16 << 10));
    let mut writer = options.create(&mut output).unwrap();
    for message in &all {
        writer.write(message).unwrap();
    }
    writer.finish().unwrap();
    drop(writer);
    output.into_inner()
}

#[test]
fn bytes_that_come_twice_are_counted_once() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let whole = finished(folder.path(), &stream);
    let mut bytes = merged(&fs::read(&whole).unwrap());
    let path = folder.path().join("merged.mcap");
    fs::write(&path, &bytes).unwrap();
    let length = stream.len() as u64;
    let recovery = recover(&path).unwrap();
    assert_eq!(recovery.outcome, Outcome::Whole);
    assert_eq!((recovery.rx_bytes, recovery.rx_missing), (length, vec![]));
    let chunks = chunks(&path);
    let (start, chunk_length) = chunks[chunks.len() / 2];
    bytes[start + chunk_length / 2] ^= 1;
    fs::write(&path, &bytes).unwrap();
    let recovery = recover(&path).unwrap();
    let missing: u64 = recovery.rx_missing.iter().map(|m| m.bytes).sum();
    assert_eq!(recovery.rx_bytes + missing, length, "{recovery:?}");
}

#[test]
fn bytes_that_come_twice_are_named_and_cut_out_once() {
    let folder = TempDir::new().unwrap();
    let stream = streams::clean(300);
    let whole = finished(folder.path(), &stream);
    let bytes = merged(&fs::read(&whole).unwrap());
    let window = Window {
        from: Some(When::Since(Duration::from_secs(10))),
        to: None,
    };
    let mut piece = Vec::new();
    let part = cut_mcap(&bytes[..], window, &mut piece).unwrap();
    let problem = part.problem.unwrap();
    assert!(problem.contains("/raw/rx: the bytes at"), "{problem}");
    assert!(problem.contains("are repeated"), "{problem}");
    let path = folder.path().join("piece.mcap");
    fs::write(&path, piece).unwrap();
    let cut = concatenated(&path);
    assert!(!cut.is_empty() && stream.ends_with(&cut));
}
