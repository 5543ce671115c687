//! A wait under way: the lines heard since its beginning, and its end.

use std::time::Duration;

use groundwave_protocol::decoder::Received;

use super::super::{Exit, Fault};
use crate::wait::{Kind, Readings, Wait};

/// A wait under way.
pub(super) struct Waiting<'a> {
    wait: &'a Wait,
    /// Only lines after its beginning count: a list that was driven before is not driven again.
    readings: Readings,
    /// Time for `expect` to hear the fields.
    patience: Duration,
}

impl<'a> Waiting<'a> {
    pub(super) fn new(wait: &'a Wait, patience: Duration) -> Self {
        Self {
            wait,
            readings: Readings::default(),
            patience,
        }
    }

    pub(super) fn take(&mut self, line: &Received) {
        self.readings.take(line);
    }

    /// The longest it may take; `None` without a limit.
    pub(super) const fn limit(&self) -> Option<Duration> {
        match self.wait.kind() {
            Kind::For(time) => Some(*time),
            Kind::Until(_, limit) => *limit,
            Kind::Expect(_) => Some(self.patience),
        }
    }

    /// The result, once there is one: the values seen.
    pub(super) fn ended(&self, after: Duration) -> Option<Result<String, Fault>> {
        let is_over = self.limit().is_some_and(|limit| after >= limit);
        let Some(condition) = self.wait.condition() else {
            return is_over.then(|| Ok(String::new()));
        };
        let seen = || condition.seen(&self.readings);
        let not_seen = |why: String| Some(Err(Fault::new(Exit::NotConfirmed, why)));
        match condition.holds(&self.readings) {
            Some(true) => Some(Ok(seen())),
            Some(false) if matches!(self.wait.kind(), Kind::Expect(_)) => {
                not_seen(format!("`{}`: {}", self.wait, seen()))
            }
            _ if is_over => not_seen(format!("`{}`: it did not come; {}", self.wait, seen())),
            _ => None,
        }
    }
}
