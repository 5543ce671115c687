//! One life of the robot, from boot to boot: is this line of the same one?

use groundwave_protocol::telemetry::{CountersLine, StatusLine};

/// Line C counts uptime modulo this, seconds.
const UPTIME_ROUND_S: u32 = 1_000_000;

/// What tells one life from the next. Every line has the boot counter, but modulo 8 only: lines B and C
/// tell the lives apart in which it agrees.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Life {
    /// Boot counter modulo 8.
    boot: Option<u8>,
    /// Boot counter modulo 1000.
    boots: Option<u16>,
    uptime_s: Option<u32>,
}

impl Life {
    /// Takes the boot counter of any line; says whether a new life has begun.
    pub(super) fn take_boot(&mut self, boot: u8) -> bool {
        let is_new = self.boot.is_some_and(|last| last != boot);
        if is_new {
            *self = Self::default();
        }
        self.boot = Some(boot);
        is_new
    }

    /// The same for line B.
    pub(super) fn take_status(&mut self, status: &StatusLine) -> bool {
        self.take_boots(status.boots)
    }

    /// The same for line C, in which time does not run backwards.
    pub(super) fn take_counters(&mut self, counters: &CountersLine) -> bool {
        let rebooted = self.take_boots(counters.boots);
        let uptime_s = counters.uptime_s % UPTIME_ROUND_S;
        let passed_s = |last: u32| (uptime_s + UPTIME_ROUND_S - last) % UPTIME_ROUND_S;
        let ran_back = self
            .uptime_s
            .is_some_and(|last| passed_s(last) > UPTIME_ROUND_S / 2);
        self.uptime_s = Some(uptime_s);
        rebooted || ran_back
    }

    fn take_boots(&mut self, boots: u16) -> bool {
        let is_new = self.boots.is_some_and(|last| last != boots);
        if is_new {
            self.uptime_s = None;
        }
        self.boots = Some(boots);
        is_new
    }
}
