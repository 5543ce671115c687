//! The robot's outline and its bumper.
//!
//! Source: the outline is free where the robot stands (*Probabilistic Robotics*, chapter 9.2, with a sensor of range 0); a
//! contact is an obstacle on the arc of its switch.

use groundwave_protocol::status_codes::Bump;

use super::Ray;
use crate::grid::{CELL_IN, Grid};
use crate::pose::Pose;

/// Radius of the outline, inches.
pub(crate) const RADIUS_IN: f64 = 5.5;

/// Log-odds: of the floor below the robot, and of a contact, shared by the cells of the arc.
const FREE: f64 = -1.2;
const CONTACT: f64 = 2.4;

/// Centre and half of a switch's arc, radians from the nose; `None` without a contact.
fn arc(bump: Bump) -> Option<(f64, f64)> {
    let deg = |center: f64, half: f64| Some((center.to_radians(), half.to_radians()));
    match bump {
        Bump::Left => deg(-50.0, 25.0),
        Bump::LeftCenter => deg(-20.0, 8.0),
        Bump::Center => deg(0.0, 15.0),
        Bump::RightCenter => deg(20.0, 8.0),
        Bump::Right => deg(50.0, 25.0),
        // Contacts on both sides leave the middle open.
        Bump::Sides | Bump::All | Bump::None | Bump::Jammed | Bump::NotFitted => None,
    }
}

fn rays(pose: Pose, (center_rad, half_rad): (f64, f64)) -> impl Iterator<Item = Ray> {
    [-1.0, -0.5, 0.0, 0.5, 1.0].into_iter().map(move |at| {
        let bearing_rad = pose.theta_rad + center_rad + at * half_rad;
        Ray::new((pose.x_in, pose.y_in), bearing_rad)
    })
}

/// Adds the evidence of the outline: the cells whose centres are well inside are free.
pub(crate) fn update_outline(grid: &mut Grid, pose: Pose) {
    let (column, row) = Grid::cell((pose.x_in, pose.y_in));
    for column in column - 2..=column + 2 {
        for row in row - 2..=row + 2 {
            let (x_in, y_in) = Grid::center((column, row));
            if libm::hypot(x_in - pose.x_in, y_in - pose.y_in) < RADIUS_IN - CELL_IN / 2.0 {
                grid.add((column, row), FREE);
            }
        }
    }
}

/// Adds the evidence of a contact.
pub(crate) fn update_contact(grid: &mut Grid, pose: Pose, bump: Bump) {
    let Some(arc) = arc(bump) else {
        return;
    };
    let mut cells: Vec<_> = rays(pose, arc)
        .map(|ray| ray.cell(RADIUS_IN + 0.5))
        .collect();
    cells.dedup();
    let share = CONTACT / libm::sqrt(cells.len() as f64);
    for cell in cells {
        grid.add(cell, share);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn robot_stands_on_free_floor_with_contacts_on_its_rim(
            x_in in -200.0..200.0, y_in in -200.0..200.0, theta_rad in 0.0..6.3,
            bump in proptest::sample::select(vec![
                Bump::Left, Bump::LeftCenter, Bump::Center, Bump::RightCenter, Bump::Right,
            ]),
        ) {
            let pose = Pose { x_in, y_in, theta_rad };
            let mut grid = Grid::default();
            update_outline(&mut grid, pose);
            update_contact(&mut grid, pose, bump);
            prop_assert!(grid.log_odds(Grid::cell((x_in, y_in))) < 0.0);
            for (cell, log_odds) in grid.cells() {
                let (x, y) = Grid::center(cell);
                let distance_in = libm::hypot(x - x_in, y - y_in);
                prop_assert!((log_odds < 0.0) == (distance_in < RADIUS_IN - CELL_IN / 2.0)
                    || (log_odds > 0.0 && distance_in < RADIUS_IN + CELL_IN));
            }
        }
    }
}
