//! Units of the program.
//!
//! Speeds are in encoder counts per second and named `_cps`: at [`COUNTS_PER_IN`] counts per inch, one is a sixteenth
//! of an inch per second. Times are in ticks of 1/20 s.

use crate::board::{COUNTS_PER_IN, TICK_HZ};

/// Counts per second of a speed in inches per second.
#[must_use]
pub const fn cps(in_s: i16) -> i16 {
    in_s * COUNTS_PER_IN as i16
}

/// A speed in inches per second, rounded as in telemetry.
#[must_use]
pub fn in_s(cps: i16) -> i8 {
    let half = COUNTS_PER_IN as i16 / 2;
    let rounded = cps.saturating_add(half).div_euclid(COUNTS_PER_IN as i16);
    rounded.clamp(-99, 99) as i8
}

/// Ticks of a time in seconds.
#[must_use]
pub const fn ticks(s: u16) -> u16 {
    s * TICK_HZ as u16
}

/// Factor between counts per second and counts per tick.
pub(crate) const TICKS_PER_S: i16 = TICK_HZ as i16;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_round_to_the_nearest_inch_per_second() {
        assert_eq!(in_s(cps(12)), 12);
        assert_eq!(in_s(cps(-12)), -12);
        assert_eq!(in_s(7), 0);
        assert_eq!(in_s(8), 1);
        assert_eq!(in_s(-9), -1);
        assert_eq!(in_s(i16::MAX), 99);
        assert_eq!(in_s(i16::MIN), -99);
    }
}
