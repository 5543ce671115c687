//! Worlds: TOML files with a floor plan drawn in characters. `worlds/README.md` describes the format.

mod built_in;
mod clutter;
mod dock;
mod drops;
mod error;
mod file;
mod grid;
mod ground;
mod material;
mod outline;
mod parts;
mod picture;
mod plan;
mod svg;

pub use error::WorldError;
pub use material::Material;
pub use outline::{Outline, OutlineKind, Point};

pub(crate) use built_in::BUILT_IN;
pub(crate) use dock::Dock;
pub(crate) use drops::Drops;
pub(crate) use grid::Grid;
pub(crate) use ground::{Ground, GroundKind};
pub(crate) use material::Surface;
pub(crate) use parts::{Lamp, Obstacle, Overhead, Snag, Walker};

use crate::dimensions::RADIUS_IN;
use crate::geometry::{Frame, Pose, Vec2};

/// The robot's surroundings. Lengths are in inches from the plan's south-west corner.
#[derive(Clone, Debug)]
pub struct World {
    pub(crate) name: String,
    pub(crate) about: String,
    pub(crate) start: Pose,
    pub(crate) size_in: [f64; 2],
    pub(crate) daylight_lux: f64,
    pub(crate) grid: Grid,
    pub(crate) drops: Drops,
    pub(crate) obstacles: Vec<Obstacle>,
    /// Number of obstacles that belong to the plan; they come first.
    pub(crate) plan_solids: usize,
    pub(crate) grounds: Vec<Ground>,
    pub(crate) snags: Vec<Snag>,
    pub(crate) overheads: Vec<Overhead>,
    pub(crate) outlines: Vec<Outline>,
    pub(crate) dock: Option<Dock>,
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) walkers: Vec<Walker>,
}

impl World {
    /// Name of the world.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Description of the world in a sentence.
    #[must_use]
    pub fn about(&self) -> &str {
        &self.about
    }

    /// East-west and north-south size of the plan in inches.
    #[must_use]
    pub const fn size_in(&self) -> [f64; 2] {
        self.size_in
    }

    /// Walls and furniture in the robot's coordinates: the start pose is the origin.
    #[must_use]
    pub fn outlines(&self) -> Vec<Outline> {
        let frame = self.frame();
        self.outlines
            .iter()
            .map(|outline| outline.seen_from(&frame))
            .collect()
    }

    /// Start pose, in inches from the plan's south-west corner.
    #[must_use]
    pub const fn start(&self) -> Pose {
        self.start
    }

    /// Distance in inches from a place of the plan to the nearest obstacle; negative inside one.
    #[must_use]
    pub fn clearance_in(&self, x_in: f64, y_in: f64) -> f64 {
        let place = Vec2::new(x_in, y_in);
        self.obstacles
            .iter()
            .map(|obstacle| obstacle.solid.approach(place).0)
            .fold(f64::INFINITY, f64::min)
    }

    /// Whether there is floor at a place of the plan.
    #[must_use]
    pub fn has_floor(&self, x_in: f64, y_in: f64) -> bool {
        !self.drops.has(Vec2::new(x_in, y_in))
    }

    /// Pose on the plan of a robot that faces the dock, its middle at this distance from the dock's front; `None` without
    /// a dock.
    #[must_use]
    pub fn before_dock(&self, distance_in: f64) -> Option<Pose> {
        let dock = self.dock?;
        let place = dock.front + dock.facing * distance_in;
        Some(Pose {
            x_in: place.x,
            y_in: place.y,
            theta_deg: (-dock.facing.x).atan2(-dock.facing.y).to_degrees(),
        })
    }

    /// The same world with another start pose; `None` if the robot does not fit there.
    #[must_use]
    pub fn started_at(&self, start: Pose) -> Option<Self> {
        (self.clearance_in(start.x_in, start.y_in) > RADIUS_IN).then(|| Self {
            start,
            ..self.clone()
        })
    }

    pub(crate) fn frame(&self) -> Frame {
        Frame::new(self.start)
    }
}
