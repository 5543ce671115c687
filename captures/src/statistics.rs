//! Link statistics. Sans-IO: time is a parameter, memory is bounded.
//!
//! - *Loss*: share of the lines sent, by their sequence, that did not arrive intact.
//! - *Errors*: line feeds that ended no intact line, by reason.
//! - *Resync*: bytes between two intact lines, where there are any: the cost of an error until the decoder is back in step. One
//!   wrong bit costs its line, 80 bytes. Bytes before the first line, or before a lost link is back, are no error.
//! - *Again*: a repeated frame: the same STOP within a second, the same session request, the same command, or waypoints of which
//!   some were sent before. Hand drive and keepalives are never repeated and not counted. The station repeats frames while it
//!   waits for an acknowledgement, also on a link without loss.
//! - *Confirmation*: from the moment a command was asked for until it was confirmed, the wait for its turn included.
//! - *Airtime*: share of the time in which the radio carried bytes, noise included, at 240 a second. Bytes arrive in bunches, each
//!   of which was in the air before. Bytes handed to the device count as sent.

mod airtime;
mod uplink;

use groundwave_protocol::decoder::Counters;
use serde::Serialize;

use crate::event::{CommandId, Moment};
use airtime::Airtime;
pub use airtime::share_pct;
pub use uplink::Uplink;

/// Maximum commands under way that are timed; the oldest are dropped.
const ASKED_MAX: usize = 64;

/// Statistics at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Intact lines of all types.
    pub lines: u64,
    /// Lines sent that did not arrive intact.
    pub lines_lost: u64,
    /// `lines_lost` in per cent of both.
    pub loss_pct: f64,
    /// Line feeds that ended no intact line.
    pub rejected: Rejected,
    /// Cost of errors; `None` before the first.
    pub resync: Option<Resync>,
    /// STOPs, requests for a session, commands and waypoints sent.
    pub frames: u64,
    /// Repeated frames among them.
    pub frames_again: u64,
    /// Time to confirmation; `None` before the first.
    pub confirmation: Option<Confirmation>,
    /// Downlink airtime over the latest 20 s, per cent.
    pub airtime_down_pct: f64,
    /// Uplink airtime over the latest 20 s, per cent.
    pub airtime_up_pct: f64,
    /// Bytes that the device did not take.
    pub not_taken_bytes: u64,
}

/// Damaged lines by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rejected {
    /// Wrong checksum.
    pub crc: u64,
    /// Bytes before a line feed that do not have the shape of a line.
    pub shape: u64,
    /// Right checksum but an invalid field: another version of the protocol.
    pub field: u64,
}

impl Rejected {
    /// The decoder's counts.
    #[must_use]
    pub const fn of(counters: &Counters) -> Self {
        Self {
            crc: counters.crc_rejected,
            shape: counters.shape_rejected,
            field: counters.field_rejected,
        }
    }
}

/// Bytes between intact lines, where there are any.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resync {
    /// Number of times.
    pub count: u64,
    /// The latest.
    pub last_bytes: u64,
    /// Mean.
    pub mean_bytes: f64,
    /// The longest.
    pub worst_bytes: u64,
}

/// Time from the queueing of a command to its confirmation, seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confirmation {
    /// Commands confirmed.
    pub count: u64,
    /// The latest.
    pub last_s: f64,
    /// Mean.
    pub mean_s: f64,
    /// The longest.
    pub worst_s: f64,
}

/// `part` in per cent of `whole`; 0 of 0.
#[must_use]
pub fn per_cent(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 * 100.0 / whole as f64
    }
}

impl Statistics {
    /// Takes the decoder's totals, which give all downlink statistics but airtime and resync.
    pub fn count(&mut self, counters: &Counters) {
        let lines = counters.lines + counters.ack_lines;
        self.lines = lines;
        self.lines_lost = counters.lines_lost;
        self.loss_pct = per_cent(counters.lines_lost, lines + counters.lines_lost);
        self.rejected = Rejected::of(counters);
    }
}

