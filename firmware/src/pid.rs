//! Speed control of one wheel: a PID controller that accumulates the count error, 20 times per second.
//!
//! The controller accumulates the error of counts, not of speeds: a delayed wheel catches up, so two wheels with equal speeds keep
//! the robot's heading.
//!
//! A motor that cannot turn its wheel would overheat, so its power is switched off for some seconds at a time.

use crate::board::PWM_MAX;
use crate::parameters::{Parameter, Parameters};
use crate::units::{TICKS_PER_S, cps, ticks};

/// Gains of the controller. The defaults: a slew of 24 in/s^2, which gears and tyres hold; the feed-forward of an
/// unloaded motor at 12 V, which reaches 20 in/s at full width; for each change of speed, the feed-forward over the
/// motors' time constant of 1/6 s; and a proportional gain that damps the rest.
#[derive(Clone, Copy, Debug)]
pub struct Gains {
    /// Maximum change of the commanded speed per tick.
    slew_cps: i16,
    /// Pulse width per count a second of commanded speed, in 1/256.
    per_cps_ordered: i32,
    /// Pulse width per count a second of change in a tick, in 1/256.
    per_cps_changed: i32,
    /// Pulse width per count a second of speed error, in 1/256.
    per_cps_slow: i32,
    /// Pulse width per count of accumulated error.
    per_count_behind: i32,
}

impl Gains {
    /// Gains from the parameters.
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

    /// Maximum accumulated error in counts: as much as gives full pulse width by itself. With more, a wheel that comes
    /// free would overshoot.
    fn behind_max_counts(&self) -> i32 {
        i32::from(PWM_MAX) / self.per_count_behind.max(1)
    }
}

impl Default for Gains {
    fn default() -> Self {
        Self::of(&Parameters::DEFAULT)
    }
}

/// Pulse width that slows an idling wheel by one count per tick within a tick: in 1/20 s a wheel gets a quarter of the
/// way to the speed of its pulse width.
const BRAKE_PER_COUNT: i32 = 45;

/// Number of ticks at full pulse width below the commanded speed after which the wheel is saturated.
const SATURATED_TICKS: u8 = ticks(1) as u8 / 2;

/// Pulse width, and ticks without a count at it, after which the wheel is stalled. At three quarters the winding takes
/// more than half of the heat of full width.
const STALLED_PWM: i32 = PWM_MAX as i32 * 3 / 4;
const STALLED_TICKS: u8 = ticks(1) as u8;

/// Number of ticks without power after a stall: the motor is powered a fifth of the time.
const REST_TICKS: u8 = 4 * STALLED_TICKS;

/// Number of ticks at full pulse width below two thirds of the commanded speed after which the robot is held and its wheels slip.
/// They slip at a third of top speed; a low battery or a rated load does not slow them as much.
const OVERLOAD_TICKS: u8 = 2 * ticks(1) as u8;

/// Maximum number of edges of a tick in which the wheel may have reversed.
const STANDING_COUNTS: u16 = 1;

/// Maximum number of edges of a wheel per tick: the fastest gives 16.
const COUNTS_MAX: u16 = 255;

/// Resolution of a wheel's speed, in parts of a count per tick.
const SPEED_PARTS: i32 = 256;

/// Speed per step of pulse width in [`SPEED_PARTS`]: 20 in/s, 16 counts per tick, at full width.
const SPEED_PER_STEP: i32 = 16 * SPEED_PARTS / PWM_MAX as i32;

/// Speed lost to the gears' friction, in [`SPEED_PARTS`].
const DRAG: i32 = SPEED_PARTS * 9 / 8;

/// Shares in 1/256 of the remaining speed difference that the mean speed during a tick and the speed at its end make
/// up: the motors' time constant is 1/6 s, and a tick is 3 tenths of it.
const FOLLOWS_DURING: i32 = 40;
const FOLLOWS_AFTER: i32 = 66;

