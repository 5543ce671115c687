//! Outages (times without lines), recognized from the lines and the events of the link. Sans-IO: time is a parameter, memory is bounded.
//!
//! The number of lines lost in an outage is final at the robot's next line C, which gives the hundreds that the sequence does not
//! show.

use std::collections::VecDeque;
use std::fmt;

use groundwave_protocol::decoder::{Counters, LASTING_SILENCE_MS, Lost, Received};
use groundwave_protocol::{BYTES_PER_S, LINE_BYTES};
use serde::ser::{Serialize, SerializeMap, Serializer};

use crate::chunk::Chunk;
use crate::event::{Moment, OutageCause};
use crate::messages::{OutageMessage, StationEvent};
use crate::words::{lost_words, plural};

/// Minimum duration of an outage. Pauses at 2400 baud are whole lines long, a third of a second; the limit is between five lost lines and six,
/// so that the jitter of a line's arrival does not decide.
pub const OUTAGE_AFTER: Moment = Moment::from_millis(2150);

/// Duration from which an outage is reported before its end.
const BEGUN_AFTER: Moment = Moment::from_millis(LASTING_SILENCE_MS);

/// Maximum time between the end of an outage and the end of the suspension that explains it, or the next line, which shows the lines lost in it
/// if the first one had begun before; bytes that waited are read first.
const EXPLAINED_WITHIN: Moment = Moment::from_millis(500);

/// Minimum noise in an outage of a radio that was not silent, bytes.
const NOISE_BYTES: u64 = 160;

/// Maximum number of outages kept between two lines C.
const WAITING_MAX: usize = 64;

/// A time without lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Outage {
    /// Cause.
    pub cause: OutageCause,
    /// Beginning: the line before the outage, or the loss of the link.
    pub begin: Moment,
    /// End: the next line; `None` while the outage lasts.
    pub end: Option<Moment>,
    /// Lines lost in the outage, as far as known; open while it lasts.
    pub lost: Lost,
}

impl Outage {
    /// Duration; zero while the outage lasts.
    #[must_use]
    pub fn duration(&self) -> Moment {
        self.end
            .map_or(Moment::ZERO, |end| end.saturating_sub(self.begin))
    }

    /// The outage as a message of a recording that begins at `zero_ns` since 1970.
    #[must_use]
    pub fn to_message(&self, zero_ns: u64) -> OutageMessage {
        let since_1970_ns =
            |at: Moment| zero_ns.saturating_add(u64::try_from(at.as_nanos()).unwrap_or(u64::MAX));
        OutageMessage {
            code: self.cause.code().to_owned(),
            begin_ns: since_1970_ns(self.begin),
            end_ns: self.end.map(since_1970_ns),
            lines_lost: self.lost.min,
            lines_lost_max: self.lost.known_max(),
        }
    }
}

/// Writes text such as `silent 55.0 s from 12.0 s: 165 lines lost` or `gap at 12.0 s: 165 lines lost`.
impl fmt::Display for Outage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (cause, begin_s) = (self.cause.code(), self.begin.as_secs_f64());
        if self.end.is_none() {
            write!(f, "{cause} from {begin_s:.1} s on")?;
            if self.lost.is_open {
                return Ok(());
            }
        } else if self.cause == OutageCause::Gap {
            // The pause is not in the capture's times.
            write!(f, "{cause} at {begin_s:.1} s")?;
        } else {
            let lasted_s = self.duration().as_secs_f64();
            write!(f, "{cause} {lasted_s:.1} s from {begin_s:.1} s")?;
        }
        let (lost, plural) = (lost_words(self.lost), plural(self.lost.max));
        match (self.cause, self.lost.max) {
            // How many lines the robot sent before is unknown.
            (OutageCause::Rebooted, 0) if self.lost.is_open => {
                f.write_str(": an unknown number of lines lost")
            }
            (OutageCause::Rebooted, 0) => Ok(()),
            (OutageCause::Rebooted, max) if max == self.lost.min => {
                write!(f, ": {lost} line{plural} lost since the boot")
            }
            _ => write!(f, ": {lost} line{plural} lost"),
        }
    }
}

