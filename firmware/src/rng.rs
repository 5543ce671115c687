//! Random numbers of the robot.

/// A 32-bit xorshift generator.
#[derive(Clone, Debug)]
pub struct Rng(u32);

impl Rng {
    /// A generator with this seed; 0 is replaced, because it would repeat forever.
    #[must_use]
    pub const fn new(seed: u32) -> Self {
        Self(if seed == 0 { 0x9E37_79B9 } else { seed })
    }

    /// The next number, never 0.
    pub fn next_u32(&mut self) -> u32 {
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
    fn seed_determines_the_numbers_and_they_change() {
        for seed in [0, 1, u32::MAX] {
            let (mut a, mut b) = (Rng::new(seed), Rng::new(seed));
            let first = a.next_u32();
            assert_eq!(first, b.next_u32());
            assert_ne!(first, a.next_u32());
        }
    }

    #[test]
    fn lowest_bit_is_fair() {
        let mut rng = Rng::new(7);
        let ones: u32 = (0..10_000).map(|_| rng.next_u32() & 1).sum();
        assert!((4800..5200).contains(&ones), "{ones}");
    }
}
