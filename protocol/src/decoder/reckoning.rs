//! Counts whole hundreds of lost lines, which the sequence does not show: from the uptime in line C; until the next line C, from the ground's
//! clock.

use super::Counters;
use crate::life::UPTIME_ROUND_S;
use crate::telemetry::{ACK_LINE_BYTES, SEQUENCE_MODULUS};
use crate::{BYTES_PER_S, LINE_BYTES};

/// Robot time without loss after which the robot's own rate is known more exactly than the wire's, seconds.
const MEASURED_S: u64 = 8;

/// Robot time without loss after which its rate is likelier than the wire's, if it differs by more than its error, seconds.
const LIKELY_S: u64 = 3;

/// Maximum time between two lines C without a gap that counts as without loss, seconds; three lines per second need longer for a
/// hundred.
const CLEAN_S: u64 = 30;

/// Minimum ground time between two lines that counts as a silence, in which lines may have been lost, ms.
pub(super) const SILENCE_MS: u64 = 2000;

/// Minimum ground time without a line at the end of a stream that counts as a silence, ms: a line that arrived in time has been read by then.
pub const LASTING_SILENCE_MS: u64 = 2400;

/// Minimum ground time without loss after which its rate is used for the duration of a gap, ms.
const HEARD_MS: u64 = 1000;

/// Error of the ground time in which lines were heard, ms: their jitter.
const HEARD_ERROR_MS: u64 = 500;

/// Maximum ground time for which lines may come later, all at once, ms.
const UNSPENT_MS: u64 = 60_000;

/// Share of a line by which it may come too early for its lines to fit exactly: the jitter of reading.
const EARLY_PART: u64 = 4;

/// Number of bytes per line in the densest mix of lines: one long and three short lines.
const DENSEST_BYTES: u64 = (LINE_BYTES as u64 + 3 * ACK_LINE_BYTES as u64) / 4;

/// A number of lost lines, or an interval if the number is not known exactly.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lost {
    /// Number of lines that are certainly lost.
    pub min: u64,
    /// Number of lines that may be lost, including the certain ones.
    pub max: u64,
    /// Whether more lines may be lost, any number of them: the outage lasts, or no clock shows how long the robot was not heard, as in text
    /// without timestamps.
    pub is_open: bool,
}

impl Lost {
    /// Between two numbers of lines.
    #[must_use]
    pub const fn between(min: u64, max: u64) -> Self {
        Self {
            min,
            max,
            is_open: false,
        }
    }

    /// Maximum number of lines that may be lost; `None` if it is open.
    #[must_use]
    pub const fn known_max(self) -> Option<u64> {
        if self.is_open { None } else { Some(self.max) }
    }

    /// The lines lost since an earlier count.
    #[must_use]
    pub const fn since(self, before: Self) -> Self {
        Self {
            min: self.min.saturating_sub(before.min),
            max: self.max.saturating_sub(before.max),
            is_open: self.is_open && !before.is_open,
        }
    }

    /// The sum of both numbers.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            min: self.min.saturating_add(other.min),
            max: self.max.saturating_add(other.max),
            is_open: self.is_open || other.is_open,
        }
    }
}

impl AtCounters {
    /// Number of lines between a boot and the first line received after it.
    pub(super) fn lines_before(&self) -> u64 {
        self.before_first.map_or(0, u64::from)
    }
}

/// How many bytes the robot sends.
struct Rate {
    bytes_per_s: u64,
    error_pct: u64,
    /// Whether it is the wire's rate, because the robot's own is not known.
    is_guess: bool,
}

