//! Counts landmarks; searches use the counts.

use groundwave_protocol::telemetry::Ack;

use crate::event::CommandStatus;
use crate::playback::Tally;

/// Counts of landmarks. Alarms of the highest level are not included; the log counts them.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counted {
    pub(super) tally: Tally,
    ack: Option<Ack>,
    /// Whether there were command events; then acknowledgements are not counted.
    knows_commands: bool,
}

impl Counted {
    /// Takes the acknowledgement in a line.
    pub(super) fn take_ack(&mut self, ack: Ack) {
        let identity = |ack: Ack| (ack.boot, ack.session, ack.sequence, ack.outcome);
        let before = self.ack.replace(ack);
        let is_new = before.is_some_and(|before| identity(before) != identity(ack));
        if is_new && !self.knows_commands {
            self.tally.commands += 1;
        }
    }

    pub(super) fn take_asked(&mut self) {
        self.knows_commands = true;
        self.tally.commands += 1;
    }

    pub(super) fn take_command_status(&mut self, status: &CommandStatus) {
        self.knows_commands = true;
        self.tally.commands += u64::from(status.is_end());
    }
}
