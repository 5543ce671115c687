//! What is claimed of the robot, and how one trial of it is run.

use std::cell::Cell;
use std::path::PathBuf;

use crate::seeds::{Dice, Seed};
use crate::statistics::{self, Estimate};

/// Trials that show one or several claims at once.
pub(crate) struct Experiment {
    /// What `--only` calls it.
    pub(crate) name: &'static str,
    /// Trials of the short version and of the long one.
    pub(crate) trials: [usize; 2],
    /// One trial: a reading for each claim, `None` where the trial says nothing of it.
    pub(crate) run: fn(&Trial) -> Vec<Option<Reading>>,
    /// What it shows.
    pub(crate) claims: &'static [Claim],
}

/// One row of the table.
pub(crate) struct Claim {
    /// The layer or part it is about.
    pub(crate) part: &'static str,
    /// What is claimed, exactly.
    pub(crate) says: &'static str,
    /// How the readings become a figure.
    pub(crate) figure: Figure,
    /// What the figure must be.
    pub(crate) required: Required,
    /// Why it is not met, where that is known: such a row does not fail the command unless it gets worse.
    pub(crate) shortfall: Option<Shortfall>,
}

/// A claim that is known not to be met.
pub(crate) struct Shortfall {
    /// What is reached instead, as far as is known.
    pub(crate) reached: f64,
    /// Why it is no more.
    pub(crate) why: &'static str,
}

/// What one trial says of one claim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// Whether it came out as claimed.
    Success(bool),
    /// A measured value.
    Value(f64),
    /// A value without something, and the same with it.
    Pair(f64, f64),
    /// Things that happened, and in how many hours.
    Events { count: u32, hours: f64 },
}

/// How readings become a figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Figure {
    /// Percent of successes.
    Share,
    /// The mean of the values.
    Mean { unit: &'static str, digits: usize },
    /// The mean of the first values of pairs over the mean of the second.
    MeanRatio { unit: &'static str, digits: usize },
    /// Events an hour.
    PerHour,
    /// Hours to an event.
    HoursTo,
}

/// What a figure must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Required {
    AtLeast(f64),
    AtMost(f64),
    Between(f64, f64),
    MoreThan(f64),
    /// It is told and judged by nobody.
    Nothing,
}

/// What became of a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// The figure is as required.
    Pass,
    /// It is not, but its interval reaches what is required.
    Fail,
    /// Not even the interval does.
    ClearFail,
}

/// The surroundings of one trial.
pub(crate) struct Trial {
    /// Its number, from 0.
    pub(crate) index: usize,
    /// Its seed.
    pub(crate) seed: Seed,
    /// Where to write what happens at every tick.
    pub(crate) trace: Option<PathBuf>,
    /// Simulations of this trial that have been traced.
    pub(crate) traced: Cell<u32>,
}

impl Trial {
    /// What the trial itself leaves to chance.
    pub(crate) fn dice(&self) -> Dice {
        self.seed.dice()
    }

    /// The same trial for what goes before it and is not to be traced.
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
    /// The figure of readings that suit it; `None` when there are none.
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
    /// Content with a figure that is known to fall short.
    pub(crate) const fn or(self, reached: f64) -> Self {
        match self {
            Self::AtLeast(least) | Self::MoreThan(least) => Self::AtLeast(least.min(reached)),
            Self::AtMost(most) => Self::AtMost(most.max(reached)),
            Self::Between(least, most) => Self::Between(least.min(reached), most.max(reached)),
            Self::Nothing => Self::Nothing,
        }
    }

    /// Judges a figure.
    pub(crate) fn judge(self, estimate: &Estimate) -> Verdict {
        let Estimate { figure, low, high } = *estimate;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_fails_clearly_only_with_its_whole_interval() {
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
        assert_eq!(judge(Required::Nothing, 0.0, 0.0, 0.0), Verdict::Pass);
    }

    #[test]
    fn what_is_known_to_fall_short_is_required_all_the_same() {
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
    fn readings_become_figures() {
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
