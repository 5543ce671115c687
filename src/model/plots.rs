//! Values over time in bounded memory: minimum and maximum per stretch of time, for several windows; and the outages.

use std::collections::VecDeque;

use groundwave_protocol::telemetry::{StateLine, StatusLine};

use super::link::Link;
use super::robot::{STATE_STALE, STATUS_STALE, ordered_wheels_in_s};
use crate::event::Moment;
use crate::outages::Outage;
use crate::statistics::Statistics;

/// Number of stretches in a window.
const STRETCHES: usize = 120;

/// The windows to choose from.
pub(crate) const WINDOWS: [(&str, Moment); 4] = [
    ("1 min", Moment::from_mins(1)),
    ("10 min", Moment::from_mins(10)),
    ("2 h", Moment::from_hours(2)),
    ("24 h", Moment::from_hours(24)),
];

/// The newest part of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Span {
    window: usize,
    halvings: u32,
}

impl Span {
    /// Length of the span.
    pub(crate) fn length(self) -> Moment {
        WINDOWS[self.window].1 / 2_u32.pow(self.halvings)
    }
}

/// A quantity that can be plotted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trace {
    /// Measured speed of a wheel, in/s.
    WheelLeft,
    WheelRight,
    /// Commanded wheel speeds, in/s.
    OrderLeft,
    OrderRight,
    /// Distance of a sonar, inches.
    SonarLeft,
    SonarRight,
    /// Darkness at a photocell, per cent.
    DarkLeft,
    DarkRight,
    /// Battery voltage, decivolts.
    Battery,
    /// Lines lost over 20 s, per cent.
    Loss,
    /// Number of damaged lines over 20 s.
    Damaged,
    /// Airtime over 20 s, per cent.
    AirDown,
    AirUp,
}

const TRACES: usize = Trace::AirUp as usize + 1;

/// Maximum number of halvings of the shortest window while the session is shorter.
const HALVINGS: u32 = 2;

/// A value that can be kept over time.
pub(crate) trait Figure: Copy + PartialOrd {
    /// A value not less than any other.
    const GREATEST: Self;
    /// A value not greater than any other.
    const LEAST: Self;
}

impl Figure for i16 {
    const GREATEST: Self = Self::MAX;
    const LEAST: Self = Self::MIN;
}

impl Figure for f32 {
    const GREATEST: Self = Self::INFINITY;
    const LEAST: Self = Self::NEG_INFINITY;
}

/// Maximum number of outages kept; the newest are kept.
const OUTAGES_MAX: usize = 100;

/// Minimum and maximum of a stretch; empty if the minimum is greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stretch<V> {
    least: V,
    greatest: V,
}

impl<V: Figure> Stretch<V> {
    const NOTHING: Self = Self {
        least: V::GREATEST,
        greatest: V::LEAST,
    };

    const fn of(value: V) -> Self {
        Self {
            least: value,
            greatest: value,
        }
    }

    fn include(&mut self, other: Self) {
        if other.least < self.least {
            self.least = other.least;
        }
        if other.greatest > self.greatest {
            self.greatest = other.greatest;
        }
    }

    fn is_nothing(self) -> bool {
        self.least > self.greatest
    }
}

/// One value over one window: a ring of stretches.
#[derive(Clone, Debug)]
struct Ring<V> {
    /// Length of one stretch.
    length: Moment,
    stretches: Vec<Stretch<V>>,
    /// Number of the newest stretch since moment zero.
    newest: u64,
}

impl<V: Figure> Ring<V> {
    const fn new(window: Moment) -> Self {
        Self {
            length: Moment::from_millis(window.as_millis() as u64 / STRETCHES as u64),
            stretches: Vec::new(),
            newest: 0,
        }
    }

    const fn number(&self, at: Moment) -> u64 {
        (at.as_millis() / self.length.as_millis()) as u64
    }

