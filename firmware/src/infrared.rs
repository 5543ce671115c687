//! The infrared detectors, sampled 250 times per second.
//!
//! The LEDs are on for one half cycle and off for the next. A reflection fires a detector only with the LEDs on; a
//! detector that also fires with the LEDs off receives ambient light. A detection needs `max_count` consecutive
//! pairs with a reflection. `max_count` rises with every detection and falls without any, so that the robot keeps its distance in the open
//! and can still enter a narrow passage. It doubles when both sides detect at once, so that the robot adapts to a
//! passage before the walls turn it around.

use crate::board::Sides;
use crate::parameters::{Parameter, Parameters};
use crate::units::{TICKS_PER_S, ticks};

/// Number of ticks between two adaptations: `max_count` rises by one after a detection and halves without any, so that the
/// robot detects normally again after a passage.
const ADAPT_TICKS: u8 = TICKS_PER_S as u8 / 2;

/// `max_count` from which the robot is in a confined space: half of its default maximum.
const CONFINED_COUNT: u8 = 20;

/// Number of ticks of uninterrupted reflections that count as a jam.
pub const JAM_TICKS: u16 = ticks(30);

/// Number of ticks for which the detectors are off after a jam.
pub const OFF_TICKS: u16 = ticks(30);

/// Both detectors and their LEDs.
#[derive(Clone, Debug)]
pub struct Infrared {
    enabled: bool,
    leds_on: bool,
    /// Detectors that fired in the half cycle with the LEDs on.
    lit: Sides,
    /// Number of consecutive pairs with a reflection, left and right.
    runs: [u8; 2],
    max_count: u8,
    /// Whether any pair since the last tick had a reflection.
    seen: bool,
    /// Detections since the last tick.
    detected: Sides,
    seen_ticks: u16,
    off_ticks: u16,
    adapt_ticks: u8,
    undetected_ticks: u8,
}

impl Default for Infrared {
    fn default() -> Self {
        Self {
            enabled: false,
            leds_on: false,
            lit: Sides::default(),
            runs: [0; 2],
            max_count: Parameter::InfraredLeast.definition().default as u8,
            seen: false,
            detected: Sides::default(),
            seen_ticks: 0,
            off_ticks: 0,
            adapt_ticks: 0,
            undetected_ticks: ADAPT_TICKS,
        }
    }
}

impl Infrared {
    /// Takes the readings of the half cycle that has ended; returns whether the LEDs are on in the next one.
    pub fn sample(&mut self, left: bool, right: bool) -> bool {
        let was_on = self.leds_on;
        self.leds_on = self.enabled && self.off_ticks == 0 && !was_on;
        if was_on {
            self.lit = Sides { left, right };
        } else {
            let lit = core::mem::take(&mut self.lit);
            self.compare(Sides {
                left: lit.left && !left,
                right: lit.right && !right,
            });
        }
        self.leds_on
    }

    /// Evaluates a complete pair of half cycles.
    fn compare(&mut self, pair: Sides) {
        self.seen |= pair.any();
        for (run, seen) in self.runs.iter_mut().zip([pair.left, pair.right]) {
            *run = if seen { run.saturating_add(1) } else { 0 };
        }
        if self.runs.iter().any(|&run| run >= self.max_count) {
            // The count restarts, so that a higher `max_count` turns the robot less often.
            self.runs = [0; 2];
            self.detected = self.detected.or(pair);
        }
    }

    /// Detections since the last tick. Call once per tick. `enabled` is the state of the layer. With equal limits,
    /// `max_count` does not adapt.
    pub fn tick(&mut self, enabled: bool, parameters: &Parameters) -> Sides {
        let detected = core::mem::take(&mut self.detected);
        let seen = core::mem::take(&mut self.seen);
        self.enabled = enabled;
        self.adapt(detected, parameters);
        if self.off_ticks > 0 {
            self.off_ticks -= 1;
            return Sides::default();
        }
        self.seen_ticks = if seen && enabled {
            self.seen_ticks + 1
        } else {
            0
        };
        if self.seen_ticks >= JAM_TICKS {
            self.seen_ticks = 0;
            self.off_ticks = OFF_TICKS;
            self.runs = [0; 2];
            return Sides::default();
        }
        if enabled { detected } else { Sides::default() }
    }

    fn adapt(&mut self, detected: Sides, parameters: &Parameters) {
        let count = |parameter| parameters.get(parameter) as u8;
        let least = count(Parameter::InfraredLeast);
        let most = count(Parameter::InfraredMost).max(least);
        self.max_count = self.max_count.clamp(least, most);
        if detected.left && detected.right {
            self.max_count = self.max_count.saturating_mul(2).min(most);
        }
        self.undetected_ticks = if detected.any() {
            0
        } else {
            self.undetected_ticks.saturating_add(1)
        };
        self.adapt_ticks += 1;
        if self.adapt_ticks < ADAPT_TICKS {
            return;
        }
        self.adapt_ticks = 0;
        self.max_count = if self.undetected_ticks < ADAPT_TICKS {
            (self.max_count + 1).min(most)
        } else {
            (self.max_count / 2).max(least)
        };
    }

    /// Current number of consecutive pairs that make a detection.
    #[must_use]
    pub const fn max_count(&self) -> u8 {
        self.max_count
    }

    /// Whether many detections, such as of the walls of a passage, have raised `max_count`.
    #[must_use]
    pub const fn is_confined(&self) -> bool {
        self.max_count >= CONFINED_COUNT
    }

