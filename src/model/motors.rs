//! Who holds the motors, since when, for what share of the time, and whether it changes too often.

use std::collections::VecDeque;

use groundwave_protocol::status_codes::{Arm, Cliff, Layer, LayerState, Mode};
use groundwave_protocol::telemetry::{CountersLine, HOLDERS, ParameterLine, StateLine};

use super::robot::Reading;
use crate::event::Moment;

/// Ticks won travel modulo this.
const TICKS_MODULUS: u16 = 4096;

/// At twenty ticks a second, a count has not gone round unseen within this.
const TICKS_UNAMBIGUOUS: Moment = Moment::from_mins(3);

/// Shares are told over about this long.
const SHARE_WINDOW: Moment = Moment::from_mins(1);

/// Steps of the share window.
const SHARE_STEP: Moment = Moment::from_secs(6);

/// So many changes from layer to layer within [`THRASH_WINDOW`] are thrashing. Those to and from prowl
/// are not counted: steering is made of them.
const THRASH_CHANGES: usize = 6;

const THRASH_WINDOW: Moment = Moment::from_secs(8);

/// The robot's parameter that switches its cliff guard on and off.
const CLIFF_GUARD: &str = "cliff-guard";

/// Whoever can hold the motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Holder {
    /// One of the eight layers.
    Layer(Layer),
    /// The default behaviour below them.
    Prowl,
    /// Behind the layers: there is no floor where the winner would go.
    CliffGuard,
    /// Behind the layers: the arm is not stowed yet.
    ArmGuard,
    /// The motors are off.
    Nobody,
}

impl Holder {
    /// Who holds the motors by one line A, of a robot whose cliff guard is switched on.
    pub(crate) fn of(state: &StateLine) -> Self {
        match (state.layers.holder(), state.mode) {
            (None, mode) if mode != Mode::Stop && lacks_floor(state) => Self::CliffGuard,
            (None, mode) if mode != Mode::Stop && state.arm == Arm::Up => Self::ArmGuard,
            _ => Self::unguarded(state),
        }
    }

    /// The same where only layers and prowl can hold them.
    fn unguarded(state: &StateLine) -> Self {
        match (state.layers.holder(), state.mode) {
            (Some(layer), _) => Self::Layer(layer),
            (None, Mode::User) => Self::Layer(Layer::User),
            (None, mode) if prowls(mode) => Self::Prowl,
            (None, _) => Self::Nobody,
        }
    }

    /// Whether its coming and going is ordinary steering.
    pub(super) const fn is_routine(self) -> bool {
        matches!(self, Self::Prowl | Self::Layer(Layer::Sonar | Layer::Photo))
    }

    /// Its place among the ticks won of line C.
    pub(crate) const fn place(self) -> Option<usize> {
        match self {
            Self::Layer(layer) => Some(layer as usize),
            Self::Prowl => Some(HOLDERS - 1),
            Self::CliffGuard | Self::ArmGuard | Self::Nobody => None,
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

/// Whether an edge sensor sees no floor, or the cliff guard acts for what one saw.
pub(crate) const fn lacks_floor(state: &StateLine) -> bool {
    !matches!(state.cliff, Cliff::None | Cliff::NotFitted)
}

/// Who wants the motors and does not get them from this holder, in priority order. A raised flag above the
/// holder was lowered again before the line was sent: nobody suppresses it.
pub(crate) fn suppressed(holder: Holder, state: &StateLine) -> Vec<Holder> {
    let above = match holder {
        Holder::Layer(holder) => Some(holder),
        Holder::CliffGuard | Holder::ArmGuard => None,
        Holder::Prowl | Holder::Nobody => return Vec::new(),
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

/// The history of who held the motors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Motors {
    holder: Option<Reading<Holder>>,
    /// How each layer stands, and since when.
    rungs: [Option<Reading<LayerState>>; Layer::ALL.len()],
    changes: VecDeque<Moment>,
    samples: Tally,
    ticks: Tally,
    newest_counters: Option<Reading<CountersLine>>,
    /// The robot has said that its cliff guard is switched off.
    is_unguarded: bool,
}

impl Motors {
    /// Takes a line P, of which one tells of the cliff guard.
    pub(super) fn take_parameter(&mut self, parameter: &ParameterLine) {
        if parameter.name.as_str() == CLIFF_GUARD {
            self.is_unguarded = parameter.value == 0;
        }
    }

    /// The robot restarted: one whose guard is off says so again.
    pub(super) fn take_restart(&mut self) {
        self.is_unguarded = false;
    }

    /// Takes a line A; says whether somebody else holds the motors now.
    pub(super) fn take_state(&mut self, now: Moment, state: &StateLine) -> bool {
        let holder = match Holder::of(state) {
            Holder::CliffGuard if self.is_unguarded => Holder::unguarded(state),
            holder => holder,
        };
        self.take_rungs(now, holder, state);
        let mut won = [0; HOLDERS];
        if let Some(place) = holder.place() {
            won[place] = 1;
        }
        // Also of a line in which nobody held them: what was won longer ago goes out of the window.
        self.samples.add(now, &won);
        if self.holder.is_some_and(|held| held.value == holder) {
            return false;
        }
        let last = self.holder.map(|held| held.value);
        if let (Some(Holder::Layer(_)), Holder::Layer(_)) = (last, holder) {
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

    /// Since when a layer has stood as it does; `None` before it was heard of.
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

    /// Who holds the motors and since when.
    pub(crate) const fn holder(&self) -> Option<Reading<Holder>> {
        self.holder
    }

    /// Share of the last minute won by a holder, 0 to 1: by the robot's own count of ticks when it has
    /// told one, else by the lines that arrived.
    pub(crate) fn share(&self, holder: Holder) -> Option<f64> {
        let place = holder.place()?;
        self.ticks
            .share(place)
            .or_else(|| self.samples.share(place))
    }

    /// Whether the motors change hands too often to get anywhere.
    pub(crate) fn thrashes(&self, now: Moment) -> bool {
        self.changes.len() == THRASH_CHANGES
            && self
                .changes
                .front()
                .is_some_and(|at| now.saturating_sub(*at) <= THRASH_WINDOW)
    }
}

/// Running totals, and what they were at some moments of the last minute.
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

    fn share(&self, place: usize) -> Option<f64> {
        let (_, then) = self.marks.front()?;
        let won = |place: usize| self.totals[place].saturating_sub(then[place]);
        let all: u64 = (0..HOLDERS).map(won).sum();
        (all > 0).then(|| won(place) as f64 / all as f64)
    }
}
