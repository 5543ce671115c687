//! The occupancy grid: log-odds per cell, in tiles that are made where there is evidence.
//!
//! Source: Moravec and Elfes, "High resolution maps from wide angle sonar", 1985; log-odds as in Thrun, Burgard and Fox,
//! *Probabilistic Robotics*, 2005, chapter 9.

/// Side of a cell, inches.
pub const CELL_IN: f64 = 3.0;

/// Log-odds from which a cell is an obstacle: 4 to 1.
pub(crate) const OBSTACLE: f64 = 1.4;

/// Log-odds below which a cell is known to be free.
pub(crate) const FREE: f64 = -0.3;

/// Cells along the side of a tile.
const TILE: i32 = 1 << TILE_BITS;
const TILE_BITS: i32 = 5;

/// Maximum tiles: 8 MiB, or a square of 700 feet. Evidence for cells beyond them is dropped.
const TILES_MAX: usize = 8192;

/// Log-odds per step of a cell's value.
const STEP: f64 = 1.0 / 16.0;

/// Limit of the log-odds, in steps: a cell that was wrong for long can still change.
const LIMIT_STEPS: i16 = 80;

/// Column and row of a cell; column 0 starts at X = 0 and row 0 at Y = 0.
pub(crate) type Cell = (i32, i32);

/// Log-odds of one tile, in steps.
type Tile = [i8; (TILE * TILE) as usize];

/// Log-odds that each cell holds an obstacle; 0 is unknown.
#[derive(Clone, Debug, Default)]
pub(crate) struct Grid {
    /// First tile's column and row, and tiles along each side.
    origin: (i32, i32),
    size: (i32, i32),
    tiles: Vec<Option<Box<Tile>>>,
    used: usize,
}

impl Grid {
    /// The cell of a position.
    pub(crate) fn cell((x_in, y_in): (f64, f64)) -> Cell {
        (floor(x_in / CELL_IN), floor(y_in / CELL_IN))
    }

    /// The centre of a cell, inches.
    pub(crate) fn center((column, row): Cell) -> (f64, f64) {
        (
            (f64::from(column) + 0.5) * CELL_IN,
            (f64::from(row) + 0.5) * CELL_IN,
        )
    }

    /// Log-odds of a cell.
    pub(crate) fn log_odds(&self, cell: Cell) -> f64 {
        f64::from(self.steps(cell)) * STEP
    }

    fn steps(&self, (column, row): Cell) -> i8 {
        let slot = self.slot((column >> TILE_BITS, row >> TILE_BITS));
        let tile = slot.and_then(|slot| self.tiles[slot].as_ref());
        tile.map_or(0, |tile| tile[within((column, row))])
    }

    /// Adds evidence to a cell; returns the log-odds before.
    pub(crate) fn add(&mut self, cell: Cell, log_odds: f64) -> f64 {
        let tile = (cell.0 >> TILE_BITS, cell.1 >> TILE_BITS);
        let Some(slot) = self.slot(tile).or_else(|| self.grow(tile)) else {
            return 0.0;
        };
        if self.tiles[slot].is_none() {
            if self.used == TILES_MAX {
                return 0.0;
            }
            self.used += 1;
        }
        let tile = self.tiles[slot].get_or_insert_with(|| Box::new([0; (TILE * TILE) as usize]));
        let value = &mut tile[within(cell)];
        let before = *value;
        let added = i16::from(before) + (log_odds / STEP + 0.5_f64.copysign(log_odds)) as i16;
        *value = added.clamp(-LIMIT_STEPS, LIMIT_STEPS) as i8;
        f64::from(before) * STEP
    }

