//! Detects received lines that the disk has to keep at once.

use std::convert::Infallible;

use foxglove::messages::log::Level;
use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::Body;

use super::bumps::Bumps;
use super::topics::LogMessages;

/// Reads the lines as they come in.
#[derive(Default)]
pub(super) struct AlarmDetector {
    decoder: Decoder,
    bumps: Bumps,
    log: LogMessages,
}

impl AlarmDetector {
    /// Takes bytes received; returns whether they hold a bump or an alarm.
    pub(super) fn handle_rx(&mut self, mut bytes: &[u8]) -> bool {
        let mut is_urgent = false;
        while !bytes.is_empty() {
            let (taken, received) = self.decoder.handle_bytes(bytes);
            bytes = &bytes[taken..];
            let Some(Received::Line(line, _)) = received else {
                continue;
            };
            if let Body::State(state) = line.body {
                is_urgent |= self.bumps.take_state(&state);
            }
            let Ok(()) = self.log.handle_line(&line, |level, _| {
                is_urgent |= level as i32 >= Level::Warning as i32;
                Ok::<(), Infallible>(())
            });
        }
        is_urgent
    }
}
