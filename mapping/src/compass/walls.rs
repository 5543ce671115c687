//! The directions of the walls in one stretch of driving.
//!
//! Sources: the Hough spectrum of Censi, Iocchi and Grisetti, "Scan matching in the Hough domain", 2005, where points that
//! lie on walls fall together when they are projected across the walls; and the regions of constant depth of Leonard and
//! Durrant-Whyte, *Directed Sonar Sensing for Mobile Robot Navigation*, 1992: a sonar measures the distance of a wall
//! along the wall's normal, anywhere in its cone. Both axes of a rectangular house count, so a direction is known up to a
//! quarter turn.

use std::f64::consts::FRAC_PI_2;

use super::matching::Foot;

/// Directions tried, one for each degree of a quarter turn.
pub(super) const DIRECTIONS: usize = 90;

/// Width of the strips in which distances are counted, inches.
const STRIP_IN: f64 = 1.5;

/// Strips across. Distances are at most 72 in from a path of some hundred inches; others wrap around.
const STRIPS: usize = 256;

/// Cosine and sine of half of a sonar's cone, 7.5 degrees; a normal within it is measured at its true distance.
const CONE: (f64, f64) = (0.991_445, 0.130_526);

/// Cosines of the angle between a sonar's axis and a wall's normal from which an echo counts in full (30 degrees), and up
/// to which it does not count (80 degrees). Furniture answers at large angles.
const FULL: f64 = 0.866;
const NONE: f64 = 0.174;

/// Weight of the foot of a normal outside of the cone.
const OBLIQUE: f64 = 0.5;

/// Path and echoes after which a stretch has a spectrum: over a longer path the odometer turns, fewer echoes form no line.
const PATH_IN: f64 = 60.0;
const ECHOES: usize = 20;

/// Most echoes and longest path; a stretch without walls for so long is dropped.
const ECHOES_MAX: usize = 128;
const PATH_MAX_IN: f64 = 400.0;

/// Furthest and nearest echo that counts, inches: far ones come by way of several walls.
const ECHO_MAX_IN: f64 = 72.0;
const ECHO_MIN_IN: f64 = 4.0;

/// Natural logarithm of the likelihood per standard deviation of the spectrum, and the share of stretches that say
/// nothing: the best of those tried by the logarithmic score of the true directions in eight houses (seeds 1 to 8).
const SHARPNESS: f64 = 2.0;
const FLOOR: f64 = 0.1;

/// An echo: the sonar's place, the sine and cosine of its axis (clockwise from +Y), and the range.
#[derive(Clone, Copy, Debug)]
struct Echo {
    eye: (f64, f64),
    axis: (f64, f64),
    range_in: f64,
}

/// Echoes of one stretch of driving.
#[derive(Clone, Debug, Default)]
pub(super) struct Stretch {
    echoes: Vec<Echo>,
    path_in: f64,
}

impl Stretch {
    /// Adds distance driven.
    pub(super) fn drive(&mut self, path_in: f64) {
        self.path_in += path_in;
        if self.path_in > PATH_MAX_IN || self.echoes.len() > ECHOES_MAX {
            *self = Self::default();
        }
    }

    /// Adds an echo of a sonar at an eye with an axis, radians clockwise from +Y.
    pub(super) fn add(&mut self, (eye, axis_rad): ((f64, f64), f64), range_in: f64) {
        if (ECHO_MIN_IN..=ECHO_MAX_IN).contains(&range_in) {
            self.echoes.push(Echo {
                eye,
                axis: libm::sincos(axis_rad),
                range_in,
            });
        }
    }

    /// Whether there is enough for a spectrum.
    pub(super) fn is_complete(&self) -> bool {
        self.path_in > PATH_IN && self.echoes.len() > ECHOES
    }

