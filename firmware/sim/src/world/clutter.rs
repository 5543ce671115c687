//! Furniture and objects made of simple solids.

use serde::Deserialize;

use super::material::Material;
use super::parts::{Obstacle, Overhead, Snag};
use crate::geometry::{Solid, Vec2, clockwise, heading};

/// Kinds of objects.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ClutterKind {
    /// A round leg or post.
    Leg,
    /// A box on the floor.
    Box,
    /// Four legs under a seat.
    Chair,
    /// Four legs under a top that the robot can pass below.
    Table,
    /// A table low enough to stop the raised arm.
    LowTable,
    /// A board without legs that the robot can pass below.
    Shelf,
    /// A post on five spokes with casters.
    OfficeChair,
    /// A cord on the floor: the robot drives over it, and it may catch on the bumper.
    Cord,
    /// A shoe, which may catch on the bumper.
    Shoe,
    /// The feet of a sitting person: two legs, and toes that only the bumper detects.
    Feet,
}

/// An object as described in its file.
pub(super) struct Spec {
    pub(super) kind: ClutterKind,
    pub(super) center: Vec2,
    pub(super) size: Option<Vec2>,
    pub(super) radius_in: Option<f64>,
    pub(super) height_in: Option<f64>,
    pub(super) turned_deg: f64,
    pub(super) material: Option<Material>,
}

const CHAIR_IN: Vec2 = Vec2::new(15.0, 15.0);
const CHAIR_SEAT_IN: f64 = 17.0;
const TABLE_TOP_IN: f64 = 28.0;
const LOW_TABLE_TOP_IN: f64 = 14.0;
const SHELF_IN: f64 = 12.0;
const CORD_IN: f64 = 48.0;
const CORD_HOOKS: f64 = 0.25;
const SHOE_IN: Vec2 = Vec2::new(4.0, 11.0);
const SHOE_HOOKS: f64 = 0.15;
/// Legs and shoes of a sitting person: distance apart, radius and size.
const STANCE_IN: f64 = 9.0;
const SHIN_RADIUS_IN: f64 = 2.2;
const TOES_IN: Vec2 = Vec2::new(3.6, 8.0);
const SPOKES: u32 = 5;
const SPOKE_IN: f64 = 12.0;
const CASTER_RADIUS_IN: f64 = 1.2;

/// The parts of an object.
#[derive(Default)]
pub(super) struct Parts {
    pub(super) obstacles: Vec<Obstacle>,
    pub(super) overhead: Option<Overhead>,
    pub(super) snag: Option<Snag>,
}

/// The parts of an object, or the problem with its description.
pub(super) fn parts(spec: &Spec) -> Result<Parts, String> {
    if spec
        .radius_in
        .is_some_and(|radius| !(0.1..=100.0).contains(&radius))
    {
        return Err("radius_in must be between 0.1 and 100 inches".to_owned());
    }
    if spec
        .size
        .is_some_and(|size| !(size.min_element() >= 0.1 && size.max_element() <= 1000.0))
    {
        return Err("each number of size_in must be between 0.1 and 1000 inches".to_owned());
    }
    if spec
        .height_in
        .is_some_and(|height| !(OVERHEAD_LEAST_IN..=100.0).contains(&height))
    {
        return Err(format!(
            "height_in must be between {OVERHEAD_LEAST_IN} and 100 inches, so that the robot can pass below"
        ));
    }
    let bare = |obstacles| Parts {
        obstacles,
        ..Parts::default()
    };
    match spec.kind {
        ClutterKind::Leg => Ok(bare(vec![spec.leg(Vec2::ZERO)])),
        ClutterKind::Box => {
            let size = spec.size.ok_or("a box needs size_in = [width, depth]")?;
            Ok(bare(vec![Obstacle {
                solid: Solid::block(spec.center, size, spec.turned_deg),
                material: spec.material.unwrap_or(Material::Wood),
            }]))
        }
        ClutterKind::Chair => Ok(spec.on_legs(spec.size.unwrap_or(CHAIR_IN), CHAIR_SEAT_IN)),
        ClutterKind::Table => Ok(spec.on_legs(spec.between_legs()?, TABLE_TOP_IN)),
        ClutterKind::LowTable => Ok(spec.on_legs(spec.between_legs()?, LOW_TABLE_TOP_IN)),
        ClutterKind::Shelf => {
            let size = spec.size.ok_or("a shelf needs size_in = [width, depth]")?;
            Ok(Parts {
                overhead: Some(spec.board(size, SHELF_IN)),
                ..Parts::default()
            })
        }
        ClutterKind::OfficeChair => Ok(bare(spec.office_chair())),
        ClutterKind::Cord => {
            let length = spec.size.map_or(CORD_IN, |size| size.x);
            let solid = Solid::block(spec.center, Vec2::new(length, 0.5), spec.turned_deg);
            Ok(Parts {
                snag: Some(Snag {
                    solid,
                    chance: CORD_HOOKS,
                }),
                ..Parts::default()
            })
        }
        ClutterKind::Shoe => {
            let solid = Solid::block(spec.center, spec.size.unwrap_or(SHOE_IN), spec.turned_deg);
            Ok(Parts {
                obstacles: vec![Obstacle {
                    solid,
                    material: Material::Low,
                }],
                snag: Some(Snag {
                    solid,
                    chance: SHOE_HOOKS,
                }),
                ..Parts::default()
            })
        }
        ClutterKind::Feet => Ok(bare(spec.feet())),
    }
}

/// Minimum height of a board that the robot passes below, inches.
const OVERHEAD_LEAST_IN: f64 = 9.0;

impl Spec {
    /// The point at an offset in the object's own axes.
    fn point(&self, offset: Vec2) -> Vec2 {
        let ahead = heading(self.turned_deg.to_radians());
        self.center + clockwise(ahead) * offset.x + ahead * offset.y
    }

    fn leg(&self, offset: Vec2) -> Obstacle {
        Obstacle {
            solid: Solid::round(self.point(offset), self.radius_in.unwrap_or(1.0)),
            material: self.material.unwrap_or(Material::Leg),
        }
    }

    fn between_legs(&self) -> Result<Vec2, String> {
        self.size.ok_or_else(|| {
            "a table needs size_in = [width, depth], measured between its legs".to_owned()
        })
    }

    /// A board on four legs.
    fn on_legs(&self, size: Vec2, height_in: f64) -> Parts {
        let half = size * 0.5;
        let legs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| self.leg(Vec2::new(x * half.x, y * half.y)));
        Parts {
            obstacles: legs.into(),
            overhead: Some(self.board(size, height_in)),
            snag: None,
        }
    }

    fn board(&self, size: Vec2, height_in: f64) -> Overhead {
        Overhead {
            solid: Solid::block(self.center, size, self.turned_deg),
            height_in: self.height_in.unwrap_or(height_in),
        }
    }

    fn feet(&self) -> Vec<Obstacle> {
        let aside = STANCE_IN / 2.0;
        let foot = |x: f64| {
            let toes = self.point(Vec2::new(x, TOES_IN.y / 2.0));
            [
                Obstacle {
                    solid: Solid::round(self.point(Vec2::new(x, 0.0)), SHIN_RADIUS_IN),
                    material: Material::Alive,
                },
                Obstacle {
                    solid: Solid::block(toes, TOES_IN, self.turned_deg),
                    material: Material::Low,
                },
            ]
        };
        [foot(-aside), foot(aside)].concat()
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
