//! Failsafe: the mode that a robot enters when the ground is silent.

use crate::status_codes::Mode;

/// Minimum silence of a failsafe, seconds; a bad channel may be silent for some seconds by chance.
pub const SILENCE_MIN_S: u16 = 10;

/// Maximum silence of a failsafe, seconds.
pub const SILENCE_MAX_S: u16 = 4095;

/// A silence of the ground, and the mode that the robot enters after it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Failsafe {
    /// Time without an intact frame, seconds, [`SILENCE_MIN_S`] to [`SILENCE_MAX_S`].
    pub silence_s: u16,
    /// The mode to enter.
    pub mode: Mode,
}

impl Failsafe {
    /// Whether a robot accepts the failsafe: the silence is in range and the mode needs no operator.
    #[must_use]
    pub const fn is_valid(&self) -> bool {
        self.silence_s >= SILENCE_MIN_S
            && self.silence_s <= SILENCE_MAX_S
            && !matches!(self.mode, Mode::User | Mode::Calibrate)
    }
}
