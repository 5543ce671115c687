//! One wheel's speed control: a PID that accumulates count error, 20 times a second.
//!
//! The error it accumulates is of counts, not of speeds: a wheel that was held back catches up, and so
//! two wheels that shall run alike keep the robot's heading.

use crate::board::PWM_MAX;
use crate::units::{TICKS_PER_S, cps, ticks};

/// How fast an ordered speed may change, per tick: 24 in/s^2, which the gears bear and rubber holds.
pub const SLEW_CPS: i16 = cps(24) / TICKS_PER_S;

/// Pulse width that an unloaded motor needs at 12 V, in 256ths per count a second: what it would take
/// to get to 20 in/s at full width.
const FEED_FORWARD: i32 = 204;

/// Pulse width that speeds the robot up by a count a second each tick, in 256ths: the motors follow
/// with a time constant of 1/6 s.
const FEED_FORWARD_CHANGE: i32 = FEED_FORWARD * TICKS_PER_S as i32 / 6;

/// Pulse width for each count behind: damps the motors' 1/6 s together with [`PER_CPS`].
const PER_COUNT: i32 = 3;

/// Pulse width for each count a second too slow, in 256ths.
const PER_CPS: i32 = 102;

/// Most counts that are made up for: enough to bring full pulse width by itself, and not more, or a
/// wheel that comes free would dash on.
const BEHIND_MAX_COUNTS: i32 = PWM_MAX as i32 / PER_COUNT;

/// Full pulse width for this long and still too slow: saturated.
const SATURATED_TICKS: u8 = ticks(1) as u8 / 2;

/// Full pulse width for this long without one count: stalled.
const STALLED_TICKS: u8 = ticks(1) as u8;

/// A tick with no more edges than this is one in which the wheel may have turned back.
const STANDING_COUNTS: u16 = 1;

/// The longest that a command against the wheel's way can be a brake: twice the motors' time constant.
const BRAKING_TICKS: u8 = 6;

/// The count error is kept in twentieths of a count, the unit in which a speed is one a tick.
const PARTS: i32 = TICKS_PER_S as i32;

/// One wheel.
#[derive(Clone, Debug, Default)]
pub struct Wheel {
    /// Ordered speed after the slew limit.
    slewed_cps: i16,
    /// Counts behind the order, in [`PARTS`].
    behind_parts: i32,
    /// The way the wheel is believed to turn.
    backward: bool,
    /// How long the motor command has been against it.
    against_ticks: u8,
    full_ticks: u8,
    still_ticks: u8,
}

impl Wheel {
    /// Gives the encoder's edges of the past tick the way the wheel is believed to turn: that of the
    /// motor command, as soon as the wheel can have followed it.
    #[must_use]
    pub fn signed_counts(&self, edges: u16) -> i16 {
        let counts = edges.min(i16::MAX as u16) as i16;
        if self.backward { -counts } else { counts }
    }

    /// Motor off at once; nothing is left to make up for.
    pub fn halt(&mut self) {
        self.slewed_cps = 0;
        self.release();
    }

    fn release(&mut self) {
        self.behind_parts = 0;
        self.full_ticks = 0;
        self.still_ticks = 0;
    }

    /// The pulse width for the coming tick, from the ordered speed and the counts of the past tick.
    pub fn control(&mut self, ordered_cps: i16, counts: i16) -> i16 {
        let change = ordered_cps.saturating_sub(self.slewed_cps);
        let change = change.clamp(-SLEW_CPS, SLEW_CPS);
        self.slewed_cps += change;
        if ordered_cps == 0 && self.slewed_cps == 0 {
            self.release();
            return 0;
        }
        let too_slow_cps = i32::from(self.slewed_cps) - i32::from(counts) * PARTS;
        let behind = self.behind_parts + too_slow_cps;
        let limit = BEHIND_MAX_COUNTS * PARTS;
        let wanted = i32::from(self.slewed_cps) * FEED_FORWARD / 256
            + i32::from(change) * FEED_FORWARD_CHANGE / 256
            + behind * PER_COUNT / PARTS
            + too_slow_cps * PER_CPS / 256;
        let full = i32::from(PWM_MAX);
        let given = wanted.clamp(-full, full);
        // Against wind-up: an error that the motor cannot work off any faster is not accumulated.
        let is_winding_up = given != wanted && (too_slow_cps > 0) == (wanted > 0);
        if !is_winding_up {
            self.behind_parts = behind.clamp(-limit, limit);
        }
        self.watch(given, counts);
        self.follow(given, counts);
        given as i16
    }

    /// A wheel cannot turn back without standing still: while edges come fast, a command against its
    /// way is a brake.
    fn follow(&mut self, given: i32, counts: i16) {
        let is_against = given != 0 && (given < 0) != self.backward;
        if !is_against {
            self.against_ticks = 0;
            return;
        }
        self.against_ticks += 1;
        if counts.unsigned_abs() <= STANDING_COUNTS || self.against_ticks >= BRAKING_TICKS {
            self.backward = !self.backward;
            self.against_ticks = 0;
        }
    }

    fn watch(&mut self, given: i32, counts: i16) {
        let is_full = given.abs() == i32::from(PWM_MAX) && (given > 0) == (self.slewed_cps > 0);
        let count = |ticks: u8, goes_on: bool| if goes_on { ticks.saturating_add(1) } else { 0 };
        self.full_ticks = count(self.full_ticks, is_full);
        self.still_ticks = count(self.still_ticks, is_full && counts == 0);
    }

    /// Whether full pulse width does not bring the ordered speed.
    #[must_use]
    pub const fn is_saturated(&self) -> bool {
        self.full_ticks >= SATURATED_TICKS
    }

    /// Whether full pulse width does not turn the wheel at all.
    #[must_use]
    pub const fn is_stalled(&self) -> bool {
        self.still_ticks >= STALLED_TICKS
    }
}
