//! Worlds: TOML files with a floor plan drawn in characters. `worlds/README.md` describes the format.

mod check;
mod clutter;
mod dock;
mod drops;
mod error;
mod file;
mod generate;
mod grid;
mod ground;
mod material;
mod outline;
mod picture;
mod plan;
mod svg;

use std::path::Path;

use serde::Deserialize;

pub use error::WorldError;
pub use material::Material;
pub use outline::{Outline, OutlineKind, Point};

pub(crate) use dock::Dock;
pub(crate) use drops::Drops;
pub(crate) use grid::Grid;
pub(crate) use ground::{Ground, GroundKind};
pub(crate) use material::Surface;

use crate::geometry::{Frame, Pose, Solid, Vec2};

/// Names and texts of the built-in worlds.
const BUILT_IN: &[(&str, &str)] = &[
    ("house", include_str!("../../worlds/house.toml")),
    ("living-room", include_str!("../../worlds/living-room.toml")),
    ("corridor", include_str!("../../worlds/corridor.toml")),
    ("open-room", include_str!("../../worlds/open-room.toml")),
    ("stairs", include_str!("../../worlds/stairs.toml")),
    ("flat", include_str!("../../worlds/flat.toml")),
    ("office", include_str!("../../worlds/office.toml")),
    ("dark-room", include_str!("../../worlds/dark-room.toml")),
];

const BUILT_IN_NAMES: &str =
    "house, living-room, corridor, open-room, stairs, flat, office and dark-room";

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

/// A fixed obstacle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacle {
    pub(crate) solid: Solid,
    pub(crate) material: Material,
}

/// An object that may catch on the bumper.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Snag {
    pub(crate) solid: Solid,
    /// Probability that it catches each time the bumper passes over it.
    pub(crate) chance: f64,
}

/// A board that the robot passes below.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overhead {
    pub(crate) solid: Solid,
    /// Height of its underside above the floor.
    pub(crate) height_in: f64,
}

/// A lamp.
#[derive(Clone, Debug)]
pub(crate) struct Lamp {
    pub(crate) name: String,
    pub(crate) center: Vec2,
    pub(crate) candela: f64,
    pub(crate) height_in: f64,
    pub(crate) on: bool,
}

/// A person or an animal that walks a closed path over and over.
#[derive(Clone, Debug)]
pub(crate) struct Walker {
    pub(crate) kind: WalkerKind,
    pub(crate) path: Vec<Vec2>,
    pub(crate) speed_in_s: f64,
    pub(crate) pause_s: f64,
}

/// Kinds of walkers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum WalkerKind {
    Person,
    Cat,
}

impl WalkerKind {
    pub(crate) const fn radius_in(self) -> f64 {
        match self {
            Self::Person => 6.0,
            Self::Cat => 3.5,
        }
    }

    const fn speed_in_s(self) -> f64 {
        match self {
            Self::Person => 30.0,
            Self::Cat => 18.0,
        }
    }
}

impl World {
    /// Names of the built-in worlds, the default first.
    pub fn built_in_names() -> impl Iterator<Item = &'static str> {
        BUILT_IN.iter().map(|(name, _)| *name)
    }

    /// A built-in world; `None` if none has this name.
    #[must_use]
    pub fn built_in(name: &str) -> Option<Self> {
        Self::parse(name, built_in_text(name)?).ok()
    }

    /// Opens a built-in world by name, a generated house as `generated:SEED`, or a world file by path.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, or has an error.
    pub fn open(name_or_path: &str) -> Result<Self, WorldError> {
        Self::parse(name_or_path, &Self::source(name_or_path)?)
    }

    /// The text of a world that [`World::open`] would open, even with errors in it.
    ///
    /// # Errors
    ///
    /// When the file cannot be read.
    pub fn source(name_or_path: &str) -> Result<String, WorldError> {
        if let Some(text) = built_in_text(name_or_path) {
            return Ok(text.to_owned());
        }
        let seed = name_or_path.strip_prefix("generated:");
        if let Some(seed) = seed.and_then(|seed| seed.parse().ok()) {
            return Ok(Self::generated_text(seed));
        }
        let path = Path::new(name_or_path);
        std::fs::read_to_string(path).map_err(|source| WorldError::Read {
            path: path.to_owned(),
            source,
        })
    }

    /// Parses the text of a world; error messages name `file`.
    ///
    /// # Errors
    ///
    /// The first error in the text, with file, line, column and remedy.
    pub fn parse(file: &str, text: &str) -> Result<Self, WorldError> {
        file::parse(file, text)
    }

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

    /// The same world with another start pose; `None` if the robot does not fit there.
    #[must_use]
    pub fn started_at(&self, start: Pose) -> Option<Self> {
        (self.clearance_in(start.x_in, start.y_in) > crate::body::RADIUS_IN).then(|| Self {
            start,
            ..self.clone()
        })
    }

    pub(crate) fn frame(&self) -> Frame {
        Frame::new(self.start)
    }
}

fn built_in_text(name: &str) -> Option<&'static str> {
    let (_, text) = BUILT_IN.iter().find(|(known, _)| *known == name)?;
    Some(text)
}

impl Default for World {
    /// The house.
    fn default() -> Self {
        // A test parses every built-in world.
        Self::built_in(BUILT_IN[0].0).expect("the built-in house is a valid world")
    }
}
