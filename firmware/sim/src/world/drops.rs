//! Places without floor: stairs going down.

use super::grid::Layout;
use crate::geometry::Vec2;

/// The plan cells without floor; none by default.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drops {
    pub(super) layout: Layout,
    /// Cells by row, north row first; empty if there is floor everywhere.
    pub(super) cells: Vec<bool>,
}

impl Drops {
    /// Whether the floor is complete.
    pub(crate) const fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Whether there is no floor at a point of the plan.
    pub(crate) fn has(&self, point: Vec2) -> bool {
        !self.is_empty()
            && self
                .layout
                .cell_at(point)
                .is_some_and(|(row, column)| self.cells[self.layout.index(row, column)])
    }
}
