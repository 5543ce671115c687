//! The robot's sensors with their errors.

pub(crate) mod beacon;
pub(crate) mod edges;
pub(crate) mod infrared;
pub(crate) mod motion;
pub(crate) mod photocells;
pub(crate) mod sonar;

use crate::geometry::{Vec2, clockwise, heading};

/// The robot's position and heading.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    pub(crate) center: Vec2,
    pub(crate) theta_rad: f64,
}

impl View {
    /// A point fixed to the robot, in inches to the right of its centre and ahead.
    pub(crate) fn point(&self, right_in: f64, ahead_in: f64) -> Vec2 {
        let forward = heading(self.theta_rad);
        self.center + clockwise(forward) * right_in + forward * ahead_in
    }

    /// Unit direction at an angle clockwise from the robot's nose.
    pub(crate) fn direction(&self, offset_rad: f64) -> Vec2 {
        heading(self.theta_rad + offset_rad)
    }
}
