//! The robot's trail in bounded memory: the newest part as a line, older parts as
//! grid cells, which grow only when the robot covers new ground.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

/// Maximum number of points in the line.
const RECENT_MAX: usize = 1024;

/// Distance between two points of the line, inches.
const SPACING_IN: f64 = 3.0;

/// Maximum number of grid cells.
const OLDER_MAX: usize = 4096;

/// First side of a grid cell, inches.
const CELL_IN: f64 = 4.0;

/// A point of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrailPoint {
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
    /// Whether no line was lost since the previous point.
    pub(crate) joined: bool,
}

/// The robot's trail.
#[derive(Clone, Debug)]
pub(crate) struct Trail {
    recent: VecDeque<TrailPoint>,
    /// Grid cells of older parts; shared with the keyframes of other moments.
    older: Arc<BTreeSet<(i32, i32)>>,
    cell_in: f64,
}

impl Default for Trail {
    fn default() -> Self {
        Self {
            recent: VecDeque::new(),
            older: Arc::default(),
            cell_in: CELL_IN,
        }
    }
}

impl Trail {
    /// Adds a position; `joined` if no line was lost since the previous one.
    pub(super) fn push(&mut self, x_in: f64, y_in: f64, joined: bool) {
        if let Some(last) = self.recent.back() {
            let moved_in = (x_in - last.x_in).hypot(y_in - last.y_in);
            if moved_in < SPACING_IN {
                return;
            }
        }
        if self.recent.len() == RECENT_MAX
            && let Some(oldest) = self.recent.pop_front()
        {
            self.remember(oldest);
        }
        self.recent.push_back(TrailPoint { x_in, y_in, joined });
    }

    fn remember(&mut self, point: TrailPoint) {
        let cell = |value: f64| (value / self.cell_in).floor() as i32;
        let passed = (cell(point.x_in), cell(point.y_in));
        if self.older.contains(&passed) {
            return;
        }
        Arc::make_mut(&mut self.older).insert(passed);
        while self.older.len() > OLDER_MAX {
            let coarser = |(x, y): &(i32, i32)| (x.div_euclid(2), y.div_euclid(2));
            self.older = Arc::new(self.older.iter().map(coarser).collect());
            self.cell_in *= 2.0;
        }
    }

    /// The newest part as a line, oldest point first.
    pub(crate) fn recent(&self) -> impl Iterator<Item = &TrailPoint> {
        self.recent.iter()
    }

    /// Middles of the grid cells of older parts.
    pub(crate) fn older(&self) -> impl Iterator<Item = (f64, f64)> {
        let middle = |cell: i32| (f64::from(cell) + 0.5) * self.cell_in;
        self.older.iter().map(move |&(x, y)| (middle(x), middle(y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_day_of_driving_is_bounded_and_keeps_its_shape() {
        let mut trail = Trail::default();
        for n in 0..400_000 {
            let angle = f64::from(n) / 40.0;
            let radius = 100.0 + f64::from(n % 9973) / 40.0;
            trail.push(radius * angle.sin(), radius * angle.cos(), true);
        }
        assert_eq!(trail.recent().count(), RECENT_MAX);
        let older: Vec<_> = trail.older().collect();
        assert!((500..=OLDER_MAX).contains(&older.len()), "{}", older.len());
        assert!(older.iter().all(|(x, y)| x.hypot(*y) < 400.0));
    }

    #[test]
    fn standing_still_adds_nothing() {
        let mut trail = Trail::default();
        for _ in 0..1000 {
            trail.push(1.0, 2.0, true);
        }
        assert_eq!(trail.recent().count(), 1);
    }
}
