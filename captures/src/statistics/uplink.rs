//! Counts sent and repeated frames.

use groundwave_protocol::command::{BLOCK_WAYPOINTS, FRAME_BYTES_MAX, Message, Open};
use groundwave_protocol::crc;

use crate::event::Moment;

/// Maximum time between a STOP and its repetition.
const STOP_AGAIN: Moment = Moment::from_secs(1);

/// Counts the frames in the bytes sent; the bytes may be split in any way.
#[derive(Clone, Debug, Default)]
pub struct Uplink {
    /// Bytes since the latest line feed; at most one more than the longest frame.
    run: Vec<u8>,
    bytes: u64,
    frames: u64,
    again: u64,
    stop_at: Option<Moment>,
    open: Option<Open>,
    /// The latest command with its checksum; the checksum distinguishes sessions.
    command: Vec<u8>,
    /// Tag of the current route, and its blocks that were sent.
    tag: u8,
    blocks: u128,
}

impl Uplink {
    /// Takes bytes sent to the radio.
    pub fn take(&mut self, now: Moment, bytes: &[u8]) {
        self.bytes += bytes.len() as u64;
        for &byte in bytes {
            if byte != b'\n' {
                if self.run.len() <= FRAME_BYTES_MAX {
                    self.run.push(byte);
                }
            } else if !self.run.is_empty() {
                self.end_frame(now);
                self.run.clear();
            }
        }
    }

    /// Number of bytes sent.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Number of frames: STOPs, session requests, commands and waypoints.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Number of frames that were repeated.
    #[must_use]
    pub const fn frames_again(&self) -> u64 {
        self.again
    }

    /// Counts a frame. A frame cut short by a STOP counts as bytes only.
    fn end_frame(&mut self, now: Moment) {
        let content = self.run.len().saturating_sub(crc::CHARACTERS);
        let Some(message) = Message::parse(&self.run[..content]) else {
            return;
        };
        let is_again = match message {
            Message::Stop(_) => {
                let before = self.stop_at.replace(now);
                before.is_some_and(|at| now.saturating_sub(at) <= STOP_AGAIN)
            }
            Message::Open(open) => {
                let is_again = self.open.replace(open) == Some(open);
                if !is_again {
                    self.blocks = 0;
                }
                is_again
            }
            Message::Command(_) => {
                let is_again = self.command == self.run;
                self.command.clone_from(&self.run);
                is_again
            }
            Message::Waypoints(slots) => {
                if slots.tag != self.tag {
                    (self.tag, self.blocks) = (slots.tag, 0);
                }
                let count = slots.waypoints().len().div_ceil(BLOCK_WAYPOINTS);
                let blocks = ((1_u128 << count) - 1) << slots.first_block;
                let is_again = self.blocks & blocks != 0;
                self.blocks |= blocks;
                is_again
            }
            Message::Drive(_) | Message::Keepalive(_) => return,
        };
        self.frames += 1;
        self.again += u64::from(is_again);
    }
}
