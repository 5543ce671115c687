//! Claims about the robot, and how a trial of a claim is run.

use std::cell::Cell;
use std::path::PathBuf;

use crate::seeds::{Rng, Seed};
use crate::statistics::{self, Estimate};

/// A series of trials for one or several claims.
pub(crate) struct Experiment {
    /// Name for `--only`.
    pub(crate) name: &'static str,
    /// Number of trials in the short and in the long version.
    pub(crate) trials: [usize; 2],
    /// Runs a trial; returns a reading per claim, `None` if the trial gives none.
    pub(crate) run: fn(&Trial) -> Vec<Option<Reading>>,
    /// Claims about which the trials give readings.
    pub(crate) claims: &'static [Claim],
}

/// A claim: one row of the table.
pub(crate) struct Claim {
    /// Layer or part of the robot.
    pub(crate) part: &'static str,
    /// Exact text of the claim.
    pub(crate) says: &'static str,
    /// Figure computed from the readings.
    pub(crate) figure: Figure,
    /// Required range of the figure.
    pub(crate) required: Required,
    /// Known shortfall: such a row fails the command only if it gets worse.
    pub(crate) shortfall: Option<Shortfall>,
}

/// A claim that is known to be missed.
pub(crate) struct Shortfall {
    /// Figure reached.
    pub(crate) reached: f64,
    /// Cause.
    pub(crate) why: &'static str,
}

/// Reading of one trial for one claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// Whether the trial succeeded.
    Success(bool),
    /// A measured value.
    Value(f64),
    /// A value without a part of the robot, and the value with it.
    Pair(f64, f64),
    /// Number of events, and the hours observed.
    Events { count: u32, hours: f64 },
}

/// Ways to compute a figure from readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Figure {
    /// Share of successes in percent.
    Share,
    /// Mean of the values.
    Mean { unit: &'static str, digits: usize },
    /// Median of the values.
    Median { unit: &'static str, digits: usize },
    /// Least of the values, without an interval.
    Least { unit: &'static str, digits: usize },
    /// Greatest of the values, without an interval.
    Greatest { unit: &'static str, digits: usize },
    /// Mean of the first values of the pairs divided by the mean of the second.
    MeanRatio { unit: &'static str, digits: usize },
    /// Number of events per hour.
    PerHour,
    /// Hours per event.
    HoursTo,
}

/// Required range of a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Required {
    AtLeast(f64),
    AtMost(f64),
    Between(f64, f64),
    MoreThan(f64),
    /// No requirement: the figure is only reported.
    Nothing,
}

/// Result of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The figure meets the requirement.
    Pass,
    /// The figure misses the requirement, but its interval reaches it.
    Fail,
    /// The whole interval misses the requirement.
    ClearFail,
}

/// A trial.
pub(crate) struct Trial {
    /// Number of the trial, from 0.
    pub(crate) index: usize,
    /// Seed of the trial.
    pub(crate) seed: Seed,
    /// File for a trace of every tick.
    pub(crate) trace: Option<PathBuf>,
    /// Number of simulations of this trial that have been traced.
    pub(crate) traced: Cell<u32>,
}

impl Trial {
    /// Random numbers of the trial itself.
    pub(crate) fn rng(&self) -> Rng {
        self.seed.rng()
    }

    /// The same trial without a trace, for simulations that prepare it.
    pub(crate) fn untraced(&self) -> Self {
        Self {
            index: self.index,
            seed: self.seed,
            trace: None,
            traced: Cell::new(0),
        }
    }
}

impl Figure {
    /// The figure of matching readings; `None` without any.
    pub(crate) fn of(self, readings: &[Reading]) -> Option<Estimate> {
        if readings.is_empty() {
            return None;
        }
        let values = || -> Vec<f64> {
            readings
                .iter()
                .map(|reading| match *reading {
                    Reading::Success(is_so) => f64::from(u8::from(is_so)),
                    Reading::Value(value) | Reading::Pair(value, _) => value,
                    Reading::Events { count, .. } => f64::from(count),
                })
                .collect()
        };
        let (count, hours) = readings
            .iter()
            .fold((0, 0.0), |sum, reading| match *reading {
                Reading::Events { count, hours } => (sum.0 + count, sum.1 + hours),
                _ => sum,
            });
        Some(match self {
            Self::Share => {
                let successes = readings
                    .iter()
                    .filter(|reading| matches!(reading, Reading::Success(true)));
                statistics::share(successes.count(), readings.len())
            }
            Self::Mean { .. } => statistics::mean(&values()),
            Self::Median { .. } => statistics::median(&values()),
            Self::Least { .. } => statistics::least(&values()),
            Self::Greatest { .. } => statistics::greatest(&values()),
            Self::MeanRatio { .. } => {
                let pairs = readings.iter().filter_map(|reading| match *reading {
                    Reading::Pair(one, other) => Some((one, other)),
                    _ => None,
                });
                statistics::ratio_of_means(&pairs.collect::<Vec<_>>())
            }
            Self::PerHour => statistics::per_hour(count, hours),
            Self::HoursTo => statistics::hours_to(count, hours),
        })
    }
}

impl Required {
    /// The requirement lowered to a known shortfall.
    pub(crate) const fn or(self, reached: f64) -> Self {
        match self {
            Self::AtLeast(least) | Self::MoreThan(least) => Self::AtLeast(least.min(reached)),
            Self::AtMost(most) => Self::AtMost(most.max(reached)),
            Self::Between(least, most) => Self::Between(least.min(reached), most.max(reached)),
            Self::Nothing => Self::Nothing,
        }
    }

    /// Compares a figure with the requirement.
    pub(crate) fn judge(self, estimate: &Estimate) -> Verdict {
        let Estimate { figure, low, high } = *estimate;
        // An extreme value has no interval: it is missed or met.
        let has_interval = low.is_finite() || high.is_finite();
        let (low, high) = if has_interval {
            (low, high)
        } else {
            (figure, figure)
        };
        let (is_met, is_within_reach) = match self {
            Self::AtLeast(least) => (figure >= least, high >= least),
            Self::AtMost(most) => (figure <= most, low <= most),
            Self::Between(least, most) => (
                (least..=most).contains(&figure),
                high >= least && low <= most,
            ),
            Self::MoreThan(least) => (figure > least, high > least),
            Self::Nothing => (true, true),
        };
        match (is_met, is_within_reach) {
            (true, _) => Verdict::Pass,
            (false, true) => Verdict::Fail,
            (false, false) => Verdict::ClearFail,
        }
    }
}

/// A reading of success or failure.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial gives an optional reading per claim"
)]
pub(crate) fn success(is_so: bool) -> Option<Reading> {
    Some(Reading::Success(is_so))
}

