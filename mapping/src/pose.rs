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

    /// The same pose in a frame with the same origin whose +Y has a bearing in this one.
    pub(crate) fn turned(self, bearing_rad: f64) -> Self {
        let (x_in, y_in) = turned((self.x_in, self.y_in), bearing_rad);
        Self {
            x_in,
            y_in,
            theta_rad: self.theta_rad - bearing_rad,
        }
    }

    /// The pose after a shift.
    pub(crate) fn moved(self, (x_in, y_in): (f64, f64)) -> Self {
        Self {
            x_in: self.x_in + x_in,
            y_in: self.y_in + y_in,
            ..self
        }
    }

    /// Distance between two positions, inches.
    pub(crate) fn distance_in(self, other: Self) -> f64 {
        libm::hypot(self.x_in - other.x_in, self.y_in - other.y_in)
    }
}

/// A point in a frame with the same origin whose +Y has a bearing in its own, clockwise from +Y.
pub(crate) fn turned((x, y): (f64, f64), bearing_rad: f64) -> (f64, f64) {
    let (sin, cos) = libm::sincos(bearing_rad);
    (x * cos - y * sin, y * cos + x * sin)
}
