//! How often a robot touched something: one count for everybody who tells it.

use groundwave_protocol::telemetry::{CountersLine, StateLine};

use super::topics::is_contact;

/// Line C counts up to this.
const COUNT_MODULUS: u16 = 10_000;

/// Counts contacts of the bumper.
///
/// The robot counts them itself, and says so in its lines C: what counts is what it counted from the first of them to the
/// last. Of a robot whose lines C are lost the contacts count that lines A show, which miss a short one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Bumps {
    seen: u32,
    counted: Option<u32>,
    is_touching: bool,
    last: Option<(u16, u16)>,
}

impl Bumps {
    /// Takes a line A; says whether it shows a contact that the one before it did not show.
    pub(super) fn take_state(&mut self, state: &StateLine) -> bool {
        let was_touching = std::mem::replace(&mut self.is_touching, is_contact(state.bump));
        let is_new = self.is_touching && !was_touching;
        self.seen += u32::from(is_new);
        is_new
    }

    /// Takes a line C; a robot that booted has begun anew.
    pub(super) fn take_counters(&mut self, counters: &CountersLine) {
        let now = (counters.boots, counters.bumps);
        if let Some((boots, bumps)) = self.last.replace(now)
            && boots == counters.boots
        {
            let more = (counters.bumps + COUNT_MODULUS - bumps) % COUNT_MODULUS;
            *self.counted.get_or_insert(0) += u32::from(more);
        }
    }

    /// Begins again at nothing; what the robot counts goes on.
    pub(super) const fn begin_anew(&mut self) {
        self.seen = 0;
        self.counted = None;
    }

    /// How many there were.
    pub(super) fn total(&self) -> u32 {
        self.counted.unwrap_or(self.seen)
    }
}
