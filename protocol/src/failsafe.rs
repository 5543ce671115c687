//! Failsafe: the mode that a robot enters when the ground falls silent.

use crate::status_codes::Mode;

/// Shortest silence of a failsafe, seconds: a bad channel is silent for some seconds by chance.
pub const SILENCE_MIN_S: u16 = 10;

/// Longest silence of a failsafe, seconds.
pub const SILENCE_MAX_S: u16 = 4095;

/// A silence of the ground and the mode to enter after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Failsafe {
    /// Seconds without an intact frame, [`SILENCE_MIN_S`] to [`SILENCE_MAX_S`].
    pub silence_s: u16,
    /// The mode to enter.
    pub mode: Mode,
}

impl Failsafe {
    /// Whether a robot accepts it: the silence is in range and the mode needs no operator.
    #[must_use]
    pub const fn is_valid(&self) -> bool {
        self.silence_s >= SILENCE_MIN_S
            && self.silence_s <= SILENCE_MAX_S
            && !matches!(self.mode, Mode::User | Mode::Calibrate)
    }
}
