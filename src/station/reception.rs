//! What comes in when no intact line does: nothing, noise, damaged lines, or a robot at another baud
//! rate. Judged from the newest bytes alone, in bounded memory.
//!
//! Lines repeat: two that follow each other share most of their text, and sampled at a wrong rate they
//! still share most of the garbage. Noise does not repeat. So the share of places where four bytes are
//! followed by bytes that were seen before tells a wrong rate from noise, whichever rates are involved
//! and whatever the receiver makes of broken stop bits. What is printable is the right rate and a bad
//! channel. And when the line is slower than the port, no bit stands alone between two others.

use std::collections::VecDeque;
use std::time::Duration;

use crate::event::{LineRate, Moment, Reception};

/// No intact line for this long is worth a judgement.
const PATIENCE: Duration = Duration::from_secs(5);

/// Judged no more often than this.
const JUDGE_EVERY: Duration = Duration::from_secs(1);

/// The newest bytes, four seconds of a full radio.
const WINDOW: usize = 1024;

/// Fewer bytes are not judged.
const BYTES_MIN: usize = 128;

/// Four bytes in a row: noise repeats so many by chance in one place of a million.
const RUN: usize = 4;

/// Share of runs seen before above which bytes have structure. Measured: structure 1.4 % and more
/// between 300 and 19200 baud, noise up to 0.7 % unless it is slower than the rate itself. All these
/// figures are from the ignored test `looks_of_everything`, which prints them.
const REPEATS_MIN: f64 = 0.01;

/// Share of printable bytes above which the rate is right. Measured: wrong rates up to 52 %, noise up to
/// 41 %; damaged lines 100 % to 33 %, the least while a receiver that takes a broken stop bit for a
/// start bit has lost its place.
const PRINTABLE_MIN: f64 = 0.6;

/// Share of bytes with a bit that stands alone, below which the line is slower than the port. Measured:
/// none where it is, 53 % and more where it is faster.
const ALONE_MAX: f64 = 0.1;

/// For so long after text was heard the rate is known to be right, whatever a window looks like.
const TRUST: Duration = Duration::from_mins(1);

/// Listens to everything that comes.
#[derive(Clone, Debug, Default)]
pub(super) struct Listener {
    is_open: bool,
    reported: Option<Reception>,
    window: VecDeque<u8>,
    /// When the latest intact line came, or listening began.
    line_at: Option<Moment>,
    /// When the latest byte came, or listening began.
    byte_at: Option<Moment>,
    judged_at: Option<Moment>,
    /// When text was heard, intact or not.
    text_at: Option<Moment>,
    is_new: bool,
}

impl Listener {
    /// The link opened or closed: what was heard before says nothing about now.
    pub(super) fn open(&mut self, is_open: bool) {
        *self = Self {
            is_open,
            ..Self::default()
        };
    }

    /// Takes bytes, and whether an intact line ended among them. Returns what is heard now if that is
    /// news, and since when.
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

    /// Lets time pass. Returns what is heard now if that is news, and since when.
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

    /// When to call [`Listener::handle_timeout`] at the latest.
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

/// What bytes look like, each as a share of their number.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Looks {
    printable: f64,
    /// Begin a run that was seen before.
    repeats: f64,
    /// Have a bit that stands alone.
    alone: f64,
}

impl Looks {
    fn of(bytes: &[u8]) -> Self {
        let share = |count: usize| count as f64 / bytes.len().max(1) as f64;
        let printable = |byte: &&u8| matches!(byte, b' '..=b'~' | b'\r' | b'\n');
        Self {
            printable: share(bytes.iter().filter(printable).count()),
            repeats: share(repeats(bytes)),
            alone: share(bytes.iter().filter(|byte| has_bit_alone(**byte)).count()),
        }
    }
}

/// What these bytes are, none of which made a line; `None` when they are too few.
fn judge(bytes: &[u8]) -> Option<Reception> {
    if bytes.len() < BYTES_MIN {
        return None;
    }
    let looks = Looks::of(bytes);
    Some(if looks.printable >= PRINTABLE_MIN {
        Reception::Damaged
    } else if looks.repeats < REPEATS_MIN {
        Reception::Noise
    } else if looks.alone < ALONE_MAX {
        Reception::WrongRate(LineRate::Slower)
    } else {
        Reception::WrongRate(LineRate::Faster)
    })
}

/// Runs of bytes that were seen before.
fn repeats(bytes: &[u8]) -> usize {
    let mut runs: Vec<&[u8]> = bytes.windows(RUN).collect();
    runs.sort_unstable();
    let seen = runs.len();
    runs.dedup();
    seen - runs.len()
}

/// Whether a bit differs from both its neighbours within the byte.
const fn has_bit_alone(byte: u8) -> bool {
    let changes = (byte ^ (byte >> 1)) & 0x7F;
    changes & (changes >> 1) != 0
}

#[cfg(test)]
mod tests;
