//! Floor that was seen but never visited: a room beyond a doorway, or a corner behind furniture.

use std::collections::{HashMap, HashSet};

use pathfinding::undirected::connected_components::components;

use crate::floor::{Floor, around};
use crate::grid::{CELL_IN, Cell, FREE, Grid, OBSTACLE};
use crate::plan::{CLEAR_IN, Point};

/// Distance from where the robot's centre has been from which floor is not visited, inches.
const AWAY_IN: f64 = 30.0;

/// Distance from a place that the robot has tried to reach within which floor is not unvisited, inches: what was seen there may be no floor.
const TRIED_IN: f64 = 48.0;

/// Square inches of a square foot.
const SQ_FT: f64 = 144.0;

/// Seen floor on which the robot has never been.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unvisited {
    /// The place in it that is furthest from its edges.
    pub(crate) middle: Point,
    /// Area, square feet.
    pub(crate) area_sq_ft: f64,
}

/// The largest such piece of a floor, away from places that the robot has tried to reach; `None` if there is none.
pub(crate) fn largest(floor: &Floor, tried: &[Point]) -> Option<Unvisited> {
    let mut taken: HashSet<Cell> = HashSet::new();
    for place in tried {
        taken.extend(around(*place, TRIED_IN));
    }
    for (cell, _) in floor.driven.cells().filter(|(_, mark)| *mark > 0.0) {
        taken.extend(around(Grid::center(cell), AWAY_IN));
    }
    for (cell, _) in floor.grid.cells().filter(|(_, odds)| *odds > OBSTACLE) {
        taken.extend(around(Grid::center(cell), CLEAR_IN));
    }
    for (cell, _) in floor.drops.cells() {
        taken.extend(around(Grid::center(cell), CLEAR_IN));
    }
    let free: HashSet<Cell> = floor
        .grid
        .cells()
        .filter(|(cell, odds)| *odds < FREE && !taken.contains(cell))
        .map(|(cell, _)| cell)
        .collect();
    let groups: Vec<Vec<Cell>> = free
        .iter()
        .map(|cell| {
            let (column, row) = *cell;
            let next = [(column + 1, row), (column, row + 1)];
            let near = next.into_iter().filter(|it| free.contains(it));
            std::iter::once(*cell).chain(near).collect()
        })
        .collect();
    // The smallest cell decides between pieces of the same size, so that the result does not depend on the order of a set.
    let piece = components(&groups).into_iter().max_by_key(|piece| {
        (
            piece.len(),
            piece.iter().min().copied().map(std::cmp::Reverse),
        )
    })?;
    let depths = depths(&piece);
    let (middle, _) = depths
        .into_iter()
        .max_by_key(|(cell, depth)| (*depth, std::cmp::Reverse(*cell)))?;
    Some(Unvisited {
        middle: Grid::center(middle),
        area_sq_ft: piece.len() as f64 * CELL_IN * CELL_IN / SQ_FT,
    })
}

/// Steps from each cell of a piece to its edge.
fn depths(piece: &HashSet<Cell>) -> HashMap<Cell, u32> {
    let neighbours = |(column, row): Cell| {
        [
            (column + 1, row),
            (column - 1, row),
            (column, row + 1),
            (column, row - 1),
        ]
    };
    let is_edge = |cell: &&Cell| neighbours(**cell).iter().any(|it| !piece.contains(it));
    let mut reached: Vec<Cell> = piece.iter().filter(is_edge).copied().collect();
    let mut depths: HashMap<Cell, u32> = reached.iter().map(|cell| (*cell, 0)).collect();
    let mut depth = 0;
    while !reached.is_empty() {
        depth += 1;
        let next = reached.drain(..).flat_map(neighbours);
        reached = next
            .filter(|cell| piece.contains(cell) && !depths.contains_key(cell))
            .collect();
        reached.sort_unstable();
        reached.dedup();
        depths.extend(reached.iter().map(|cell| (*cell, depth)));
    }
    depths
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Two rooms that were seen from the first: the second is the piece, and the place is well inside.
        #[test]
        fn the_room_that_was_only_seen_is_found(wide in 24..40_i32, deep in 24..32_i32, wall in 50..60_i32) {
            let mut floor = Floor::default();
            for column in 0..wall + wide {
                for row in 0..deep {
                    floor.grid.add((column, row), if column == wall { 5.0 } else { -1.0 });
                }
            }
            for column in 0..wall - 8 {
                for cell in around(Grid::center((column, deep / 2)), 12.0) {
                    floor.driven.add(cell, 1.0);
                }
            }
            let found = largest(&floor, &[]).unwrap();
            let (column, row) = Grid::cell(found.middle);
            prop_assert!(column > wall + 6 && column < wall + wide - 4, "{found:?}");
            prop_assert!(row > 4 && row < deep - 4, "{found:?}");
            let most = f64::from(wide * deep) * CELL_IN * CELL_IN / SQ_FT;
            prop_assert!(found.area_sq_ft <= most && found.area_sq_ft > most / 4.0, "{found:?}");
            if let Some(other) = largest(&floor, &[found.middle]) {
                let far_in = (other.middle.0 - found.middle.0).hypot(other.middle.1 - found.middle.1);
                prop_assert!(far_in > TRIED_IN, "{other:?} after {found:?}");
            }
        }
    }

    #[test]
    fn where_the_robot_has_been_everywhere_there_is_none() {
        let mut floor = Floor::default();
        for cell in around((0.0, 0.0), 100.0) {
            floor.grid.add(cell, -1.0);
            floor.driven.add(cell, 1.0);
        }
        assert_eq!(largest(&floor, &[]), None);
        assert_eq!(largest(&Floor::default(), &[]), None);
    }
}
