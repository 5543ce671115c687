//! Counts bumps.

use groundwave_protocol::telemetry::{CountersLine, StateLine};

use super::topics::is_contact;

/// Modulus of the count in line C.
const COUNT_MODULUS: u16 = 10_000;

/// Counts contacts of the bumper. Between the first and the last line C, the robot's own count is used; elsewhere,
/// lines A, which miss short contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Bumps {
    /// Contacts until the latest line C.
    counted: u32,
    /// Contacts in lines A since.
    seen: u32,
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
        let seen = std::mem::take(&mut self.seen);
        self.counted += match self.last.replace(now) {
            Some((boots, bumps)) if boots == counters.boots => {
                u32::from((counters.bumps + COUNT_MODULUS - bumps) % COUNT_MODULUS)
            }
            _ => seen,
        };
    }

    /// Number of contacts.
    pub(super) const fn total(&self) -> u32 {
        self.counted + self.seen
    }
}