impl Serialize for Outage {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("code", self.cause.code())?;
        map.serialize_entry("begin_s", &self.begin.as_secs_f64())?;
        map.serialize_entry("end_s", &self.end.map(|end| end.as_secs_f64()))?;
        map.serialize_entry("lines_lost", &self.lost.min)?;
        map.serialize_entry("lines_lost_max", &self.lost.known_max())?;
        map.end()
    }
}

/// Recognizes outages.
#[derive(Clone, Debug, Default)]
pub struct Outages {
    latest: Option<Seen>,
    /// Time at which the link was lost; `None` if that was before the latest line.
    unplugged_at: Option<Moment>,
    /// Time at which this station was suspended; `None` if that was before the latest line.
    suspended_at: Option<Moment>,
    /// Reported cause and beginning of the current outage.
    begun: Option<(OutageCause, Moment)>,
    /// Outages that have ended since the latest line C.
    waiting: Vec<Outage>,
    /// Outages with a known number of lost lines that a suspension may still explain.
    settled: VecDeque<Outage>,
    /// The place since the latest line C where the loss of hundreds of lines is most likely.
    likeliest: Option<(Likelihood, Outage)>,
    found: VecDeque<Outage>,
}

/// Rank of a pause as the place of hundreds of lost lines that only the robot's clock shows. The longest outage ranks highest; without
/// outages, as in text without times, the pause with the most lost lines by sequence; then the longest pause.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Likelihood {
    outage: Option<Moment>,
    lost: u64,
    pause: Moment,
}

impl Likelihood {
    /// Rank of a pause in which the sequence shows `lost` lost lines.
    pub(crate) fn of(pause: Moment, lost: u64) -> Self {
        let outage = (pause >= OUTAGE_AFTER).then_some(pause);
        Self {
            outage,
            lost,
            pause,
        }
    }
}

/// Beginning of an outage in which the link was lost at a time after the latest line: that time, or the line if the silence had been
/// reported before.
fn begin_of(line_at: Moment, cause_at: Moment) -> Moment {
    if cause_at >= line_at + BEGUN_AFTER {
        line_at
    } else {
        cause_at.max(line_at)
    }
}

/// Whether sending a number of lines takes longer than a pause.
fn is_longer_than(lines: u64, pause: Moment) -> bool {
    let bytes = u128::from(lines) * LINE_BYTES as u128;
    bytes * 1000 > pause.as_millis() * u128::from(BYTES_PER_S)
}

/// Counts and time at a line.
#[derive(Clone, Copy, Debug)]
struct Seen {
    at: Moment,
    shown_lost: u64,
    hidden: Lost,
    unsettled: Lost,
    unclocked_gaps: u64,
    restarts: u64,
    noise_bytes: u64,
    replaced_robot: Option<u8>,
}

impl Seen {
    fn of(now: Moment, counters: &Counters) -> Self {
        Self {
            at: now,
            shown_lost: counters.lost().min.saturating_sub(counters.hidden.min),
            hidden: counters.hidden,
            unsettled: counters.unsettled,
            unclocked_gaps: counters.unclocked_gaps,
            restarts: counters.restarts,
            noise_bytes: counters.noise_bytes,
            replaced_robot: counters.replaced_robot,
        }
    }

    /// Whether more than stray bytes arrived since then that are no line.
    const fn has_noise_until(&self, counters: &Counters) -> bool {
        counters.noise_bytes.saturating_sub(self.noise_bytes) >= NOISE_BYTES
    }
}

impl Outages {
    /// Takes the loss of the link.
    pub fn handle_unplugged(&mut self, now: Moment) {
        if self.unplugged_at.is_none() {
            self.unplugged_at = Some(now);
            self.begin(OutageCause::Unplugged, now);
        }
    }

    /// Takes an event of the station.
    pub fn handle_event(&mut self, now: Moment, event: &StationEvent) {
        if event.is_loss_of_link() {
            self.handle_unplugged(now);
        } else if let Some(duration) = event.suspension() {
            self.handle_suspension(now.saturating_sub(duration));
        }
    }

