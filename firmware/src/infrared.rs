//! The infrared detectors, looked at 250 times a second.
//!
//! The LEDs are on for one half cycle and off for the next. A detector sees something when it fires
//! with the LEDs on and not with them off: what fires by itself is ambient light. So many pairs in a
//! row must agree before the detection counts; that number, `max_count`, grows with every detection
//! and falls in their absence, which lets the robot keep its distance in the open and still enter a
//! confined space. Where both sides are near it grows at once: between two walls the robot has to get used to
//! them before they have turned it round.

use crate::board::Sides;
use crate::parameters::{Parameter, Parameters};
use crate::units::{TICKS_PER_S, ticks};

/// In so many ticks `max_count` grows by one when something was detected in them, and is halved when nothing
/// was: a robot that has left a passage must not go on being blind.
const ADAPT_TICKS: u8 = TICKS_PER_S as u8 / 2;

/// Something seen in every tick for this long is a jam.
pub const JAM_TICKS: u16 = ticks(30);

/// After a jam the detectors are off for this long.
pub const OFF_TICKS: u16 = ticks(30);

/// Both detectors and their LEDs.
#[derive(Clone, Debug)]
pub struct Infrared {
    enabled: bool,
    leds_on: bool,
    /// What fired in the half cycle with the LEDs on.
    lit: Sides,
    /// Pairs in a row that saw something.
    runs: [u8; 2],
    max_count: u8,
    /// Any pair that saw something since the last tick.
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
    /// Takes what the detectors read in the half cycle that just ended; says whether the LEDs are on
    /// in the next one.
    pub fn look(&mut self, left: bool, right: bool) -> bool {
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

    /// A pair of half cycles is complete.
    fn compare(&mut self, pair: Sides) {
        self.seen |= pair.any();
        for (run, seen) in self.runs.iter_mut().zip([pair.left, pair.right]) {
            *run = if seen { run.saturating_add(1) } else { 0 };
        }
        if self.runs.iter().any(|&run| run >= self.max_count) {
            // The count begins anew: the higher it must get, the less often the robot is turned away.
            self.runs = [0; 2];
            self.detected = self.detected.or(pair);
        }
    }

    /// Once a tick: what has been detected since the last one. `enabled` is whether the layer is. With
    /// equal limits `max_count` does not adapt.
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

    /// Pairs in a row that make a detection at present.
    #[must_use]
    pub const fn max_count(&self) -> u8 {
        self.max_count
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

    /// Six pairs a tick, of what each half cycle reads.
    fn tick(infrared: &mut Infrared, lit: Sides, dark: Sides) -> Sides {
        for _ in 0..12 {
            let reading = if infrared.leds_on { lit } else { dark };
            infrared.look(reading.left, reading.right);
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

    /// Switched on, and the LEDs just lit for the first half cycle of a pair.
    fn running() -> Infrared {
        let mut infrared = Infrared::default();
        infrared.tick(true, &Parameters::DEFAULT);
        infrared.look(false, false);
        infrared
    }

    #[test]
    fn the_leds_blink_at_half_the_rate_of_the_looks_while_the_layer_is_on() {
        let mut infrared = running();
        let leds: [bool; 6] = core::array::from_fn(|_| infrared.look(false, false));
        assert_eq!(leds, [false, true, false, true, false, true]);
        infrared.tick(false, &Parameters::DEFAULT);
        assert!((0..6).all(|_| !infrared.look(true, true)));
        assert_eq!(infrared.tick(false, &Parameters::DEFAULT), NONE);
    }

    #[test]
    fn what_fires_in_the_dark_is_no_reflection() {
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
    fn fewer_pairs_in_a_row_than_max_count_are_nothing() {
        let mut infrared = running();
        for pairs in 0..20 {
            let seen = pairs % 3 != 2;
            infrared.look(seen, false);
            infrared.look(false, false);
        }
        assert_eq!(infrared.tick(true, &Parameters::DEFAULT), NONE);
        for _ in 0..3 {
            infrared.look(true, false);
            infrared.look(false, false);
        }
        assert_eq!(infrared.tick(true, &Parameters::DEFAULT), LEFT);
    }

    #[test]
    fn max_count_grows_with_detections_and_falls_without() {
        let mut infrared = running();
        let mut detections = 0;
        for _ in 0..590 {
            detections += u32::from(tick(&mut infrared, LEFT, NONE).any());
        }
        assert_eq!(infrared.max_count(), 40);
        // At most one in 40 pairs, of 6 a tick, by then.
        assert!(detections < 590 / 2, "{detections}");
        for _ in 0..380 {
            tick(&mut infrared, NONE, NONE);
        }
        assert_eq!(infrared.max_count(), 3);
    }

    #[test]
    fn between_two_walls_max_count_doubles_with_each_detection() {
        let mut infrared = running();
        let mut counts = [0; 4];
        for count in &mut counts {
            while !tick(&mut infrared, BOTH, NONE).any() {}
            *count = infrared.max_count();
        }
        assert_eq!(counts, [6, 12, 24, 40]);
    }

    #[test]
    fn with_equal_limits_it_does_not_adapt() {
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::InfraredLeast, 12));
        assert!(parameters.set(Parameter::InfraredMost, 5));
        let mut infrared = running();
        for seen in [LEFT, BOTH, NONE] {
            for _ in 0..200 {
                for _ in 0..6 {
                    infrared.look(seen.left, seen.right);
                    infrared.look(false, false);
                }
                infrared.tick(true, &parameters);
                assert_eq!(infrared.max_count(), 12, "the larger of two that cross");
            }
        }
    }

    #[test]
    fn thirty_seconds_of_detection_switch_it_off_for_thirty_seconds_to_the_tick() {
        let mut infrared = running();
        for n in 1..600 {
            tick(&mut infrared, LEFT, NONE);
            assert!(!infrared.is_jammed(), "tick {n}");
        }
        tick(&mut infrared, BOTH, NONE);
        for n in 1..=600 {
            assert!(infrared.is_jammed(), "tick {n}");
            assert!(!infrared.look(true, true));
            assert_eq!(tick(&mut infrared, LEFT, NONE), NONE);
        }
        assert!(!infrared.is_jammed());
        // And a whole thirty seconds again.
        for n in 1..600 {
            tick(&mut infrared, LEFT, NONE);
            assert!(!infrared.is_jammed(), "tick {n}");
        }
        tick(&mut infrared, LEFT, NONE);
        assert!(infrared.is_jammed());
    }

    #[test]
    fn one_tick_without_a_detection_begins_the_thirty_seconds_anew() {
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