/// Compares the robot's clock with the sequence, from line C to line C.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reckoning {
    /// The sum of all steps of the sequence, and the number of lines by which the latest line is behind.
    progress: i64,
    behind: u8,
    /// The same number if that line was lost before; 0 if it has the sequence of one that arrived.
    late: u8,
    latest: Option<AtCounters>,
    /// Lines since then that arrived once more, by the ground's clock.
    repeated: Repeated,
    /// Maximum number of lines that the robot can have sent in the silence before the latest line, if that line is the next one by its sequence: it may
    /// have begun before the silence.
    most_before: u64,
    /// Bytes and seconds of the parts with a certain number of lost lines, and the number of separate parts after the first.
    clean_bytes: u64,
    clean_s: u64,
    breaks: u64,
    was_measured: bool,
    /// Whether a short line arrived since the line C before the latest one, in this life.
    has_short: bool,
    takes_turns: bool,
    /// Ground time of the next bytes, and of the latest line, ms.
    now_ms: Option<u64>,
    line_ms: Option<u64>,
    /// Ground time that sending the lines has not taken up: the latest pause, and earlier ones after which lines came at once; ms.
    unspent_ms: u64,
    /// Number of bytes and ground time (ms) without loss and silence.
    heard_bytes: u64,
    heard_ms: u64,
}

/// Lines that arrived once more.
#[derive(Clone, Copy, Debug, Default)]
struct Repeated {
    lines: u64,
    bytes: u64,
    /// Whether the latest line is one.
    is_latest: bool,
}

/// Counts and time at a line C, or at a boot.
#[derive(Clone, Copy, Debug)]
pub(super) struct AtCounters {
    uptime_s: u32,
    /// Number of frames that the robot has heard since its boot, modulo 1000.
    frames_heard: u16,
    progress: i64,
    lines: u64,
    ack_lines: u64,
    lines_lost: u64,
    /// Number of lines before the first line received after a boot; `None` for a line C.
    before_first: Option<u8>,
}

impl Reckoning {
    /// Takes a step of the sequence.
    pub(super) const fn advance(&mut self, lines: u8) {
        self.progress += lines as i64;
        (self.behind, self.late) = (0, 0);
        self.repeated.is_latest = false;
    }

    /// Takes a late or repeated line, which is behind the newest by a number of lines.
    pub(super) const fn set_behind(&mut self, lines: u8, is_late: bool) {
        (self.behind, self.late) = (lines, if is_late { lines } else { 0 });
        self.repeated.is_latest = false;
    }

    /// Takes a line of `length` bytes that arrived once more, after a pause in which no gap fits; without times, it may follow a gap.
    pub(super) const fn take_repeated(&mut self, length: usize) {
        if self.now_ms.is_none() {
            return;
        }
        self.repeated.lines += 1;
        self.repeated.bytes += length as u64;
        self.repeated.is_latest = true;
    }

    /// Whether the latest line arrived once more, by the ground's clock.
    pub(super) const fn is_repeated(&self) -> bool {
        self.repeated.is_latest
    }

    /// Goes on at a line behind the newest one, which followed a gap; returns by how many lines it is behind. A late line stays late.
    pub(super) fn go_back(&mut self) -> u8 {
        let behind = self.behind - self.late;
        self.progress -= i64::from(behind);
        self.behind -= behind;
        behind
    }

    /// Whether the latest line came late.
    pub(super) const fn is_late(&self) -> bool {
        self.late > 0
    }

    /// Sets the ground's time of the next bytes, ms.
    pub(super) const fn set_time(&mut self, now_ms: Option<u64>) {
        self.now_ms = now_ms;
    }

    /// The ground's time of the next bytes, ms.
    pub(super) const fn time(&self) -> Option<u64> {
        self.now_ms
    }

    /// The ground's time since the latest line of the followed robot, ms; `None` if it is unknown.
    pub(super) fn silence_ms(&self) -> Option<u64> {
        Some(self.now_ms?.saturating_sub(self.line_ms?))
    }

    /// Takes the time of a line, whether it is the next one by its sequence, and its length; returns the maximum number of lines that the robot
    /// can have sent in a silence before it, if there was one.
    pub(super) fn take_pause(&mut self, is_next: bool, length: usize) -> Option<u64> {
        self.has_short |= length < LINE_BYTES;
        self.most_before = 0;
        let before = core::mem::replace(&mut self.line_ms, self.now_ms)?;
        let pause_ms = self.now_ms?.saturating_sub(before);
        self.unspent_ms = self.unspent_ms.saturating_add(pause_ms).min(UNSPENT_MS);
        if pause_ms < SILENCE_MS {
            if is_next {
                self.heard_bytes += length as u64;
                self.heard_ms += pause_ms;
            }
            return None;
        }
        let most = self.most_in(pause_ms);
        self.most_before = if is_next { most } else { 0 };
        Some(most)
    }