/// Share in 1/256 of their difference by which the edges correct the expected speed. Without expectation a wheel whose
/// direction was once wrong would stay wrong forever, with its motor driving against it.
const CORRECTS: i32 = 64;

/// Resolution of the count error: 1/20 count, because a speed of 1 count per second makes one of them per tick.
const PARTS: i32 = TICKS_PER_S as i32;

/// Controller of one wheel.
#[derive(Clone, Debug, Default)]
pub struct Wheel {
    /// Commanded speed after the slew limit.
    slewed_cps: i16,
    /// Accumulated count error in [`PARTS`].
    behind_parts: i32,
    /// Assumed direction of the wheel.
    backward: bool,
    /// Speed at the end of the past tick in [`SPEED_PARTS`].
    speed_parts: i32,
    /// Pulse width of the current tick.
    pwm: i16,
    full_ticks: u8,
    still_ticks: u8,
    /// Number of ticks at full pulse width with much too low a speed, less those without.
    overload_ticks: u8,
    /// Whether the wheel has stalled and not moved since.
    is_stalled: bool,
    /// Whether the wheel has stalled since its last encoder edge: backward, and forward.
    silent: (bool, bool),
    /// Remaining number of ticks without power after a stall, and the direction in which the wheel stalled.
    rest_ticks: u8,
    stalled_backward: bool,
    /// While braking: counts per tick at the end of the past tick.
    braked_counts: Option<i16>,
}

impl Wheel {
    /// Gives the encoder edges of the past tick their sign, from a motor model with the previous speed and pulse width. A
    /// command against the direction of the wheel first brakes it.
    #[must_use]
    pub fn signed_counts(&mut self, edges: u16) -> i16 {
        let pwm = i32::from(self.pwm) * SPEED_PER_STEP;
        let drag = if self.speed_parts.abs() > DRAG / 4 {
            DRAG * self.speed_parts.signum()
        } else {
            pwm.clamp(-DRAG, DRAG)
        };
        let pull = pwm - drag - self.speed_parts;
        let during = self.speed_parts + pull * FOLLOWS_DURING / SPEED_PARTS;
        if during != 0 {
            self.backward = during < 0;
        }
        if edges > 0 {
            self.silent = (false, false);
        }
        let counts = edges.min(COUNTS_MAX) as i16;
        let counts = if self.backward { -counts } else { counts };
        let missed = i32::from(counts) * SPEED_PARTS - during;
        self.speed_parts += (pull * FOLLOWS_AFTER + missed * CORRECTS) / SPEED_PARTS;
        counts
    }

    /// Switches the motor off and clears the accumulated error.
    pub fn halt(&mut self) {
        self.slewed_cps = 0;
        self.is_stalled = false;
        self.rest_ticks = 0;
        self.pwm = 0;
        self.release();
    }

