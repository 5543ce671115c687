//! Warnings about a valid world: places, lamps, walkers and docks that the robot cannot reach.

use crate::dimensions::RADIUS_IN;
use crate::geometry::Vec2;
use crate::scene::Scene;
use crate::world::World;

/// Clearance in inches that the robot needs on each side.
const MARGIN_IN: f64 = 0.25;
/// Minimum area in square feet of an unreachable place that is worth a warning.
const AREA_LEAST_FT2: f64 = 4.0;
/// Distance within which a lamp or a walker counts as reachable, inches.
const NEAR_IN: f64 = 36.0;

/// The cells where the robot's centre can be, grouped into connected areas.
struct Areas {
    /// Area number of each cell; `None` where the robot does not fit.
    of: Vec<Option<usize>>,
    /// Number of cells and first cell of each area. The area with the start comes first.
    sizes: Vec<(usize, (usize, usize))>,
}

impl World {
    /// Warnings about areas, lamps, walkers and a dock that the robot cannot reach. Each starts with
    /// `file:line:column:` of its place in the plan; `file` is the name of the world in messages.
    #[must_use]
    pub fn warnings(&self, file: &str) -> Vec<String> {
        let areas = self.areas();
        let at = |(row, column): (usize, usize)| {
            format!("{file}:{}:{}", self.grid.first_line + row, column + 1)
        };
        let cell_ft2 = self.grid.layout.cell_in * self.grid.layout.cell_in / 144.0;
        let mut warnings = Vec::new();
        for &(cells, first) in areas.sizes.iter().skip(1) {
            let area_ft2 = cells as f64 * cell_ft2;
            if area_ft2 >= AREA_LEAST_FT2 {
                warnings.push(format!(
                    "{}: the robot cannot reach the {area_ft2:.0} square feet that begin here: \
                     widen the doorway or open a wall",
                    at(first)
                ));
            }
        }
        let mut warn = |problem: String, place: Vec2| {
            let cell = self.grid.layout.cell_at(place).unwrap_or_default();
            warnings.push(format!("{}: {problem}", at(cell)));
        };
        for lamp in &self.lamps {
            if !self.is_reachable(&areas, lamp.center, NEAR_IN) {
                let problem = format!(
                    "lamp {:?} is more than {NEAR_IN} inches from every place the robot can reach",
                    lamp.name
                );
                warn(problem, lamp.center);
            }
        }
        for walker in &self.walkers {
            if !walker
                .path
                .iter()
                .any(|&place| self.is_reachable(&areas, place, NEAR_IN))
            {
                let problem = "the robot cannot reach this walker's path".to_owned();
                warn(problem, walker.path.first().copied().unwrap_or_default());
            }
        }
        if let Some(dock) = &self.dock {
            let before = dock.front + dock.facing * (RADIUS_IN + self.grid.layout.cell_in);
            if !self.is_reachable(&areas, before, self.grid.layout.cell_in) {
                warn(
                    "the robot cannot reach the dock's front".to_owned(),
                    dock.front,
                );
            }
        }
        warnings
    }

    /// Share of the floor area that the robot can reach from its start, 0 to 1.
    #[must_use]
    pub fn reach(&self) -> f64 {
        let areas = self.areas();
        let all: usize = areas.sizes.iter().map(|(cells, _)| cells).sum();
        areas
            .sizes
            .first()
            .map_or(0.0, |(cells, _)| *cells as f64 / all as f64)
    }

    fn areas(&self) -> Areas {
        let (rows, columns) = (self.grid.layout.rows, self.grid.layout.columns);
        let scene = Scene::new(self);
        let fits = |point: Vec2| {
            let mut is_free = true;
            scene.near(point, RADIUS_IN + MARGIN_IN, |_| is_free = false);
            is_free && !scene.drops.has(point)
        };
        let is_floor = |row: usize, column: usize| {
            matches!(
                self.grid.glyph(row, column),
                '.' | '^' | '>' | 'v' | '<' | 'A'..='Z'
            )
        };
        let free: Vec<bool> = (0..rows * columns)
            .map(|index| {
                let (row, column) = (index / columns, index % columns);
                is_floor(row, column) && fits(self.grid.layout.center(row, column))
            })
            .collect();
        let mut areas = Areas {
            of: vec![None; rows * columns],
            sizes: Vec::new(),
        };
        let start = self
            .grid
            .layout
            .cell_at(Vec2::new(self.start.x_in, self.start.y_in));
        let cells = (0..rows * columns).map(|index| (index / columns, index % columns));
        for first in start.into_iter().chain(cells) {
            let number = areas.sizes.len();
            let mut open = vec![first];
            let mut count = 0;
            while let Some((row, column)) = open.pop() {
                let index = row * columns + column;
                if !free[index] || areas.of[index].is_some() {
                    continue;
                }
                areas.of[index] = Some(number);
                count += 1;
                // The border of a plan is never free, so a free cell has four neighbours.
                let center = self.grid.layout.center(row, column);
                for next in [
                    (row - 1, column),
                    (row + 1, column),
                    (row, column - 1),
                    (row, column + 1),
                ] {
                    if fits(center.midpoint(self.grid.layout.center(next.0, next.1))) {
                        open.push(next);
                    }
                }
            }
            if count > 0 {
                areas.sizes.push((count, first));
            }
        }
        areas
    }

    /// Whether the robot can get within `reach_in` of a place.
    fn is_reachable(&self, areas: &Areas, place: Vec2, reach_in: f64) -> bool {
        areas.of.iter().enumerate().any(|(index, area)| {
            let center = self.grid.layout.center(
                index / self.grid.layout.columns,
                index % self.grid.layout.columns,
            );
            *area == Some(0) && center.distance(place) <= reach_in
        })
    }
}
