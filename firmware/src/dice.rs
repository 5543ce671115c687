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
