//! The drive train: from a speed and a rotation of the robot to two pulse widths.

use crate::board::{Inputs, Side};
use crate::pid::{Gains, Wheel};
use crate::units::{TICKS_PER_S, cps};

/// A motion of the whole robot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Motion {
    /// Speed at the centre in counts per second.
    pub velocity_cps: i16,
    /// Left wheel speed minus right wheel speed in counts per second: positive turns right.
    pub rotation_cps: i16,
}

impl Motion {
    /// Standing still.
    pub const STILL: Self = Self::new(0, 0);

    /// A motion in whole inches per second.
    #[must_use]
    pub const fn new(velocity_in_s: i16, rotation_in_s: i16) -> Self {
        Self {
            velocity_cps: cps(velocity_in_s),
            rotation_cps: cps(rotation_in_s),
        }
    }

    /// Speeds of the left and right wheels. Above [`WHEEL_MAX_CPS`] the robot drives slower but turns as requested.
    #[must_use]
    pub fn wheels(self) -> (i16, i16) {
        let half = self
            .rotation_cps
            .clamp(-2 * WHEEL_MAX_CPS, 2 * WHEEL_MAX_CPS)
            / 2;
        let room = WHEEL_MAX_CPS - half.abs();
        let velocity = self.velocity_cps.clamp(-room, room);
        (velocity + half, velocity - half)
    }
}

/// Maximum speed of a wheel: 12 in/s, which a low battery reaches under load.
pub const WHEEL_MAX_CPS: i16 = cps(12);

/// Resolution of averaged speeds, in parts of a count per second.
const AVERAGE_PARTS: i32 = 64;

/// Averaging of the reported speeds: about 4 ticks.
const SPEED_SHIFT: u32 = 2;

/// Averaging of the turning direction: about 3 s.
const TURNING_SHIFT: u32 = 6;

/// The drive train.
#[derive(Clone, Debug, Default)]
pub struct DriveTrain {
    left: Wheel,
    right: Wheel,
    left_parts: i32,
    right_parts: i32,
    turning_parts: i32,
}

/// Signed numbers of counts of both wheels in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Number of counts of the left wheel, negative backward.
    pub left: i16,
    /// Number of counts of the right wheel, negative backward.
    pub right: i16,
}

impl DriveTrain {
    /// Signed numbers of counts of both wheels in the past tick.
    pub fn measure(&mut self, inputs: &Inputs) -> Counts {
        let counts = Counts {
            left: self.left.signed_counts(inputs.counts_left),
            right: self.right.signed_counts(inputs.counts_right),
        };
        let follow = |average: &mut i32, counts: i16, shift: u32| {
            let now = i32::from(counts) * i32::from(TICKS_PER_S) * AVERAGE_PARTS;
            *average += (now - *average) >> shift;
        };
        follow(&mut self.left_parts, counts.left, SPEED_SHIFT);
        follow(&mut self.right_parts, counts.right, SPEED_SHIFT);
        let turning = counts.left.saturating_sub(counts.right);
        follow(&mut self.turning_parts, turning, TURNING_SHIFT);
        counts
    }

    /// Left and right pulse widths that control the wheels to a motion.
    pub fn control(&mut self, motion: Motion, counts: Counts, gains: &Gains) -> (i16, i16) {
        let (left, right) = motion.wheels();
        (
            self.left.control(left, counts.left, gains),
            self.right.control(right, counts.right, gains),
        )
    }

    /// Pulse widths that stop both wheels as fast as possible.
    pub fn brake(&mut self, counts: Counts) -> (i16, i16) {
        (self.left.brake(counts.left), self.right.brake(counts.right))
    }

    /// Switches both motors off.
    pub fn halt(&mut self) {
        self.left.halt();
        self.right.halt();
    }

    /// Measured speed of the left wheel in counts per second.
    #[must_use]
    pub const fn left_cps(&self) -> i16 {
        (self.left_parts / AVERAGE_PARTS) as i16
    }

    /// Measured speed of the right wheel in counts per second.
    #[must_use]
    pub const fn right_cps(&self) -> i16 {
        (self.right_parts / AVERAGE_PARTS) as i16
    }

    /// Whether neither wheel measurably turns.
    #[must_use]
    pub const fn is_standing(&self) -> bool {
        self.left_cps() == 0 && self.right_cps() == 0
    }

    /// Long-term average of left minus right in counts per second.
    #[must_use]
    pub const fn turning_cps(&self) -> i16 {
        (self.turning_parts / AVERAGE_PARTS) as i16
    }

    /// Whether a wheel does not reach its speed at full pulse width.
    #[must_use]
    pub const fn is_saturated(&self) -> bool {
        self.left.is_saturated() || self.right.is_saturated()
    }

    /// Whether an obstacle holds a wheel, or holds the robot while a wheel slips.
    #[must_use]
    pub const fn is_held(&self) -> bool {
        self.left.is_held() || self.right.is_held()
    }

    /// The wheel with a broken encoder. If neither wheel turns, the robot is wedged, and no encoder counts as broken.
    #[must_use]
    pub const fn mute_side(&self) -> Option<Side> {
        if self.left.is_mute() && !self.right.is_silent() {
            Some(Side::Left)
        } else if self.right.is_mute() && !self.left.is_silent() {
            Some(Side::Right)
        } else {
            None
        }
    }

    /// Trusts both encoders again.
    pub const fn trust_again(&mut self) {
        self.left.trust_again();
        self.right.trust_again();
    }

    /// Whether a wheel does not turn at high pulse width.
    #[must_use]
    pub const fn is_stalled(&self) -> bool {
        self.left.is_stalled() || self.right.is_stalled()
    }
}
