//! Inverse sensor models: the evidence of a reading for the cells around it.

pub(crate) mod body;
pub(crate) mod infrared;
pub(crate) mod sonar;

use groundwave_protocol::status_codes::{Bump, Cliff, Infrared, Layer, LayerState};
use groundwave_protocol::telemetry::StateLine;

use crate::grid::{CELL_IN, Cell, Grid, floor};
use crate::pose::Pose;

/// Value of a range without an echo. Longer ranges are kept as the next smaller one: no model looks so far.
const NO_ECHO: u8 = u8::MAX;

/// What a line A says of the obstacles around the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Readings {
    sonars_in: [u8; 2],
    wheels_in_s: (i8, i8),
    infrared: infrared::Sides,
    bump: Bump,
    pub(crate) cliff: Cliff,
}

impl Readings {
    pub(crate) fn of(state: &StateLine) -> Self {
        let kept_in = |range_in: Option<u16>| {
            range_in.map_or(NO_ECHO, |it| it.min(u16::from(NO_ECHO) - 1) as u8)
        };
        Self {
            sonars_in: [state.sonar_left_in, state.sonar_right_in].map(kept_in),
            wheels_in_s: (state.wheel_left_in_s, state.wheel_right_in_s),
            infrared: detections(state),
            bump: state.bump,
            cliff: state.cliff,
        }
    }

    /// Adds the obstacles that were read from a pose to a map.
    pub(crate) fn update(self, grid: &mut Grid, pose: Pose) {
        let pinged_at = sonar::pinged_at(pose, self.wheels_in_s);
        let sides = [sonar::Side::Left, sonar::Side::Right];
        for (side, range_in) in sides.into_iter().zip(self.sonars_in) {
            if range_in != NO_ECHO {
                sonar::update(grid, pinged_at, side, f64::from(range_in));
            }
        }
        infrared::update(grid, pose, self.infrared);
        body::update_outline(grid, pose);
        body::update_contact(grid, pose, self.bump);
    }
}

/// The detectors' states; those of a layer that is off are known only while they fire.
fn detections(state: &StateLine) -> infrared::Sides {
    let is_on = state.layers.get(Layer::Infrared) != LayerState::Off;
    let side = |fired: Infrared| {
        let fires = state.infrared == fired || state.infrared == Infrared::Both;
        (is_on || fires).then_some(fires)
    };
    match state.infrared {
        Infrared::Jammed | Infrared::NotFitted => (None, None),
        _ => (side(Infrared::Left), side(Infrared::Right)),
    }
}

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
