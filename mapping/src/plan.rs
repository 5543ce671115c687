//! The cheapest route over a floor, and its fewest waypoints.
//!
//! The robot's centre follows the route: obstacles are inflated by its body (Lozano-Pérez, "Spatial planning: a configuration
//! space approach", 1983). A straight leg replaces a piece of the route where it is clear and costs no more (Daniel, Nash,
//! Koenig and Felner, "Theta*: any-angle path planning on grids", 2010, as a post-process).

use pathfinding::directed::astar::astar;

use crate::floor::{Floor, around};
use crate::grid::{CELL_IN, Cell, FREE, Grid, OBSTACLE};
use crate::sensors::body::RADIUS_IN;

/// Distance of the robot's centre from the centre of an obstacle's cell that is clear, inches: the body and half of a cell.
pub(crate) const CLEAR_IN: f64 = RADIUS_IN + CELL_IN / 2.0;

/// The same where the robot has driven: it passed, so the obstacle is misplaced, unless it stands in the middle of the path.
pub(crate) const DRIVEN_CLEAR_IN: f64 = CELL_IN;

/// Distance from the centre of a drop's cell where the robot has driven, inches: it stood before the drop.
pub(crate) const DRIVEN_DROP_IN: f64 = RADIUS_IN - CELL_IN / 2.0;

/// Distance from obstacles up to which cells cost more, inches: the odometer is not exact.
const NEAR_IN: f64 = 12.0;

/// Distance from the robot in which no obstacle keeps it: it stands there.
const STANDS_IN: f64 = RADIUS_IN + CELL_IN;

/// Distance from the target in which the route may end if the target itself is blocked, inches.
const BESIDE_IN: f64 = 24.0;

/// Cost of a cell by what is known of it: driven, seen to be free, near an obstacle, and unknown.
const DRIVEN: u32 = 2;
const SEEN: u32 = 3;
const NEAR: u32 = 6;
const UNKNOWN: u32 = 10;

/// Length of a step to the next cell, and to the next one on the diagonal, as whole numbers.
const STRAIGHT: u32 = 10;
const DIAGONAL: u32 = 14;

/// Excess of a straight leg's cost over that of the piece that it replaces, as a share, and in straight steps of driven cells.
const EXCESS: f64 = 0.02;
const EXCESS_STEPS: f64 = 1.0;

/// Distance of the points of a leg that are checked, inches.
const CHECK_IN: f64 = 1.0;

/// Cells around what is known through which a route may lead.
const MARGIN: i32 = 16;

/// Maximum cells: a square of 180 ft. The search of more would keep the operator waiting.
const CELLS_MAX: i64 = 1 << 19;

/// A point, inches.
pub(crate) type Point = (f64, f64);

/// Reason why there is no route over the floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Blocked {
    /// The target and its surroundings are blocked.
    Target,
    /// Obstacles are all around the robot or the target.
    Between,
}

/// The cost of each cell for the robot's centre; 0 is blocked.
pub(crate) struct Terrain {
    from: Cell,
    columns: i32,
    rows: i32,
    costs: Vec<u32>,
}

