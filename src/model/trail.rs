//! Where the robot has been, in bounded memory: the newest part as a line, everything older as the
//! places it passed, on a grid that grows coarser only when the robot covers new ground.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

/// Points of the line.
const RECENT_MAX: usize = 1024;

/// Distance between two points of the line, inches.
const SPACING_IN: f64 = 3.0;

/// Places remembered of what is older than the line.
const OLDER_MAX: usize = 4096;

/// Side of a grid cell at the start, inches.
const CELL_IN: f64 = 4.0;

/// A point of the line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TrailPoint {
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
    /// Whether the robot was heard all the way from the point before.
    pub(crate) joined: bool,
}

/// Where the robot has been.
#[derive(Clone, Debug)]
pub(crate) struct Trail {
    recent: VecDeque<TrailPoint>,
    /// Shared with the states kept of other moments: a robot that has been everywhere adds nothing.
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
    /// Takes a position; `joined` when nothing was missed since the one before.
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

    /// The middles of the places passed before that.
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