    /// Cells with evidence and their log-odds, row by row in each tile.
    pub(crate) fn cells(&self) -> impl Iterator<Item = (Cell, f64)> {
        let (origin, width) = (self.origin, self.size.0);
        let tiles = self.tiles.iter().enumerate();
        tiles.flat_map(move |(slot, tile)| {
            let (column, row) = (
                (origin.0 + slot as i32 % width) * TILE,
                (origin.1 + slot as i32 / width) * TILE,
            );
            let values = tile.iter().flat_map(|tile| tile.iter().enumerate());
            values
                .filter(|(_, value)| **value != 0)
                .map(move |(at, value)| {
                    let cell = (column + at as i32 % TILE, row + at as i32 / TILE);
                    (cell, f64::from(*value) * STEP)
                })
        })
    }

    fn slot(&self, (column, row): (i32, i32)) -> Option<usize> {
        let (column, row) = (column - self.origin.0, row - self.origin.1);
        ((0..self.size.0).contains(&column) && (0..self.size.1).contains(&row))
            .then_some((row * self.size.0 + column) as usize)
    }

    /// Extends the grid to a tile; `None` if it would become too large.
    fn grow(&mut self, (column, row): (i32, i32)) -> Option<usize> {
        let (from, to) = if self.tiles.is_empty() {
            ((column, row), (column + 1, row + 1))
        } else {
            let end = (self.origin.0 + self.size.0, self.origin.1 + self.size.1);
            (
                (self.origin.0.min(column), self.origin.1.min(row)),
                (end.0.max(column + 1), end.1.max(row + 1)),
            )
        };
        let size = (to.0.checked_sub(from.0)?, to.1.checked_sub(from.1)?);
        if size.0.checked_mul(size.1)? as usize > TILES_MAX {
            return None;
        }
        let mut grown = vec![None; (size.0 * size.1) as usize];
        for (slot, tile) in self.tiles.drain(..).enumerate() {
            let (column, row) = (slot as i32 % self.size.0, slot as i32 / self.size.0);
            let (column, row) = (
                column + self.origin.0 - from.0,
                row + self.origin.1 - from.1,
            );
            grown[(row * size.0 + column) as usize] = tile;
        }
        (self.origin, self.size, self.tiles) = (from, size, grown);
        self.slot((column, row))
    }
}

/// The greatest whole number up to a number.
pub(crate) fn floor(number: f64) -> i32 {
    let whole = number as i32;
    whole.saturating_sub(i32::from(f64::from(whole) > number))
}

/// Place of a cell in its tile.
fn within((column, row): Cell) -> usize {
    ((row & (TILE - 1)) << TILE_BITS | (column & (TILE - 1))) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    use proptest::prelude::*;

    proptest! {
        #[test]
        fn cells_keep_their_evidence_while_the_grid_grows(
            cells in proptest::collection::btree_map((-300..300_i32, -300..300_i32), 1..40_i32, 1..40)
        ) {
            let mut grid = Grid::default();
            for (cell, steps) in &cells {
                grid.add(*cell, f64::from(*steps) * STEP);
            }
            let kept: BTreeMap<Cell, f64> = grid.cells().collect();
            prop_assert_eq!(kept.len(), cells.len());
            for (cell, steps) in cells {
                prop_assert!((kept[&cell] - f64::from(steps) * STEP).abs() < 1e-9);
                prop_assert_eq!(Grid::cell(Grid::center(cell)), cell);
            }
        }

        #[test]
        fn evidence_is_bounded_and_can_be_undone(many in 0..2000_usize) {
            let mut grid = Grid::default();
            for _ in 0..many {
                grid.add((0, 0), 0.9);
            }
            prop_assert!(grid.log_odds((0, 0)) <= 5.0);
            for _ in 0..12 {
                grid.add((0, 0), -0.9);
            }
            prop_assert!(grid.log_odds((0, 0)) < 0.0);
        }
    }

    #[test]
    fn evidence_far_away_is_dropped() {
        let mut grid = Grid::default();
        grid.add((0, 0), 1.0);
        grid.add((i32::MAX, i32::MIN), 1.0);
        assert_eq!(grid.cells().count(), 1);
    }
}
