//! The holder of the motors (the behaviour that controls them): since when, its share of the time, and the number of changes.

use std::collections::VecDeque;

use groundwave_protocol::status_codes::{Arm, Cliff, Layer, LayerState, Mode};
use groundwave_protocol::telemetry::{CountersLine, HOLDERS, StateLine};

use super::robot::Reading;
use crate::event::Moment;

/// Modulus of the tick counts in line C (ticks in which each behaviour controlled the motors).
const TICKS_MODULUS: u16 = 4096;

/// Maximum time between two counts without an unseen wrap, at twenty ticks per second.
const TICKS_UNAMBIGUOUS: Moment = Moment::from_mins(3);

/// Time over which the shares are measured.
const SHARE_WINDOW: Moment = Moment::from_mins(1);

/// Steps of the share window.
const SHARE_STEP: Moment = Moment::from_secs(6);

/// Number of changes between layers within [`THRASH_WINDOW`] that counts as thrashing. Changes to and from prowl
/// and dead reckoning are ordinary steering round obstacles.
const THRASH_CHANGES: usize = 6;

const THRASH_WINDOW: Moment = Moment::from_secs(8);

/// Time between two lines A after which it is unknown whether a state lasted meanwhile.
const UNSEEN: Moment = Moment::from_secs(10);

/// A holder of the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holder {
    /// One of the eight layers.
    Layer(Layer),
    /// Prowl, the default behaviour below the layers.
    Prowl,
    /// The cliff guard, which acts after the layers: there is no floor in the winner's direction.
    CliffGuard,
    /// The arm guard, which acts after the layers: the arm is not stowed yet.
    ArmGuard,
    /// No layer: the motors are off.
    NoLayer,
}

impl Holder {
    /// The holder by one line A, with the cliff guard on.
    pub(crate) fn of(state: &StateLine) -> Self {
        match (state.layers.holder(), state.mode) {
            (None, mode) if mode != Mode::Stop && lacks_floor(state) => Self::CliffGuard,
            (None, mode) if mode != Mode::Stop && state.arm == Arm::Up => Self::ArmGuard,
            _ => Self::unguarded(state),
        }
    }

    /// The holder by one line A.
    fn guarded(state: &StateLine, is_unguarded: bool) -> Self {
        match Self::of(state) {
            Self::CliffGuard if is_unguarded => Self::unguarded(state),
            holder => holder,
        }
    }

    /// The holder by one line A, with the cliff guard off.
    fn unguarded(state: &StateLine) -> Self {
        match (state.layers.holder(), state.mode) {
            (Some(layer), _) => Self::Layer(layer),
            (None, Mode::User) => Self::Layer(Layer::User),
            (None, mode) if prowls(mode) => Self::Prowl,
            (None, _) => Self::NoLayer,
        }
    }

    /// Whether the holder is ordinary steering.
    pub(super) const fn is_routine(self) -> bool {
        matches!(self, Self::Prowl | Self::Layer(Layer::Sonar | Layer::Photo))
    }

    /// Whether the holder is a layer that interrupts the robot on its way.
    const fn reacts(self) -> bool {
        matches!(self, Self::Layer(layer) if !matches!(layer, Layer::DeadReckoning))
    }

    /// Index of the holder in the tick counts of line C.
    pub(crate) const fn place(self) -> Option<usize> {
        match self {
            Self::Layer(layer) => Some(layer as usize),
            Self::Prowl => Some(HOLDERS - 1),
            Self::CliffGuard | Self::ArmGuard | Self::NoLayer => None,
        }
    }
}

/// Whether prowl runs below the layers in a mode.
pub(crate) const fn prowls(mode: Mode) -> bool {
    matches!(
        mode,
        Mode::Prowl | Mode::Wander | Mode::GoHome | Mode::Forage | Mode::Calibrate
    )
}

/// Whether a sensor sees no floor, or the cliff guard acts on it.
pub(crate) const fn lacks_floor(state: &StateLine) -> bool {
    !matches!(state.cliff, Cliff::None | Cliff::NotFitted)
}

/// Layers suppressed by a holder, in order of priority. A flag raised above the
/// holder was lowered before the line was sent.
pub(crate) fn suppressed(holder: Holder, state: &StateLine) -> Vec<Holder> {
    let above = match holder {
        Holder::Layer(holder) => Some(holder),
        Holder::CliffGuard | Holder::ArmGuard => None,
        Holder::Prowl | Holder::NoLayer => return Vec::new(),
    };
    let mut suppressed: Vec<Holder> = Layer::ALL
        .into_iter()
        .filter(|&layer| above.is_none_or(|above| layer > above))
        .filter(|&layer| state.layers.get(layer) == LayerState::Raised)
        .map(Holder::Layer)
        .collect();
    if prowls(state.mode) {
        suppressed.push(Holder::Prowl);
    }
    suppressed
}

/// The history of the holders.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motors {
    holder: Option<Reading<Holder>>,
    /// The state of each layer, and since when.
    rungs: [Option<Reading<LayerState>>; Layer::ALL.len()],
    changes: VecDeque<Moment>,
    /// Time of the newest line A.
    heard_at: Moment,
    /// Whether the ages of the states begin with the next report.
    starts_afresh: bool,
    samples: Tally,
    ticks: Tally,
    newest_counters: Option<Reading<CountersLine>>,
}

impl Motors {
    /// Takes a line A; returns whether the holder changed.
    pub(super) fn take_state(
        &mut self,
        now: Moment,
        state: &StateLine,
        is_unguarded: bool,
    ) -> bool {
        if now.saturating_sub(self.heard_at) > UNSEEN {
            self.start_afresh();
        }
        self.heard_at = now;
        let mut won = [0; HOLDERS];
        if let Some(place) = Holder::guarded(state, is_unguarded).place() {
            won[place] = 1;
        }
        // Lines without a holder also advance the window.
        self.samples.add(now, &won);
        self.take_holder(now, state, is_unguarded)
    }

