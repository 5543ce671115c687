//! Positions and headings: +Y is ahead at heading 0, and headings turn clockwise.

/// A position and a heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pose {
    /// X, inches.
    pub(crate) x_in: f64,
    /// Y, inches.
    pub(crate) y_in: f64,
    /// Heading clockwise from +Y, radians.
    pub(crate) theta_rad: f64,
}

impl Pose {
    /// A point fixed to the robot, inches to its right and ahead of its centre.
    pub(crate) fn point(self, right_in: f64, ahead_in: f64) -> (f64, f64) {
        let (sin, cos) = libm::sincos(self.theta_rad);
        (
            self.x_in + right_in * cos + ahead_in * sin,
            self.y_in - right_in * sin + ahead_in * cos,
        )
    }

    /// Distance between two positions, inches.
    pub(crate) fn distance_in(self, other: Self) -> f64 {
        libm::hypot(self.x_in - other.x_in, self.y_in - other.y_in)
    }
}
