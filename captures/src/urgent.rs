//! Detects lines that must reach the disk at once.

use std::convert::Infallible;

use foxglove::messages::log::Level;
use groundwave_protocol::telemetry::{Body, Line};

use super::bumps::Bumps;
use super::topics::LogMessages;

/// Detects bumps, warnings and alarms in the decoded lines.
#[derive(Default)]
pub(super) struct UrgentLines {
    bumps: Bumps,
    log: LogMessages,
}

impl UrgentLines {
    /// Takes a line; returns whether it reports a bump, a warning or an alarm.
    pub(super) fn take_line(&mut self, line: &Line) -> bool {
        let mut is_urgent =
            matches!(&line.body, Body::State(state) if self.bumps.take_state(state));
        let Ok(()) = self.log.handle_line(line, |level, _| {
            is_urgent |= level as i32 >= Level::Warning as i32;
            Ok::<(), Infallible>(())
        });
        is_urgent
    }
}

#[cfg(test)]
mod tests {
    use groundwave_protocol::decoder::{Decoder, Received};

    use super::*;
    use crate::topics::is_contact;

    #[test]
    fn each_bump_of_the_sample_is_urgent_and_few_other_lines_are() {
        let sample = include_bytes!("../house-clean.txt");
        let mut urgent_lines = UrgentLines::default();
        let (mut lines, mut urgent, mut bumps, mut was_contact) = (0, 0, 0, false);
        for received in Decoder::default().lines(sample) {
            let Received::Line(line, _) = received else {
                continue;
            };
            let is_urgent = urgent_lines.take_line(&line);
            lines += 1;
            urgent += usize::from(is_urgent);
            if let Body::State(state) = &line.body {
                let is_bump = is_contact(state.bump) && !was_contact;
                assert!(is_urgent || !is_bump, "{line:?}");
                bumps += usize::from(is_bump);
                was_contact = is_contact(state.bump);
            }
        }
        assert!(
            bumps > 0 && urgent < lines / 4,
            "{bumps}, {urgent}, {lines}"
        );
    }
}
