//! The parts of a world: obstacles, boards, lamps and walkers.

use serde::Deserialize;

use super::material::Material;
use crate::geometry::{Solid, Vec2};

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
    /// Probability that the object catches each time the bumper passes over it.
    pub(crate) chance: f64,
}

/// A board that the robot passes below.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overhead {
    pub(crate) solid: Solid,
    /// Height of the board's underside above the floor, inches.
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

/// A person or an animal that walks a closed path repeatedly.
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

    pub(super) const fn speed_in_s(self) -> f64 {
        match self {
            Self::Person => 30.0,
            Self::Cat => 18.0,
        }
    }
}
