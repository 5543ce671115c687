//! What a robot does by itself when the ground falls silent.

use crate::letters::Mode;

/// Shortest silence a robot may be told to act on: a bad channel is silent for some seconds by chance.
pub const SILENCE_MIN_S: u16 = 10;

/// Longest.
pub const SILENCE_MAX_S: u16 = 4095;

/// A silence and the mode to enter after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Failsafe {
    /// Seconds without an intact frame, [`SILENCE_MIN_S`] to [`SILENCE_MAX_S`].
    pub silence_s: u16,
    /// What to enter then.
    pub mode: Mode,
}

impl Failsafe {
    /// Whether a robot may be told this: the silence is neither too short nor too long, and the mode is
    /// one that needs no operator.
    #[must_use]
    pub const fn is_valid(&self) -> bool {
        self.silence_s >= SILENCE_MIN_S
            && self.silence_s <= SILENCE_MAX_S
            && !matches!(self.mode, Mode::User | Mode::Calibrate)
    }
}
