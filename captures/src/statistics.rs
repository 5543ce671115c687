//! Link statistics. Sans-IO: time is a parameter, memory is bounded.
//!
//! - *Loss*: share of the robot's lines that did not arrive in any recognizable form, by their sequence and the robot's clock. It is an
//!   interval if the number of lost lines is known only as an interval.
//! - *Damaged*: lines that arrived but were not intact, by kind and type. They do not count as lost.
//! - *Resync*: bytes between two intact lines: the cost of an error until the decoder finds the next line. One
//!   wrong bit costs its line, 80 bytes. Bytes before the first line after the start or a loss of the link are not errors.
//! - *Again*: repeated frames: the same STOP within a second, the same session request, the same command, or waypoints of which
//!   some were sent before. Hand drive and keepalives are not counted. The station repeats frames while it
//!   waits for an acknowledgement, also on a link without loss.
//! - *Confirmation*: time from the queueing of a command to its confirmation.
//! - *Airtime*: share of the time in which the radio carried bytes, noise included, at the lower baud rate of port and robot
//!   (line I), or 2400 if both are unknown. Bytes that arrive
//!   together were in the air before. Bytes handed to the device count as sent.

mod airtime;
mod uplink;

use std::io;

use groundwave_protocol::decoder::{self, Counters, DamageKind, OTHERS_MAX};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

use crate::event::{CommandId, Moment};
use crate::words::counted;
use crate::words::{interval_pct, lost_words};
use airtime::Airtime;
pub use airtime::{SHARE_MAX_PCT, share_pct};
pub use uplink::Uplink;

/// Bits of a byte on the wire, with its start and stop bits.
pub const BITS_PER_BYTE: u32 = 10;

/// Maximum number of open commands that are timed; the oldest are dropped.
const ASKED_MAX: usize = 64;

/// Statistics at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Number of intact lines of all types.
    pub lines: u64,
    /// Loss of lines.
    #[serde(flatten)]
    pub loss: Loss,
    /// Numbers of damaged lines.
    pub damaged: Damaged,
    /// Another robot on the channel.
    #[serde(flatten)]
    pub other: OtherRobot,
    /// Cost of errors; `None` before the first.
    pub resync: Option<Resync>,
    /// Number of frames sent: STOPs, requests for a session, commands and waypoints.
    pub frames: u64,
    /// Number of repeated frames; part of `frames`.
    pub frames_again: u64,
    /// Time to confirmation; `None` before the first.
    pub confirmation: Option<Confirmation>,
    /// Downlink airtime over the latest 20 s, per cent; `None` if more bytes came than the rate can carry, so
    /// that the rate is another one.
    pub airtime_down_pct: Option<f64>,
    /// Uplink airtime over the latest 20 s, per cent; `None` when `airtime_down_pct` is.
    pub airtime_up_pct: Option<f64>,
    /// Number of bytes that the device did not take.
    pub not_taken_bytes: u64,
}

/// Loss of lines: lines that did not arrive in any recognizable form.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Loss {
    /// Minimum number of lost lines.
    pub lines_lost: u64,
    /// Maximum number of lost lines. The hundreds are known at the robot's next line C, and may stay uncertain after a long outage;
    /// `None` while an outage lasts, or if no clock shows them.
    pub lines_lost_max: Option<u64>,
    /// `lines_lost` in per cent of the lines sent.
    pub loss_pct: f64,
    /// `lines_lost_max` in per cent of the lines sent; 100 if it is unknown.
    pub loss_max_pct: f64,
}

impl Loss {
    /// Takes the values from the decoder's counts.
    #[must_use]
    pub fn of(counters: &Counters) -> Self {
        let lost = counters.lost();
        let arrived = counters.intact() + counters.damaged_in_gaps;
        Self {
            lines_lost: lost.min,
            lines_lost_max: lost.known_max(),
            loss_pct: per_cent(lost.min, arrived + lost.min),
            loss_max_pct: (lost.known_max()).map_or(100.0, |max| per_cent(max, arrived + max)),
        }
    }

    /// Leaves the upper end open.
    pub const fn leave_open(&mut self) {
        self.lines_lost_max = None;
        self.loss_max_pct = 100.0;
    }

