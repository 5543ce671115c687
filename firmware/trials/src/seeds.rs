//! Seeds for tuning and seeds whose results are reported: two sets that never meet.

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// The first seed that is reported.
const REPORTED_FROM: u64 = 20_000;

/// Tuning seeds lie below this. Those between served a first table, which definitions were settled by.
const TUNING_UNDER: u64 = 10_000;

/// What a result is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// To choose a constant or to look for a bug: seeds below 10,000.
    Tuning,
    /// To be believed: seeds from 20,000 on, which nobody has tuned with.
    Report,
}

/// A seed. There is no other way to one than by its purpose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seed(u64);

impl Seed {
    /// The seed of a trial.
    pub(crate) fn nth(purpose: Purpose, trial: usize) -> Self {
        let trial = trial as u64;
        match purpose {
            Purpose::Tuning => {
                assert!(trial < TUNING_UNDER, "tuning must not use reported seeds");
                Self(trial)
            }
            Purpose::Report => Self(REPORTED_FROM + trial),
        }
    }

    /// For the simulation.
    pub(crate) const fn value(self) -> u64 {
        self.0
    }

    /// For what the trial itself leaves to chance.
    pub(crate) fn dice(self) -> Dice {
        Dice(Pcg32::new(self.0, 0x0071_71A1))
    }
}

/// What a trial leaves to chance, the same on every platform.
pub(crate) struct Dice(Pcg32);

impl Dice {
    /// Evenly from `low` up to, not including, `high`.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / 4_294_967_296.0
    }

    /// 0 to `sides` - 1.
    pub(crate) fn below(&mut self, sides: usize) -> usize {
        (self.between(0.0, sides as f64) as usize).min(sides.saturating_sub(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tuning_and_report_share_no_seed() {
        let tuning = Seed::nth(Purpose::Tuning, 9_999).value();
        assert!(tuning < Seed::nth(Purpose::Report, 0).value());
    }

    #[test]
    #[should_panic(expected = "reported seeds")]
    fn tuning_cannot_reach_a_reported_seed() {
        Seed::nth(Purpose::Tuning, 10_000);
    }
}