    /// Maximum number of lines that the robot can send in a ground time, ms.
    pub(super) fn most_in(&self, pause_ms: u64) -> u64 {
        let (_, most) = self.expected(pause_ms / 1000, 0, self.has_short);
        u64::try_from(most).unwrap_or(0)
    }

    /// Maximum number of lines that the robot can have sent since the latest one until `now_ms`; 0 without a silence, unless the link was lost.
    pub(super) fn most_until(&self, now_ms: u64, is_interrupted: bool) -> u64 {
        let most = match self.line_ms.map(|at_ms| now_ms.saturating_sub(at_ms)) {
            Some(pause_ms) if is_interrupted || pause_ms >= LASTING_SILENCE_MS => {
                self.most_in(pause_ms)
            }
            _ => 0,
        };
        most + self.most_before
    }

    /// Maximum number of lines that the robot can have sent in the time before a line of `length` bytes, which is no silence; 0 if the
    /// time is unknown. To be called before the line is taken.
    pub(super) fn fitting(&self, length: usize) -> u64 {
        let line = self.densest_line();
        let sent = |ms: u64| {
            let (bytes, of_ms) = self.measured().unwrap_or((BYTES_PER_S.into(), 1000));
            let early = length as u64 / EARLY_PART;
            (ms * bytes / of_ms + early).saturating_sub(length as u64) / line
        };
        self.silence_ms().map_or(0, sent)
    }

    /// Takes a line of `length` bytes after `lost` lost lines. Returns whether the ground's clock shows too little time for sending the
    /// lost lines, so that it does not contain the pause.
    pub(super) const fn spend(&mut self, lost: u64, length: usize) -> bool {
        let (bytes, ms) = match self.measured() {
            Some(rate) => rate,
            None if self.now_ms.is_none() => (BYTES_PER_S as u64, 1000),
            None => {
                // How long these lines took is not known.
                self.unspent_ms = 0;
                return false;
            }
        };
        let line = self.densest_line();
        if bytes == 0 {
            return false;
        }
        let is_missing = lost * line * ms / bytes > self.unspent_ms + SILENCE_MS;
        let spent_ms = (lost * line + length as u64) * ms / bytes;
        self.unspent_ms = self.unspent_ms.saturating_sub(spent_ms);
        is_missing
    }

    /// The robot's rate as bytes in ms, if it is measured.
    const fn measured(&self) -> Option<(u64, u64)> {
        if self.clean_s >= MEASURED_S {
            Some((self.clean_bytes, self.clean_s * 1000))
        } else if self.heard_ms >= HEARD_MS {
            Some((self.heard_bytes, self.heard_ms))
        } else {
            None
        }
    }

    /// Mean length of a line in the densest mix that is likely now, bytes.
    const fn densest_line(&self) -> u64 {
        if self.has_short {
            DENSEST_BYTES
        } else {
            LINE_BYTES as u64
        }
    }

    /// The state at the first line received after a boot. The boot set the sequence to 0, so earlier lines are lost.
    pub(super) const fn boot(
        &self,
        sequence: u8,
        counters: &Counters,
        length: usize,
    ) -> AtCounters {
        let is_long = length == LINE_BYTES;
        AtCounters {
            uptime_s: 0,
            frames_heard: 0,
            progress: self.progress - 1,
            lines: counters.lines - counters.other_lines - is_long as u64,
            ack_lines: counters.ack_lines - counters.other_ack_lines - !is_long as u64,
            lines_lost: counters.lines_lost,
            before_first: Some(sequence),
        }
    }

    /// Begins again at a boot.
    pub(super) fn begin(&mut self, boot: AtCounters) {
        self.latest = Some(boot);
        self.repeated = Repeated::default();
        self.was_measured = false;
    }

    /// Takes a go-ahead (line G), which shows that the robot is half duplex.
    pub(super) const fn take_go_ahead(&mut self) {
        self.takes_turns = true;
    }

