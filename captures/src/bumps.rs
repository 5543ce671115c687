//! Counts bumps.

use groundwave_protocol::telemetry::{CountersLine, StateLine};

use super::topics::is_contact;

/// Modulus of the count in line C.
const COUNT_MODULUS: u16 = 10_000;

/// Counts contacts of the bumper. Between the first and the last line C, the robot's own count is used; elsewhere,
/// lines A, which miss short contacts.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Bumps {
    seen: u32,
    counted: Option<u32>,
    is_touching: bool,
    last: Option<(u16, u16)>,
}

impl Bumps {
    /// Takes a line A; returns whether a contact begins.
    pub(super) fn take_state(&mut self, state: &StateLine) -> bool {
        let was_touching = std::mem::replace(&mut self.is_touching, is_contact(state.bump));
        let is_new = self.is_touching && !was_touching;
        self.seen += u32::from(is_new);
        is_new
    }

    /// Takes a line C; a boot resets the robot's count.
    pub(super) fn take_counters(&mut self, counters: &CountersLine) {
        let now = (counters.boots, counters.bumps);
        if let Some((boots, bumps)) = self.last.replace(now)
            && boots == counters.boots
        {
            let more = (counters.bumps + COUNT_MODULUS - bumps) % COUNT_MODULUS;
            *self.counted.get_or_insert(0) += u32::from(more);
        }
    }

    /// Resets the count.
    pub(super) const fn begin_anew(&mut self) {
        self.seen = 0;
        self.counted = None;
    }

    /// Number of contacts.
    pub(super) fn total(&self) -> u32 {
        self.counted.unwrap_or(self.seen)
    }
}
