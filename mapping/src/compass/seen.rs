//! What a run has seen, for maps of one run and of several.

use super::matching::Foot;
use crate::floor::Floor;
use crate::floor_map::FloorMap;
use crate::pose::Pose;
use crate::sensors::Readings;

/// Place of the house's frame in the world's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// The house's origin in the world, inches.
    pub(crate) origin_in: (f64, f64),
    /// Bearing of the house's +Y in the world, radians.
    pub(crate) house_rad: f64,
}

impl Frame {
    /// A pose in the house's frame, in the world.
    pub(crate) fn in_world(self, pose: Pose) -> Pose {
        pose.turned(-self.house_rad).moved(self.origin_in)
    }

    /// A pose in the world, in the house's frame.
    pub(crate) fn in_house(self, pose: Pose) -> Pose {
        let origin_in = (-self.origin_in.0, -self.origin_in.1);
        pose.moved(origin_in).turned(self.house_rad)
    }
}

/// What was seen, in the house's frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seen {
    /// Poses and readings, oldest first.
    pub(crate) views: Vec<(Pose, Readings)>,
    /// Feet of the walls.
    pub(crate) feet: Vec<Foot>,
    pub(crate) frame: Frame,
}

impl Seen {
    /// The floor, in the world's frame; `None` if nothing is known of it.
    pub(crate) fn floor_map(&self) -> Option<FloorMap> {
        FloorMap::new(&Floor::new(
            &self.views_at(|pose| self.frame.in_world(pose)),
        ))
    }

    /// Poses in another frame and their readings, oldest first.
    pub(crate) fn views_at(&self, place: impl Fn(Pose) -> Pose) -> Vec<(Pose, Readings)> {
        let views = self.views.iter();
        views
            .map(|(pose, readings)| (place(*pose), *readings))
            .collect()
    }
}