    /// Takes the end of a suspension of this station, which began at `since`. Lines that waited may have come already.
    pub fn handle_suspension(&mut self, since: Moment) {
        let ended = self.settled.iter_mut().chain(&mut self.waiting);
        let is_silence =
            |it: &&mut Outage| matches!(it.cause, OutageCause::Silent | OutageCause::Damaged);
        let explained = ended
            .filter(is_silence)
            .find(|it| it.end.is_some_and(|end| end > since));
        match explained {
            // Its beginning may have been reported.
            Some(outage) => outage.cause = OutageCause::Suspended,
            None => self.suspended_at = Some(since),
        }
    }

    /// Takes a gap in the capture; its lines were received, so they are not lost.
    pub fn handle_missing(&mut self) {
        self.give_up_settling();
        self.latest = None;
    }

    /// Takes a line and the decoder's totals right after it.
    pub fn handle_line(&mut self, now: Moment, received: &Received, counters: &Counters) {
        self.report(now);
        let seen = Seen::of(now, counters);
        let Some(latest) = self.latest.replace(seen) else {
            return;
        };
        let has_restarted = counters.restarts > latest.restarts;
        let mut hidden = seen.hidden.since(latest.hidden);
        // Lines of the life before that counted as lost in the gap in which the robot booted.
        let never_sent = latest.shown_lost.saturating_sub(seen.shown_lost);
        let mut is_told = false;
        if has_restarted && never_sent > 0 {
            if let Some(gap) = self.longest_waiting() {
                gap.lost.min = gap.lost.min.saturating_sub(never_sent);
                gap.lost.max = gap.lost.max.saturating_sub(never_sent);
                gap.lost.is_open |= seen.hidden.is_open;
                is_told = gap.cause == OutageCause::Silent;
                if is_told {
                    gap.cause = OutageCause::Rebooted;
                }
            }
        } else if has_restarted {
            self.add_hidden(latest.unsettled);
            hidden = hidden.since(latest.unsettled);
            self.settle();
        }
        let (unplugged_at, suspended_at) = (self.unplugged_at.take(), self.suspended_at.take());
        let begun = self.begun.take().map(|(_, begin)| begin);
        let pause = now.saturating_sub(latest.at);
        // Lines that waited while this station was suspended do not count as an outage.
        let suspended_at = suspended_at.filter(|_| pause >= OUTAGE_AFTER);
        let is_interrupted = unplugged_at.or(suspended_at).is_some();
        let lost = seen.shown_lost.saturating_sub(latest.shown_lost);
        let is_unclocked = seen.unclocked_gaps > latest.unclocked_gaps;
        let shown = Lost {
            min: lost,
            max: lost,
            is_open: is_unclocked,
        };
        if pause >= OUTAGE_AFTER
            || is_interrupted
            || is_unclocked
            || has_restarted && !is_told
            || begun.is_some()
        {
            let has_noise = latest.has_noise_until(counters);
            let (cause, begin) = match (suspended_at, unplugged_at) {
                (Some(_), None) => (OutageCause::Suspended, latest.at),
                (Some(_), Some(at)) => (OutageCause::Suspended, begin_of(latest.at, at)),
                (None, Some(at)) => (OutageCause::Unplugged, begin_of(latest.at, at)),
                (None, None) if has_restarted => (OutageCause::Rebooted, latest.at),
                (None, None) if pause < OUTAGE_AFTER && begun.is_none() => {
                    (OutageCause::Gap, latest.at)
                }
                (None, None) if has_noise => (OutageCause::Damaged, latest.at),
                (None, None) => (OutageCause::Silent, latest.at),
            };
            let outage = Outage {
                cause,
                // Times of a damaged capture may go back.
                begin: begun.unwrap_or(begin).min(now).max(latest.at),
                end: Some(now.max(latest.at)),
                lost: shown,
            };
            self.waiting.push(outage);
            if has_restarted && is_interrupted {
                let rebooted = Outage {
                    cause: OutageCause::Rebooted,
                    lost: Lost::default(),
                    ..outage
                };
                self.waiting.push(rebooted);
            }
        } else if is_longer_than(lost, pause)
            && let Some(outage) = self.ended_at(latest.at)
        {
            outage.lost = outage.lost.and(shown);
        }
        let likelihood = Likelihood::of(pause, lost);
        if self.likeliest.is_none_or(|(it, _)| likelihood > it) {
            let gap = Outage {
                cause: OutageCause::Gap,
                begin: latest.at,
                end: Some(now),
                lost: shown,
            };
            self.likeliest = Some((likelihood, gap));
        }
        self.add_hidden(hidden);
        if seen.replaced_robot != latest.replaced_robot {
            // No clock shows how many lines the replaced robot sent.
            self.settle();
        }
        if received.uptime_s().is_some() {
            // The clock in line C has shown the hundreds, unless it is the first one. It counts from the boot, so it never shows how many
            // lines were lost before.
            let is_open = seen.hidden.since(latest.hidden).is_open;
            for gap in &mut self.waiting {
                let is_of_boot = gap.cause == OutageCause::Rebooted && seen.hidden.is_open;
                gap.lost.is_open &= is_open || is_of_boot;
            }
        }
        if received.uptime_s().is_some() || self.waiting.len() >= WAITING_MAX {
            self.settle();
            self.report(now);
        }
    }

