//! A map of a house from several runs.

use std::f64::consts::FRAC_PI_2;

use crate::compass::{Foot, Frame, NoPlace, align, thinned};
use crate::floor::Floor;
use crate::floor_map::FloorMap;
use crate::mapper::SessionMap;
use crate::pose::Pose;

/// The map of a house, in the world's frame of its first run: home of that run is the origin.
///
/// Each later run is placed as a whole by its walls. Until it is added, a run takes less than 1 MB besides its own floor map: up to
/// 8,192 feet of walls and 12,288 views. Then it costs only the cells that it adds, at most 8 MiB for each of three grids in all.
#[derive(Clone, Debug)]
pub struct HouseMap {
    frame: Frame,
    /// Walls of all runs, in the house's frame of the first.
    feet: Vec<Foot>,
    floor: Floor,
    map: FloorMap,
}

/// Place of a run on a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Bearing on the map of the run's +Y, degrees clockwise from the map's +Y, above -180 and up to 180.
    pub turn_deg: f64,
    /// X and Y on the map of the run's origin, inches.
    pub shift_in: (f64, f64),
}

impl Placement {
    /// A point of the run, on the map, inches.
    #[must_use]
    pub fn on_map(&self, (x_in, y_in): (f64, f64)) -> (f64, f64) {
        let pose = Pose {
            x_in,
            y_in,
            theta_rad: 0.0,
        };
        let pose = pose
            .turned(-self.turn_deg.to_radians())
            .moved(self.shift_in);
        (pose.x_in, pose.y_in)
    }
}

impl HouseMap {
    /// The map of one run.
    #[must_use]
    pub fn new(run: &SessionMap) -> Self {
        let seen = &run.seen;
        Self {
            frame: seen.frame,
            feet: thinned(&seen.feet),
            floor: Floor::new(&seen.views_at(|pose| seen.frame.in_world(pose))),
            map: run.map.clone(),
        }
    }

    /// Adds a run of the same house.
    ///
    /// # Errors
    /// If the run has no certain place on the map; the map is as before.
    pub fn add(&mut self, run: &SessionMap) -> Result<Placement, NoPlace> {
        let seen = &run.seen;
        let feet = thinned(&seen.feet);
        let alignment = align(&self.feet, &feet)?;
        let turn_rad = alignment.quarters as f64 * FRAC_PI_2;
        let placed = |pose: Pose| {
            let in_house = pose.turned(-turn_rad).moved(alignment.shift_in);
            self.frame.in_world(in_house)
        };
        let (views, origin) = (
            seen.views_at(placed),
            placed(seen.frame.in_house(Pose::default())),
        );
        self.floor.add(&views);
        self.feet
            .extend(feet.iter().map(|foot| alignment.foot(foot)));
        self.feet = thinned(&self.feet);
        if let Some(map) = FloorMap::new(&self.floor) {
            self.map = map;
        }
        Ok(Placement {
            turn_deg: 180.0 - (180.0 - origin.theta_rad.to_degrees()).rem_euclid(360.0),
            shift_in: (origin.x_in, origin.y_in),
        })
    }

    /// The floor that the runs saw.
    #[must_use]
    pub const fn floor_map(&self) -> &FloorMap {
        &self.map
    }
}
