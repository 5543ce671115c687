//! Counts bumps.

use groundwave_protocol::telemetry::{CountersLine, StateLine};

use super::topics::is_contact;

/// Modulus of the count in line C.
const COUNT_MODULUS: u16 = 10_000;

/// Counts contacts of the bumper. Between the first and the last line C, the robot's own count is used; elsewhere,
/// lines A, which miss short contacts.
#[derive(Clone, Debug, Default)]
pub(super) struct Bumps {
    /// Number of contacts until the latest line C.
    counted: u32,
    /// Number of contacts in lines A since that line C.
    seen: u32,
    is_touching: bool,
    /// Uptime, boots and bumps of the latest line C.
    last: Option<(u32, u16, u16)>,
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
        let now = (counters.uptime_s, counters.boots, counters.bumps);
        let seen = std::mem::take(&mut self.seen);
        self.counted += match self.last.replace(now) {
            // A robot without a lasting count of its boots is recognized by its uptime.
            Some((uptime_s, boots, bumps))
                if boots == counters.boots && uptime_s <= counters.uptime_s =>
            {
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

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::FirmwareVersion;

    #[test]
    fn a_boot_restarts_the_count_even_if_boots_are_not_counted() {
        let mut bumps = Bumps::default();
        for (uptime_s, boots, count) in [(10, 1, 5), (20, 1, 9), (2, 1, 0), (9, 1, 1), (3, 2, 0)] {
            bumps.take_counters(&CountersLine {
                robot_id: 4,
                uptime_s,
                boots,
                version: FirmwareVersion { major: 1, minor: 0 },
                bumps: count,
                ..CountersLine::default()
            });
        }
        assert_eq!(bumps.total(), 5);
    }
}
