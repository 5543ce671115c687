//! Inverse sensor models: the evidence of a reading for the cells around it.

pub(crate) mod body;
pub(crate) mod infrared;
pub(crate) mod sonar;

use crate::grid::{CELL_IN, Cell, floor};

/// A ray over the grid, in cells.
#[derive(Clone, Copy, Debug)]
struct Ray {
    from: (f64, f64),
    /// Cells per inch along the ray.
    toward: (f64, f64),
}

impl Ray {
    /// A ray from a point at a bearing clockwise from +Y.
    fn new(from: (f64, f64), bearing_rad: f64) -> Self {
        let (sin, cos) = libm::sincos(bearing_rad);
        Self {
            from: (from.0 / CELL_IN, from.1 / CELL_IN),
            toward: (sin / CELL_IN, cos / CELL_IN),
        }
    }

    /// The cell at a distance.
    fn cell(&self, distance_in: f64) -> Cell {
        (
            floor(self.from.0 + self.toward.0 * distance_in),
            floor(self.from.1 + self.toward.1 * distance_in),
        )
    }

    /// Distances one cell apart, from half a cell up to a limit.
    fn steps(limit_in: f64) -> impl Iterator<Item = f64> {
        let steps = (limit_in / CELL_IN).max(0.0) as u32;
        (0..steps).map(|step| (f64::from(step) + 0.5) * CELL_IN)
    }
}