impl Terrain {
    /// The costs around a start and all that is known; `None` if that is too large, or a target is beyond it.
    pub(crate) fn new(floor: &Floor, start: Point, target: Point) -> Option<Self> {
        let known = floor.grid.cells().map(|(cell, _)| cell);
        let start_cell = Grid::cell(start);
        let (mut low, mut high) = (start_cell, start_cell);
        for (column, row) in known {
            low = (low.0.min(column), low.1.min(row));
            high = (high.0.max(column), high.1.max(row));
        }
        let span = |low: i32, high: i32| i64::from(high) - i64::from(low) + 1 + 2 * MARGIN as i64;
        let (columns, rows) = (span(low.0, high.0), span(low.1, high.1));
        if columns.checked_mul(rows)? > CELLS_MAX {
            return None;
        }
        let mut it = Self {
            from: (low.0 - MARGIN, low.1 - MARGIN),
            columns: columns as i32,
            rows: rows as i32,
            costs: Vec::new(),
        };
        it.at(Grid::cell(target))?;
        let obstacles = floor.grid.cells().filter(|(_, odds)| *odds > OBSTACLE);
        let obstacles_in = it.distances_in(obstacles.map(|(cell, _)| cell));
        let drops_in = it.distances_in(floor.drops.cells().map(|(cell, _)| cell));
        it.costs = (0..(columns * rows) as usize)
            .map(|at| {
                let cell = it.cell(at);
                let (x_in, y_in) = Grid::center(cell);
                let stands = libm::hypot(x_in - start.0, y_in - start.1) < STANDS_IN;
                let is_driven = stands || floor.driven.log_odds(cell) > 0.0;
                let (clear_in, drop_in) = if is_driven {
                    (DRIVEN_CLEAR_IN, DRIVEN_DROP_IN)
                } else {
                    (CLEAR_IN, CLEAR_IN)
                };
                let is_blocked = !stands && obstacles_in[at] < clear_in || drops_in[at] < drop_in;
                match (is_blocked, is_driven) {
                    (true, _) => 0,
                    (false, true) => DRIVEN,
                    _ if obstacles_in[at].min(drops_in[at]) < NEAR_IN => NEAR,
                    _ if floor.grid.log_odds(cell) < FREE => SEEN,
                    _ => UNKNOWN,
                }
            })
            .collect();
        Some(it)
    }

    /// Distance of each cell from the nearest of some cells, up to that from which no cell is near.
    fn distances_in(&self, cells: impl Iterator<Item = Cell>) -> Vec<f64> {
        let mut distances_in = vec![f64::MAX; (self.columns * self.rows) as usize];
        for cell in cells {
            let (x_in, y_in) = Grid::center(cell);
            for near in around((x_in, y_in), NEAR_IN) {
                let (x, y) = Grid::center(near);
                if let Some(at) = self.at(near) {
                    let distance_in = libm::hypot(x - x_in, y - y_in);
                    distances_in[at] = distances_in[at].min(distance_in);
                }
            }
        }
        distances_in
    }

    fn at(&self, (column, row): Cell) -> Option<usize> {
        let (column, row) = (column - self.from.0, row - self.from.1);
        ((0..self.columns).contains(&column) && (0..self.rows).contains(&row))
            .then_some((row * self.columns + column) as usize)
    }

    fn cell(&self, at: usize) -> Cell {
        let at = at as i32;
        (
            self.from.0 + at % self.columns,
            self.from.1 + at / self.columns,
        )
    }

    /// Cost of a cell; `None` if it is blocked.
    fn cost(&self, cell: Cell) -> Option<u32> {
        self.at(cell)
            .map(|at| self.costs[at])
            .filter(|cost| *cost > 0)
    }

    /// The cell of a point, or the passable one that is nearest.
    fn nearest(&self, point: Point) -> Option<Cell> {
        let cell = Grid::cell(point);
        if self.cost(cell).is_some() {
            return Some(cell);
        }
        let distance_in = |cell: &Cell| {
            let (x_in, y_in) = Grid::center(*cell);
            libm::hypot(x_in - point.0, y_in - point.1)
        };
        around(point, BESIDE_IN)
            .filter(|cell| self.cost(*cell).is_some())
            .min_by(|one, other| distance_in(one).total_cmp(&distance_in(other)))
    }

    /// The passable neighbours of a cell with the costs of the steps to them. No step cuts the corner of a blocked cell.
    fn steps(&self, (column, row): Cell) -> impl Iterator<Item = (Cell, u32)> {
        let offsets = (-1..=1).flat_map(|x| (-1..=1).map(move |y| (x, y)));
        offsets.filter_map(move |(x, y)| {
            let cost = self.cost((column + x, row + y))?;
            self.cost((column + x, row))?;
            self.cost((column, row + y))?;
            let length = [0, STRAIGHT, DIAGONAL][(x.abs() + y.abs()) as usize];
            (length > 0).then_some(((column + x, row + y), cost * length))
        })
    }