    /// The outage that a line at `at` ended. If that line had begun before the outage, the next one shows how many were lost.
    fn ended_at(&mut self, at: Moment) -> Option<&mut Outage> {
        let ended = self.waiting.last_mut().or(self.settled.back_mut());
        ended.filter(|it| it.end == Some(at))
    }

    /// The longest outage since the previous line C; of two at one time, the loss of the link and not the boot.
    fn longest_waiting(&mut self) -> Option<&mut Outage> {
        let waiting = self.waiting.iter_mut().rev();
        waiting.max_by_key(|it| Likelihood::of(it.duration(), it.lost.min))
    }

    /// Adds lost lines that only the robot's clock shows, to the longest outage since the previous line C. A single lost line, after which
    /// hundreds remain possible, is no outage.
    fn add_hidden(&mut self, hidden: Lost) {
        if hidden.max == 0 && !hidden.is_open {
            return;
        }
        if let Some(outage) = self.longest_waiting() {
            outage.lost = outage.lost.and(hidden);
        } else if let Some((_, gap)) = self.likeliest.filter(|_| hidden.max > 0) {
            let lost = gap.lost.and(hidden);
            self.waiting.push(Outage { lost, ..gap });
        }
    }

    /// Reports the outages that have ended, although the robot's clock has not yet shown how many lines were lost.
    fn give_up_settling(&mut self) {
        self.add_hidden(self.latest.map_or_else(Lost::default, |it| it.unsettled));
        self.settle();
        self.found.extend(self.settled.drain(..));
    }

    /// Makes the number of lost lines final for the outages that have ended.
    fn settle(&mut self) {
        self.settled.extend(self.waiting.drain(..));
        self.likeliest = None;
    }

    /// Reports the outages with a known number of lost lines that no suspension can explain any more.
    fn report(&mut self, now: Moment) {
        while let Some(at) = self.report_at()
            && at <= now
        {
            self.found.extend(self.settled.pop_front());
        }
    }

    /// Time at which the next settled outage is to be reported.
    fn report_at(&self) -> Option<Moment> {
        let outage = self.settled.front()?;
        Some(outage.end? + EXPLAINED_WITHIN)
    }

    /// Handles the passing of time, with the decoder's totals: may begin an outage.
    pub fn handle_timeout(&mut self, now: Moment, counters: &Counters) {
        self.report(now);
        if let Some(latest) = self.latest
            && self.begin_at().is_some_and(|at| at <= now)
        {
            let cause = match self.suspended_at {
                Some(_) => OutageCause::Suspended,
                None if latest.has_noise_until(counters) => OutageCause::Damaged,
                None => OutageCause::Silent,
            };
            self.begin(cause, latest.at);
        }
    }