    /// Pulse width that stops the wheel within two ticks: full power against its direction, based on its estimated speed
    /// at the end of the tick.
    pub fn brake(&mut self, counts: i16) -> i16 {
        self.halt();
        // A wheel does not stop at once: without any edge its encoder may be broken, and the motor model is the better guess.
        let model = (self.speed_parts.abs() / SPEED_PARTS) as i16;
        let during = if counts == 0 && self.is_silent() {
            model
        } else {
            counts.saturating_abs()
        };
        let now = match self.braked_counts {
            // Faster while braking: the assumed direction is wrong, so let the wheel run out.
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
        self.pwm = if self.backward { against } else { -against };
        self.pwm
    }

    fn release(&mut self) {
        self.behind_parts = 0;
        self.full_ticks = 0;
        self.still_ticks = 0;
        self.overload_ticks = 0;
    }

    /// Pulse width for the next tick from the commanded speed and the counts of the past tick.
    pub fn control(&mut self, ordered_cps: i16, counts: i16, gains: &Gains) -> i16 {
        self.braked_counts = None;
        if self.is_resting(ordered_cps) {
            self.pwm = 0;
            return 0;
        }
        if i32::from(ordered_cps) * i32::from(self.slewed_cps) < 0 {
            self.overload_ticks = 0;
        }
        let change = ordered_cps.saturating_sub(self.slewed_cps);
        let change = change.clamp(-gains.slew_cps, gains.slew_cps);
        self.slewed_cps += change;
        if ordered_cps == 0 && self.slewed_cps == 0 {
            self.is_stalled = false;
            self.pwm = 0;
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
        let pwm = wanted.clamp(-full, full);
        // Anti-windup: an error that the motor cannot work off faster is not accumulated.
        let is_winding_up = pwm != wanted && (too_slow_cps > 0) == (wanted > 0);
        if !is_winding_up {
            self.behind_parts = behind.clamp(-limit, limit);
        }
        self.watch(pwm, counts);
        self.pwm = pwm as i16;
        self.pwm
    }

    /// Whether the motor is without power after a stall. A command in the other direction, as in an escape, ends the rest.
    fn is_resting(&mut self, ordered_cps: i16) -> bool {
        if self.rest_ticks == 0 {
            return false;
        }
        self.rest_ticks -= 1;
        self.slewed_cps = 0;
        let turns_back = ordered_cps != 0 && (ordered_cps < 0) != self.stalled_backward;
        if turns_back {
            self.rest_ticks = 0;
        }
        !turns_back
    }

    fn watch(&mut self, pwm: i32, counts: i16) {
        let is_onward = (pwm > 0) == (self.slewed_cps > 0);
        let is_full = is_onward && pwm.abs() == i32::from(PWM_MAX);
        let is_high = is_onward && pwm.abs() >= STALLED_PWM;
        let count = |ticks: u8, goes_on: bool| if goes_on { ticks.saturating_add(1) } else { 0 };
        self.full_ticks = count(self.full_ticks, is_full);
        self.still_ticks = count(self.still_ticks, is_high && counts == 0);
        let speed_cps = i32::from(counts).abs() * PARTS;
        self.overload_ticks = if is_full && speed_cps * 3 < i32::from(self.slewed_cps).abs() * 2 {
            self.overload_ticks.saturating_add(1).min(OVERLOAD_TICKS)
        } else {
            self.overload_ticks.saturating_sub(1)
        };
        // A single count may be play of the gears.
        self.is_stalled &= counts.unsigned_abs() <= STANDING_COUNTS;
        if self.still_ticks >= STALLED_TICKS {
            self.release();
            self.is_stalled = true;
            self.rest_ticks = REST_TICKS;
            self.stalled_backward = pwm < 0;
            self.silent.0 |= pwm < 0;
            self.silent.1 |= pwm > 0;
        }
    }

    /// Whether the encoder is broken: power in either direction gives no edge. An obstacle holds a wheel in only one direction;
    /// in the other, the wheel turns at least by the play of its gears.
    #[must_use]
    pub const fn is_mute(&self) -> bool {
        self.silent.0 && self.silent.1
    }

    /// Whether the wheel has stalled since its last encoder edge.
    #[must_use]
    pub const fn is_silent(&self) -> bool {
        self.silent.0 || self.silent.1
    }

    /// Clears the stalls without an edge, because the operator has checked the encoder.
    pub const fn trust_again(&mut self) {
        self.silent = (false, false);
    }

    /// Whether full pulse width does not reach the commanded speed.
    #[must_use]
    pub const fn is_saturated(&self) -> bool {
        self.full_ticks >= SATURATED_TICKS
    }

    /// Whether an obstacle holds the wheel, or holds the robot while the wheel slips.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        self.is_stalled || self.overload_ticks >= OVERLOAD_TICKS
    }

    /// Whether high pulse width does not turn the wheel; stays true while the motor rests and until the wheel moves.
    #[must_use]
    pub const fn is_stalled(&self) -> bool {
        self.is_stalled
    }
}
