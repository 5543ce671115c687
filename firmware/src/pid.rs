//! One wheel's speed control: a PID that accumulates count error, 20 times a second.
//!
//! The error it accumulates is of counts, not of speeds: a wheel that was held back catches up, and so
//! two wheels that shall run alike keep the robot's heading.
//!
//! A motor that cannot turn its wheel is not heated for ever: its power is taken away for some seconds, again
//! and again.

use crate::board::PWM_MAX;
use crate::parameters::{Parameter, Parameters};
use crate::units::{TICKS_PER_S, cps, ticks};

/// What the operator may tune of the control. The defaults: 24 in/s^2, which the gears bear and rubber
/// holds; the pulse width that an unloaded motor needs at 12 V, which gets to 20 in/s at full width; the
/// same over the motors' time constant of 1/6 s for each change of speed; and what damps the rest.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// How fast an ordered speed may change, per tick.
    slew_cps: i16,
    /// Pulse width for each count a second ordered, in 256ths.
    per_cps_ordered: i32,
    /// Pulse width for each count a second by which the order changes in a tick, in 256ths.
    per_cps_changed: i32,
    /// Pulse width for each count a second too slow, in 256ths.
    per_cps_slow: i32,
    /// Pulse width for each count behind.
    per_count_behind: i32,
}

impl Gains {
    /// As the parameters have it.
    #[must_use]
    pub fn of(parameters: &Parameters) -> Self {
        let value = |parameter| i32::from(parameters.get(parameter));
        Self {
            slew_cps: cps(parameters.get(Parameter::Slew)) / TICKS_PER_S,
            per_cps_ordered: value(Parameter::PidFeed),
            per_cps_changed: value(Parameter::PidD),
            per_cps_slow: value(Parameter::PidP),
            per_count_behind: value(Parameter::PidI),
        }
    }

    /// Most counts that are made up for: enough to bring full pulse width by itself, and not more, or a
    /// wheel that comes free would dash on.
    fn behind_max_counts(&self) -> i32 {
        i32::from(PWM_MAX) / self.per_count_behind.max(1)
    }
}

impl Default for Gains {
    fn default() -> Self {
        Self::of(&Parameters::DEFAULT)
    }
}

/// Pulse width that takes a count a tick off an idling wheel in one tick: in 1/20 s a wheel gets a quarter
/// of the way to what its pulse width would bring.
const BRAKE_PER_COUNT: i32 = 45;

/// Full pulse width for this long and still too slow: saturated.
const SATURATED_TICKS: u8 = ticks(1) as u8 / 2;

/// So much pulse width for this long without one count: stalled. At three quarters the winding takes more than half
/// of the heat that it takes at full width.
const STALLED_PWM: i32 = PWM_MAX as i32 * 3 / 4;
const STALLED_TICKS: u8 = ticks(1) as u8;

/// A stalled motor has its power taken away for so long before it tries again: it is warm a fifth of the time.
const REST_TICKS: u8 = 4 * STALLED_TICKS;

/// Full pulse width for so long without two thirds of the ordered speed: something holds the robot, and its wheels
/// slip. They do at a third of top speed; a battery and a load for which the robot was made do not slow it so.
const LABOURED_TICKS: u8 = 2 * ticks(1) as u8;

/// A tick with no more edges than this is one in which the wheel may have turned back.
const STANDING_COUNTS: u16 = 1;

/// No wheel does more edges in a tick: the fastest does 16.
const COUNTS_MAX: u16 = 255;

/// The speed of a wheel is kept in these parts of a count a tick.
const SPEED_PARTS: i32 = 256;

/// What one step of pulse width brings a motor to, in [`SPEED_PARTS`]: 20 in/s, 16 counts a tick, at full width.
const SPEED_PER_STEP: i32 = 16 * SPEED_PARTS / PWM_MAX as i32;

/// What the gears take of that.
const DRAG: i32 = SPEED_PARTS * 9 / 8;

/// How much of the way to what is left its mean speed gets in a tick, and its speed at the end of the tick, in
/// 256ths: of the motors' time constant of 1/6 s a tick is 3 tenths.
const FOLLOWS_DURING: i32 = 40;
const FOLLOWS_AFTER: i32 = 66;

/// The edges correct the expected speed by so many 256ths of what they differ by. A wheel that was believed to turn
/// the wrong way would for ever seem to turn so if they were believed alone, its motor against it.
const CORRECTS: i32 = 64;

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
    /// Its speed at the end of the past tick, in [`SPEED_PARTS`].
    speed_parts: i32,
    /// The pulse width of the present tick.
    given: i16,
    full_ticks: u8,
    still_ticks: u8,
    /// Ticks of full pulse width with much too little speed, less those without.
    laboured_ticks: u8,
    /// It stalled, and has not moved since.
    is_stalled: bool,
    /// How long it is left without power for that, and which way it was to turn.
    rest_ticks: u8,
    rests_from_backward: bool,
    /// While it brakes: counts a tick that it still did at the end of the past tick.
    braked_counts: Option<i16>,
}

impl Wheel {
    /// Gives the encoder's edges of the past tick the way that the wheel must have turned: from the speed it had
    /// and the pulse width it was given, as a motor follows it. A command against its way is a brake at first.
    #[must_use]
    pub fn signed_counts(&mut self, edges: u16) -> i16 {
        let given = i32::from(self.given) * SPEED_PER_STEP;
        let drag = if self.speed_parts.abs() > DRAG / 4 {
            DRAG * self.speed_parts.signum()
        } else {
            given.clamp(-DRAG, DRAG)
        };
        let pull = given - drag - self.speed_parts;
        let during = self.speed_parts + pull * FOLLOWS_DURING / SPEED_PARTS;
        if during != 0 {
            self.backward = during < 0;
        }
        let counts = edges.min(COUNTS_MAX) as i16;
        let counts = if self.backward { -counts } else { counts };
        let missed = i32::from(counts) * SPEED_PARTS - during;
        self.speed_parts += (pull * FOLLOWS_AFTER + missed * CORRECTS) / SPEED_PARTS;
        counts
    }

