//! Whole hundreds of lost lines, which the sequence does not show, from the uptime in line C.

use super::Counters;
use crate::life::UPTIME_ROUND_S;
use crate::telemetry::{ACK_LINE_BYTES, SEQUENCE_MODULUS};
use crate::{BYTES_PER_S, LINE_BYTES};

/// Robot time without loss after which its own rate is known better than the wire's, seconds.
const MEASURED_S: u64 = 8;

/// Longest time between two lines C without a gap that counts as without loss, seconds: three lines a second need more for a
/// hundred.
const CLEAN_S: u64 = 30;

/// Bytes of the densest mix of lines, one long and three short ones, per line.
const DENSEST_BYTES: u64 = (LINE_BYTES as u64 + 3 * ACK_LINE_BYTES as u64) / 4;

/// Number of lines, or an interval where it is not known exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// Lines that are certainly lost.
    pub min: u64,
    /// Lines that may be lost, the certain ones included.
    pub max: u64,
}

impl Lost {
    /// The lines lost since an earlier count.
    #[must_use]
    pub const fn since(self, before: Self) -> Self {
        Self {
            min: self.min.saturating_sub(before.min),
            max: self.max.saturating_sub(before.max),
        }
    }

    /// Both together.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            min: self.min.saturating_add(other.min),
            max: self.max.saturating_add(other.max),
        }
    }
}

/// Compares the robot's clock with the sequence, from line C to line C.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reckoning {
    /// The sum of all steps of the sequence, and by how much the latest line is behind it.
    progress: u64,
    behind: u8,
    latest: Option<AtCounters>,
    /// Bytes and seconds without loss, and the number of their parts after the first.
    clean_bytes: u64,
    clean_s: u64,
    breaks: u64,
    was_clean: bool,
    /// Short lines in this life, as long as one came since the line C before the latest.
    has_short: bool,
    takes_turns: bool,
}

/// What was known at a line C.
#[derive(Clone, Copy, Debug)]
struct AtCounters {
    uptime_s: u32,
    progress: u64,
    lines: u64,
    ack_lines: u64,
    lines_lost: u64,
}

impl Reckoning {
    /// Takes a step of the sequence.
    pub(super) const fn advance(&mut self, lines: u8) {
        self.progress += lines as u64;
        self.behind = 0;
    }

    /// Takes a late or repeated line, which is behind the newest by a number of lines.
    pub(super) const fn set_behind(&mut self, lines: u8) {
        self.behind = lines;
    }

    /// Takes a go-ahead: the robot is half duplex.
    pub(super) const fn take_go_ahead(&mut self) {
        self.takes_turns = true;
    }

    /// Forgets the latest line C, after a reboot or missing bytes.
    pub(super) const fn forget(&mut self) {
        self.latest = None;
        self.was_clean = false;
    }

    /// Takes the uptime of a line C; returns the lines lost since the one before that are not in `lines_lost`.
    pub(super) fn take_uptime(&mut self, uptime_s: u32, counters: &Counters) -> Lost {
        let now = AtCounters {
            uptime_s,
            progress: self.progress.saturating_sub(u64::from(self.behind)),
            lines: counters.lines - counters.other_lines,
            ack_lines: counters.ack_lines - counters.other_ack_lines,
            lines_lost: counters.lines_lost,
        };
        let Some(then) = self.latest.replace(now) else {
            return Lost::default();
        };
        let passed_s = u64::from((uptime_s + UPTIME_ROUND_S - then.uptime_s) % UPTIME_ROUND_S);
        let long = now.lines - then.lines;
        let short = now.ack_lines - then.ack_lines;
        let bytes = long * LINE_BYTES as u64 + short * ACK_LINE_BYTES as u64;
        // Negative where lines were repeated or a gap looked like a late line.
        let missing = now.progress as i64 - then.progress as i64 - (long + short) as i64;
        let counted = now.lines_lost.saturating_sub(then.lines_lost) as i64;
        let had_short = core::mem::replace(&mut self.has_short, short > 0);
        let is_mixed = had_short || short > 0;
        let is_plausible = self.clean_s < MEASURED_S
            || bytes * self.clean_s * 2 >= self.clean_bytes * passed_s.saturating_sub(1);
        let is_clean = missing == 0 && counted == 0 && passed_s < CLEAN_S && is_plausible;
        if is_clean {
            self.breaks += u64::from(!self.was_clean);
            self.clean_bytes += bytes;
            self.clean_s += passed_s;
        }
        self.was_clean = is_clean;
        if is_clean {
            return Lost::default();
        }
        let (least, most) = self.expected(passed_s, bytes, is_mixed);
        let hundreds = |lines: i64| (lines - missing).max(0) / MODULUS;
        let (min, max) = (hundreds(least + MODULUS - 1), hundreds(most));
        let (min, max) = if min <= max {
            (min, max)
        } else {
            let nearest = hundreds(i64::midpoint(least, most) + MODULUS / 2);
            (nearest, nearest)
        };
        let hidden = |hundreds: i64| match hundreds {
            0 => 0,
            _ => (missing + hundreds * MODULUS - counted).max(0) as u64,
        };
        Lost {
            min: hidden(min),
            max: hidden(max),
        }
    }

    /// Least and greatest number of lines that can be missing among `bytes` in `passed_s` of the robot's clock, which counts
    /// whole seconds.
    fn expected(&self, passed_s: u64, bytes: u64, is_mixed: bool) -> (i64, i64) {
        let (rate, error_pct) = if self.clean_s >= MEASURED_S {
            let parts = 1 + self.breaks.isqrt();
            (
                self.clean_bytes / self.clean_s,
                2 + parts * 100 / self.clean_s,
            )
        } else {
            (u64::from(BYTES_PER_S), 3)
        };
        let (least_rate, most_rate) = if self.takes_turns {
            // The ground's turns are part of the time.
            (rate / 4, rate * 2)
        } else {
            (
                rate * (100 - error_pct) / 100,
                rate * (100 + error_pct) / 100,
            )
        };
        let densest = if is_mixed {
            DENSEST_BYTES
        } else {
            LINE_BYTES as u64
        };
        let least =
            (least_rate * passed_s.saturating_sub(1)).saturating_sub(bytes) / LINE_BYTES as u64;
        let most = (most_rate * (passed_s + 1)).saturating_sub(bytes) / densest;
        (least as i64 - 1, most as i64 + 1)
    }
}

const MODULUS: i64 = SEQUENCE_MODULUS as i64;