    /// Adds a value; `held` fills the stretches since the previous value, `None` leaves a gap.
    fn push(&mut self, now: Moment, value: V, held: Option<V>) {
        if self.stretches.is_empty() {
            self.stretches = vec![Stretch::NOTHING; STRETCHES];
            self.newest = self.number(now);
        }
        let number = self.number(now).max(self.newest);
        let skipped = (number - self.newest).min(STRETCHES as u64);
        let between = held.map_or(Stretch::NOTHING, Stretch::of);
        for back in (0..skipped).rev() {
            let at = ((number - back) % STRETCHES as u64) as usize;
            self.stretches[at] = if back == 0 { Stretch::NOTHING } else { between };
        }
        self.newest = number;
        let at = (number % STRETCHES as u64) as usize;
        self.stretches[at].include(Stretch::of(value));
    }

    /// The stretch that is `back` stretches before the current one.
    fn before(&self, now: Moment, back: u64) -> Stretch<V> {
        let Some(number) = self.number(now).max(self.newest).checked_sub(back) else {
            return Stretch::NOTHING;
        };
        if number > self.newest || self.newest - number >= STRETCHES as u64 {
            return Stretch::NOTHING;
        }
        let at = (number % STRETCHES as u64) as usize;
        self.stretches.get(at).copied().unwrap_or(Stretch::NOTHING)
    }
}

/// One value over all windows.
#[derive(Clone, Debug)]
pub(crate) struct Series<V> {
    rings: [Ring<V>; WINDOWS.len()],
    newest: Option<(Moment, V)>,
}

impl<V: Figure> Default for Series<V> {
    fn default() -> Self {
        Self {
            rings: WINDOWS.map(|(_, window)| Ring::new(window)),
            newest: None,
        }
    }
}

impl<V: Figure> Series<V> {
    /// Adds a value; the previous value fills the time until now if it is younger than `joined`.
    pub(super) fn push(&mut self, now: Moment, value: V, joined: Moment) {
        let held = self
            .newest
            .filter(|(at, _)| now.saturating_sub(*at) < joined)
            .map(|(_, value)| value);
        for ring in &mut self.rings {
            ring.push(now, value, held);
        }
        self.newest = Some((now, value));
    }

    /// The value over a time span until `now`, in `columns` columns, oldest first: minimum and maximum of each,
    /// `None` without a value.
    pub(crate) fn columns(&self, span: Span, now: Moment, columns: usize) -> Vec<Option<(V, V)>> {
        let ring = &self.rings[span.window];
        let stretches = STRETCHES >> span.halvings;
        let back = |column: usize| (columns - column) * stretches / columns.max(1);
        (0..columns)
            .map(|column| {
                let mut all = Stretch::NOTHING;
                let (oldest, newest) = (back(column), back(column + 1));
                for back in newest..oldest.max(newest + 1) {
                    all.include(ring.before(now, back as u64));
                }
                (!all.is_nothing()).then_some((all.least, all.greatest))
            })
            .collect()
    }
}

/// All values over time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Plots {
    series: [Series<i16>; TRACES],
    /// Time of the session's first value.
    since: Option<Moment>,
    /// Beginning and end of each outage.
    outages: VecDeque<(Moment, Moment)>,
    /// Beginning of an outage since which no line A has arrived.
    silent_since: Option<Moment>,
}

impl Plots {
    pub(super) fn take_state(&mut self, now: Moment, state: &StateLine, link: &Link) {
        // The end of the outage is reported only at the next line C.
        if let Some(begin) = self.silent_since.take() {
            self.add_outage(begin, now);
        }
        let [order_left, order_right] = ordered_wheels_in_s(state).map(|in_s| in_s as i16);
        let whole = |value: u16| i16::try_from(value).unwrap_or(i16::MAX);
        let figures = [
            (Trace::WheelLeft, Some(state.wheel_left_in_s.into())),
            (Trace::WheelRight, Some(state.wheel_right_in_s.into())),
            (Trace::OrderLeft, Some(order_left)),
            (Trace::OrderRight, Some(order_right)),
            (Trace::SonarLeft, state.sonar_left_in.map(whole)),
            (Trace::SonarRight, state.sonar_right_in.map(whole)),
            (Trace::DarkLeft, state.photo_left_pct.map(i16::from)),
            (Trace::DarkRight, state.photo_right_pct.map(i16::from)),
            (
                Trace::Loss,
                link.shares(now)
                    .map(|it| (it.unusable() * 100.0).round() as i16),
            ),
        ];
        for (trace, value) in figures {
            if let Some(value) = value {
                self.push(trace, now, value, STATE_STALE);
            }
        }
    }