    /// Motor off at once; nothing is left to make up for.
    pub fn halt(&mut self) {
        self.slewed_cps = 0;
        self.is_stalled = false;
        self.rest_ticks = 0;
        self.given = 0;
        self.release();
    }

    /// The pulse width that stops the wheel within two ticks, whatever it was ordered to do: full power
    /// against its way, by what it does at the end of a tick rather than during it.
    pub fn brake(&mut self, counts: i16) -> i16 {
        self.halt();
        let during = counts.saturating_abs();
        let now = match self.braked_counts {
            // Faster under the brake: its way is not what was believed, so let it run out.
            Some(before) if during > before + STANDING_COUNTS as i16 => 0,
            Some(before) => during
                .saturating_mul(2)
                .saturating_sub(before)
                .clamp(0, during),
            None => during,
        };
        self.braked_counts = Some(now);
        if now <= STANDING_COUNTS as i16 {
            return 0;
        }
        let against = (i32::from(now) * BRAKE_PER_COUNT).min(i32::from(PWM_MAX)) as i16;
        self.given = if self.backward { against } else { -against };
        self.given
    }

    fn release(&mut self) {
        self.behind_parts = 0;
        self.full_ticks = 0;
        self.still_ticks = 0;
        self.laboured_ticks = 0;
    }

    /// The pulse width for the coming tick, from the ordered speed and the counts of the past tick.
    pub fn control(&mut self, ordered_cps: i16, counts: i16, gains: &Gains) -> i16 {
        self.braked_counts = None;
        if self.rests(ordered_cps) {
            self.given = 0;
            return 0;
        }
        if i32::from(ordered_cps) * i32::from(self.slewed_cps) < 0 {
            self.laboured_ticks = 0;
        }
        let change = ordered_cps.saturating_sub(self.slewed_cps);
        let change = change.clamp(-gains.slew_cps, gains.slew_cps);
        self.slewed_cps += change;
        if ordered_cps == 0 && self.slewed_cps == 0 {
            self.is_stalled = false;
            self.given = 0;
            self.release();
            return 0;
        }
        let too_slow_cps = i32::from(self.slewed_cps) - i32::from(counts) * PARTS;
        let behind = self.behind_parts + too_slow_cps;
        let limit = gains.behind_max_counts() * PARTS;
        let wanted = i32::from(self.slewed_cps) * gains.per_cps_ordered / 256
            + i32::from(change) * gains.per_cps_changed / 256
            + behind * gains.per_count_behind / PARTS
            + too_slow_cps * gains.per_cps_slow / 256;
        let full = i32::from(PWM_MAX);
        let given = wanted.clamp(-full, full);
        // Against wind-up: an error that the motor cannot work off any faster is not accumulated.
        let is_winding_up = given != wanted && (too_slow_cps > 0) == (wanted > 0);
        if !is_winding_up {
            self.behind_parts = behind.clamp(-limit, limit);
        }
        self.watch(given, counts);
        self.given = given as i16;
        self.given
    }

    /// Whether the motor is left without power after a stall. The other way, which escapes take, it tries at once.
    fn rests(&mut self, ordered_cps: i16) -> bool {
        if self.rest_ticks == 0 {
            return false;
        }
        self.rest_ticks -= 1;
        self.slewed_cps = 0;
        let turns_back = ordered_cps != 0 && (ordered_cps < 0) != self.rests_from_backward;
        if turns_back {
            self.rest_ticks = 0;
        }
        !turns_back
    }

    fn watch(&mut self, given: i32, counts: i16) {
        let is_onward = (given > 0) == (self.slewed_cps > 0);
        let is_full = is_onward && given.abs() == i32::from(PWM_MAX);
        let is_high = is_onward && given.abs() >= STALLED_PWM;
        let count = |ticks: u8, goes_on: bool| if goes_on { ticks.saturating_add(1) } else { 0 };
        self.full_ticks = count(self.full_ticks, is_full);
        self.still_ticks = count(self.still_ticks, is_high && counts == 0);
        let speed_cps = i32::from(counts).abs() * PARTS;
        self.laboured_ticks = if is_full && speed_cps * 3 < i32::from(self.slewed_cps).abs() * 2 {
            self.laboured_ticks.saturating_add(1).min(LABOURED_TICKS)
        } else {
            self.laboured_ticks.saturating_sub(1)
        };
        // A count may be the gears' play.
        self.is_stalled &= counts.unsigned_abs() <= STANDING_COUNTS;
        if self.still_ticks >= STALLED_TICKS {
            self.release();
            self.is_stalled = true;
            self.rest_ticks = REST_TICKS;
            self.rests_from_backward = given < 0;
        }
    }

    /// Whether full pulse width does not bring the ordered speed.
    #[must_use]
    pub const fn is_saturated(&self) -> bool {
        self.full_ticks >= SATURATED_TICKS
    }

    /// Whether something holds the wheel, or holds the robot while the wheel slips.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        self.is_stalled || self.laboured_ticks >= LABOURED_TICKS
    }

    /// Whether high pulse width does not turn the wheel at all: until it moves, also while the motor is left
    /// without power for it.
    #[must_use]
    pub const fn is_stalled(&self) -> bool {
        self.is_stalled
    }
}
