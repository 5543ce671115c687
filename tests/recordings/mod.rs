//! Recordings made without a robot, and readers that use the `mcap` crate alone.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use groundwave::capture::messages::RawBytes;
use groundwave::capture::{Existing, Recorder, Session};
use groundwave::event::{CommandId, CommandStatus, Event};
use groundwave::recorded::to_recorded;
use groundwave::request::Request;
use mcap::sans_io::LinearReaderOptions;
use prost::Message;

pub const START_S: u64 = 1_741_944_413;

pub fn wall(now: Duration) -> SystemTime {
    UNIX_EPOCH + Duration::from_secs(START_S) + now
}

pub fn session() -> Session {
    Session {
        link: "/dev/ttyUSB0".into(),
        start: wall(Duration::ZERO),
        notes: BTreeMap::new(),
        configuration: "[link]\nbaud = 2400\n".into(),
    }
}

/// Feeds a stream at 240 bytes per second, with some commands.
pub fn feed(recorder: &mut Recorder, stream: &[u8]) -> Duration {
    let mut now = Duration::ZERO;
    for (n, read) in (0_u32..).zip(stream.chunks(33)) {
        now += Duration::from_millis(137);
        recorder.handle_rx(now, wall(now), read);
        if n % 97 == 50 {
            let id = CommandId(n);
            let (request, by) = (Request::Scan, None);
            let status = CommandStatus::Confirmed { digest: None };
            for event in [
                Event::Asked { id, request, by },
                Event::Command { id, status },
            ] {
                let event = to_recorded(now, &event).unwrap();
                recorder.handle_event(now, wall(now), &event);
            }
            recorder.handle_tx(now, wall(now), b"\nframe\n");
        }
    }
    now
}

pub fn finished(folder: &Path, stream: &[u8]) -> PathBuf {
    let path = folder.join("finished.mcap");
    let mut recorder = Recorder::start(&path, Existing::Refuse, &session()).unwrap();
    feed(&mut recorder, stream);
    recorder.finish().unwrap();
    path
}

/// The file that remains if the program is killed after this stream: a copy of a recording in progress.
pub fn killed(folder: &Path, stream: &[u8]) -> PathBuf {
    let live = folder.join("live.mcap");
    let mut recorder = Recorder::start(&live, Existing::Refuse, &session()).unwrap();
    feed(&mut recorder, stream);
    wait_until_written(&recorder);
    let killed = folder.join("killed.mcap");
    fs::copy(&live, &killed).unwrap();
    recorder.discard();
    assert!(!live.exists(), "something is left of a discarded recording");
    killed
}

/// Waits for the recorder's thread.
pub fn wait_until_written(recorder: &Recorder) {
    while recorder.unwritten_bytes() > 0 {
        std::thread::yield_now();
    }
}

/// Offset and length of every intact chunk, found by the `mcap` crate.
pub fn chunks(path: &Path) -> Vec<(usize, usize)> {
    let bytes = fs::read(path).unwrap();
    let mut reader = mcap::sans_io::LinearReader::new_with_options(
        LinearReaderOptions::default().with_emit_chunks(true),
    );
    let mut found = Vec::new();
    let mut at = mcap::MAGIC.len();
    let mut rest = &bytes[..];
    while let Some(event) = reader.next_event() {
        match event.unwrap() {
            mcap::sans_io::LinearReadEvent::ReadRequest(need) => {
                let have = need.min(rest.len());
                if have == 0 {
                    break;
                }
                reader.insert(have).copy_from_slice(&rest[..have]);
                reader.notify_read(have);
                rest = &rest[have..];
            }
            mcap::sans_io::LinearReadEvent::Record { data, opcode } => {
                if opcode == mcap::records::op::CHUNK {
                    found.push((at, data.len() + 9));
                }
                at += data.len() + 9;
            }
        }
    }
    found
}

/// All messages by topic, read by the `mcap` crate with every checksum; also checks index and statistics.
pub fn messages(path: &Path) -> BTreeMap<String, Vec<Vec<u8>>> {
    let bytes = fs::read(path).unwrap();
    let options = LinearReaderOptions::default()
        .with_prevalidate_chunk_crcs(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true);
    let mut messages = BTreeMap::<_, Vec<Vec<u8>>>::new();
    let mut count = 0;
    let mut last_ns = 0;
    for message in mcap::io::MessageReader::new_with_options(&bytes[..], options) {
        let message = message.unwrap();
        assert!(message.log_time >= last_ns, "time runs backwards");
        last_ns = message.log_time;
        messages
            .entry(message.channel.topic.clone())
            .or_default()
            .push(message.data.to_vec());
        count += 1;
    }
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let statistics = summary.stats.as_ref().unwrap();
    assert_eq!(statistics.message_count, count);
    assert_eq!(statistics.chunk_count as usize, summary.chunk_indexes.len());
    for (id, indexed) in &statistics.channel_message_counts {
        let streamed = messages
            .get(&summary.channels[id].topic)
            .map_or(0, Vec::len);
        assert_eq!(*indexed, streamed as u64, "channel {id}");
    }
    let mut indexed = 0;
    for chunk in &summary.chunk_indexes {
        indexed += summary.stream_chunk(&bytes, chunk).unwrap().count() as u64;
        for (channel_id, entries) in summary.read_message_indexes(&bytes, chunk).unwrap() {
            assert!(channel_id.id > 0 && !entries.is_empty());
        }
    }
    assert_eq!(indexed, count, "indexed and streamed");
    messages
}

/// The received bytes in pieces, each with its offset in the stream.
pub fn received(path: &Path) -> Vec<(u64, Vec<u8>)> {
    let messages = messages(path);
    let raw = messages.get("/raw/rx").cloned().unwrap_or_default();
    raw.iter()
        .map(|data| {
            let raw = RawBytes::decode(&**data).unwrap();
            (raw.stream_offset, raw.data)
        })
        .collect()
}

pub fn concatenated(path: &Path) -> Vec<u8> {
    received(path)
        .into_iter()
        .flat_map(|piece| piece.1)
        .collect()
}
