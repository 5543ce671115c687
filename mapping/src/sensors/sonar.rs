//! A sonar: a cone whose empty part is free and whose end holds an obstacle somewhere.
//!
//! Sources: the inverse model is that of Moravec and Elfes, 1985, with the caution of Konolige, "Improved occupancy grids
//! for map building", 1997: a reading that a known wall contradicts is a mirrored one, and says nothing of the floor
//! behind that wall.

use groundwave_protocol::telemetry::StateLine;

use super::Ray;
use crate::grid::{CELL_IN, Grid};
use crate::pose::Pose;

/// Angle of each ranger's axis from the nose, and its distances from the robot's centre.
const MOUNT_RAD: f64 = 7.5 / 180.0 * std::f64::consts::PI;
const RIGHT_IN: f64 = 1.5;
const AHEAD_IN: f64 = 5.0;

/// Rays of the 15-degree cone, radians from its axis, and the weight of the evidence of each.
const RAYS: [(f64, f64); 5] = [
    (-0.105, 0.5),
    (-0.052, 0.8),
    (0.0, 1.0),
    (0.052, 0.8),
    (0.105, 0.5),
];

/// Log-odds at a near range: of the empty part, and of its end.
const FREE: f64 = -0.3;
const OCCUPIED: f64 = 2.0;

/// Range up to which the empty part is taken, and range of the furthest end: far echoes come by way of several walls.
const FREE_MAX_IN: f64 = 96.0;
const END_MAX_IN: f64 = 96.0;

/// Log-odds from which a cell is a known wall.
const WALL: f64 = 1.5;

/// Half of the zone at the end of a reading that is neither free nor behind it: timing and noise.
const END_IN: f64 = 2.0;

/// Which of the two rangers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Left,
    Right,
}

impl Side {
    const fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

/// A ranger's place, and the bearing of its axis.
pub(crate) fn eye(pose: Pose, side: Side) -> ((f64, f64), f64) {
    (
        pose.point(side.sign() * RIGHT_IN, AHEAD_IN),
        pose.theta_rad + side.sign() * MOUNT_RAD,
    )
}

/// Mean age of an echo when its line begins, seconds.
const ECHO_AGE_S: f64 = 0.14;

/// Distance of the wheels, inches.
pub(crate) const TRACK_IN: f64 = 10.0;

/// Pose at the time of the echoes of a line, from the pose of the line and the speeds of its wheels.
pub(crate) fn pinged_at(pose: Pose, (left_in_s, right_in_s): (i8, i8)) -> Pose {
    let (left_in_s, right_in_s) = (f64::from(left_in_s), f64::from(right_in_s));
    let (x_in, y_in) = pose.point(0.0, -f64::midpoint(left_in_s, right_in_s) * ECHO_AGE_S);
    Pose {
        x_in,
        y_in,
        theta_rad: pose.theta_rad - (left_in_s - right_in_s) / TRACK_IN * ECHO_AGE_S,
    }
}

/// The echoes of a line.
pub(crate) fn ranges(state: &StateLine) -> impl Iterator<Item = (Side, f64)> {
    let sides = [
        (Side::Left, state.sonar_left_in),
        (Side::Right, state.sonar_right_in),
    ];
    sides
        .into_iter()
        .filter_map(|(side, range_in)| Some((side, f64::from(range_in?))))
}

/// Adds the evidence of an echo.
pub(crate) fn update(grid: &mut Grid, pose: Pose, side: Side, range_in: f64) {
    let (from, axis_rad) = eye(pose, side);
    let nearness = |distance_in: f64| 1.0 / (1.0 + distance_in / 60.0);
    for (across_rad, weight) in RAYS {
        let ray = Ray::new(from, axis_rad + across_rad);
        let mut is_mirrored = false;
        for distance_in in Ray::steps((range_in - END_IN).min(FREE_MAX_IN)) {
            let cell = ray.cell(distance_in);
            let free = FREE * weight * nearness(distance_in);
            let before = grid.add(cell, free);
            if before > WALL && distance_in < range_in - 2.0 * CELL_IN {
                // The wall may have gone: a little evidence adds up.
                grid.add(cell, FREE * weight * 0.3 - free);
                is_mirrored = true;
                break;
            }
        }
        if !is_mirrored && range_in <= END_MAX_IN {
            let strength = OCCUPIED * weight * nearness(range_in);
            grid.add(ray.cell(range_in), strength);
            grid.add(ray.cell(range_in + CELL_IN), strength * 0.4);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pose(x_in: f64, y_in: f64, theta_rad: f64) -> Pose {
        Pose {
            x_in,
            y_in,
            theta_rad,
        }
    }

    proptest! {
        #[test]
        fn cone_is_free_up_to_its_end_and_unknown_behind(
            x_in in -200.0..200.0, y_in in -200.0..200.0, theta_rad in 0.0..6.3, range_in in 12.0..90.0,
            is_left: bool,
        ) {
            let side = if is_left { Side::Left } else { Side::Right };
            let at = pose(x_in, y_in, theta_rad);
            let mut grid = Grid::default();
            for _ in 0..20 {
                update(&mut grid, at, side, range_in);
            }
            let (from, axis_rad) = eye(at, side);
            let axis = Ray::new(from, axis_rad);
            let before = Ray::steps(range_in / 2.0).last().unwrap();
            prop_assert!(grid.log_odds(axis.cell(before)) < -1.0);
            prop_assert!(grid.log_odds(axis.cell(range_in)) > 1.0);
            prop_assert!(grid.log_odds(axis.cell(range_in + 4.0 * CELL_IN)).abs() < 1e-9);
            for (cell, _) in grid.cells() {
                let (x, y) = Grid::center(cell);
                let distance_in = libm::hypot(x - from.0, y - from.1);
                prop_assert!(distance_in < range_in + 3.0 * CELL_IN);
            }
        }

        #[test]
        fn mirrored_reading_leaves_a_known_wall(theta_rad in 0.0..6.3, wall_in in 20.0..50.0) {
            let at = pose(0.0, 0.0, theta_rad);
            let mut grid = Grid::default();
            for _ in 0..20 {
                update(&mut grid, at, Side::Right, wall_in);
            }
            for _ in 0..5 {
                update(&mut grid, at, Side::Right, wall_in + 30.0);
            }
            let (from, axis_rad) = eye(at, Side::Right);
            prop_assert!(grid.log_odds(Ray::new(from, axis_rad).cell(wall_in)) > WALL);
        }
    }
}
