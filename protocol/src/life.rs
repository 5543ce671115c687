//! Reboots of the robot, recognized from its lines.

use crate::received::Received;
use crate::telemetry::{Body, CountersLine, Line};

/// Modulus of the uptime in line C, seconds.
pub(crate) const UPTIME_ROUND_S: u32 = 1_000_000;

/// The current life of the robot, from boot to boot. Every line contains the boot counter modulo 8, lines B and C
/// modulo 1000, and line C the uptime; each distinguishes lives that the previous one confuses.
#[derive(Clone, Copy, Debug, Default)]
pub struct Life {
    /// Boot counter modulo 8.
    boot: Option<u8>,
    /// Boot counter modulo 1000.
    boots: Option<u16>,
    uptime_s: Option<u32>,
}

impl Life {
    /// Takes a line of any type; returns whether the robot has rebooted.
    pub fn take(&mut self, received: &Received) -> bool {
        match received {
            Received::Line(line, _) => self.take_line(line),
            Received::Ack(line) => self.take_boot(line.ack.boot),
        }
    }

    /// Takes a line of 80 bytes; returns whether the robot has rebooted.
    pub fn take_line(&mut self, line: &Line) -> bool {
        self.take_boot(line.ack.boot)
            | match &line.body {
                Body::Status(status) => self.take_boots(status.boots),
                Body::Counters(counters) => self.take_counters(counters),
                _ => false,
            }
    }

    /// Takes the boot counter of an acknowledgement; returns whether the robot has rebooted.
    pub fn take_boot(&mut self, boot: u8) -> bool {
        let is_new = self.boot.is_some_and(|last| last != boot);
        if is_new {
            *self = Self::default();
        }
        self.boot = Some(boot);
        is_new
    }

    /// Takes a line C; an uptime that runs backward means a reboot.
    fn take_counters(&mut self, counters: &CountersLine) -> bool {
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