    /// Whether the detectors are off because of a jam.
    #[must_use]
    pub const fn is_jammed(&self) -> bool {
        self.off_ticks > 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One tick of six pairs with these readings.
    fn tick(infrared: &mut Infrared, lit: Sides, dark: Sides) -> Sides {
        for _ in 0..12 {
            let reading = if infrared.leds_on { lit } else { dark };
            infrared.sample(reading.left, reading.right);
        }
        infrared.tick(true, &Parameters::DEFAULT)
    }

    const LEFT: Sides = Sides {
        left: true,
        right: false,
    };
    const NONE: Sides = Sides {
        left: false,
        right: false,
    };
    const BOTH: Sides = Sides {
        left: true,
        right: true,
    };

    /// Enabled detectors, at the first half cycle of a pair with the LEDs on.
    fn running() -> Infrared {
        let mut infrared = Infrared::default();
        infrared.tick(true, &Parameters::DEFAULT);
        infrared.sample(false, false);
        infrared
    }

    #[test]
    fn leds_blink_at_half_the_sample_rate_while_enabled() {
        let mut infrared = running();
        let leds: [bool; 6] = core::array::from_fn(|_| infrared.sample(false, false));
        assert_eq!(leds, [false, true, false, true, false, true]);
        infrared.tick(false, &Parameters::DEFAULT);
        assert!((0..6).all(|_| !infrared.sample(true, true)));
        assert_eq!(infrared.tick(false, &Parameters::DEFAULT), NONE);
    }

    #[test]
    fn ambient_light_is_not_a_reflection() {
        let mut infrared = running();
        assert_eq!(tick(&mut infrared, LEFT, NONE), LEFT);
        assert_eq!(tick(&mut infrared, BOTH, BOTH), NONE);
        assert_eq!(tick(&mut infrared, NONE, BOTH), NONE);
        assert_eq!(
            tick(&mut infrared, BOTH, LEFT),
            Sides {
                left: false,
                right: true
            }
        );
    }

    #[test]
    fn fewer_pairs_than_max_count_are_no_detection() {
        let mut infrared = running();
        for pairs in 0..20 {
            let seen = pairs % 3 != 2;
            infrared.sample(seen, false);
            infrared.sample(false, false);
        }
        assert_eq!(infrared.tick(true, &Parameters::DEFAULT), NONE);
        for _ in 0..3 {
            infrared.sample(true, false);
            infrared.sample(false, false);
        }
        assert_eq!(infrared.tick(true, &Parameters::DEFAULT), LEFT);
    }

    #[test]
    fn max_count_rises_with_detections_and_falls_without() {
        let mut infrared = running();
        let mut detections = 0;
        for _ in 0..590 {
            detections += u32::from(tick(&mut infrared, LEFT, NONE).any());
        }
        assert_eq!(infrared.max_count(), 40);
        // At most one detection per 40 pairs, at 6 pairs per tick.
        assert!(detections < 590 / 2, "{detections}");
        for _ in 0..380 {
            tick(&mut infrared, NONE, NONE);
        }
        assert_eq!(infrared.max_count(), 3);
    }

    #[test]
    fn max_count_doubles_when_both_sides_detect() {
        let mut infrared = running();
        let mut counts = [0; 4];
        for count in &mut counts {
            while !tick(&mut infrared, BOTH, NONE).any() {}
            *count = infrared.max_count();
        }
        assert_eq!(counts, [6, 12, 24, 40]);
    }

    #[test]
    fn max_count_is_fixed_with_equal_limits() {
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::InfraredLeast, 12));
        assert!(parameters.set(Parameter::InfraredMost, 5));
        let mut infrared = running();
        for seen in [LEFT, BOTH, NONE] {
            for _ in 0..200 {
                for _ in 0..6 {
                    infrared.sample(seen.left, seen.right);
                    infrared.sample(false, false);
                }
                infrared.tick(true, &parameters);
                assert_eq!(infrared.max_count(), 12, "the larger of two crossed limits");
            }
        }
    }

    #[test]
    fn jam_turns_the_detectors_off_after_and_for_thirty_seconds() {
        let mut infrared = running();
        for n in 1..600 {
            tick(&mut infrared, LEFT, NONE);
            assert!(!infrared.is_jammed(), "tick {n}");
        }
        tick(&mut infrared, BOTH, NONE);
        for n in 1..=600 {
            assert!(infrared.is_jammed(), "tick {n}");
            assert!(!infrared.sample(true, true));
            assert_eq!(tick(&mut infrared, LEFT, NONE), NONE);
        }
        assert!(!infrared.is_jammed());
        // The next jam again takes thirty seconds.
        for n in 1..600 {
            tick(&mut infrared, LEFT, NONE);
            assert!(!infrared.is_jammed(), "tick {n}");
        }
        tick(&mut infrared, LEFT, NONE);
        assert!(infrared.is_jammed());
    }

    #[test]
    fn tick_without_a_detection_restarts_the_jam_timer() {
        let mut infrared = running();
        for _ in 0..599 {
            tick(&mut infrared, LEFT, NONE);
        }
        tick(&mut infrared, NONE, NONE);
        for n in 1..600 {
            tick(&mut infrared, LEFT, NONE);
            assert!(!infrared.is_jammed(), "tick {n}");
        }
    }
}
