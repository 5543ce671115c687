//! The infrared detectors, looked at 250 times a second.
//!
//! The LEDs are on for one half cycle and off for the next. A detector sees something when it fires
//! with the LEDs on and not with them off: what fires by itself is ambient light. So many pairs in a
//! row must agree before the detection counts; that number, `max_count`, grows with every detection
//! and falls in their absence, which lets the robot keep its distance in the open and still enter a
//! confined space.

use crate::units::{TICKS_PER_S, ticks};

/// Pairs in a row that make a detection when little has been detected lately: 24 ms.
pub const MAX_COUNT_LEAST: u8 = 3;

/// Pairs in a row that make a detection in the thick of things: a third of a second.
pub const MAX_COUNT_MOST: u8 = 40;

/// Without a detection `max_count` falls by one in so many ticks: from most to least in 9 s.
const RELAX_TICKS: u8 = TICKS_PER_S as u8 / 4;

/// Something seen in every tick for this long is a jam.
pub const JAM_TICKS: u16 = ticks(30);

/// After a jam the detectors are off for this long.
pub const OFF_TICKS: u16 = ticks(30);

/// What each side says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sides {
    /// Left detector.
    pub left: bool,
    /// Right detector.
    pub right: bool,
}

impl Sides {
    /// Whether either does.
    #[must_use]
    pub const fn any(self) -> bool {
        self.left || self.right
    }

    /// What either of two said.
    #[must_use]
    pub const fn or(self, other: Self) -> Self {
        Self {
            left: self.left || other.left,
            right: self.right || other.right,
        }
    }
}

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
    quiet_ticks: u8,
}

impl Default for Infrared {
    fn default() -> Self {
        Self {
            enabled: false,
            leds_on: false,
            lit: Sides::default(),
            runs: [0; 2],
            max_count: MAX_COUNT_LEAST,
            seen: false,
            detected: Sides::default(),
            seen_ticks: 0,
            off_ticks: 0,
            quiet_ticks: 0,
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

    /// Once a tick: what has been detected since the last one. `enabled` is whether the layer is.
    pub fn tick(&mut self, enabled: bool) -> Sides {
        let detected = core::mem::take(&mut self.detected);
        let seen = core::mem::take(&mut self.seen);
        self.enabled = enabled;
        self.adapt(detected.any());
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

    fn adapt(&mut self, detected: bool) {
        if detected {
            self.max_count = (self.max_count + 1).min(MAX_COUNT_MOST);
            self.quiet_ticks = 0;
            return;
        }
        self.quiet_ticks += 1;
        if self.quiet_ticks >= RELAX_TICKS {
            self.quiet_ticks = 0;
            self.max_count = (self.max_count - 1).max(MAX_COUNT_LEAST);
        }
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