    /// The number of lost lines as text: `165`, `165 to 265`, or `at least 65`.
    #[must_use]
    pub fn lines(&self) -> String {
        lost_words(decoder::Lost {
            min: self.lines_lost,
            max: self.lines_lost_max.unwrap_or(self.lines_lost),
            is_open: self.lines_lost_max.is_none(),
        })
    }

    /// The share of lost lines for a table: `7.5%`, `62-73%`, or `>=7.5%`.
    #[must_use]
    pub fn short_share(&self) -> String {
        let (min_pct, max_pct) = (self.loss_pct, self.loss_max_pct);
        if self.lines_lost_max.is_none() {
            format!(">={min_pct:.1}%")
        } else if min_pct < max_pct {
            format!("{:.0}-{:.0}%", min_pct.floor(), max_pct.ceil())
        } else {
            format!("{max_pct:.1}%")
        }
    }

    /// The share of lost lines as text: `7.5 %`, `62.3 to 72.6 %`, or `at least 7.5 %`.
    #[must_use]
    pub fn share(&self) -> String {
        if self.lines_lost_max.is_none() {
            return format!("at least {:.1} %", self.loss_pct);
        }
        interval_pct(self.loss_pct, self.loss_max_pct)
    }
}

/// Lines of other robots on the channel, counted separately.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct OtherRobot {
    /// Id of the first other robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_robot: Option<u8>,
    /// Ids of all other robots.
    #[serde(
        skip_serializing_if = "is_one_at_most",
        serialize_with = "serialize_ids"
    )]
    pub other_robots: [Option<u8>; OTHERS_MAX],
    /// Number of their lines.
    #[serde(skip_serializing_if = "is_zero")]
    pub other_lines: u64,
    /// Id of the robot that was followed before, if another one replaced it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub replaced_robot: Option<u8>,
    /// Id of the followed robot, if it replaced another one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub followed_robot: Option<u8>,
}

impl OtherRobot {
    /// Takes the values from the decoder's counts.
    #[must_use]
    pub const fn of(counters: &Counters) -> Self {
        Self {
            other_robot: counters.other_robots[0],
            other_robots: counters.other_robots,
            other_lines: counters.other_lines + counters.other_ack_lines,
            replaced_robot: counters.replaced_robot,
            followed_robot: match counters.replaced_robot {
                Some(_) => counters.robot,
                None => None,
            },
        }
    }

    /// The other robots as text: `robot 7` or `robots 7 and 9`; `None` if there are none.
    #[must_use]
    pub fn names(&self) -> Option<String> {
        let mut ids: Vec<String> = self.ids().map(|id| id.to_string()).collect();
        let last = ids.pop()?;
        // Lines of the followed robot are among them, from before it was followed.
        if self.replaced_robot.is_some() {
            return Some("other robots".to_owned());
        }
        Some(if ids.is_empty() {
            format!("robot {last}")
        } else {
            format!("robots {} and {last}", ids.join(", "))
        })
    }

    /// Ids of the other robots.
    pub fn ids(&self) -> impl Iterator<Item = u8> {
        self.other_robots.into_iter().flatten()
    }

    /// The change of the followed robot as text; `None` if there was none.
    #[must_use]
    pub fn change(&self) -> Option<String> {
        let (followed, replaced) = (self.followed_robot?, self.replaced_robot?);
        Some(format!(
            "robot {followed} is followed now; robot {replaced} was not heard for a minute"
        ))
    }

    /// Writes the rows of a summary, if there is another robot.
    pub(super) fn write_rows(&self, output: &mut impl io::Write) -> io::Result<()> {
        if let Some(names) = self.names() {
            let lines = counted(self.other_lines, "line");
            writeln!(output, "others     {lines} of {names}, kept apart")?;
        }
        if let Some(change) = self.change() {
            writeln!(output, "followed   {change}")?;
        }
        Ok(())
    }
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn is_one_at_most(ids: &[Option<u8>; OTHERS_MAX]) -> bool {
    ids.iter().flatten().count() <= 1
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
fn serialize_ids<S: Serializer>(
    ids: &[Option<u8>; OTHERS_MAX],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(ids.iter().flatten())
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde calls it with a reference"
)]
const fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Damaged lines by kind and type.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Damaged(decoder::Damaged);

impl Damaged {
    /// Takes the values from the decoder's counts.
    #[must_use]
    pub const fn of(counters: &Counters) -> Self {
        Self(counters.damaged)
    }

