//! The true outlines of a world, for drawing a map.

use super::material::Material;
use crate::geometry::{Frame, Solid, Vec2};

/// A point in inches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Point {
    /// X in inches.
    pub x_in: f64,
    /// Y in inches.
    pub y_in: f64,
}

/// Kind of object that an outline belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutlineKind {
    /// A wall or a window.
    Wall,
    /// Furniture that sensors can see.
    Furniture,
    /// An object that only the bumper detects.
    Low,
    /// An edge of the floor.
    Edge,
}

impl OutlineKind {
    pub(super) const fn of(material: Material) -> Self {
        match material {
            Material::Wall | Material::Glass => Self::Wall,
            Material::Low | Material::Dock => Self::Low,
            _ => Self::Furniture,
        }
    }
}

/// A line, wall or circle of the world's true outlines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outline {
    /// A straight edge.
    Segment {
        /// One end.
        from: Point,
        /// The other end.
        to: Point,
        /// Kind of object.
        kind: OutlineKind,
    },
    /// A wall of the plan, filled; its sides run along the axes.
    Block {
        /// One corner.
        from: Point,
        /// The opposite corner.
        to: Point,
    },
    /// A round object.
    Circle {
        /// Centre.
        center: Point,
        /// The radius, inches.
        radius_in: f64,
        /// Kind of object.
        kind: OutlineKind,
    },
}

impl Outline {
    /// Outlines of one solid.
    pub(super) fn of(solid: &Solid, material: Material) -> Vec<Self> {
        let kind = OutlineKind::of(material);
        match *solid {
            Solid::Round { center, radius_in } => {
                vec![Self::Circle {
                    center: Point::from(center),
                    radius_in,
                    kind,
                }]
            }
            Solid::Block {
                ref place,
                ref cuboid,
            } => {
                let half = cuboid.half_extents;
                let corner = |x: f64, y: f64| {
                    Point::from(place.transform_point(Vec2::new(x * half.x, y * half.y)))
                };
                let corners = [
                    corner(-1.0, -1.0),
                    corner(1.0, -1.0),
                    corner(1.0, 1.0),
                    corner(-1.0, 1.0),
                ];
                (0..4)
                    .map(|at| Self::Segment {
                        from: corners[at],
                        to: corners[(at + 1) % 4],
                        kind,
                    })
                    .collect()
            }
        }
    }

    /// The same outline in the robot's coordinates.
    pub(crate) fn seen_from(self, frame: &Frame) -> Self {
        let turn = |point: Point| Point::from(frame.point(Vec2::new(point.x_in, point.y_in)));
        match self {
            Self::Segment { from, to, kind } => Self::Segment {
                from: turn(from),
                to: turn(to),
                kind,
            },
            Self::Block { from, to } => Self::Block {
                from: turn(from),
                to: turn(to),
            },
            Self::Circle {
                center,
                radius_in,
                kind,
            } => Self::Circle {
                center: turn(center),
                radius_in,
                kind,
            },
        }
    }
}

impl From<Vec2> for Point {
    fn from(vector: Vec2) -> Self {
        Self {
            x_in: vector.x,
            y_in: vector.y,
        }
    }
}
