//! The code's result for a line, stream or frame, which the generator writes and the test compares.

use super::describe;
use groundwave_protocol::command::Key;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::receiver::Receiver;
use serde_json::{Value, json};

/// Result for a line: its `fields`, or its `error`.
pub fn line(bytes: &[u8]) -> Value {
    let mut decoder = Decoder::default();
    let received = decoder.lines(bytes).next();
    let counters = decoder.counters();
    match (received, decoder.last_field_error()) {
        (Some(received), _) => json!({ "fields": describe::received(&received) }),
        (None, Some(error)) => json!({ "error": "field", "column": error.column }),
        (None, None) if counters.crc_rejected > 0 => json!({ "error": "crc" }),
        (None, None) => json!({ "error": "shape" }),
    }
}

/// The lines found in a stream, and the counters after it.
pub fn stream(bytes: &[u8]) -> Value {
    let mut decoder = Decoder::default();
    let lines: Vec<_> = decoder
        .lines(bytes)
        .map(|received| match received {
            Received::Line(_, line) => text(&line),
            Received::Ack(line) => text(&line.encode()),
        })
        .collect();
    json!({ "lines": lines, "counters": describe::counters(decoder.counters()) })
}

/// A robot's id and session; an owner of 0 means that no session is open.
#[derive(Clone, Copy)]
pub struct Ear {
    pub robot_id: u8,
    pub boot: u8,
    pub session: u8,
    pub owner: u16,
    /// Era of the session; 0 also if the session was opened without an era.
    pub era: u16,
}

impl Ear {
    pub fn key(self) -> Option<Key> {
        (self.owner != 0).then(|| {
            Key::session(self.robot_id, self.boot, self.session, self.owner).in_era(self.era)
        })
    }

    /// Result for a frame: the last `message`, the last `error`, or neither.
    pub fn hear(self, bytes: &[u8]) -> Value {
        let mut receiver = Receiver::default();
        let mut message = None;
        for &byte in bytes {
            message = receiver
                .handle_byte(byte, self.robot_id, self.key())
                .or(message);
        }
        let counters = receiver.counters();
        match message {
            Some(message) => json!({ "message": describe::message(&message) }),
            None if counters.crc > 0 => json!({ "error": "crc" }),
            None if counters.too_long > 0 => json!({ "error": "too_long" }),
            None if counters.unreadable > 0 => json!({ "error": "unreadable" }),
            None => json!({ "message": null }),
        }
    }
}

/// ASCII bytes as text.
pub fn text(bytes: &[u8]) -> String {
    bytes.iter().copied().map(char::from).collect()
}