    /// The points of the route after its start; the last is at the target, or beside it if it is blocked.
    pub(crate) fn route(&self, start: Point, target: Point) -> Result<Vec<Point>, Blocked> {
        let first = self.nearest(start).ok_or(Blocked::Between)?;
        let goal = self.nearest(target).ok_or(Blocked::Target)?;
        let estimate = |(column, row): &Cell| {
            let (x, y) = (goal.0.abs_diff(*column), goal.1.abs_diff(*row));
            DRIVEN * (STRAIGHT * x.max(y) + (DIAGONAL - STRAIGHT) * x.min(y))
        };
        let (cells, _) = astar(
            &first,
            |cell| self.steps(*cell).collect::<Vec<_>>(),
            estimate,
            |cell| *cell == goal,
        )
        .ok_or(Blocked::Between)?;
        let mut points: Vec<Point> = cells.into_iter().map(Grid::center).collect();
        points[0] = start;
        if goal == Grid::cell(target) {
            points.push(target);
        } else if points.len() == 1 {
            points.push(Grid::center(goal));
        }
        Ok(self.fewest(&points))
    }

    /// The fewest of the points whose legs are clear and cost no more than the route along all points; without the first.
    fn fewest(&self, points: &[Point]) -> Vec<Point> {
        let mut costs = vec![0.0];
        for pair in points.windows(2) {
            let cost = self.leg_cost(pair[0], pair[1]);
            costs.push(costs[costs.len() - 1] + cost.unwrap_or(0.0));
        }
        // Breadth first: a point is reached with the fewest legs, over the point that is nearest to the start.
        let mut before = vec![None; points.len()];
        let (mut reached, mut next) = (vec![0], Vec::new());
        while before[points.len() - 1].is_none() && !reached.is_empty() {
            for from in reached.drain(..) {
                for to in (from + 1)..points.len() {
                    let most = (costs[to] - costs[from]) * (1.0 + EXCESS)
                        + EXCESS_STEPS * f64::from(DRIVEN) * CELL_IN;
                    let is_good = |cost: f64| to == from + 1 || cost <= most;
                    if before[to].is_none()
                        && (to == from + 1
                            || self.leg_cost(points[from], points[to]).is_some_and(is_good))
                    {
                        before[to] = Some(from);
                        next.push(to);
                    }
                }
            }
            std::mem::swap(&mut reached, &mut next);
        }
        let mut kept = Vec::new();
        let mut at = points.len() - 1;
        while let Some(from) = before[at] {
            kept.push(points[at]);
            at = from;
        }
        kept.reverse();
        kept
    }

    /// Cost of a straight leg; `None` if it is blocked.
    fn leg_cost(&self, from: Point, to: Point) -> Option<f64> {
        let length_in = libm::hypot(to.0 - from.0, to.1 - from.1);
        let steps = libm::ceil(length_in / CHECK_IN).max(1.0) as u32;
        let mut sum = 0.0;
        for step in 0..=steps {
            let share = f64::from(step) / f64::from(steps);
            let point = (
                from.0 + (to.0 - from.0) * share,
                from.1 + (to.1 - from.1) * share,
            );
            sum += f64::from(self.cost(Grid::cell(point))?);
        }
        Some(sum / f64::from(steps + 1) * length_in)
    }