    /// Takes an outage that has begun or ended.
    pub(super) fn take_outage(&mut self, outage: &Outage) {
        match outage.end {
            Some(end) => self.add_outage(outage.begin, end),
            None => self.silent_since = Some(outage.begin),
        }
    }

    fn add_outage(&mut self, begin: Moment, end: Moment) {
        if self.outages.back() != Some(&(begin, end)) {
            self.outages.push_back((begin, end));
        }
        if self.outages.len() > OUTAGES_MAX {
            self.outages.pop_front();
        }
    }

    /// The columns of a time span until `now` that overlap outages, as ranges between 0 and `columns`.
    pub(crate) fn outages(
        &self,
        span: Span,
        now: Moment,
        columns: usize,
    ) -> impl Iterator<Item = (f64, f64)> {
        let lasting = self.silent_since.map(|begin| (begin, now));
        let start_s = now.as_secs_f64() - span.length().as_secs_f64();
        let column = move |at: Moment| {
            let share = (at.as_secs_f64() - start_s) / span.length().as_secs_f64();
            share.clamp(0.0, 1.0) * columns as f64
        };
        let outages = self.outages.iter().copied().chain(lasting);
        outages
            .filter(move |(_, end)| end.as_secs_f64() > start_s)
            .map(move |(begin, end)| (column(begin), column(end)))
    }

    pub(super) fn take_statistics(&mut self, now: Moment, statistics: &Statistics, link: &Link) {
        let damaged = i16::try_from(link.damaged(now)).unwrap_or(i16::MAX);
        self.push(Trace::Damaged, now, damaged, STATE_STALE);
        for (trace, pct) in [
            (Trace::AirDown, statistics.airtime_down_pct),
            (Trace::AirUp, statistics.airtime_up_pct),
        ] {
            if let Some(pct) = pct {
                self.push(trace, now, pct.round() as i16, STATE_STALE);
            }
        }
    }

    pub(super) fn take_status(&mut self, now: Moment, status: &StatusLine) {
        let value = i16::try_from(status.battery_dv).unwrap_or(i16::MAX);
        self.push(Trace::Battery, now, value, STATUS_STALE);
    }

    fn push(&mut self, trace: Trace, now: Moment, value: i16, joined: Moment) {
        self.begin(now);
        self.series[trace as usize].push(now, value, joined);
    }

    /// Takes the time of a value; the first one is the beginning of the session's plots.
    pub(super) fn begin(&mut self, now: Moment) {
        self.since.get_or_insert(now);
    }

    /// The time span to show for an index in [`WINDOWS`]; a half or a quarter of the shortest window while the session is not longer.
    pub(crate) fn span(&self, window: usize, now: Moment) -> Span {
        let (_, whole) = WINDOWS[window];
        let age = self.since.map_or(whole, |since| now.saturating_sub(since));
        let fits = |halvings: &u32| window == 0 && age <= whole / 2_u32.pow(*halvings);
        Span {
            window,
            halvings: (0..=HALVINGS).rev().find(fits).unwrap_or_default(),
        }
    }

    /// Removes the downlink's airtime, which depends on how the bytes arrive.
    #[cfg(test)]
    pub(crate) fn forget_airtime(&mut self) {
        self.series[Trace::AirDown as usize] = Series::default();
    }

