//! The map of the floor that the robot has driven on last.

use std::collections::{BTreeSet, VecDeque};
use std::fmt;
use std::sync::{Arc, OnceLock};

use groundwave_protocol::telemetry::StateLine;

use crate::grid::{CELL_IN, Cell, Grid, OBSTACLE};
use crate::pose::Pose;
use crate::sensors::Readings;

/// Distance driven after which a reading is forgotten, inches. Wheels that differ by 0.4 % turn the odometer by 7 degrees
/// over it.
const WINDOW_IN: f64 = 300.0;

/// Greatest number of readings, for a robot that turns on the spot.
const READINGS_MAX: usize = 512;

/// Movement after which readings are new: those of a robot that stands repeat themselves.
const MOVED_IN: f64 = 1.5;
const TURNED_DEG: u16 = 4;

/// Distance between two lines that no robot drives, inches.
const JUMP_IN: f64 = 60.0;

/// A line A and the distance driven up to it.
#[derive(Clone, Copy, Debug)]
struct Reading {
    state: StateLine,
    path_in: f64,
}

/// An occupancy map around the robot, in the odometer's frame.
///
/// Dead reckoning is good over a short distance, so readings that are close together in distance driven fit each other,
/// and older ones do not. The map holds those of the last 300 inches: the rolling window that navigation stacks call a
/// local map. Taking a line is cheap; the map is made when it is looked at.
#[derive(Clone, Default)]
pub struct LocalMap {
    readings: VecDeque<Reading>,
    grid: OnceLock<Arc<Grid>>,
}

/// The readings are all that a map knows: whether it was looked at makes no difference.
impl fmt::Debug for LocalMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_list().entries(&self.readings).finish()
    }
}

impl LocalMap {
    /// Takes a line A.
    pub fn take(&mut self, state: &StateLine) {
        let mut path_in = 0.0;
        if let Some(last) = self.readings.back() {
            let moved_in = pose_of(state).distance_in(pose_of(&last.state));
            let turned_deg = (state.theta_deg + 360 - last.state.theta_deg) % 360;
            if self.jumps(state) {
                self.readings.clear();
            } else if moved_in < MOVED_IN && turned_deg.min(360 - turned_deg) < TURNED_DEG {
                return;
            } else {
                path_in = last.path_in + moved_in;
            }
        }
        let state = *state;
        self.readings.push_back(Reading { state, path_in });
        while self.readings.len() > READINGS_MAX
            || self
                .readings
                .front()
                .is_some_and(|first| path_in - first.path_in > WINDOW_IN)
        {
            self.readings.pop_front();
        }
        self.grid = OnceLock::new();
    }

    /// Whether no robot drives from the last line to this one.
    fn jumps(&self, state: &StateLine) -> bool {
        let last = self.readings.back();
        last.is_some_and(|last| pose_of(state).distance_in(pose_of(&last.state)) > JUMP_IN)
    }

    fn grid(&self) -> &Grid {
        self.grid.get_or_init(|| {
            let mut grid = Grid::default();
            for reading in &self.readings {
                let pose = pose_of(&reading.state);
                Readings::of(&reading.state).update(&mut grid, pose);
            }
            Arc::new(grid)
        })
    }

    /// The lower left and upper right corners of the cells that hold an obstacle, inches.
    pub fn obstacles(&self) -> impl Iterator<Item = [(f64, f64); 2]> {
        self.held().map(|cell| corners(cell, cell))
    }

    fn held(&self) -> impl Iterator<Item = Cell> {
        let cells = self.grid().cells();
        let held = cells.filter(|(_, log_odds)| *log_odds > OBSTACLE);
        held.map(|(cell, _)| cell)
    }
}

/// The obstacles along a whole drive, where the odometer believed them: those of the local map every 150 inches.
#[derive(Clone, Debug, Default)]
pub struct DriveMap {
    local: LocalMap,
    /// Path of the local map when its obstacles were taken last, inches.
    taken_at_in: f64,
    /// Row and column of each cell that held an obstacle.
    held: BTreeSet<(i32, i32)>,
}

impl DriveMap {
    /// Takes a line A.
    pub fn take(&mut self, state: &StateLine) {
        if self.local.jumps(state) {
            self.take_obstacles();
            self.taken_at_in = 0.0;
        }
        self.local.take(state);
        let path_in = self.local.readings.back().map_or(0.0, |last| last.path_in);
        if path_in - self.taken_at_in >= WINDOW_IN / 2.0 {
            self.taken_at_in = path_in;
            self.take_obstacles();
        }
    }

    fn take_obstacles(&mut self) {
        let cells = self.local.held().map(|(column, row)| (row, column));
        self.held.extend(cells);
    }

    /// The lower left and upper right corners of rows of cells that hold an obstacle, inches.
    #[must_use]
    pub fn into_obstacles(mut self) -> Vec<[(f64, f64); 2]> {
        self.take_obstacles();
        let cells: Vec<(i32, i32)> = self.held.into_iter().collect();
        let rows = cells.chunk_by(|a, b| a.0 == b.0 && a.1 + 1 == b.1);
        let ends = rows.filter_map(|row| row.first().zip(row.last()));
        ends.map(|((row, first), (_, last))| corners((*first, *row), (*last, *row)))
            .collect()
    }
}

/// The lower left corner of a cell and the upper right corner of another, inches.
fn corners(first: Cell, last: Cell) -> [(f64, f64); 2] {
    let place = |(column, row): Cell| (f64::from(column) * CELL_IN, f64::from(row) * CELL_IN);
    [place(first), place((last.0 + 1, last.1 + 1))]
}

/// The pose that a line reports.
fn pose_of(state: &StateLine) -> Pose {
    Pose {
        x_in: f64::from(state.x_tenths_in) / 10.0,
        y_in: f64::from(state.y_tenths_in) / 10.0,
        theta_rad: f64::from(state.theta_deg).to_radians(),
    }
}