    /// All kinds.
    #[must_use]
    pub fn lines(&self) -> u64 {
        self.0.total()
    }

    /// Number of each kind: wrong checksum, wrong length, unreadable field.
    #[must_use]
    pub fn kinds(&self) -> [u64; 3] {
        [DamageKind::Checksum, DamageKind::Shape, DamageKind::Field]
            .map(|kind| self.0.of_kind(kind))
    }

    /// Number of damaged lines by type; types without any are left out.
    pub fn types(&self) -> impl Iterator<Item = (char, u64)> {
        self.0.by_type().filter(|(_, count)| *count > 0)
    }

    /// Writes the row of a summary: numbers by kind and by type.
    pub(super) fn write_row(&self, output: &mut impl io::Write) -> io::Result<()> {
        let [checksum, shape, field] = self.kinds();
        write!(
            output,
            "damaged    {checksum} checksum, {shape} shape, {field} field"
        )?;
        match self.types_words() {
            types if types.is_empty() => writeln!(output),
            types => writeln!(output, ": {types}"),
        }
    }

    /// The damaged lines by type as text: `A 7, B 5`.
    #[must_use]
    pub fn types_words(&self) -> String {
        let types = self
            .types()
            .map(|(letter, count)| format!("{letter} {count}"));
        types.collect::<Vec<_>>().join(", ")
    }
}

impl Serialize for Damaged {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let [checksum, shape, field] = self.kinds();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("lines", &self.lines())?;
        map.serialize_entry("checksum", &checksum)?;
        map.serialize_entry("shape", &shape)?;
        map.serialize_entry("field", &field)?;
        for (letter, count) in self.types() {
            map.serialize_entry(&letter, &count)?;
        }
        map.end()
    }
}

/// Bytes between intact lines, if there are any.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resync {
    /// Number of errors.
    pub count: u64,
    /// Latest.
    pub last_bytes: u64,
    /// Mean.
    pub mean_bytes: f64,
    /// Longest.
    pub worst_bytes: u64,
}

/// Time from the queueing of a command to its confirmation, seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Confirmation {
    /// Number of commands confirmed.
    pub count: u64,
    /// Time of the latest command, seconds.
    pub last_s: f64,
    /// Mean time, seconds.
    pub mean_s: f64,
    /// Longest time, seconds.
    pub worst_s: f64,
}

/// `part` in per cent of `whole`; 0 if `whole` is 0.
#[must_use]
pub fn per_cent(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 * 100.0 / whole as f64
    }
}

impl Statistics {
    /// Takes the decoder's totals; they give all downlink statistics except airtime and resync.
    pub fn count(&mut self, counters: &Counters) {
        self.lines = counters.intact();
        self.loss = Loss::of(counters);
        self.damaged = Damaged::of(counters);
        self.other = OtherRobot::of(counters);
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
    /// Takes the decoder's totals right after a line.
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

    /// Takes an interruption of the link; bytes before the next line are not errors.
    pub const fn interrupt(&mut self) {
        self.noise_bytes = None;
    }

    /// The resync statistics; `None` before the first error.
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

/// Measures the statistics of a link.
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
    /// Sets the radio's baud rate; the default is 2400.
    pub fn set_baud(&mut self, baud: u32) {
        for airtime in [&mut self.down, &mut self.up] {
            airtime.set_rate(baud / BITS_PER_BYTE);
        }
    }

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
        let airtime_down_pct = self.down.share_pct(now);
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
            airtime_down_pct,
            airtime_up_pct: airtime_down_pct.and_then(|_| self.up.share_pct(now)),
            ..Statistics::default()
        };
        statistics.count(counters);
        statistics
    }
}

#[cfg(test)]
mod tests;
