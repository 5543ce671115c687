//! The floor that was seen, cell by cell, for other programs.

use crate::floor::Floor;
use crate::grid::{CELL_IN, Cell, FREE, Grid, OBSTACLE};

/// What is known of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FloorCell {
    /// Nothing, or not enough.
    #[default]
    Unknown,
    /// The robot drove over it or saw nothing in it.
    Free,
    /// Something stands there.
    Obstacle,
    /// The floor ends there, as at a stair.
    Drop,
}

/// A rectangle around all cells of which something is known, with sides of [`CELL_IN`].
#[derive(Clone, Debug, PartialEq)]
pub struct FloorMap {
    /// X and Y of the lower left corner, inches.
    pub corner_in: (f64, f64),
    /// Cells along X.
    pub columns: usize,
    /// The cells, row by row; X grows within a row, and Y from row to row.
    pub cells: Vec<FloorCell>,
}

impl FloorMap {
    /// The map of a floor; `None` if nothing is known of it.
    pub(crate) fn new(floor: &Floor) -> Option<Self> {
        let known = [&floor.grid, &floor.driven, &floor.drops].map(Grid::cells);
        let known = known.into_iter().flatten().map(|(at, _)| at);
        let known = known.filter(|at| cell(floor, *at) != FloorCell::Unknown);
        let (low, high) = known.fold(None, |bounds, (column, row)| {
            let (low, high) = bounds.unwrap_or(((column, row), (column, row)));
            Some((
                (column.min(low.0), row.min(low.1)),
                (column.max(high.0), row.max(high.1)),
            ))
        })?;
        let cells = (low.1..=high.1)
            .flat_map(|row| (low.0..=high.0).map(move |column| cell(floor, (column, row))));
        Some(Self {
            corner_in: (f64::from(low.0) * CELL_IN, f64::from(low.1) * CELL_IN),
            columns: (high.0 - low.0 + 1) as usize,
            cells: cells.collect(),
        })
    }

    /// X and Y of the middles of all cells of a kind, inches.
    pub fn middles_in(&self, kind: FloorCell) -> impl Iterator<Item = (f64, f64)> {
        let cells = self.cells.iter().enumerate();
        cells
            .filter(move |(_, cell)| **cell == kind)
            .map(|(at, _)| {
                let (column, row) = (at % self.columns, at / self.columns);
                let middle =
                    |corner_in: f64, cells: usize| corner_in + (cells as f64 + 0.5) * CELL_IN;
                (
                    middle(self.corner_in.0, column),
                    middle(self.corner_in.1, row),
                )
            })
    }
}

fn cell(floor: &Floor, cell: Cell) -> FloorCell {
    let log_odds = floor.grid.log_odds(cell);
    if floor.drops.log_odds(cell) > 0.0 {
        FloorCell::Drop
    } else if log_odds > OBSTACLE {
        FloorCell::Obstacle
    } else if log_odds < FREE || floor.driven.log_odds(cell) > 0.0 {
        FloorCell::Free
    } else {
        FloorCell::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_cell_is_where_it_was_seen(
            cells in proptest::collection::btree_map((-90..90_i32, -90..90_i32), 0..4_u8, 1..40)
        ) {
            let mut floor = Floor::default();
            for (cell, kind) in &cells {
                match kind {
                    0 => floor.grid.add(*cell, 3.0),
                    1 => floor.grid.add(*cell, -1.0),
                    2 => floor.driven.add(*cell, 1.0),
                    _ => floor.drops.add(*cell, 1.0),
                };
            }
            let map = FloorMap::new(&floor).unwrap();
            prop_assert_eq!(map.cells.len() % map.columns, 0);
            let kinds = [FloorCell::Obstacle, FloorCell::Free, FloorCell::Free, FloorCell::Drop];
            let mut seen = 0;
            for known in [FloorCell::Obstacle, FloorCell::Free, FloorCell::Drop] {
                for middle_in in map.middles_in(known) {
                    let kind = cells.get(&Grid::cell(middle_in));
                    prop_assert_eq!(kind.map(|kind| kinds[usize::from(*kind)]), Some(known));
                    seen += 1;
                }
            }
            prop_assert_eq!(seen, cells.len());
        }
    }

    #[test]
    fn nothing_known_is_no_map() {
        assert_eq!(FloorMap::new(&Floor::default()), None);
    }
}
