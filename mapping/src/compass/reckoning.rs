//! Dead reckoning with the corrected heading.
//!
//! The covariance is propagated to first order (Thrun, Burgard and Fox, *Probabilistic Robotics*, 2005, chapter 5). The
//! error of the heading is a first-order Gauss-Markov process whose variance the compass states.

use super::drift::Estimate;

/// Path over which the error of the corrected heading changes, inches.
const CORRELATED_IN: f64 = 600.0;

/// Factor on the stated deviation of the heading: a house can turn all of its stretches to one side.
const ALIKE: f64 = 1.4;

/// Variance of the position, square inches: per inch driven (encoders, curves between two lines), and per contact second.
const PER_IN: f64 = 0.01;
const PER_CONTACT_S: f64 = 1.0;

/// 95 % quantile of chi-squared with two degrees of freedom.
const CHI_95: f64 = 5.991;

/// The ellipse that contains the true position with a probability of 95 %.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ellipse {
    /// Long semi-axis, inches.
    pub long_in: f64,
    /// Short semi-axis, inches.
    pub short_in: f64,
    /// Bearing of the long axis, degrees clockwise from +Y, 0 to 180.
    pub bearing_deg: f64,
}

impl Ellipse {
    /// Distance of a point from the middle, as a multiple of the distance of the edge: more than 1 is outside. Axes of less than an
    /// inch count as one.
    #[must_use]
    pub fn multiple(&self, (x_in, y_in): (f64, f64)) -> f64 {
        let (sin, cos) = libm::sincos(self.bearing_deg.to_radians());
        let along = (x_in * sin + y_in * cos) / self.long_in.max(1.0);
        let across = (x_in * cos - y_in * sin) / self.short_in.max(1.0);
        libm::hypot(along, across)
    }
}

/// A position, and the covariance of it and of the heading (X, Y, heading in radians).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Reckoning {
    pub(super) x_in: f64,
    pub(super) y_in: f64,
    covariance: [[f64; 3]; 3],
}

impl Reckoning {
    /// A known position.
    pub(super) fn at((x_in, y_in): (f64, f64)) -> Self {
        Self {
            x_in,
            y_in,
            covariance: [[0.0; 3]; 3],
        }
    }

    /// A position with the same variance in all directions.
    pub(super) fn near((x_in, y_in): (f64, f64), variance: f64) -> Self {
        Self {
            x_in,
            y_in,
            covariance: [[variance, 0.0, 0.0], [0.0, variance, 0.0], [0.0; 3]],
        }
    }

    /// Adds a movement in the odometer's frame with the heading error during it, degrees.
    pub(super) fn advance(
        &mut self,
        moved: (f64, f64),
        error: Estimate,
        path_in: f64,
        contact_s: f64,
    ) {
        let (sin, cos) = libm::sincos(error.value.to_radians());
        let (x_in, y_in) = (moved.0 * cos + moved.1 * sin, moved.1 * cos - moved.0 * sin);
        self.x_in += x_in;
        self.y_in += y_in;

        let p = &mut self.covariance;
        let keep = libm::exp(-path_in / CORRELATED_IN);
        let deviation_rad = ALIKE * error.deviation.to_radians();
        p[2][2] = deviation_rad * deviation_rad;
        // A heading error turns the movement to its right.
        let lever = [y_in, -x_in];
        let across = [p[0][2] * keep, p[1][2] * keep];
        for row in 0..2 {
            for column in 0..2 {
                p[row][column] += lever[row] * across[column]
                    + lever[column] * across[row]
                    + lever[row] * lever[column] * p[2][2];
            }
            p[row][row] += PER_IN * path_in + PER_CONTACT_S * contact_s;
            p[row][2] = across[row] + lever[row] * p[2][2];
            p[2][row] = p[row][2];
        }
    }

    /// Variance of the position in its worst direction, square inches.
    pub(super) fn variance(&self) -> f64 {
        let p = &self.covariance;
        let half = (p[0][0] - p[1][1]) / 2.0;
        f64::midpoint(p[0][0], p[1][1]) + libm::hypot(half, p[0][1])
    }

    pub(super) fn ellipse(&self) -> Ellipse {
        let p = &self.covariance;
        ellipse([[p[0][0], p[0][1]], [p[1][0], p[1][1]]])
    }
}

/// The 95 % ellipse of a covariance.
pub(super) fn ellipse(p: [[f64; 2]; 2]) -> Ellipse {
    let (mean, half) = (f64::midpoint(p[0][0], p[1][1]), (p[0][0] - p[1][1]) / 2.0);
    let radius = libm::hypot(half, p[0][1]);
    let axis = |variance: f64| libm::sqrt(CHI_95 * variance.max(0.0));
    let from_x_deg = (libm::atan2(p[0][1], half) / 2.0).to_degrees();
    Ellipse {
        long_in: axis(mean + radius),
        short_in: axis(mean - radius),
        bearing_deg: (90.0 - from_x_deg).rem_euclid(180.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A straight way with a constant heading error: the error is across the way, and inside the ellipse.
        #[test]
        fn ellipse_lies_across_the_way(bearing_deg in 0.0..180.0_f64, error_deg in 2.0..8.0_f64, steps in 5..40) {
            let mut reckoning = Reckoning::at((0.0, 0.0));
            let (sin, cos) = libm::sincos(bearing_deg.to_radians());
            let unknown = Estimate { value: 0.0, deviation: error_deg };
            for _ in 0..steps {
                reckoning.advance((10.0 * sin, 10.0 * cos), unknown, 10.0, 0.0);
            }
            let path_in = 10.0 * f64::from(steps);
            prop_assert!((libm::hypot(reckoning.x_in, reckoning.y_in) - path_in).abs() < 1e-6);
            let ellipse = reckoning.ellipse();
            let off_deg = (ellipse.bearing_deg - bearing_deg).rem_euclid(180.0);
            prop_assert!((off_deg - 90.0).abs() < 1e-3, "{ellipse:?}");
            prop_assert!(ellipse.long_in > path_in * error_deg.to_radians(), "{ellipse:?}");
            prop_assert!(ellipse.short_in <= ellipse.long_in);
        }
    }
}
