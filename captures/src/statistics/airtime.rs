//! Airtime of one direction of the radio.

use std::collections::VecDeque;

use groundwave_protocol::BYTES_PER_S;

use crate::event::Moment;

/// Time over which airtime is measured.
const WINDOW: Moment = Moment::from_secs(20);

/// Largest plausible airtime, per cent: clocks of serial ports differ by a few per cent.
pub const SHARE_MAX_PCT: f64 = 105.0;

/// Time of bytes that may have waited somewhere when a session began, seconds.
const SLACK_S: f64 = 2.0;

/// Longest pause after which its bytes may come all at once, as from a suspended program, seconds.
const PAUSE_MAX_S: f64 = 120.0;

/// Limit of the time by which bytes are too many, so that a flood is forgotten soon, seconds.
const OVERDRAWN_MAX_S: f64 = 10.0;

/// Measures the airtime of one direction.
#[derive(Clone, Debug)]
pub(super) struct Airtime {
    /// Number of bytes per second that the radio carries.
    bytes_per_s: u32,
    /// Time at which the transmission of the first bytes began.
    begun: Option<Moment>,
    /// Bytes of each second that has any, oldest first.
    clumps: VecDeque<Clump>,
    /// Time of the latest bytes.
    latest: Moment,
    /// Time not taken up by bytes at the latest ones, seconds; negative if more bytes came than the rate carries.
    unspent_s: f64,
}

/// Number of bytes and the time of the last of them.
#[derive(Clone, Copy, Debug)]
struct Clump {
    until: Moment,
    bytes: u64,
}

impl Default for Airtime {
    fn default() -> Self {
        Self {
            bytes_per_s: BYTES_PER_S,
            begun: None,
            clumps: VecDeque::new(),
            latest: Moment::ZERO,
            unspent_s: 0.0,
        }
    }
}

impl Airtime {
    pub(super) fn set_rate(&mut self, bytes_per_s: u32) {
        self.bytes_per_s = bytes_per_s.max(1);
    }

    pub(super) fn take(&mut self, now: Moment, bytes: usize) {
        let bytes = bytes as u64;
        let air = self.air(bytes);
        if self.begun.is_none() {
            self.begun = Some(now.saturating_sub(air));
            self.latest = now;
        }
        let spent_s = air.as_secs_f64() * 100.0 / SHARE_MAX_PCT;
        self.unspent_s = (self.unspent_s(now) - spent_s).max(-OVERDRAWN_MAX_S);
        self.latest = self.latest.max(now);
        while self
            .clumps
            .front()
            .is_some_and(|clump| clump.until + WINDOW < now)
        {
            self.clumps.pop_front();
        }
        match self.clumps.back_mut() {
            Some(clump) if clump.until.as_secs() >= now.as_secs() => {
                clump.until = clump.until.max(now);
                clump.bytes += bytes;
            }
            _ => self.clumps.push_back(Clump { until: now, bytes }),
        }
    }

    /// Airtime over the window, or since the beginning but at least a second, per cent. Bytes were in the air before they arrived and
    /// before later bytes, so the airtime never exceeds 100. `None` if the bytes took longer at this rate than has passed: the rate is
    /// another one.
    pub(super) fn share_pct(&self, now: Moment) -> Option<f64> {
        let Some(begun) = self.begun else {
            return Some(0.0);
        };
        if self.unspent_s(now) < -SLACK_S {
            return None;
        }
        let since = begun.max(now.saturating_sub(WINDOW));
        let mut free_until = now;
        let mut busy = Moment::ZERO;
        for clump in self.clumps.iter().rev() {
            let ended = clump.until.min(free_until);
            let began = ended.saturating_sub(self.air(clump.bytes)).max(since);
            busy += ended.saturating_sub(began);
            free_until = began.min(free_until);
        }
        let passed = now.saturating_sub(since).max(Moment::from_secs(1));
        Some(busy.div_duration_f64(passed) * 100.0)
    }

    fn unspent_s(&self, now: Moment) -> f64 {
        (self.unspent_s + now.saturating_sub(self.latest).as_secs_f64()).min(PAUSE_MAX_S)
    }

    /// Transmission time of a number of bytes.
    fn air(&self, bytes: u64) -> Moment {
        Moment::from_micros(bytes.saturating_mul(1_000_000) / u64::from(self.bytes_per_s))
    }
}

/// Airtime of a number of bytes in a time at a rate, per cent; 0 if the time is zero.
#[must_use]
pub fn share_pct(bytes: u64, time: Moment, bytes_per_s: u32) -> f64 {
    if time.is_zero() {
        return 0.0;
    }
    bytes as f64 * 100.0 / (f64::from(bytes_per_s.max(1)) * time.as_secs_f64())
}
