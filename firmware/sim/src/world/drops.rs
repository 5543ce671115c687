//! Places without floor: stairs going down.

use crate::geometry::Vec2;

/// The plan cells without floor; none by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drops {
    pub(super) cell_in: f64,
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// North row first; empty when the floor is everywhere.
    pub(super) cells: Vec<bool>,
}

impl Drops {
    /// Whether the floor is complete.
    pub(crate) const fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Whether there is no floor at a point of the plan.
    pub(crate) fn has(&self, point: Vec2) -> bool {
        if self.cells.is_empty() || point.x < 0.0 || point.y < 0.0 {
            return false;
        }
        let column = (point.x / self.cell_in) as usize;
        let from_south = (point.y / self.cell_in) as usize;
        column < self.columns
            && from_south < self.rows
            && self.cells[(self.rows - 1 - from_south) * self.columns + column]
    }
}
