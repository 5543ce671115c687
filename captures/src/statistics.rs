//! How the link does, in figures that somebody can act on. Sans-IO: time is a parameter, memory is bounded.
//!
//! - *Loss*: lines that the sequence says were sent and that did not arrive intact, of those sent.
//! - *Errors*: line feeds that ended no intact line, by reason.
//! - *Resync*: bytes from the end of an intact line to the beginning of the next, where there are any: what
//!   an error costs until the decoder is back in step. One wrong bit in a line costs that line, 80. What
//!   came before the first line, or before a lost link was back, is no error.
//! - *Again*: a frame that has gone before: the same STOP within a second, the same request for a session,
//!   the same command, or waypoints of which some have gone before. Hand drive and keepalives are not
//!   counted: they are never repeated. The station sends again while it waits for an acknowledgement, before it knows of
//!   any loss: some frames go again on a link that loses nothing.
//! - *Proof*: from the moment a command was asked for until it was proven, the wait for its turn included.
//! - *Airtime*: the share of time in which the radio carried bytes, noise included, at 240 a second. Bytes come in
//!   clumps, each of which was in the air before it is told of. What was handed to the device counts as sent.

mod airtime;
mod uplink;

use groundwave_protocol::decoder::Counters;
use serde::Serialize;

use crate::event::{CommandId, Moment};
use airtime::Airtime;
pub use airtime::share_pct;
pub use uplink::Uplink;

/// Commands under way whose time is taken; of more the oldest are not timed.
const ASKED_MAX: usize = 64;

/// The figures at a moment.
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
    /// What errors cost; `None` before the first.
    pub resync: Option<Resync>,
    /// STOPs, requests for a session, commands and waypoints sent.
    pub frames: u64,
    /// Those of them that had gone before.
    pub frames_again: u64,
    /// How long proof takes; `None` before the first.
    pub proof: Option<Proof>,
    /// Share of the way down in use over the latest 20 s, per cent.
    pub airtime_down_pct: f64,
    /// Share of the way up in use over the latest 20 s, per cent.
    pub airtime_up_pct: f64,
    /// Bytes that the device did not take.
    pub not_taken_bytes: u64,
}

/// Candidates for a line, by what was wrong with them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Rejected {
    /// The checksum did not hold.
    pub crc: u64,
    /// A line feed with nothing like a line before it.
    pub shape: u64,
    /// The checksum held and a field made no sense: another version of the wire.
    pub field: u64,
}

impl Rejected {
    /// As the decoder counted them.
    #[must_use]
    pub const fn of(counters: &Counters) -> Self {
        Self {
            crc: counters.crc_rejected,
            shape: counters.shape_rejected,
            field: counters.field_rejected,
        }
    }
}

/// Bytes from an intact line to the next, where there were any between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resync {
    /// How often.
    pub count: u64,
    /// The latest.
    pub last_bytes: u64,
    /// All of them together, divided by how many.
    pub mean_bytes: f64,
    /// The longest.
    pub worst_bytes: u64,
}

/// Seconds from a wish to its proof.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Proof {
    /// Commands proven.
    pub count: u64,
    /// The latest.
    pub last_s: f64,
    /// All of them together, divided by how many.
    pub mean_s: f64,
    /// The longest.
    pub worst_s: f64,
}

/// `part` in per cent of `whole`; none of nothing.
#[must_use]
pub fn per_cent(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 * 100.0 / whole as f64
    }
}

impl Statistics {
    /// Takes the decoder's totals, from which everything about the way down but the airtime and the resync follows.
    pub fn count(&mut self, counters: &Counters) {
        let lines = counters.lines + counters.ack_lines;
        self.lines = lines;
        self.lines_lost = counters.lines_lost;
        self.loss_pct = per_cent(counters.lines_lost, lines + counters.lines_lost);
        self.rejected = Rejected::of(counters);
    }
}

/// Measures how far intact lines lie apart.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    /// Noise before the latest intact line; `None` before the first.
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

    /// The link was interrupted: what comes until the next line is no error.
    pub const fn interrupt(&mut self) {
        self.noise_bytes = None;
    }

    /// What was found; `None` before the first gap.
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

/// Watches a link.
#[derive(Clone, Debug, Default)]
pub struct LinkMeter {
    gaps: Gaps,
    down: Airtime,
    up: Airtime,
    uplink: Uplink,
    asked: Vec<(CommandId, Moment)>,
    proven: u64,
    last: Moment,
    sum: Moment,
    worst: Moment,
}

impl LinkMeter {
    /// So many bytes came from the radio.
    pub fn take_received(&mut self, now: Moment, bytes: usize) {
        self.down.take(now, bytes);
    }

    /// The decoder has just found a line.
    pub fn take_line(&mut self, counters: &Counters) {
        self.gaps.take_line(counters);
    }

    /// The link is gone, or back.
    pub const fn interrupt(&mut self) {
        self.gaps.interrupt();
    }

    /// These bytes go to the radio.
    pub fn take_sent(&mut self, now: Moment, bytes: &[u8]) {
        self.up.take(now, bytes.len());
        self.uplink.take(now, bytes);
    }

    /// A command was asked for.
    pub fn take_asked(&mut self, now: Moment, id: CommandId) {
        if self.asked.len() == ASKED_MAX {
            self.asked.remove(0);
        }
        self.asked.push((id, now));
    }

    /// A command has ended, with proof or without.
    pub fn take_end(&mut self, now: Moment, id: CommandId, is_proven: bool) {
        let Some(at) = self.asked.iter().position(|(asked, _)| *asked == id) else {
            return;
        };
        let (_, asked_at) = self.asked.remove(at);
        if is_proven {
            self.proven += 1;
            self.last = now.saturating_sub(asked_at);
            self.sum += self.last;
            self.worst = self.worst.max(self.last);
        }
    }

    /// The figures; what the device did not take is for its owner to say.
    #[must_use]
    pub fn statistics(&self, now: Moment, counters: &Counters) -> Statistics {
        let mut statistics = Statistics {
            resync: self.gaps.resync(),
            frames: self.uplink.frames(),
            frames_again: self.uplink.frames_again(),
            proof: (self.proven > 0).then(|| Proof {
                count: self.proven,
                last_s: self.last.as_secs_f64(),
                mean_s: self.sum.as_secs_f64() / self.proven as f64,
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