    /// A value over a time span until `now`; see [`Series::columns`].
    pub(crate) fn columns(
        &self,
        trace: Trace,
        span: Span,
        now: Moment,
        columns: usize,
    ) -> Vec<Option<(i16, i16)>> {
        self.series[trace as usize].columns(span, now, columns)
    }

    /// The newest value and its time.
    pub(crate) fn newest(&self, trace: Trace) -> Option<(Moment, i16)> {
        self.series[trace as usize].newest
    }

    /// Number of stretches kept, for tests of a session's memory.
    #[cfg(test)]
    pub(crate) fn size(&self) -> usize {
        let rings = self.series.iter().flat_map(|series| &series.rings);
        rings.map(|ring| ring.stretches.len()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn whole(window: usize) -> Span {
        Span {
            window,
            halvings: 0,
        }
    }

    const J: Moment = Moment::from_secs(2);

    #[test]
    fn a_column_has_the_least_and_the_greatest_of_its_time() {
        let mut plots = Plots::default();
        for n in 0..180_u64 {
            let at = Moment::from_millis(n * 333);
            plots.series[0].push(at, [5, -3, 7][n as usize % 3], J);
        }
        let now = Moment::from_millis(179 * 333);
        let columns = plots.columns(Trace::WheelLeft, whole(0), now, 20);
        assert!(
            columns[1..].iter().all(|column| *column == Some((-3, 7))),
            "{columns:?}"
        );
        assert_eq!(
            plots.columns(Trace::WheelLeft, whole(0), now, 300).len(),
            300
        );
        assert_eq!(plots.columns(Trace::WheelLeft, whole(0), now, 0), []);
    }

    #[test]
    fn a_gap_is_a_gap_and_a_slow_figure_is_none() {
        let mut plots = Plots::default();
        for s in [0_u64, 2, 4, 6, 30, 32] {
            plots.series[0].push(Moment::from_secs(s), s as i16, STATUS_STALE);
        }
        let columns = plots.columns(Trace::WheelLeft, whole(0), Moment::from_secs(40), 120);
        let known: Vec<usize> = (0..120)
            .filter(|&column| columns[column].is_some())
            .collect();
        // Each column is half a second; the newest is at the right.
        let from = |s: usize| 119 - 2 * (40 - s);
        let expected: Vec<usize> = (from(0)..=from(6)).chain(from(30)..=from(32)).collect();
        assert_eq!(known, expected);
        assert_eq!(columns[from(1)], Some((0, 0)), "held until the next");
    }

    #[test]
    fn a_day_takes_no_more_room_than_a_minute() {
        let mut plots = Plots::default();
        let push = |plots: &mut Plots, from_s: u64, to_s: u64| {
            for s in from_s..to_s {
                for series in &mut plots.series {
                    series.push(Moment::from_secs(s), (s % 100) as i16, J);
                }
            }
        };
        push(&mut plots, 0, 60);
        let minute = plots.size();
        push(&mut plots, 60, 86_400);
        assert_eq!(plots.size(), minute);
        let day = plots.columns(Trace::Loss, whole(3), Moment::from_secs(86_399), 100);
        assert!(day.iter().all(|column| *column == Some((0, 99))));
    }

    #[test]
    fn a_young_session_fills_the_picture() {
        let mut plots = Plots::default();
        assert_eq!(plots.span(0, J), whole(0), "nothing is known");
        let mut lengths_s = Vec::new();
        for s in 100..200 {
            let now = Moment::from_secs(s);
            plots.push(Trace::Loss, now, 7, J);
            let span = plots.span(0, now);
            lengths_s.push(span.length().as_secs());
            let columns = plots.columns(Trace::Loss, span, now, 40);
            let empty = columns.iter().filter(|column| column.is_none()).count();
            assert!(s < 108 || empty <= 20, "{empty} of 40 after {} s", s - 100);
        }
        lengths_s.dedup();
        assert_eq!(lengths_s, [15, 30, 60]);
    }
}
