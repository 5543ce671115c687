//! What the program counts in.
//!
//! Speeds are encoder counts a second, named `_cps`: with [`COUNTS_PER_IN`] counts to the inch that is
//! a sixteenth of an inch a second, fine enough to creep by. Times are ticks of a twentieth of a
//! second.

use crate::board::{COUNTS_PER_IN, TICK_HZ};

/// A speed in counts a second.
#[must_use]
pub const fn cps(in_s: i16) -> i16 {
    in_s * COUNTS_PER_IN as i16
}

/// A speed in inches a second, rounded, as it travels in telemetry.
#[must_use]
pub fn in_s(cps: i16) -> i8 {
    let half = COUNTS_PER_IN as i16 / 2;
    let rounded = cps.saturating_add(half).div_euclid(COUNTS_PER_IN as i16);
    rounded.clamp(-99, 99) as i8
}

/// A time in ticks.
#[must_use]
pub const fn ticks(s: u16) -> u16 {
    s * TICK_HZ as u16
}

/// The tick rate as a factor between counts a second and counts a tick.
pub(crate) const TICKS_PER_S: i16 = TICK_HZ as i16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_round_to_the_nearest_inch_a_second() {
        assert_eq!(in_s(cps(12)), 12);
        assert_eq!(in_s(cps(-12)), -12);
        assert_eq!(in_s(7), 0);
        assert_eq!(in_s(8), 1);
        assert_eq!(in_s(-9), -1);
        assert_eq!(in_s(i16::MAX), 99);
        assert_eq!(in_s(i16::MIN), -99);
    }
}
