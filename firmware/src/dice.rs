//! The robot's own randomness.

/// A xorshift generator of 32 bits.
#[derive(Clone, Debug)]
pub struct Dice(u32);

impl Dice {
    /// Dice of a seed; 0 is taken for another number, because it would never change.
    #[must_use]
    pub const fn new(seed: u32) -> Self {
        Self(if seed == 0 { 0x9E37_79B9 } else { seed })
    }

    /// The next number, never 0.
    pub fn roll(&mut self) -> u32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_means_the_same_rolls_and_none_stands_still() {
        for seed in [0, 1, u32::MAX] {
            let (mut a, mut b) = (Dice::new(seed), Dice::new(seed));
            let first = a.roll();
            assert_eq!(first, b.roll());
            assert_ne!(first, a.roll());
        }
    }

    #[test]
    fn the_lowest_bit_is_fair() {
        let mut dice = Dice::new(7);
        let ones: u32 = (0..10_000).map(|_| dice.roll() & 1).sum();
        assert!((4800..5200).contains(&ones), "{ones}");
    }
}
