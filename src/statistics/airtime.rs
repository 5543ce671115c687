//! How much of a direction of the radio is in use.

use std::collections::VecDeque;

use groundwave_protocol::BYTES_PER_S;

use crate::event::Moment;

/// The share is taken over so many seconds, the present one among them.
const WINDOW_S: u64 = 20;

/// Bytes of the latest seconds.
#[derive(Clone, Debug, Default)]
pub(super) struct Airtime {
    /// When the first bytes passed.
    begun: Option<Moment>,
    /// Bytes of each second in which there were any, oldest first.
    seconds: VecDeque<(u64, u64)>,
}

impl Airtime {
    pub(super) fn take(&mut self, now: Moment, bytes: usize) {
        self.begun.get_or_insert(now);
        let second = now.as_secs();
        while self
            .seconds
            .front()
            .is_some_and(|(at, _)| at + WINDOW_S <= second)
        {
            self.seconds.pop_front();
        }
        match self.seconds.back_mut() {
            Some((at, sum)) if *at >= second => *sum += bytes as u64,
            _ => self.seconds.push_back((second, bytes as u64)),
        }
    }

    /// Per cent of what the radio can carry, over the window or since the beginning, at least a second.
    pub(super) fn share_pct(&self, now: Moment) -> f64 {
        let Some(begun) = self.begun else {
            return 0.0;
        };
        let first = (now.as_secs() + 1).saturating_sub(WINDOW_S);
        let inside = self.seconds.iter().filter(|(at, _)| *at >= first);
        let bytes = inside.map(|(_, bytes)| bytes).sum();
        let since = begun.max(Moment::from_secs(first));
        let passed = now.saturating_sub(since).max(Moment::from_secs(1));
        share_pct(bytes, passed)
    }
}

/// So many bytes in a time, in per cent of what the radio can carry in it; nothing in no time.
#[must_use]
pub fn share_pct(bytes: u64, time: Moment) -> f64 {
    if time.is_zero() {
        return 0.0;
    }
    bytes as f64 * 100.0 / (f64::from(BYTES_PER_S) * time.as_secs_f64())
}