    /// Feet of the normals of walls, in the frame in which +Y has a bearing in the frame of the stretch and is along a wall.
    pub(super) fn feet(&self, bearing_rad: f64) -> Vec<Foot> {
        let (sin, cos) = libm::sincos(bearing_rad);
        let turn = |(x, y): (f64, f64)| (x * cos - y * sin, y * cos + x * sin);
        let mut feet = Vec::new();
        for echo in &self.echoes {
            let axis = turn(echo.axis);
            for facing in 0..4 {
                let (east, north) = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][facing];
                let ahead = axis.0 * east + axis.1 * north;
                if ahead < FULL {
                    continue;
                }
                let is_in_cone = ahead > CONE.0;
                let toward = if is_in_cone {
                    (east, north)
                } else {
                    // The edge of the cone next to the normal.
                    let to_right = axis.1 * east - axis.0 * north;
                    let aside = CONE.1.copysign(to_right);
                    (
                        axis.0 * CONE.0 + axis.1 * aside,
                        axis.1 * CONE.0 - axis.0 * aside,
                    )
                };
                let eye = turn(echo.eye);
                feet.push(Foot {
                    facing,
                    x_in: eye.0 + echo.range_in * toward.0,
                    y_in: eye.1 + echo.range_in * toward.1,
                    weight: if is_in_cone { 1.0 } else { OBLIQUE },
                });
            }
        }
        feet
    }

    /// Likelihood of each direction, whole degrees clockwise from a heading; 1 on average.
    pub(super) fn likelihood(&self, theta_rad: f64) -> [f64; DIRECTIONS] {
        let mut spectrum = [0.0; DIRECTIONS];
        for (degree, value) in spectrum.iter_mut().enumerate() {
            *value = self.agreement(theta_rad + (degree as f64).to_radians());
        }
        let count = DIRECTIONS as f64;
        let mean = spectrum.iter().sum::<f64>() / count;
        let variance = spectrum.iter().map(|value| (value - mean) * (value - mean));
        let deviation = libm::sqrt(variance.sum::<f64>() / count).max(1e-9);
        let likelihood = spectrum.map(|value| libm::exp(SHARPNESS * (value - mean) / deviation));
        let sum = likelihood.iter().sum::<f64>();
        likelihood.map(|value| FLOOR + (1.0 - FLOOR) * value / sum * count)
    }

    /// Mean number of echoes in the strip of an echo, if the walls' normals have this bearing or one a quarter turn from it.
    fn agreement(&self, bearing_rad: f64) -> f64 {
        let (mut squares, mut sum) = (0.0, 0.0);
        for quarter in 0..4 {
            let normal_rad = bearing_rad + f64::from(quarter) * FRAC_PI_2;
            let (sin, cos) = libm::sincos(normal_rad);
            let mut strips = [0.0; STRIPS];
            for echo in &self.echoes {
                let (ahead, aside) = (
                    sin * echo.axis.0 + cos * echo.axis.1,
                    (cos * echo.axis.0 - sin * echo.axis.1).abs(),
                );
                let weight = ((ahead - NONE) / (FULL - NONE)).clamp(0.0, 1.0);
                if weight == 0.0 {
                    continue;
                }
                let is_in_cone = ahead > CONE.0;
                let share = if is_in_cone {
                    1.0
                } else {
                    ahead * CONE.0 + aside * CONE.1
                };
                let at = echo.eye.0 * sin + echo.eye.1 * cos + echo.range_in * share;
                let at = at / STRIP_IN;
                let strip = libm::floor(at);
                let share = at - strip;
                for (strip, part) in [(strip, 1.0 - share), (strip + 1.0, share)] {
                    strips[(strip as i64).rem_euclid(STRIPS as i64) as usize] += weight * part;
                }
                sum += weight;
            }
            squares += strips.iter().map(|count| count * count).sum::<f64>();
        }
        squares / sum.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A robot that turns to and fro in a corner of two walls.
        #[test]
        fn direction_of_walls_is_the_likeliest(
            wall_deg in 0.0..90.0_f64, theta_deg in 0.0..360.0_f64,
            error_in in 0.0..0.5_f64, phase in 0.0..6.3_f64,
        ) {
            let mut stretch = Stretch::default();
            for step in 0..40 {
                let noise = |place: f64| libm::sin(f64::from(step) * 2.399_963 * place + phase);
                let quarter = if step % 2 == 0 { 0.0 } else { 90.0 };
                let normal_rad = (wall_deg + quarter).to_radians();
                let (sin, cos) = libm::sincos(normal_rad);
                let along_in = f64::from(step) * 0.5;
                let eye = (along_in * cos, -along_in * sin);
                // The axis is up to 7 degrees off the normal, but the range is that along the normal.
                let axis_rad = normal_rad + (noise(1.0) * 7.0).to_radians();
                stretch.add((eye, axis_rad), 40.0 + error_in * noise(3.0));
            }
            let likelihood = stretch.likelihood(theta_deg.to_radians());
            let best = (0..DIRECTIONS).max_by(|a, b| likelihood[*a].total_cmp(&likelihood[*b])).unwrap();
            let error = (best as f64 + theta_deg - wall_deg + 45.0).rem_euclid(90.0) - 45.0;
            prop_assert!(error.abs() <= 4.0, "{best} is {error} off");
            let mean = likelihood.iter().sum::<f64>() / DIRECTIONS as f64;
            prop_assert!((mean - 1.0).abs() < 1e-9);
        }
    }
}