    /// Takes the robot's state without counting a line A for the shares; returns whether the holder changed.
    pub(super) fn take_holder(
        &mut self,
        now: Moment,
        state: &StateLine,
        is_unguarded: bool,
    ) -> bool {
        let holder = Holder::guarded(state, is_unguarded);
        if std::mem::take(&mut self.starts_afresh) {
            let rungs = self.rungs.iter_mut().flatten();
            rungs.for_each(|rung| rung.at = now);
            self.holder.iter_mut().for_each(|held| held.at = now);
        }
        self.take_rungs(now, holder, state);
        if self.holder.is_some_and(|held| held.value == holder) {
            return false;
        }
        let last = self.holder.map(|held| held.value);
        if last.is_some_and(Holder::reacts) && holder.reacts() {
            self.changes.push_back(now);
            if self.changes.len() > THRASH_CHANGES {
                self.changes.pop_front();
            }
        }
        self.holder = Some(Reading {
            value: holder,
            at: now,
        });
        true
    }

    /// Forgets since when the robot has been in its state.
    pub(super) fn start_afresh(&mut self) {
        self.starts_afresh = true;
    }

    fn take_rungs(&mut self, now: Moment, holder: Holder, state: &StateLine) {
        for (layer, rung) in Layer::ALL.into_iter().zip(&mut self.rungs) {
            let value = match layer {
                Layer::User if holder == Holder::Layer(Layer::User) => LayerState::Holds,
                Layer::User => LayerState::Quiet,
                layer => state.layers.get(layer),
            };
            if rung.is_none_or(|known| known.value != value) {
                *rung = Some(Reading { value, at: now });
            }
        }
    }

    /// Time since which a layer has been in its state; `None` before the first report.
    pub(crate) fn since(&self, layer: Layer) -> Option<Moment> {
        self.rungs
            .get(layer as usize)
            .copied()
            .flatten()
            .map(|rung| rung.at)
    }

    /// Takes a line C.
    pub(super) fn take_counters(&mut self, now: Moment, counters: &CountersLine) {
        let reading = Reading {
            value: *counters,
            at: now,
        };
        let Some(last) = self.newest_counters.replace(reading) else {
            return;
        };
        let same_life = last.value.boots == counters.boots
            && last.value.uptime_s <= counters.uptime_s
            && last.age(now) < TICKS_UNAMBIGUOUS;
        if !same_life {
            self.ticks = Tally::default();
            return;
        }
        let mut won = [0; HOLDERS];
        for ((won, now), then) in won
            .iter_mut()
            .zip(counters.ticks_won)
            .zip(last.value.ticks_won)
        {
            *won = u64::from(now.wrapping_sub(then) % TICKS_MODULUS);
        }
        self.ticks.add(now, &won);
    }

    /// The holder, and the time at which it took control.
    pub(crate) const fn holder(&self) -> Option<Reading<Holder>> {
        self.holder
    }

    /// A holder's share of the last minute, 0 to 1: by the robot's count of ticks, if reported,
    /// else by the lines received.
    pub(crate) fn share(&self, holder: Holder) -> Option<f64> {
        let place = holder.place()?;
        self.ticks
            .share(place)
            .or_else(|| self.samples.share(place))
    }

    /// A holder's share of each step of the last minute, 0 to 1, oldest first, by the lines received.
    pub(crate) fn recent(&self, holder: Holder) -> Vec<f64> {
        let place = holder.place();
        place.map_or_else(Vec::new, |place| self.samples.steps(place))
    }

    /// Whether the holder changes too often.
    pub(crate) fn thrashes(&self, now: Moment) -> bool {
        self.changes.len() == THRASH_CHANGES
            && self
                .changes
                .front()
                .is_some_and(|at| now.saturating_sub(*at) <= THRASH_WINDOW)
    }
}

/// Running totals, and their values during the last minute.
#[derive(Clone, Debug, Default)]
struct Tally {
    totals: [u64; HOLDERS],
    marks: VecDeque<(Moment, [u64; HOLDERS])>,
}

impl Tally {
    fn add(&mut self, now: Moment, won: &[u64; HOLDERS]) {
        if self
            .marks
            .back()
            .is_none_or(|(at, _)| now.saturating_sub(*at) >= SHARE_STEP)
        {
            self.marks.push_back((now, self.totals));
        }
        while self.marks.len() > 1
            && self
                .marks
                .front()
                .is_some_and(|(at, _)| now.saturating_sub(*at) > SHARE_WINDOW)
        {
            self.marks.pop_front();
        }
        for (total, won) in self.totals.iter_mut().zip(won) {
            *total += won;
        }
    }

    fn steps(&self, place: usize) -> Vec<f64> {
        let starts = self.marks.iter().map(|(_, totals)| totals);
        let ends = starts.clone().skip(1).chain([&self.totals]);
        let share = |(start, end): (&[u64; HOLDERS], &[u64; HOLDERS])| {
            let won = |place: usize| end[place].saturating_sub(start[place]);
            let all: u64 = (0..HOLDERS).map(won).sum();
            won(place) as f64 / all.max(1) as f64
        };
        starts.zip(ends).map(share).collect()
    }

    fn share(&self, place: usize) -> Option<f64> {
        let (_, then) = self.marks.front()?;
        let won = |place: usize| self.totals[place].saturating_sub(then[place]);
        let all: u64 = (0..HOLDERS).map(won).sum();
        (all > 0).then(|| won(place) as f64 / all as f64)
    }
}
