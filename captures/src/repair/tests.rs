//! Damage to unfinished recordings, which have no chunks.

use std::collections::BTreeMap;
use std::io::Cursor;

use ::mcap::records::MessageHeader;
use proptest::prelude::*;
use prost::Message as _;

use super::*;
use crate::messages::RawBytes;

const MESSAGES: u64 = 200;

/// A file with messages of 80 bytes.
fn written(options: ::mcap::WriteOptions) -> Vec<u8> {
    let mut writer = options.create(Cursor::new(Vec::new())).unwrap();
    let schema = writer.add_schema("Bytes", "protobuf", b"text").unwrap();
    let table = BTreeMap::new();
    let channel_id = writer
        .add_channel(schema, "/raw/rx", "protobuf", &table)
        .unwrap();
    for number in 0..MESSAGES {
        let data = RawBytes {
            stream_offset: number * 80,
            data: vec![b'A' + (number % 26) as u8; 80],
        };
        let header = MessageHeader {
            channel_id,
            sequence: number as u32,
            log_time: 1_700_000_000_000_000_000 + number * 333_000_000,
            publish_time: 1_700_000_000_000_000_000,
        };
        writer
            .write_to_known_channel(&header, &data.encode_to_vec())
            .unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

/// An unfinished file, with the beginning and end of each message.
fn unfinished() -> (Vec<u8>, Vec<(usize, usize)>) {
    let options = ::mcap::WriteOptions::new()
        .use_chunks(false)
        .compression(None)
        .emit_summary_records(false);
    let mut bytes = written(options);
    let mut messages = Vec::new();
    let mut at = MAGIC.len();
    while let Some((opcode, length)) = head(&bytes[at..]) {
        let end = at + HEAD_BYTES + length;
        match opcode {
            op::MESSAGE => messages.push((at, end)),
            op::DATA_END => break,
            _ => {}
        }
        at = end;
    }
    // Nothing follows the last message.
    bytes.truncate(at);
    (bytes, messages)
}

/// Numbers of the messages read, and the damage found.
fn read(bytes: &[u8]) -> (Vec<u32>, Vec<Damage>) {
    let mut reader = RepairingReader::new(bytes);
    let (mut numbers, mut damages) = (Vec::new(), Vec::new());
    while let Some(part) = reader.next_part().unwrap() {
        match part {
            Part::Record { opcode, body } if opcode == op::MESSAGE => {
                numbers.push(u32::from_le_bytes(body[2..6].try_into().unwrap()));
            }
            Part::Record { .. } => {}
            Part::Damage(damage) => damages.push(damage),
        }
    }
    (numbers, damages)
}

#[test]
fn a_cut_costs_no_whole_message_before_it() {
    let (bytes, messages) = unfinished();
    for cut in (messages[0].0..bytes.len()).step_by(7) {
        let whole = messages.iter().filter(|(_, end)| *end <= cut).count() as u32;
        let (numbers, damages) = read(&bytes[..cut]);
        assert_eq!(numbers, (0..whole).collect::<Vec<_>>(), "cut at {cut}");
        assert_eq!(damages, [], "cut at {cut}");
    }
}

#[test]
fn long_damage_is_returned_in_parts() {
    const GARBAGE: usize = 20 << 20;
    let (bytes, messages) = unfinished();
    let (begin, end) = bytes.split_at(messages[100].0);
    let (numbers, damages) = read(&[begin, &vec![0; GARBAGE], end].concat());
    assert_eq!(numbers, (0..MESSAGES as u32).collect::<Vec<_>>());
    assert_eq!(damages.len(), 3, "{damages:?}");
    let mut at = begin.len() as u64;
    for damage in damages {
        assert_eq!(damage.offset, at);
        assert!(damage.bytes <= SEARCH_BYTES_MAX + 1);
        at += damage.bytes;
    }
    assert_eq!(at, (begin.len() + GARBAGE) as u64);
}

proptest! {
    /// A flipped bit in the length of a message costs that message alone.
    #[test]
    fn a_damaged_length_costs_its_message_and_is_named(
        number in 0..MESSAGES as usize - 8,
        bit in 0..64_usize,
    ) {
        let (mut bytes, messages) = unfinished();
        bytes[messages[number].0 + 1 + bit / 8] ^= 1 << (bit % 8);
        let (numbers, damages) = read(&bytes);
        let lost = MESSAGES as usize - numbers.len();
        prop_assert!(lost <= 1, "{lost} lost of bit {bit}: {damages:?}");
        prop_assert_eq!(damages.len(), 1);
        prop_assert!(damages[0].offset == messages[number].0 as u64);
    }

    /// Reading resumed at any position gives the same records.
    #[test]
    fn reading_resumes_at_each_position(stop in 0..MESSAGES as usize) {
        let (bytes, _) = unfinished();
        let mut reader = RepairingReader::new(&bytes[..]);
        for _ in 0..stop {
            reader.next_part().unwrap();
        }
        let position = reader.position();
        let rest = &bytes[position.offset as usize..];
        let mut resumed = RepairingReader::resume(rest, position).unwrap();
        loop {
            let (one, other) = (reader.next_part().unwrap(), resumed.next_part().unwrap());
            prop_assert_eq!(format!("{one:?}"), format!("{other:?}"));
            if one.is_none() {
                break;
            }
        }
    }

    /// A flipped bit of a finished file costs at most the messages of one chunk, and is reported.
    #[test]
    fn a_flipped_bit_costs_at_most_a_chunk(place in 0.0..1.0_f64, bit in 0..8_u32) {
        const CHUNK_MESSAGES: usize = 20;
        let options = ::mcap::WriteOptions::new().chunk_size(Some(110 * CHUNK_MESSAGES as u64));
        let mut bytes = written(options);
        let at = (place * bytes.len() as f64) as usize;
        bytes[at] ^= 1 << bit;
        let (numbers, damages) = read(&bytes);
        let lost = MESSAGES as usize - numbers.len();
        prop_assert!(lost <= CHUNK_MESSAGES + 1, "{lost} lost at {at}: {damages:?}");
        prop_assert!(lost == 0 || !damages.is_empty(), "{lost} lost at {at}");
        prop_assert!(numbers.is_sorted_by(|one, next| one < next));
    }

    /// Reading ends after any damage.
    #[test]
    fn any_damage_is_read_to_the_end(
        is_chunked in any::<bool>(),
        changes in prop::collection::vec((0.0..1.0_f64, any::<u8>()), 1..40),
        cut in 0.0..1.0_f64,
    ) {
        let options = ::mcap::WriteOptions::new().use_chunks(is_chunked).chunk_size(Some(2000));
        let mut bytes = written(options);
        for (place, byte) in changes {
            let at = (place * bytes.len() as f64) as usize;
            bytes[at] = byte;
        }
        bytes.truncate(((1.0 - cut * cut) * bytes.len() as f64) as usize);
        let (numbers, _) = read(&bytes);
        prop_assert!(numbers.len() <= MESSAGES as usize);
    }
}
