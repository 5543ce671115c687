//! What the compass states.

use super::drift::Estimate;
use super::reckoning::Ellipse;

/// Factor from a standard deviation to the half of a 95 % interval.
const HALF_95: f64 = 1.96;

/// A value with the half of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The value.
    pub value: f64,
    /// Half of the 95 % interval.
    pub half: f64,
}

impl Interval {
    pub(super) fn of(estimate: Estimate) -> Self {
        Self {
            value: estimate.value,
            half: HALF_95 * estimate.deviation,
        }
    }
}

/// The robot's pose as the compass has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrectedPose {
    /// X, inches.
    pub x_in: f64,
    /// Y, inches.
    pub y_in: f64,
    /// Heading, degrees from 0 to 360, clockwise from +Y.
    pub theta_deg: Interval,
    /// Where the true position is, around X and Y.
    pub ellipse: Ellipse,
}

/// Diameters of the wheels, inches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wheels {
    /// Left wheel.
    pub left_in: f64,
    /// Right wheel.
    pub right_in: f64,
}