    /// Latest time for the next call of [`Self::handle_timeout`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        [self.begin_at(), self.report_at()]
            .into_iter()
            .flatten()
            .min()
    }

    /// Time at which the present silence is reported as an outage.
    fn begin_at(&self) -> Option<Moment> {
        let latest = self.latest.filter(|_| self.begun.is_none())?;
        Some(latest.at + BEGUN_AFTER)
    }

    /// Reports the beginning of an outage, unless one is reported already; its end will have the same beginning.
    fn begin(&mut self, cause: OutageCause, begin: Moment) {
        if self.latest.is_some() && self.begun.is_none() {
            self.begun = Some((cause, begin));
            self.found.push_back(Outage {
                cause,
                begin,
                end: None,
                lost: Lost {
                    is_open: true,
                    ..Lost::default()
                },
            });
        }
    }

    /// Whether an outage has been reported as begun and lasts.
    #[must_use]
    pub const fn is_lasting(&self) -> bool {
        self.begun.is_some()
    }

    /// Takes the end of the session and the decoder's totals until then: reports outages whose number of lost lines is not final, and one that lasts with the
    /// lines that may be lost in it.
    pub fn finish(&mut self, now: Moment, counters: &Counters) {
        self.handle_timeout(now, counters);
        self.found.pop_back_if(|it| it.end.is_none());
        let latest = self.latest;
        let lost = latest.map_or_else(Lost::default, |it| counters.unsettled.since(it.unsettled));
        if self.begun.is_none()
            && let Some(outage) = latest.and_then(|it| self.ended_at(it.at))
        {
            // The line after it may have begun before it.
            outage.lost = outage.lost.and(lost);
        }
        self.give_up_settling();
        if let (Some(_), Some((cause, begin))) = (self.latest.take(), self.begun) {
            self.found.push_back(Outage {
                cause,
                begin,
                end: None,
                lost,
            });
        }
    }

    /// The next outage, which is returned twice with the same beginning: when it begins, if [`Self::handle_timeout`] is called or the link is lost, and when it has ended
    /// or the session has.
    pub fn poll(&mut self) -> Option<Outage> {
        self.found.pop_front()
    }
}

/// List of a capture's outages.
#[derive(Clone, Debug, Default)]
pub struct OutageList {
    outages: Outages,
    ended: Vec<Outage>,
    lasting: Option<Outage>,
}

/// Maximum number of outages in a list; the first ones are kept.
const LISTED_MAX: usize = 10_000;

impl OutageList {
    /// Takes a line and the decoder's totals right after it.
    pub fn handle_line(&mut self, now: Moment, received: &Received, counters: &Counters) {
        self.outages.handle_line(now, received, counters);
        self.collect();
    }

    /// The outages that have ended so far.
    #[must_use]
    pub fn ended(&self) -> &[Outage] {
        &self.ended
    }

    /// Takes a gap in the capture; its lines were received, so they are not lost.
    pub fn handle_missing(&mut self) {
        self.outages.handle_missing();
        self.collect();
    }

    /// Takes an event of the station.
    pub fn handle_event(&mut self, now: Moment, event: &StationEvent) {
        self.outages.handle_event(now, event);
        self.collect();
    }

    /// Takes the gap before a chunk.
    pub fn handle_chunk(&mut self, chunk: &Chunk<'_>) {
        if chunk.is_after_missing {
            self.outages.handle_missing();
        }
        if let Some(at) = chunk.unplugged_at {
            self.outages.handle_unplugged(at);
        }
        if let Some(at) = chunk.suspended_at {
            self.outages.handle_suspension(at);
        }
        self.collect();
    }

    fn collect(&mut self) {
        while let Some(outage) = self.outages.poll() {
            self.lasting = outage.end.is_none().then_some(outage);
            if outage.end.is_some() && self.ended.len() < LISTED_MAX {
                self.ended.push(outage);
            }
        }
    }

    /// The outages in the order of their ends, with the decoder's totals until `end`; an outage that lasts at the end of the capture comes last.
    #[must_use]
    pub fn into_outages(mut self, end: Moment, counters: &Counters) -> Vec<Outage> {
        self.outages.finish(end, counters);
        self.collect();
        self.ended.extend(self.lasting);
        self.ended
    }
}

#[cfg(test)]
mod tests;
