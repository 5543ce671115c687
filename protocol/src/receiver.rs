//! The robot's end of the uplink: frames found between line feeds.

use crate::command::{FRAME_BYTES_MAX, Key, Message};
use crate::crc;

/// What was heard and what was thrown away, since boot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReceiverCounters {
    /// Intact frames that made sense.
    pub frames: u16,
    /// Runs of bytes between line feeds whose CRC did not hold.
    pub crc: u16,
    /// Runs too long to be a frame.
    pub too_long: u16,
    /// Intact, but nothing this version can read.
    pub unreadable: u16,
}

impl ReceiverCounters {
    /// Everything thrown away.
    #[must_use]
    pub const fn rejected(&self) -> u16 {
        self.crc
            .wrapping_add(self.too_long)
            .wrapping_add(self.unreadable)
    }
}

const CONTENT_MAX: usize = FRAME_BYTES_MAX - 2;

/// Collects bytes until a line feed and hands out what was between two of them when its CRC holds.
#[derive(Clone, Debug)]
pub struct Receiver {
    buffer: [u8; CONTENT_MAX],
    /// Bytes since the last line feed; more than the buffer holds means too long.
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
    /// Takes a byte; returns the message that it completed. `session` is the key of the open session.
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

    /// What was heard and thrown away.
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
    // Which key applies is all that is read before the CRC holds; a wrong guess only fails it.
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
