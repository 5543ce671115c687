//! Effect of the floor on the robot: sills, carpets and inclines.

use super::motor::{self, IN_PER_M};
use crate::geometry::Vec2;
use crate::scene::Scene;
use crate::world::GroundKind;

/// Drag of a sill and of a carpet on a wheel, as a share of a stalled motor's force.
const SILL_SHARE: f64 = 0.2;
const CARPET_SHARE: f64 = 0.06;
/// Share of the distance that wheels lose on a carpet.
const CARPET_CREEP: f64 = 0.02;
/// Gravity, in/s^2.
pub(super) const GRAVITY: f64 = 9.81 * IN_PER_M;

/// Effect of the floor below both wheels and the centre.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct FloorEffect {
    /// Extra friction of the left and right wheel.
    pub(super) friction: (f64, f64),
    /// Downhill acceleration in the plan.
    pub(super) downhill: Vec2,
    /// Share of the distance that the wheels lose.
    pub(super) creep: f64,
}

impl FloorEffect {
    /// The effect on a robot whose right wheel is at `axle` from its centre.
    pub(super) fn at(scene: &Scene, center: Vec2, axle: Vec2) -> Self {
        let mut effect = Self::default();
        for ground in &scene.grounds {
            let share = match ground.kind {
                GroundKind::Sill => SILL_SHARE,
                GroundKind::Carpet => CARPET_SHARE,
                GroundKind::Ramp => 0.0,
            };
            let friction = motor::load_friction(share);
            let under = |wheel| if ground.has(wheel) { friction } else { 0.0 };
            effect.friction.0 += under(center - axle);
            effect.friction.1 += under(center + axle);
            if ground.has(center) {
                effect.downhill -= ground.slope * GRAVITY;
                if ground.kind == GroundKind::Carpet {
                    effect.creep = CARPET_CREEP;
                }
            }
        }
        effect
    }
}
