//! The floor that a robot has seen: obstacles, drops, and where it has driven.

use groundwave_protocol::status_codes::Cliff;

use crate::grid::{CELL_IN, Cell, Grid};
use crate::pose::Pose;
use crate::sensors::{Readings, body::RADIUS_IN};

/// Distance between two views up to which the robot drove straight from one to the other: lines may be lost.
const STRAIGHT_IN: f64 = 12.0;

/// Distance from the path up to which a cell counts as driven: its centre need not have been met.
const DRIVEN_IN: f64 = 3.0;

/// Where a drop is when its line is received, inches from the robot's centre; the robot has begun to retreat.
const DROP_IN: (f64, f64) = (6.0, 9.0);

/// Half of the arc in which a sensor sees a drop, radians.
const DROP_ARC_RAD: f64 = 0.6;

/// Views before and after a drop whose outlines had floor: later ones may be misplaced beside it.
const AROUND: usize = 30;

/// Mark of a cell in a set.
const MARK: f64 = 1.0;

/// What is known of the floor, in the frame of the views' poses.
#[derive(Clone, Debug, Default)]
pub(crate) struct Floor {
    /// Obstacles and free floor.
    pub(crate) grid: Grid,
    /// Cells in which the robot's centre was, or next to it; others are 0.
    pub(crate) driven: Grid,
    /// Cells where the floor may end; others are 0.
    pub(crate) drops: Grid,
}

impl Floor {
    /// The floor in views, oldest first.
    pub(crate) fn new(views: &[(Pose, Readings)]) -> Self {
        let mut it = Self::default();
        it.add(views);
        it
    }

    /// Adds what another run saw: its views, oldest first.
    pub(crate) fn add(&mut self, views: &[(Pose, Readings)]) {
        let mut last: Option<(Pose, Readings)> = None;
        for (at, (pose, readings)) in views.iter().enumerate() {
            readings.update(&mut self.grid, *pose);
            let from = last.filter(|(from, _)| from.distance_in(*pose) < STRAIGHT_IN);
            self.drive(from.map_or(*pose, |(from, _)| from), *pose);
            let was_safe = last.is_none_or(|(_, last)| drop_arc(last.cliff).is_none());
            if let Some(arc) = drop_arc(readings.cliff).filter(|_| was_safe) {
                let around = &views[at.saturating_sub(AROUND)..(at + AROUND).min(views.len())];
                self.drop_at(*pose, arc, around);
            }
            last = Some((*pose, *readings));
        }
    }

    /// Marks the cells of a straight path.
    fn drive(&mut self, from: Pose, to: Pose) {
        let steps = libm::ceil(from.distance_in(to)).max(1.0) as u32;
        for step in 0..=steps {
            let share = f64::from(step) / f64::from(steps);
            let (x_in, y_in) = (
                from.x_in + (to.x_in - from.x_in) * share,
                from.y_in + (to.y_in - from.y_in) * share,
            );
            for cell in around((x_in, y_in), DRIVEN_IN) {
                self.driven.add(cell, MARK);
            }
        }
    }

    /// Marks the cells of a drop, apart from those that were below the robot.
    fn drop_at(&mut self, pose: Pose, (center_rad, half_rad): Arc, views: &[(Pose, Readings)]) {
        for cell in around((pose.x_in, pose.y_in), DROP_IN.1) {
            let (x_in, y_in) = Grid::center(cell);
            let (x, y) = (x_in - pose.x_in, y_in - pose.y_in);
            let off_rad = libm::atan2(x, y) - pose.theta_rad - center_rad;
            let is_ahead = libm::cos(off_rad) >= libm::cos(half_rad);
            let had_floor = views
                .iter()
                .any(|(pose, _)| libm::hypot(x_in - pose.x_in, y_in - pose.y_in) < RADIUS_IN);
            if is_ahead && libm::hypot(x, y) >= DROP_IN.0 - CELL_IN / 2.0 && !had_floor {
                self.drops.add(cell, MARK);
            }
        }
    }
}

/// The middle and the half of an arc, radians from the nose.
type Arc = (f64, f64);

/// The arc of a drop; several sensors, or one at the rear, leave any direction possible.
fn drop_arc(cliff: Cliff) -> Option<Arc> {
    match cliff {
        Cliff::None | Cliff::NotFitted => None,
        Cliff::Left => Some((-0.9, DROP_ARC_RAD)),
        Cliff::Center => Some((0.0, DROP_ARC_RAD)),
        Cliff::Right => Some((0.9, DROP_ARC_RAD)),
        Cliff::Several => Some((0.0, std::f64::consts::PI)),
    }
}

/// Cells whose centres are near a position.
pub(crate) fn around((x_in, y_in): (f64, f64), reach_in: f64) -> impl Iterator<Item = Cell> {
    let reach = (reach_in / CELL_IN) as i32 + 1;
    let (column, row) = Grid::cell((x_in, y_in));
    (column - reach..=column + reach)
        .flat_map(move |column| (row - reach..=row + reach).map(move |row| (column, row)))
        .filter(move |cell| {
            let (x, y) = Grid::center(*cell);
            libm::hypot(x - x_in, y - y_in) < reach_in
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::telemetry::StateLine;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn drop_is_before_the_robot_and_not_where_it_was(
            theta_rad in 0.0..6.3_f64,
            cliff in proptest::sample::select(vec![Cliff::Left, Cliff::Center, Cliff::Right, Cliff::Several]),
        ) {
            let view = |back_in: f64, cliff: Cliff| {
                let (x_in, y_in) = Pose { theta_rad, ..Pose::default() }.point(0.0, -back_in);
                let state = StateLine { cliff, ..StateLine::BLANK };
                (Pose { x_in, y_in, theta_rad }, Readings::of(&state))
            };
            let there = (0..10).rev().map(|at| view(f64::from(at) * 2.0, Cliff::None));
            let back = (0..5).map(|at| view(f64::from(at) * 2.0, cliff));
            let floor = Floor::new(&there.chain(back).collect::<Vec<_>>());
            prop_assert!(floor.drops.cells().count() >= 3);
            for (cell, _) in floor.drops.cells() {
                let (x, y) = Grid::center(cell);
                let ahead_in = x * libm::sin(theta_rad) + y * libm::cos(theta_rad);
                prop_assert!(libm::hypot(x, y) > 4.0 && ahead_in > -9.0, "{cell:?}");
                // The robot came from behind.
                let aside_in = x * libm::cos(theta_rad) - y * libm::sin(theta_rad);
                prop_assert!(ahead_in > 0.0 || aside_in.abs() > 4.0, "{cell:?}");
            }
        }

        #[test]
        fn driven_cells_are_connected_over_lost_lines(theta_rad in 0.0..6.3_f64, step_in in 1.0..11.0_f64) {
            let readings = Readings::of(&StateLine::BLANK);
            let start = Pose { theta_rad, ..Pose::default() };
            let views: Vec<_> = (0..8)
                .map(|at| {
                    let (x_in, y_in) = start.point(0.0, f64::from(at) * step_in);
                    (Pose { x_in, y_in, theta_rad }, readings)
                })
                .collect();
            let floor = Floor::new(&views);
            for at_in in 0..(7.0 * step_in) as u32 {
                let cell = Grid::cell(start.point(0.0, f64::from(at_in)));
                prop_assert!(floor.driven.log_odds(cell) > 0.0, "{at_in}");
            }
        }
    }
}
