//! Dimensions of the robot that the world and the sensors share with the body.

/// Radius of the round outline, bumper included, inches.
pub(crate) const RADIUS_IN: f64 = 5.5;

/// Distance of the arm behind the robot's centre.
pub(crate) const ARM_BEHIND_IN: f64 = 4.0;