    /// Length of a route over floor that was never seen, inches.
    pub(crate) fn unknown_in(&self, start: Point, route: &[Point]) -> f64 {
        let mut from = start;
        let mut unknown_in = 0.0;
        for to in route {
            let length_in = libm::hypot(to.0 - from.0, to.1 - from.1);
            let steps = libm::ceil(length_in / CHECK_IN).max(1.0) as u32;
            for step in 0..steps {
                let share = (f64::from(step) + 0.5) / f64::from(steps);
                let point = (
                    from.0 + (to.0 - from.0) * share,
                    from.1 + (to.1 - from.1) * share,
                );
                if self.cost(Grid::cell(point)) == Some(UNKNOWN) {
                    unknown_in += length_in / f64::from(steps);
                }
            }
            from = *to;
        }
        unknown_in
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    /// Side of the floors, cells.
    const SIDE: i32 = 40;

    /// A floor of free cells with some obstacles, drops, and cells where the robot drove.
    fn floor(obstacles: &[Cell], drops: &[Cell], driven: &[Cell]) -> Floor {
        let mut floor = Floor::default();
        for column in 0..SIDE {
            for row in 0..SIDE {
                floor.grid.add((column, row), -1.0);
            }
        }
        for cell in obstacles {
            floor.grid.add(*cell, 5.0);
        }
        for cell in drops {
            floor.drops.add(*cell, 1.0);
        }
        for cell in driven {
            floor.driven.add(*cell, 1.0);
        }
        floor
    }

    fn cells(count: usize) -> impl Strategy<Value = Vec<Cell>> {
        proptest::collection::vec((0..SIDE, 0..SIDE), 0..count)
    }

    fn point() -> impl Strategy<Value = Point> {
        let most = f64::from(SIDE) * CELL_IN;
        (0.0..most, 0.0..most)
    }

    fn distance_in(one: Point, other: Point) -> f64 {
        libm::hypot(one.0 - other.0, one.1 - other.1)
    }

    /// Points on a route, half an inch apart.
    fn along(start: Point, route: &[Point]) -> Vec<Point> {
        let mut from = start;
        let mut points = Vec::new();
        for to in route {
            let steps = (distance_in(from, *to) * 2.0) as u32 + 1;
            points.extend((0..=steps).map(|step| {
                let share = f64::from(step) / f64::from(steps);
                (
                    from.0 + (to.0 - from.0) * share,
                    from.1 + (to.1 - from.1) * share,
                )
            }));
            from = *to;
        }
        points
    }

    /// Half of a cell's diagonal, and the distance of two checked points: what the grid does not resolve.
    const ROUNDING_IN: f64 = 2.2 + 1.0;

    proptest! {
        #[test]
        fn way_keeps_clear_of_obstacles_and_drops(
            start in point(), target in point(), obstacles in cells(40), drops in cells(4), driven in cells(60),
        ) {
            let floor = floor(&obstacles, &drops, &driven);
            let terrain = Terrain::new(&floor, start, target).unwrap();
            if let Ok(route) = terrain.route(start, target) {
                let end = *route.last().unwrap();
                prop_assert!(distance_in(end, target) <= BESIDE_IN);
                let driven: BTreeSet<Cell> = driven.into_iter().collect();
                for point in along(start, &route) {
                    if distance_in(point, start) < STANDS_IN + ROUNDING_IN {
                        continue;
                    }
                    let is_driven = around(point, ROUNDING_IN).any(|cell| driven.contains(&cell));
                    let (clear_in, drop_in) =
                        if is_driven { (DRIVEN_CLEAR_IN, DRIVEN_DROP_IN) } else { (CLEAR_IN, CLEAR_IN) };
                    for obstacle in &obstacles {
                        prop_assert!(distance_in(point, Grid::center(*obstacle)) >= clear_in - ROUNDING_IN, "{route:?} at {point:?} by {obstacle:?}");
                    }
                    for drop in &drops {
                        prop_assert!(distance_in(point, Grid::center(*drop)) >= drop_in - ROUNDING_IN, "{route:?} at {point:?} by {drop:?}");
                    }
                }
                prop_assert_eq!(route, Terrain::new(&floor, start, target).unwrap().route(start, target).unwrap());
            }
        }

        #[test]
        fn way_over_open_floor_is_one_leg(start in point(), target in point()) {
            let terrain = Terrain::new(&floor(&[], &[], &[]), start, target).unwrap();
            prop_assert_eq!(terrain.route(start, target).unwrap(), [target]);
        }

        /// A wall across the floor with one opening.
        #[test]
        fn way_leads_through_the_opening(opening in 4..SIDE - 9, is_driven: bool) {
            // 15 in are too narrow for the body, unless it has passed.
            let width = if is_driven { 4 } else { 6 };
            let wall: Vec<Cell> = (-60..100).filter(|column| !(opening..opening + width).contains(column)).map(|column| (column, 20)).collect();
            let middle = opening + width / 2;
            let driven: Vec<Cell> = (10..30).flat_map(|row| [(middle - 1, row), (middle, row)]).collect();
            let floor = floor(&wall, &[], if is_driven { &driven } else { &[] });
            let (start, target) = ((60.0, 30.0), (60.0, 100.0));
            let terrain = Terrain::new(&floor, start, target).unwrap();
            let route = terrain.route(start, target).unwrap();
            let (column, _) = crossing(start, &route);
            prop_assert!((opening..opening + width).contains(&column), "{route:?}");
            prop_assert!(route.len() <= 4, "{route:?}");
            prop_assert_eq!(*route.last().unwrap(), target);
        }
    }

    /// The first point of a route behind the wall of row 20.
    fn crossing(start: Point, route: &[Point]) -> Cell {
        let mut points = along(start, route).into_iter();
        Grid::cell(points.find(|point| point.1 >= 61.5).unwrap())
    }

    #[test]
    fn narrow_opening_is_for_a_robot_that_has_passed_it() {
        let wall: Vec<Cell> = (-60..100)
            .filter(|column| !(18..22).contains(column))
            .map(|column| (column, 20))
            .collect();
        let (start, target) = ((60.0, 30.0), (60.0, 100.0));
        let route = |driven: &[Cell]| {
            let floor = floor(&wall, &[], driven);
            let terrain = Terrain::new(&floor, start, target).unwrap();
            crossing(start, &terrain.route(start, target).unwrap())
        };
        let (column, _) = route(&[]);
        assert!(!(-60..100).contains(&column), "{column}");
        let driven: Vec<Cell> = (10..30).flat_map(|row| [(19, row), (20, row)]).collect();
        let (column, _) = route(&driven);
        assert!((18..22).contains(&column), "{column}");
    }

    #[test]
    fn robot_between_obstacles_has_no_way() {
        let ring = (10..31).flat_map(|at| [(at, 10), (at, 30), (10, at), (30, at)]);
        let floor = floor(&ring.collect::<Vec<_>>(), &[], &[]);
        let (start, target) = ((60.0, 60.0), (60.0, 110.0));
        let terrain = Terrain::new(&floor, start, target).unwrap();
        assert_eq!(terrain.route(start, target), Err(Blocked::Between));
    }

    #[test]
    fn floor_that_was_never_seen_is_the_last_choice() {
        let mut floor = Floor::default();
        // A seen corridor around a corner, and unknown floor between its ends.
        for at in 0..40 {
            for across in 0..8 {
                floor.grid.add((at, across), -1.0);
                floor.grid.add((39 - across, at), -1.0);
            }
        }
        let (start, target) = ((12.0, 12.0), (106.0, 110.0));
        let terrain = Terrain::new(&floor, start, target).unwrap();
        let route = terrain.route(start, target).unwrap();
        assert!(terrain.unknown_in(start, &route) < 10.0, "{route:?}");
        assert!(terrain.unknown_in(start, &[target]) > 50.0);
    }

    #[test]
    fn blocked_target_is_approached_and_a_floor_too_large_is_refused() {
        let wall: Vec<Cell> = (-4..5)
            .flat_map(|x| (-4..5).map(move |y| (20 + x, 20 + y)))
            .collect();
        let terrain = |target| Terrain::new(&floor(&wall, &[], &[]), (10.0, 10.0), target);
        let target = Grid::center((20, 20));
        let route = terrain(target)
            .unwrap()
            .route((10.0, 10.0), target)
            .unwrap();
        let short_in = distance_in(*route.last().unwrap(), target);
        assert!(short_in > CLEAR_IN && short_in <= BESIDE_IN, "{short_in}");
        assert!(terrain((9000.0, 9000.0)).is_none());
    }
}
