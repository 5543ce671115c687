//! The floor plan as drawn, cell by cell.

use crate::geometry::Vec2;

/// Size of a plan's cells and their number.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Layout {
    pub(crate) cell_in: f64,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Layout {
    /// Index of a cell in a list by rows, the north row first.
    pub(crate) const fn index(&self, row: usize, column: usize) -> usize {
        row * self.columns + column
    }

    /// Centre of a cell in inches from the south-west corner.
    pub(crate) fn center(&self, row: usize, column: usize) -> Vec2 {
        Vec2::new(
            (column as f64 + 0.5) * self.cell_in,
            ((self.rows - row) as f64 - 0.5) * self.cell_in,
        )
    }

    /// Row and column of the cell that contains a point; `None` outside the plan.
    pub(crate) fn cell_at(&self, point: Vec2) -> Option<(usize, usize)> {
        if point.x < 0.0 || point.y < 0.0 {
            return None;
        }
        let column = (point.x / self.cell_in) as usize;
        let from_south = (point.y / self.cell_in) as usize;
        (column < self.columns && from_south < self.rows)
            .then(|| (self.rows - 1 - from_south, column))
    }
}

/// The characters of a plan and their position in the file.
#[derive(Clone, Debug)]
pub(crate) struct Grid {
    pub(crate) layout: Layout,
    /// Cells by row, north row first.
    pub(crate) glyphs: Vec<char>,
    /// Line of the north row in the file, from 1.
    pub(crate) first_line: usize,
}

impl Grid {
    /// Character of a cell.
    pub(crate) fn glyph(&self, row: usize, column: usize) -> char {
        self.glyphs[self.layout.index(row, column)]
    }
}
