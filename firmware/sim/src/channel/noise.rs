//! Bit errors.

use super::spec::{BURST_FLIPS, ChannelSpec};
use crate::rng::Rng;

/// A bit error process. It draws the length of each clean stretch at its start, so clean bits cost nothing.
#[derive(Debug)]
pub(super) struct Noise {
    rng: Rng,
    /// Probability per clean bit that a burst starts.
    starts: f64,
    /// Probability per bit of a burst that it is the last.
    ends: f64,
    /// Probability that a bit of a burst flips.
    flips: f64,
    clean_left: u64,
    burst_left: u64,
}

impl Noise {
    pub(super) fn new(spec: &ChannelSpec, rng: Rng) -> Self {
        let (starts, ends, flips) = match spec.burst_bits {
            // Each error is a burst of one bit.
            None => (spec.ber, 1.0, 1.0),
            Some(bits) => {
                let bad_share = (spec.ber / BURST_FLIPS).min(0.5);
                (
                    bad_share / (1.0 - bad_share) / bits,
                    1.0 / bits,
                    BURST_FLIPS,
                )
            }
        };
        let mut noise = Self {
            rng,
            starts,
            ends,
            flips,
            clean_left: 0,
            burst_left: 0,
        };
        noise.clean_left = noise.rng.failures_before_success(starts);
        noise
    }

    /// Replaces the parameters and keeps the stream of random numbers.
    pub(super) fn set(&mut self, spec: &ChannelSpec) {
        *self = Self::new(spec, self.rng.clone());
    }

    /// Skips this many bits if none of them can flip; returns whether it did.
    pub(super) fn skip(&mut self, bits: u64) -> bool {
        let is_clean = self.burst_left == 0 && self.clean_left >= bits;
        if is_clean && self.clean_left != u64::MAX {
            self.clean_left -= bits;
        }
        is_clean
    }

    /// Whether the next bit flips.
    pub(super) fn flip(&mut self) -> bool {
        if self.burst_left == 0 {
            if self.clean_left > 0 {
                if self.clean_left != u64::MAX {
                    self.clean_left -= 1;
                }
                return false;
            }
            self.burst_left = 1 + self.rng.failures_before_success(self.ends);
        }
        self.burst_left -= 1;
        if self.burst_left == 0 {
            self.clean_left = self.rng.failures_before_success(self.starts);
        }
        self.rng.chance(self.flips)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;

    const BITS: u32 = 4_000_000;

    fn flips(text: &str) -> Vec<bool> {
        let spec = text.parse().unwrap();
        let mut noise = Noise::new(&spec, Rng::new(11, Stream::Downlink));
        (0..BITS).map(|_| noise.flip()).collect()
    }

    fn rate(flips: &[bool]) -> f64 {
        flips.iter().filter(|flip| **flip).count() as f64 / flips.len() as f64
    }

    #[test]
    fn mean_error_rate_is_as_specified() {
        for (text, ber, tolerance) in [
            ("ber=1e-3", 1e-3, 0.08),
            ("ber=0.05", 0.05, 0.02),
            ("ber=1e-3,burst=50", 1e-3, 0.4),
            ("ber=0.02,burst=8", 0.02, 0.05),
        ] {
            let measured = rate(&flips(text));
            assert!(
                (measured / ber - 1.0).abs() < tolerance,
                "{text}: {measured}"
            );
        }
    }

    #[test]
    fn bursts_cluster_errors() {
        // Share of flipped bits directly after a flipped bit.
        let follow = |flips: &[bool]| {
            let pairs = flips.windows(2).filter(|pair| pair[0]);
            let (mut all, mut both) = (0.0, 0.0);
            for pair in pairs {
                all += 1.0;
                both += f64::from(u8::from(pair[1]));
            }
            both / all
        };
        assert!(follow(&flips("ber=0.01")) < 0.02);
        let clustered = follow(&flips("ber=0.01,burst=50"));
        assert!((clustered - 0.49).abs() < 0.03, "{clustered}");
    }

    #[test]
    fn skipping_clean_bits_equals_drawing_them() {
        let spec = "ber=0.01,burst=5".parse().unwrap();
        let mut walked = Noise::new(&spec, Rng::new(4, Stream::Uplink));
        let mut skipped = Noise::new(&spec, Rng::new(4, Stream::Uplink));
        for _ in 0..100_000 {
            let bits: Vec<bool> = (0..10).map(|_| walked.flip()).collect();
            if skipped.skip(10) {
                assert!(!bits.contains(&true));
            } else {
                let again: Vec<bool> = (0..10).map(|_| skipped.flip()).collect();
                assert_eq!(bits, again);
            }
        }
    }
}