    /// Drops the latest line C, after a reboot or missing bytes.
    pub(super) const fn forget(&mut self) {
        self.latest = None;
        self.was_measured = false;
    }

    /// Drops the time of the latest line, after missing bytes.
    pub(super) const fn forget_time(&mut self) {
        self.line_ms = None;
    }

    /// Whether a line C or a boot is known, so that the next line C shows the hundreds.
    pub(super) const fn has_begun(&self) -> bool {
        self.latest.is_some()
    }

    /// Whether short lines arrived recently.
    pub(super) const fn has_short(&self) -> bool {
        self.has_short
    }

    /// Takes the uptime and the frames heard of a line C; returns the lines lost since the previous line C that are not in `lines_lost`.
    pub(super) fn take_uptime(
        &mut self,
        uptime_s: u32,
        frames_heard: u16,
        counters: &Counters,
    ) -> Lost {
        let now = AtCounters {
            uptime_s,
            frames_heard,
            progress: self.progress - i64::from(self.behind),
            lines: counters.lines - counters.other_lines,
            ack_lines: counters.ack_lines - counters.other_ack_lines,
            lines_lost: counters.lines_lost,
            before_first: None,
        };
        let repeated = core::mem::take(&mut self.repeated);
        let Some(then) = self.latest.replace(now) else {
            return Lost::default();
        };
        let passed_s = u64::from((uptime_s + UPTIME_ROUND_S - then.uptime_s) % UPTIME_ROUND_S);
        let long = now.lines - then.lines;
        let short = now.ack_lines - then.ack_lines;
        let bytes = long * LINE_BYTES as u64 + short * ACK_LINE_BYTES as u64;
        let bytes = bytes.saturating_sub(repeated.bytes);
        // Negative if a gap looked like a late line, or, without times, lines were repeated.
        let missing = now.progress - then.progress + repeated.lines as i64 - (long + short) as i64;
        // Negative if lines that were lost before the earlier line C look late.
        let counted = now.lines_lost as i64 - then.lines_lost as i64;
        let had_short = core::mem::replace(&mut self.has_short, short > 0);
        // The robot acknowledges the frames that it hears with short lines, also while it is not heard.
        let is_mixed = had_short || short > 0 || frames_heard != then.frames_heard;
        let is_plausible = self.clean_s < MEASURED_S
            || bytes * self.clean_s * 2 >= self.clean_bytes * passed_s.saturating_sub(1);
        let is_clean = missing == 0
            && counted == 0
            && passed_s < CLEAN_S
            && is_plausible
            && then.before_first.is_none();
        let was_measured = core::mem::replace(&mut self.was_measured, false);
        if is_clean {
            self.measure(was_measured, bytes, passed_s);
            return Lost::default();
        }
        let (least, most) = self.expected(passed_s, bytes, is_mixed);
        if let Some(before_first) = then.before_first {
            // A robot may begin to send some time after its boot, so the uptime gives only the maximum number of lines sent. A robot
            // whose first line was received has lost none before it.
            let unseen = most - missing - i64::from(before_first);
            let hidden = unseen / MODULUS * MODULUS;
            let max = if before_first == 0 { 0 } else { hidden.max(0) };
            return Lost::between(0, max as u64);
        }
        let hundreds = |lines: i64| (lines - missing).max(0) / MODULUS;
        let (min, max) = (hundreds(least + MODULUS - 1), hundreds(most));
        let is_possible = min <= max && missing <= most;
        let is_guess = self.rate().is_guess;
        // The steps of the sequence alone tell the rate, where they fit it and a hundred more do not, or where no number fits a
        // guessed rate.
        let is_measure = passed_s < CLEAN_S
            && !is_mixed
            && !self.takes_turns
            && if is_possible { max == 0 } else { is_guess };
        let nearest = hundreds(i64::midpoint(least, most) + MODULUS / 2);
        let (min, max) = match (is_possible, is_guess) {
            // Until a part fits the wire's rate, the robot may be slow.
            (true, true) if !self.is_wire_rate_likely() => (0, max),
            (true, _) => (min, max),
            (false, true) if is_measure => (0, 0),
            (false, true) => (0, nearest),
            (false, false) => (nearest, nearest),
        };
        if let Ok(missing) = u64::try_from(missing)
            && is_measure
        {
            self.measure(was_measured, bytes + missing * LINE_BYTES as u64, passed_s);
        }
        let hidden = |hundreds: i64| match hundreds {
            0 => 0,
            _ => (missing + hundreds * MODULUS - counted).max(0) as u64,
        };
        let (min, max) = (hidden(min), hidden(max));
        // A late line C may also have followed a gap: then the lines up to the newest one seem to be late after it.
        let after = if max > 0 { self.late } else { 0 };
        Lost::between(min, max + u64::from(after))
    }

