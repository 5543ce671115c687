//! An infrared detector: a wedge that holds a reflecting obstacle somewhere, or none.
//!
//! Source: the inverse model of a binary proximity sensor in Elfes, "Using occupancy grids for mobile robot perception and
//! navigation", 1989. Dark and oblique surfaces are not seen, so silence says little.

use super::Ray;
use crate::grid::{CELL_IN, Grid};
use crate::pose::Pose;

/// Which detectors fired; `None` for one that is off.
pub(crate) type Sides = (Option<bool>, Option<bool>);

/// Angle of each axis from the nose, and distances of each detector from the robot's centre.
const MOUNT_RAD: f64 = std::f64::consts::FRAC_PI_4;
const RIGHT_IN: f64 = 3.5;
const AHEAD_IN: f64 = 3.5;

/// Rays of the wedge, radians from its axis.
const RAYS: [f64; 5] = [-0.6, -0.3, 0.0, 0.3, 0.6];

/// Distance at which a detector usually fires at a white wall while the robot drives, and the limit of its reach.
const LIKELY_IN: f64 = 18.0;
const REACH_IN: f64 = 30.0;

/// Distance within which a silent detector makes an obstacle unlikely.
const SILENT_IN: f64 = 10.0;

/// Log-odds of the evidence.
const OCCUPIED: f64 = 0.12;
const FREE: f64 = -0.12;

/// Log-odds from which a cell is known.
const KNOWN: f64 = 1.0;

fn eye(pose: Pose, sign: f64) -> ((f64, f64), f64) {
    (
        pose.point(sign * RIGHT_IN, AHEAD_IN),
        pose.theta_rad + sign * MOUNT_RAD,
    )
}

fn each(sides: Sides) -> impl Iterator<Item = (f64, bool)> {
    let signs = [(-1.0, sides.0), (1.0, sides.1)];
    signs
        .into_iter()
        .filter_map(|(sign, fired)| Some((sign, fired?)))
}

/// Adds the evidence of the detectors.
pub(crate) fn update(grid: &mut Grid, pose: Pose, sides: Sides) {
    for (sign, fired) in each(sides) {
        let (from, axis_rad) = eye(pose, sign);
        for across_rad in RAYS {
            let ray = Ray::new(from, axis_rad + across_rad);
            if !fired {
                for at_in in Ray::steps(SILENT_IN) {
                    grid.add(ray.cell(at_in), FREE);
                }
                continue;
            }
            // An obstacle that is known explains the detection.
            let known = Ray::steps(REACH_IN).find(|at_in| grid.log_odds(ray.cell(*at_in)) > KNOWN);
            if known.is_none() && across_rad.abs() < 0.5 {
                for at_in in Ray::steps(LIKELY_IN).filter(|at_in| *at_in > 2.0 * CELL_IN) {
                    grid.add(ray.cell(at_in), OCCUPIED);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn detections_raise_one_side_and_silence_frees_the_other(
            x_in in -200.0..200.0, y_in in -200.0..200.0, theta_rad in 0.0..6.3,
        ) {
            let pose = Pose { x_in, y_in, theta_rad };
            let mut grid = Grid::default();
            for _ in 0..8 {
                update(&mut grid, pose, (Some(true), Some(false)));
            }
            for (cell, log_odds) in grid.cells() {
                let (x, y) = Grid::center(cell);
                let (dx, dy) = (x - x_in, y - y_in);
                let right = dx * libm::cos(theta_rad) - dy * libm::sin(theta_rad);
                // A cell across the middle belongs to either side.
                prop_assert!(right.abs() < CELL_IN || (right < 0.0) == (log_odds > 0.0));
                prop_assert!(libm::hypot(dx, dy) < REACH_IN + 8.0);
            }
        }
    }
}
