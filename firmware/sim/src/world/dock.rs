//! The charging dock.

use super::material::Material;
use super::parts::Obstacle;
use crate::dimensions::RADIUS_IN;
use crate::geometry::{Solid, Vec2, clockwise, heading, wrap_deg};

/// Size of the plate, inches.
const WIDTH_IN: f64 = 10.0;
const DEPTH_IN: f64 = 3.0;
/// Distance that the spring contacts reach ahead of the plate, inches.
const SPRING_IN: f64 = 0.5;
/// Maximum offset and angle of the robot's nose at which the contacts meet.
const ASIDE_IN: f64 = 2.0;
const TURNED_DEG: f64 = 20.0;

/// A charging dock that stands on the floor and faces the room.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dock {
    /// Middle of the front.
    pub(crate) front: Vec2,
    /// Unit direction that the front faces.
    pub(crate) facing: Vec2,
    facing_deg: f64,
}

impl Dock {
    pub(super) fn new(front: Vec2, facing_deg: f64) -> Self {
        Self {
            front,
            facing: heading(facing_deg.to_radians()),
            facing_deg,
        }
    }

    pub(super) fn obstacle(&self) -> Obstacle {
        let middle = self.front - self.facing * (DEPTH_IN / 2.0);
        Obstacle {
            solid: Solid::block(middle, Vec2::new(WIDTH_IN, DEPTH_IN), self.facing_deg),
            material: Material::Dock,
        }
    }

    /// Whether a robot at this pose has the charger connected.
    pub(crate) fn holds(&self, center: Vec2, theta_rad: f64) -> bool {
        let nose = center + heading(theta_rad) * RADIUS_IN - self.front;
        let turned_deg = wrap_deg(theta_rad.to_degrees() - self.facing_deg - 180.0);
        nose.dot(self.facing) <= SPRING_IN
            && nose.dot(self.facing) > -DEPTH_IN
            && nose.dot(clockwise(self.facing)).abs() <= ASIDE_IN
            && turned_deg.abs() <= TURNED_DEG
    }
}