    /// Takes the bytes that the robot sent in `passed_s` of its clock; `is_next` if the previous time was measured, too.
    const fn measure(&mut self, is_next: bool, bytes: u64, passed_s: u64) {
        self.breaks += !is_next as u64;
        self.clean_bytes += bytes;
        self.clean_s += passed_s;
        self.was_measured = true;
    }

    /// The robot's measured rate, or the wire's, which is more likely until a measurement differs.
    fn rate(&self) -> Rate {
        let wire = u64::from(BYTES_PER_S);
        let rate = |bytes_per_s, error_pct| Rate {
            bytes_per_s,
            error_pct,
            is_guess: false,
        };
        if self.clean_s >= MEASURED_S {
            let parts = 1 + self.breaks.isqrt();
            let error_pct = 2 + parts * 100 / self.clean_s;
            return rate(self.clean_bytes / self.clean_s, error_pct);
        }
        let clean = (self.clean_s >= LIKELY_S)
            .then(|| (self.clean_bytes / self.clean_s, 2 + 100 / self.clean_s));
        let heard = (self.heard_ms >= HEARD_MS).then(|| self.heard_bytes * 1000 / self.heard_ms);
        // Lines that come late, all at once, are heard faster than the robot sends them.
        let is_clean = |heard: u64| {
            clean.is_none_or(|(rate, error_pct)| heard.abs_diff(rate) * 100 <= rate * error_pct)
        };
        let (likely, error_pct) = if let Some(heard) = heard.filter(|heard| is_clean(*heard)) {
            if self.heard_ms >= MEASURED_S * 1000 {
                return rate(heard, 3);
            }
            (heard, 3 + HEARD_ERROR_MS * 100 / self.heard_ms)
        } else {
            clean.unwrap_or((wire, 3))
        };
        if likely.abs_diff(wire) * 100 > wire * error_pct {
            return rate(likely, error_pct);
        }
        Rate {
            is_guess: true,
            ..rate(wire, 3)
        }
    }

    /// Whether the parts measured so far fit the wire's rate.
    const fn is_wire_rate_likely(&self) -> bool {
        let usual_bytes = self.clean_s * BYTES_PER_S as u64;
        let second_bytes = self.breaks * BYTES_PER_S as u64;
        self.clean_s > 0 && self.clean_bytes.abs_diff(usual_bytes) <= second_bytes
    }

    /// Minimum and maximum number of lines that can be missing among `bytes` in `passed_s` of the robot's clock, which counts
    /// whole seconds.
    fn expected(&self, passed_s: u64, bytes: u64, is_mixed: bool) -> (i64, i64) {
        let Rate {
            bytes_per_s: rate,
            error_pct,
            ..
        } = self.rate();
        let (least_rate, most_rate) = if self.takes_turns {
            // The time includes the ground's turns.
            (rate / 4, rate * 2)
        } else {
            (
                rate * 100_u64.saturating_sub(error_pct) / 100,
                rate * (100 + error_pct) / 100,
            )
        };
        let densest = if is_mixed {
            DENSEST_BYTES
        } else {
            LINE_BYTES as u64
        };
        let missing = |sent: u64, line: u64| (sent as i64 - bytes as i64) / line as i64;
        let least = missing(least_rate * passed_s.saturating_sub(1), LINE_BYTES as u64);
        let most = missing(most_rate * (passed_s + 1), densest);
        (least - 1, most + 1)
    }
}

const MODULUS: i64 = SEQUENCE_MODULUS as i64;
