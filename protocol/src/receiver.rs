//! The robot's receiver: finds frames between line feeds.

use crate::command::{FRAME_BYTES_MAX, Key, Message};
use crate::crc;

/// Number of frames received and rejected since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceiverCounters {
    /// Number of intact frames that could be read.
    pub frames: u16,
    /// Number of byte sequences between line feeds with a wrong CRC.
    pub crc: u16,
    /// Number of byte sequences too long for a frame.
    pub too_long: u16,
    /// Number of intact frames that this version cannot read.
    pub unreadable: u16,
}

impl ReceiverCounters {
    /// Number of all rejected byte sequences.
    #[must_use]
    pub const fn rejected(&self) -> u16 {
        self.crc
            .wrapping_add(self.too_long)
            .wrapping_add(self.unreadable)
    }
}

const CONTENT_MAX: usize = FRAME_BYTES_MAX - 2;

/// Collects the bytes between two line feeds and returns them as a message if the CRC is valid.
#[derive(Clone, Debug)]
pub struct Receiver {
    buffer: [u8; CONTENT_MAX],
    /// Number of bytes since the last line feed; larger than the buffer if there are too many.
    length: u8,
    counters: ReceiverCounters,
}

impl Default for Receiver {
    fn default() -> Self {
        Self {
            buffer: [0; CONTENT_MAX],
            length: 0,
            counters: ReceiverCounters::default(),
        }
    }
}

impl Receiver {
    /// Takes a byte; returns the message that it completes. `session` is the key of the open session.
    pub fn handle_byte(&mut self, byte: u8, robot_id: u8, session: Option<Key>) -> Option<Message> {
        if byte != b'\n' {
            if let Some(slot) = self.buffer.get_mut(usize::from(self.length)) {
                *slot = byte;
            }
            self.length = self.length.saturating_add(1);
            return None;
        }
        let length = usize::from(core::mem::take(&mut self.length));
        if length == 0 {
            return None;
        }
        let Some(run) = self.buffer.get(..length) else {
            self.counters.too_long = self.counters.too_long.wrapping_add(1);
            return None;
        };
        let message = match check(run, robot_id, session) {
            Ok(message) => message,
            Err(Reject::Crc) => {
                self.counters.crc = self.counters.crc.wrapping_add(1);
                return None;
            }
            Err(Reject::Unreadable) => {
                self.counters.unreadable = self.counters.unreadable.wrapping_add(1);
                return None;
            }
        };
        self.counters.frames = self.counters.frames.wrapping_add(1);
        Some(message)
    }

    /// The counts since boot.
    #[must_use]
    pub const fn counters(&self) -> &ReceiverCounters {
        &self.counters
    }
}

enum Reject {
    Crc,
    Unreadable,
}

fn check(run: &[u8], robot_id: u8, session: Option<Key>) -> Result<Message, Reject> {
    let (content, trailer) = run
        .split_last_chunk::<{ crc::CHARACTERS }>()
        .ok_or(Reject::Crc)?;
    let kind = content.first().copied().ok_or(Reject::Crc)?;
    let holds = |key: Key| crc::characters(crc::update(key.init(), content)) == *trailer;
    // The type is read before the CRC is verified only to choose the key; a wrong key fails the CRC.
    let intact = match kind {
        b'X' => holds(Key::robot(robot_id)) || holds(Key::EVERY_ROBOT),
        b'O' => holds(Key::robot(robot_id)),
        _ => session.is_some_and(holds),
    };
    if !intact {
        return Err(Reject::Crc);
    }
    Message::parse(content).ok_or(Reject::Unreadable)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Command, Order};
    use crate::status_codes::Mode;
    use proptest::prelude::*;

    const ROBOT_ID: u8 = 7;
    const SESSION: Key = Key::session(ROBOT_ID, 1, 1, 0x2A5);
    const PROWL: Message = Message::Command(Command {
        sequence: 1,
        order: Order::Mode(Mode::Prowl),
    });

    fn hear(bytes: &[u8], session: Option<Key>) -> (std::vec::Vec<Message>, ReceiverCounters) {
        let mut receiver = Receiver::default();
        let messages = bytes
            .iter()
            .filter_map(|&byte| receiver.handle_byte(byte, ROBOT_ID, session))
            .collect();
        (messages, *receiver.counters())
    }

    #[test]
    fn frames_are_accepted_under_their_key_only() {
        let frame = PROWL.encode(SESSION);
        assert_eq!(hear(frame.as_bytes(), Some(SESSION)).0, [PROWL]);
        for key in [
            Key::session(ROBOT_ID + 1, 1, 1, 0x2A5),
            Key::session(ROBOT_ID, 2, 1, 0x2A5),
            Key::session(ROBOT_ID, 1, 2, 0x2A5),
            Key::session(ROBOT_ID, 1, 1, 0x2A4),
            Key::robot(ROBOT_ID),
        ] {
            assert_eq!(hear(frame.as_bytes(), Some(key)).0, []);
        }
        assert_eq!(hear(frame.as_bytes(), None).0, []);
    }

    #[test]
    fn stop_is_accepted_under_the_robots_key_and_under_key_0() {
        for (key, heard) in [
            (Key::robot(ROBOT_ID), true),
            (Key::EVERY_ROBOT, true),
            (Key::robot(ROBOT_ID + 1), false),
        ] {
            let frame = Message::Stop(None).encode(key);
            for session in [None, Some(SESSION)] {
                assert_eq!(hear(frame.as_bytes(), session).0.len(), usize::from(heard));
            }
        }
    }

    #[test]
    fn rejected_runs_are_counted_by_reason() {
        let mut bytes = std::vec::Vec::new();
        bytes.extend(b"\n\n\n");
        bytes.extend(b"noise\n");
        bytes.extend([b'x'; 87]);
        bytes.push(b'\n');
        bytes.extend([b'x'; 88]);
        bytes.push(b'\n');
        bytes.extend([b'x'; 1000]);
        bytes.push(b'\n');
        let content = b"Z";
        bytes.extend(content);
        bytes.extend(crc::characters(crc::update(SESSION.init(), content)));
        bytes.extend(PROWL.encode(SESSION).as_bytes());
        let (messages, counters) = hear(&bytes, Some(SESSION));
        assert_eq!(messages, [PROWL]);
        let expected = ReceiverCounters {
            frames: 1,
            crc: 2,
            too_long: 2,
            unreadable: 1,
        };
        assert_eq!(counters, expected);
        assert_eq!(counters.rejected(), 5);
    }

    #[test]
    fn a_leading_line_feed_ends_noise_and_aborts_a_frame() {
        let stop = Message::Stop(None).encode(Key::robot(ROBOT_ID));
        let prowl = PROWL.encode(SESSION);
        for length in 0..prowl.as_bytes().len() - 1 {
            let mut bytes = prowl.as_bytes()[..length].to_vec();
            bytes.extend(stop.as_bytes());
            assert_eq!(hear(&bytes, Some(SESSION)).0, [Message::Stop(None)]);
        }
    }

    proptest! {
        #[test]
        fn noise_executes_nothing(noise in prop::collection::vec(any::<u8>(), 0..2000)) {
            prop_assert_eq!(hear(&noise, Some(SESSION)).0, []);
        }
    }
}
