//! Counts landmarks, so that searches find them.

use groundwave_protocol::telemetry::Ack;

use crate::event::CommandStatus;
use crate::playback::Tally;

/// What counts as a landmark and is not told by what the model shows: of alarms, those that are logged as less.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counted {
    pub(super) tally: Tally,
    ack: Option<Ack>,
    /// The session's own commands are known: the robot's acknowledgements need not speak for them.
    knows_commands: bool,
}

impl Counted {
    /// Takes the acknowledgement in any line.
    pub(super) fn take_ack(&mut self, ack: Ack) {
        let told = |ack: Ack| (ack.boot, ack.session, ack.sequence, ack.outcome);
        let before = self.ack.replace(ack);
        let is_new = before.is_some_and(|before| told(before) != told(ack));
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
