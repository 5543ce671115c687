//! Classifies the received bytes when no intact line arrives: nothing, noise, damaged lines, or a robot at another baud
//! rate. Only the newest bytes are examined, in bounded memory.

use std::collections::VecDeque;
use std::time::Duration;

use crate::content::judge;
use crate::event::{Moment, Reception};

/// Time without an intact line before bytes are judged.
const PATIENCE: Duration = Duration::from_secs(5);

/// Minimum time between two judgements.
const JUDGE_EVERY: Duration = Duration::from_secs(1);

/// Number of newest bytes examined: four seconds of a busy radio.
const WINDOW: usize = 1024;

/// Time after received text during which the baud rate counts as right.
const TRUST: Duration = Duration::from_mins(1);

/// Classifies the received bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct Listener {
    is_open: bool,
    reported: Option<Reception>,
    window: VecDeque<u8>,
    /// Time of the latest intact line, or of the beginning.
    line_at: Option<Moment>,
    /// Time of the latest byte, or of the beginning.
    byte_at: Option<Moment>,
    judged_at: Option<Moment>,
    /// Time of the latest text, intact or not.
    text_at: Option<Moment>,
    is_new: bool,
}

impl Listener {
    /// Takes the opening or closing of the link; drops everything received before.
    pub(super) fn open(&mut self, is_open: bool) {
        *self = Self {
            is_open,
            ..Self::default()
        };
    }

    /// Takes the end of a suspension of this station: what was not read meanwhile says nothing about the robot.
    pub(super) fn resume(&mut self, now: Moment) {
        self.line_at = self.line_at.map(|_| now);
        self.byte_at = self.byte_at.map(|_| now);
    }

    /// Takes bytes, and whether an intact line ended in them. Returns the kind of reception and the time at which it began, if
    /// the kind has changed.
    pub(super) fn take(
        &mut self,
        now: Moment,
        bytes: &[u8],
        has_line: bool,
    ) -> Option<(Reception, Moment)> {
        if !self.is_open || bytes.is_empty() {
            return None;
        }
        self.byte_at = Some(now);
        if has_line {
            self.window.clear();
            self.line_at = Some(now);
            self.text_at = Some(now);
            self.is_new = false;
            return self.report(Reception::Lines, now);
        }
        let newest = &bytes[bytes.len().saturating_sub(WINDOW)..];
        let excess = (self.window.len() + newest.len()).saturating_sub(WINDOW);
        self.window.drain(..excess);
        self.window.extend(newest);
        self.is_new = true;
        None
    }

    /// Handles the passing of time. Returns the kind of reception and the time at which it began, if the kind has changed.
    pub(super) fn handle_timeout(&mut self, now: Moment) -> Option<(Reception, Moment)> {
        if !self.is_open {
            return None;
        }
        let line_at = *self.line_at.get_or_insert(now);
        let byte_at = *self.byte_at.get_or_insert(now);
        if now < byte_at + PATIENCE {
            let is_due = self.judge_at().is_some_and(|at| at <= now);
            if !is_due {
                return None;
            }
            self.judged_at = Some(now);
            self.is_new = false;
            let reception = match judge(self.window.make_contiguous())? {
                Reception::Damaged => {
                    self.text_at = Some(now);
                    Reception::Damaged
                }
                Reception::WrongRate(_) if self.text_at.is_some_and(|at| now < at + TRUST) => {
                    Reception::Damaged
                }
                reception => reception,
            };
            return self.report(reception, line_at);
        }
        self.window.clear();
        self.is_new = false;
        self.report(Reception::Nothing, byte_at)
    }

    /// Latest time for the next call of [`Listener::handle_timeout`].
    pub(super) fn poll_timeout(&self) -> Option<Moment> {
        if !self.is_open {
            return None;
        }
        let silence = match (self.byte_at, self.reported) {
            (_, Some(Reception::Nothing)) => None,
            (Some(at), _) => Some(at + PATIENCE),
            (None, _) => Some(Moment::ZERO),
        };
        [silence, self.judge_at()].into_iter().flatten().min()
    }

    fn judge_at(&self) -> Option<Moment> {
        let patient = self.line_at? + PATIENCE;
        let rested = self.judged_at.map(|at| at + JUDGE_EVERY);
        self.is_new
            .then(|| rested.map_or(patient, |at| at.max(patient)))
    }

    fn report(&mut self, reception: Reception, since: Moment) -> Option<(Reception, Moment)> {
        let is_news = self.reported != Some(reception);
        self.reported = Some(reception);
        is_news.then_some((reception, since))
    }
}

#[cfg(test)]
mod tests;
