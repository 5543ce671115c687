//! Seeded random numbers: one independent stream per purpose, so that more noise in one sensor never changes another.

use rand_core::Rng as _;
use rand_pcg::Pcg32;

/// Purpose of a stream of random numbers. The numbers are part of every committed seed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Stream {
    Build = 1,
    Sonar = 2,
    Infrared = 3,
    Photocells = 4,
    Uplink = 5,
    Downlink = 6,
    Robot = 7,
    Modem = 8,
    Motion = 9,
    Beacon = 10,
    Snags = 11,
    House = 12,
    Faults = 13,
}

/// One stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Rng {
    generator: Pcg32,
    /// Every draw is the middle of its range, so that no chance event happens.
    is_constant: bool,
}

impl Rng {
    pub(crate) fn new(seed: u64, stream: Stream) -> Self {
        let purpose = stream as u64;
        Self {
            // Neighbouring seeds give similar streams unless they are mixed first.
            generator: Pcg32::new(split_mix(seed ^ split_mix(purpose)), purpose),
            is_constant: false,
        }
    }

    /// A stream for a sensor; without `noise` every draw is the middle of its range.
    pub(crate) fn for_sensor(seed: u64, stream: Stream, noise: bool) -> Self {
        Self {
            is_constant: !noise,
            ..Self::new(seed, stream)
        }
    }

    /// A new independent stream for a part of the same purpose.
    pub(crate) fn split(&mut self) -> Self {
        let state = u64::from(self.next_u32()) << 32 | u64::from(self.next_u32());
        Self {
            generator: Pcg32::new(split_mix(state), u64::from(self.next_u32())),
            is_constant: self.is_constant,
        }
    }

    pub(crate) fn next_u32(&mut self) -> u32 {
        if self.is_constant {
            return u32::MAX / 2 + 1;
        }
        self.generator.next_u32()
    }

    /// Uniform from 0 up to but not including 1.
    pub(crate) fn unit(&mut self) -> f64 {
        f64::from(self.next_u32()) / 4_294_967_296.0
    }

    /// Uniform between minus and plus `limit`.
    pub(crate) fn spread(&mut self, limit: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * limit
    }

    /// Approximately normal: mean 0, standard deviation 1, never beyond 3.5.
    pub(crate) fn normal(&mut self) -> f64 {
        let sum = self.unit() + self.unit() + self.unit() + self.unit();
        (sum - 2.0) * SQRT_3
    }

    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        probability > 0.0 && self.unit() < probability
    }

    /// Number of failed trials before the first success at this probability.
    pub(crate) fn failures_before_success(&mut self, probability: f64) -> u64 {
        if probability <= 0.0 {
            return u64::MAX;
        }
        if probability >= 1.0 {
            return 0;
        }
        let failures = libm::log(1.0 - self.unit()) / libm::log1p(-probability);
        failures as u64
    }
}

/// Scale of the sum of four uniform draws to variance 1: their variance is 4/12.
const SQRT_3: f64 = 1.732_050_807_568_877_2;

fn split_mix(value: u64) -> u64 {
    let value = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let value = (value ^ (value >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let value = (value ^ (value >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    value ^ (value >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_of_one_seed_differ() {
        let draw = |stream| Rng::new(1, stream).next_u32();
        assert_ne!(draw(Stream::Sonar), draw(Stream::Infrared));
        assert_ne!(draw(Stream::Uplink), draw(Stream::Downlink));
    }

    #[test]
    fn draws_without_noise_are_the_middle_of_the_range() {
        let mut rng = Rng::for_sensor(1, Stream::Sonar, false);
        assert!((rng.unit() - 0.5).abs() < f64::EPSILON);
        assert!(rng.normal().abs() < f64::EPSILON && rng.spread(3.0).abs() < f64::EPSILON);
        assert!(!rng.chance(0.3) && rng.chance(0.98));
    }

    #[test]
    fn normal_draws_have_mean_0_and_deviation_1() {
        let mut rng = Rng::new(7, Stream::Sonar);
        let draws: Vec<f64> = (0..20_000).map(|_| rng.normal()).collect();
        let mean = draws.iter().sum::<f64>() / 20_000.0;
        let variance = draws.iter().map(|draw| draw * draw).sum::<f64>() / 20_000.0;
        assert!(mean.abs() < 0.03, "mean {mean}");
        assert!((variance - 1.0).abs() < 0.05, "variance {variance}");
    }

    #[test]
    fn mean_wait_is_the_inverse_of_the_probability() {
        let mut rng = Rng::new(3, Stream::Uplink);
        let total: u64 = (0..20_000).map(|_| rng.failures_before_success(0.01)).sum();
        let mean = total as f64 / 20_000.0;
        assert!((mean - 99.0).abs() < 3.0, "mean {mean}");
    }
}
