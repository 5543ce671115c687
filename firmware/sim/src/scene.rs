//! Solid objects that rays and bodies hit: fixed obstacles and walkers.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy};
use parry2d_f64::query::Ray;

use crate::geometry::{Solid, Vec2};
use crate::walker::MovingWalker;
use crate::world::{Dock, Drops, Ground, Material, Obstacle, Overhead, Snag, Surface, World};

/// The point at which a ray hits a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) distance_in: f64,
    /// Outward normal, against the ray.
    pub(crate) normal: Vec2,
    pub(crate) material: Material,
    pub(crate) is_round: bool,
}

/// A solid near a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Near {
    /// Distance from the point to the boundary, negative inside, inches.
    pub(crate) distance_in: f64,
    /// Unit direction to the solid.
    pub(crate) toward: Vec2,
    pub(crate) material: Material,
    /// Radius if the solid is round, inches.
    pub(crate) radius_in: Option<f64>,
}

/// All solid objects, and the places without floor.
pub(crate) struct Scene {
    pub(crate) drops: Drops,
    pub(crate) dock: Option<Dock>,
    pub(crate) grounds: Vec<Ground>,
    pub(crate) snags: Vec<Snag>,
    overheads: Vec<Overhead>,
    obstacles: Vec<Obstacle>,
    tree: Bvh,
    pub(crate) walkers: Vec<MovingWalker>,
}

impl Scene {
    pub(crate) fn new(world: &World) -> Self {
        let bounds: Vec<Aabb> = world
            .obstacles
            .iter()
            .map(|obstacle| obstacle.solid.bounds())
            .collect();
        Self {
            drops: world.drops.clone(),
            dock: world.dock,
            grounds: world.grounds.clone(),
            snags: world.snags.clone(),
            overheads: world.overheads.clone(),
            obstacles: world.obstacles.clone(),
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &bounds),
            walkers: world
                .walkers
                .iter()
                .cloned()
                .map(MovingWalker::new)
                .collect(),
        }
    }

    /// First solid along a ray of unit direction whose surface satisfies `meets`.
    pub(crate) fn cast(
        &self,
        origin: Vec2,
        direction: Vec2,
        max_in: f64,
        meets: fn(&Surface) -> bool,
    ) -> Option<Hit> {
        let ray = Ray::new(origin, direction);
        let still = self.tree.cast_ray(&ray, max_in, |index, best_in| {
            let obstacle = self.obstacle(index)?;
            if meets(&obstacle.material.surface()) {
                obstacle.solid.cast(&ray, best_in)
            } else {
                None
            }
        });
        let mut first =
            still.and_then(|(index, distance)| Some((distance, *self.obstacle(index)?)));
        if meets(&Material::Alive.surface()) {
            for walker in &self.walkers {
                let limit = first.map_or(max_in, |(distance, _)| distance);
                if let Some(distance) = walker.solid().cast(&ray, limit) {
                    first = Some((distance, walker.as_obstacle()));
                }
            }
        }
        let (distance_in, obstacle) = first?;
        Some(Hit {
            distance_in,
            normal: obstacle.solid.normal(&ray, max_in).unwrap_or(-direction),
            material: obstacle.material,
            is_round: matches!(obstacle.solid, Solid::Round { .. }),
        })
    }

    /// Whether no shading object stands between two points.
    pub(crate) fn is_lit(&self, from: Vec2, to: Vec2) -> bool {
        let offset = to - from;
        let length = offset.length();
        length < 1e-6
            || self
                .cast(from, offset / length, length, |surface| surface.shades)
                .is_none()
    }

    /// Height in inches of the lowest board above a point of the floor; infinite without one.
    pub(crate) fn headroom_in(&self, point: Vec2) -> f64 {
        let above = self.overheads.iter();
        above
            .filter(|overhead| overhead.solid.approach(point).0 <= 0.0)
            .map(|overhead| overhead.height_in)
            .fold(f64::INFINITY, f64::min)
    }

    /// Calls `found` with every solid whose boundary lies within `reach_in` of a point.
    pub(crate) fn near(&self, point: Vec2, reach_in: f64, mut found: impl FnMut(Near)) {
        let square = Aabb::from_half_extents(point, Vec2::splat(reach_in));
        for index in self.tree.intersect_aabb(&square) {
            let Some(obstacle) = self.obstacle(index) else {
                continue;
            };
            report(obstacle, point, reach_in, &mut found);
        }
        for walker in &self.walkers {
            report(&walker.as_obstacle(), point, reach_in, &mut found);
        }
    }

    fn obstacle(&self, index: u32) -> Option<&Obstacle> {
        self.obstacles.get(index as usize)
    }
}

fn report(obstacle: &Obstacle, point: Vec2, reach_in: f64, found: &mut impl FnMut(Near)) {
    let (distance_in, toward) = obstacle.solid.approach(point);
    if distance_in < reach_in {
        found(Near {
            distance_in,
            toward,
            material: obstacle.material,
            radius_in: match obstacle.solid {
                Solid::Round { radius_in, .. } => Some(radius_in),
                Solid::Block { .. } => None,
            },
        });
    }
}
