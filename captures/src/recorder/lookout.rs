//! Sees a bump before the recorder's thread is told of its line: it shall be on the disk at once.

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::Body;

use crate::bumps::Bumps;

/// Reads the lines as they come in.
#[derive(Default)]
pub(super) struct Lookout {
    decoder: Decoder,
    bumps: Bumps,
}

impl Lookout {
    /// Takes what was read; says whether the robot has touched something in it.
    pub(super) fn sees_bump(&mut self, mut bytes: &[u8]) -> bool {
        let mut is_bumped = false;
        while !bytes.is_empty() {
            let (taken, received) = self.decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            if let Some(Received::Line(line, _)) = received
                && let Body::State(state) = line.body
            {
                is_bumped |= self.bumps.take_state(&state);
            }
        }
        is_bumped
    }
}
