//! Things that stand about, made of simple solids.

use serde::Deserialize;

use super::Obstacle;
use super::material::Material;
use crate::geometry::{Solid, Vec2, heading};

/// A kind of thing.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ClutterKind {
    /// One round leg or post.
    Leg,
    /// A box on the floor.
    Box,
    /// Four legs under a seat.
    Chair,
    /// Four legs under a top that the robot passes beneath.
    Table,
    /// A post on five spokes with casters.
    OfficeChair,
}

/// One thing as its file describes it.
pub(super) struct Spec {
    pub(super) kind: ClutterKind,
    pub(super) center: Vec2,
    pub(super) size: Option<Vec2>,
    pub(super) radius_in: Option<f64>,
    pub(super) turned_deg: f64,
    pub(super) material: Option<Material>,
}

const CHAIR_IN: Vec2 = Vec2::new(15.0, 15.0);
const SPOKES: u32 = 5;
const SPOKE_IN: f64 = 12.0;
const CASTER_RADIUS_IN: f64 = 1.2;

/// The solids of a thing, or what its file left out.
pub(super) fn parts(spec: &Spec) -> Result<Vec<Obstacle>, String> {
    if spec
        .radius_in
        .is_some_and(|radius| !(0.1..=100.0).contains(&radius))
    {
        return Err("radius_in lies between 0.1 and 100 inches".to_owned());
    }
    if spec
        .size
        .is_some_and(|size| !(size.min_element() >= 0.1 && size.max_element() <= 1000.0))
    {
        return Err("each number of size_in lies between 0.1 and 1000 inches".to_owned());
    }
    match spec.kind {
        ClutterKind::Leg => Ok(vec![spec.leg(Vec2::ZERO)]),
        ClutterKind::Box => {
            let size = spec.size.ok_or("a box needs size_in = [width, depth]")?;
            Ok(vec![Obstacle {
                solid: Solid::block(spec.center, size, spec.turned_deg),
                material: spec.material.unwrap_or(Material::Wood),
            }])
        }
        ClutterKind::Chair => Ok(spec.four_legs(spec.size.unwrap_or(CHAIR_IN))),
        ClutterKind::Table => {
            let size = spec
                .size
                .ok_or("a table needs size_in = [width, depth] between its legs")?;
            Ok(spec.four_legs(size))
        }
        ClutterKind::OfficeChair => Ok(spec.office_chair()),
    }
}

impl Spec {
    /// A leg at an offset in the thing's own axes.
    fn leg(&self, offset: Vec2) -> Obstacle {
        let ahead = heading(self.turned_deg.to_radians());
        let right = Vec2::new(ahead.y, -ahead.x);
        let center = self.center + right * offset.x + ahead * offset.y;
        Obstacle {
            solid: Solid::round(center, self.radius_in.unwrap_or(1.0)),
            material: self.material.unwrap_or(Material::Leg),
        }
    }

    fn four_legs(&self, size: Vec2) -> Vec<Obstacle> {
        let half = size * 0.5;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| self.leg(Vec2::new(x * half.x, y * half.y)))
            .into()
    }

    fn office_chair(&self) -> Vec<Obstacle> {
        let mut parts = vec![Obstacle {
            solid: Solid::round(self.center, 1.5),
            material: Material::DarkLeg,
        }];
        for spoke in 0..SPOKES {
            let angle_deg = self.turned_deg + f64::from(spoke) * 360.0 / f64::from(SPOKES);
            let outward = heading(angle_deg.to_radians());
            let middle = self.center + outward * (SPOKE_IN / 2.0);
            parts.push(Obstacle {
                solid: Solid::block(middle, Vec2::new(1.5, SPOKE_IN), angle_deg),
                material: Material::Low,
            });
            parts.push(Obstacle {
                solid: Solid::round(self.center + outward * SPOKE_IN, CASTER_RADIUS_IN),
                material: Material::DarkLeg,
            });
        }
        parts
    }
}