/// Measures the bytes between intact lines.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    /// Total noise bytes when the latest intact line arrived; `None` before the first and after an interruption.
    noise_bytes: Option<u64>,
    count: u64,
    last_bytes: u64,
    sum_bytes: u64,
    worst_bytes: u64,
}

impl Gaps {
    /// Takes the decoder's totals right after it found a line.
    pub fn take_line(&mut self, counters: &Counters) {
        let before = self.noise_bytes.replace(counters.noise_bytes);
        let gap = before.map_or(0, |before| counters.noise_bytes.saturating_sub(before));
        if gap > 0 {
            self.count += 1;
            self.last_bytes = gap;
            self.sum_bytes += gap;
            self.worst_bytes = self.worst_bytes.max(gap);
        }
    }

    /// Takes an interruption of the link: bytes until the next line are no error.
    pub const fn interrupt(&mut self) {
        self.noise_bytes = None;
    }

    /// The result; `None` before the first gap.
    #[must_use]
    pub fn resync(&self) -> Option<Resync> {
        (self.count > 0).then(|| Resync {
            count: self.count,
            last_bytes: self.last_bytes,
            mean_bytes: self.sum_bytes as f64 / self.count as f64,
            worst_bytes: self.worst_bytes,
        })
    }
}

/// Observes a link.
#[derive(Clone, Debug, Default)]
pub struct LinkMeter {
    gaps: Gaps,
    down: Airtime,
    up: Airtime,
    uplink: Uplink,
    asked: Vec<(CommandId, Moment)>,
    confirmed: u64,
    last: Moment,
    sum: Moment,
    worst: Moment,
}

impl LinkMeter {
    /// Takes a number of bytes from the radio.
    pub fn take_received(&mut self, now: Moment, bytes: usize) {
        self.down.take(now, bytes);
    }

    /// Takes the decoder's totals after a line.
    pub fn take_line(&mut self, counters: &Counters) {
        self.gaps.take_line(counters);
    }

    /// Takes the loss or the return of the link.
    pub const fn interrupt(&mut self) {
        self.gaps.interrupt();
    }

    /// Takes bytes sent to the radio.
    pub fn take_sent(&mut self, now: Moment, bytes: &[u8]) {
        self.up.take(now, bytes.len());
        self.uplink.take(now, bytes);
    }

    /// Takes a queued command.
    pub fn take_asked(&mut self, now: Moment, id: CommandId) {
        if self.asked.len() == ASKED_MAX {
            self.asked.remove(0);
        }
        self.asked.push((id, now));
    }

    /// Takes the end of a command, confirmed or not.
    pub fn take_end(&mut self, now: Moment, id: CommandId, is_confirmed: bool) {
        let Some(at) = self.asked.iter().position(|(asked, _)| *asked == id) else {
            return;
        };
        let (_, asked_at) = self.asked.remove(at);
        if is_confirmed {
            self.confirmed += 1;
            self.last = now.saturating_sub(asked_at);
            self.sum += self.last;
            self.worst = self.worst.max(self.last);
        }
    }

    /// Statistics at a moment; the caller adds `not_taken_bytes`.
    #[must_use]
    pub fn statistics(&self, now: Moment, counters: &Counters) -> Statistics {
        let mut statistics = Statistics {
            resync: self.gaps.resync(),
            frames: self.uplink.frames(),
            frames_again: self.uplink.frames_again(),
            confirmation: (self.confirmed > 0).then(|| Confirmation {
                count: self.confirmed,
                last_s: self.last.as_secs_f64(),
                mean_s: self.sum.as_secs_f64() / self.confirmed as f64,
                worst_s: self.worst.as_secs_f64(),
            }),
            airtime_down_pct: self.down.share_pct(now),
            airtime_up_pct: self.up.share_pct(now),
            ..Statistics::default()
        };
        statistics.count(counters);
        statistics
    }
}

#[cfg(test)]
mod tests;