/// A reading of a measured value.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial gives an optional reading per claim"
)]
pub(crate) fn value(value: f64) -> Option<Reading> {
    Some(Reading::Value(value))
}

/// Cost of an ablation in percentage points: the same trial with a part and without it.
pub(crate) fn loss(with: bool, without: bool) -> Option<Reading> {
    value(100.0 * (f64::from(u8::from(with)) - f64::from(u8::from(without))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_failure_needs_the_whole_interval() {
        let judge =
            |required: Required, figure, low, high| required.judge(&Estimate { figure, low, high });
        let least = Required::AtLeast(95.0);
        assert_eq!(judge(least, 95.0, 90.0, 98.0), Verdict::Pass);
        assert_eq!(judge(least, 94.0, 90.0, 98.0), Verdict::Fail);
        assert_eq!(judge(least, 90.0, 85.0, 94.9), Verdict::ClearFail);
        let most = Required::AtMost(2.0);
        assert_eq!(judge(most, 3.0, 2.1, 4.0), Verdict::ClearFail);
        let between = Required::Between(92.0, 98.0);
        assert_eq!(judge(between, 99.0, 98.5, 99.5), Verdict::ClearFail);
        assert_eq!(judge(between, 99.0, 97.0, 99.9), Verdict::Fail);
        assert_eq!(
            judge(Required::MoreThan(0.0), 0.0, 0.0, 0.0),
            Verdict::ClearFail
        );
        let (none, any) = (f64::NEG_INFINITY, f64::INFINITY);
        assert_eq!(judge(most, 3.0, none, any), Verdict::ClearFail);
        assert_eq!(judge(Required::Nothing, 0.0, 0.0, 0.0), Verdict::Pass);
    }

    #[test]
    fn known_shortfall_lowers_the_requirement() {
        let required = |required: Required| required.or(90.0);
        assert_eq!(required(Required::AtLeast(95.0)), Required::AtLeast(90.0));
        assert_eq!(required(Required::AtLeast(80.0)), Required::AtLeast(80.0));
        assert_eq!(required(Required::MoreThan(95.0)), Required::AtLeast(90.0));
        assert_eq!(required(Required::AtMost(2.0)), Required::AtMost(90.0));
        let between = Required::Between(92.0, 98.0);
        assert_eq!(required(between), Required::Between(90.0, 98.0));
        assert_eq!(between.or(99.0), Required::Between(92.0, 99.0));
        assert_eq!(required(Required::Nothing), Required::Nothing);
    }

    #[test]
    fn readings_give_figures() {
        let half = [Reading::Success(true), Reading::Success(false)];
        let figure = |figure: Figure, readings: &[Reading]| {
            figure.of(readings).map(|estimate| estimate.figure)
        };
        assert_eq!(figure(Figure::Share, &half), Some(50.0));
        assert_eq!(figure(Figure::Share, &[]), None);
        let values = [Reading::Value(1.0), Reading::Value(2.0)];
        let mean = Figure::Mean {
            unit: "in",
            digits: 1,
        };
        assert_eq!(figure(mean, &values), Some(1.5));
        let events = [
            Reading::Events {
                count: 1,
                hours: 4.0,
            },
            Reading::Events {
                count: 0,
                hours: 4.0,
            },
        ];
        assert_eq!(figure(Figure::PerHour, &events), Some(0.125));
        assert_eq!(figure(Figure::HoursTo, &events), Some(8.0));
    }
}
