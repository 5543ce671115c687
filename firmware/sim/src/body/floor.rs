//! What the floor does to the robot where it stands: sills, carpets and inclines.

use super::motor::{self, IN_PER_M};
use crate::geometry::Vec2;
use crate::scene::Scene;
use crate::world::GroundKind;

/// What holds a wheel back on a sill and on a carpet, as a share of a stalled motor's force.
const SILL_SHARE: f64 = 0.2;
const CARPET_SHARE: f64 = 0.06;
/// Share of the way that wheels lose on a carpet.
const CARPET_CREEP: f64 = 0.02;
/// In in/s^2.
pub(super) const GRAVITY: f64 = 9.81 * IN_PER_M;

/// The floor under both wheels and the centre.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Underfoot {
    /// Friction beside the wheels' own, left and right.
    pub(super) friction: (f64, f64),
    /// Acceleration in the plan.
    pub(super) downhill: Vec2,
    /// Share of the way that the wheels lose.
    pub(super) creep: f64,
}

impl Underfoot {
    /// Of a robot whose right wheel stands at `axle` from its centre.
    pub(super) fn at(scene: &Scene, center: Vec2, axle: Vec2) -> Self {
        let mut floor = Self::default();
        for ground in &scene.grounds {
            let share = match ground.kind {
                GroundKind::Sill => SILL_SHARE,
                GroundKind::Carpet => CARPET_SHARE,
                GroundKind::Ramp => 0.0,
            };
            let friction = motor::load_friction(share);
            let under = |wheel| if ground.has(wheel) { friction } else { 0.0 };
            floor.friction.0 += under(center - axle);
            floor.friction.1 += under(center + axle);
            if ground.has(center) {
                floor.downhill -= ground.slope * GRAVITY;
                if ground.kind == GroundKind::Carpet {
                    floor.creep = CARPET_CREEP;
                }
            }
        }
        floor
    }
}
