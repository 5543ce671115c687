//! Seeds for tuning and seeds for reported results: two disjoint sets.

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// First reported seed.
const REPORTED_FROM: u64 = 20_000;

/// Upper limit of the tuning seeds. The seeds up to the reported ones were used for a first table that settled the
/// definitions.
const TUNING_UNDER: u64 = 10_000;

/// Purpose of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// Choosing a constant or finding a bug: seeds below 10,000.
    Tuning,
    /// A reported result: seeds from 20,000, never used for tuning.
    Report,
}

/// A seed, which is given out only for a purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seed(u64);

impl Seed {
    /// Seed of a trial.
    pub(crate) fn nth(purpose: Purpose, trial: usize) -> Self {
        let trial = trial as u64;
        match purpose {
            Purpose::Tuning => {
                assert!(
                    trial < TUNING_UNDER,
                    "tuning must not use reported seeds: choose a trial below 10,000"
                );
                Self(trial)
            }
            Purpose::Report => Self(REPORTED_FROM + trial),
        }
    }

    /// Seed of the simulation.
    pub(crate) const fn value(self) -> u64 {
        self.0
    }

    /// Random numbers of the trial itself.
    pub(crate) fn rng(self) -> Rng {
        Rng(Pcg32::new(self.0, 0x0071_71A1))
    }
}

/// Random numbers of a trial, the same on every platform.
pub(crate) struct Rng(Pcg32);

impl Rng {
    /// Uniform from `low` up to but not including `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// Uniform from 0 to `sides` - 1.
    pub(crate) fn below(&mut self, sides: usize) -> usize {
        (self.between(0.0, sides as f64) as usize).min(sides.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_and_reported_seeds_are_disjoint() {
        let tuning = Seed::nth(Purpose::Tuning, 9_999).value();
        assert!(tuning < Seed::nth(Purpose::Report, 0).value());
    }

    #[test]
    #[should_panic(expected = "reported seeds")]
    fn tuning_cannot_use_a_reported_seed() {
        Seed::nth(Purpose::Tuning, 10_000);
    }
}
