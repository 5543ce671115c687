//! Points, frames and solid shapes. Lengths in inches.
//!
//! Angle 0 points along +Y and angles grow clockwise, as in the robot. Only float functions that are exact by
//! definition come from the standard library (`sqrt`, `floor`, `round`, `abs`); the others come from `libm`, so that
//! a run is the same on every platform.

use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::{Pose as Isometry, Rot2};
use parry2d_f64::query::{PointQuery as _, Ray, RayCast as _};
use parry2d_f64::shape::{Ball, Cuboid, Shape as _};

/// A point or direction in the plane.
pub(crate) use parry2d_f64::math::Vector as Vec2;

/// Unit vector at an angle in radians, clockwise from +Y.
pub(crate) fn heading(theta_rad: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(theta_rad);
    Vec2::new(sin, cos)
}

/// The direction turned a quarter turn clockwise.
pub(crate) fn clockwise(direction: Vec2) -> Vec2 {
    Vec2::new(direction.y, -direction.x)
}

/// Angle of a vector in radians, clockwise from +Y.
pub(crate) fn bearing(vector: Vec2) -> f64 {
    libm::atan2(vector.x, vector.y)
}

/// A position and a heading.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// X in inches.
    pub x_in: f64,
    /// Y in inches.
    pub y_in: f64,
    /// Heading in degrees clockwise from +Y, above -180 up to 180.
    pub theta_deg: f64,
}

/// Converts from the floor plan to the robot's coordinates, whose origin is the start pose.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    origin: Vec2,
    theta_deg: f64,
    ahead: Vec2,
}

impl Frame {
    pub(crate) fn new(start: Pose) -> Self {
        Self {
            origin: Vec2::new(start.x_in, start.y_in),
            theta_deg: start.theta_deg,
            ahead: heading(start.theta_deg.to_radians()),
        }
    }

    pub(crate) fn point(&self, plan: Vec2) -> Vec2 {
        let offset = plan - self.origin;
        Vec2::new(offset.dot(clockwise(self.ahead)), offset.dot(self.ahead))
    }

    pub(crate) fn pose(&self, plan: Vec2, theta_rad: f64) -> Pose {
        let point = self.point(plan);
        Pose {
            x_in: point.x,
            y_in: point.y,
            theta_deg: wrap_deg(theta_rad.to_degrees() - self.theta_deg),
        }
    }

    /// Place and heading (radians) on the floor plan of a pose in the robot's coordinates.
    pub(crate) fn place(&self, pose: Pose) -> (Vec2, f64) {
        let plan = self.origin + clockwise(self.ahead) * pose.x_in + self.ahead * pose.y_in;
        (plan, (pose.theta_deg + self.theta_deg).to_radians())
    }
}

/// The same angle, above -180 up to 180 degrees.
pub(crate) fn wrap_deg(angle_deg: f64) -> f64 {
    let turns = ((angle_deg + 180.0) / 360.0).ceil() - 1.0;
    angle_deg - turns * 360.0
}

/// A solid shape on the floor.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Solid {
    Block { place: Isometry, cuboid: Cuboid },
    Round { center: Vec2, radius_in: f64 },
}

impl Solid {
    /// A rectangle around its centre, turned clockwise by `turned_deg`.
    pub(crate) fn block(center: Vec2, size_in: Vec2, turned_deg: f64) -> Self {
        let rotation = if turned_deg == 0.0 {
            Rot2::identity()
        } else {
            let (sin, cos) = libm::sincos(-turned_deg.to_radians());
            Rot2::from_cos_sin_unchecked(cos, sin)
        };
        Self::Block {
            place: Isometry::from_parts(center, rotation),
            cuboid: Cuboid::new(size_in * 0.5),
        }
    }

    pub(crate) const fn round(center: Vec2, radius_in: f64) -> Self {
        Self::Round { center, radius_in }
    }

    pub(crate) fn bounds(&self) -> Aabb {
        match *self {
            Self::Block {
                ref place,
                ref cuboid,
            } => cuboid.compute_aabb(place),
            Self::Round { center, radius_in } => {
                Aabb::from_half_extents(center, Vec2::splat(radius_in))
            }
        }
    }

    /// Distance in inches along `ray` to the shape; `None` if it is not hit within `max_in`. The ray's direction has length 1.
    pub(crate) fn cast(&self, ray: &Ray, max_in: f64) -> Option<f64> {
        match *self {
            Self::Block {
                ref place,
                ref cuboid,
            } => cuboid.cast_ray(place, ray, max_in, true),
            Self::Round { center, radius_in } => {
                let ray = Ray::new(ray.origin - center, ray.dir);
                Ball::new(radius_in).cast_local_ray(&ray, max_in, true)
            }
        }
    }

    /// Outward normal where a ray hits; `None` when the ray starts inside.
    pub(crate) fn normal(&self, ray: &Ray, max_in: f64) -> Option<Vec2> {
        let normal = match *self {
            Self::Block {
                ref place,
                ref cuboid,
            } => {
                cuboid
                    .cast_ray_and_get_normal(place, ray, max_in, true)?
                    .normal
            }
            Self::Round { center, radius_in } => {
                let ray = Ray::new(ray.origin - center, ray.dir);
                Ball::new(radius_in)
                    .cast_local_ray_and_get_normal(&ray, max_in, true)?
                    .normal
            }
        };
        (normal.length_squared() > 0.5).then_some(normal)
    }

    /// Distance from a point to the boundary in inches, negative inside, and the unit direction to the solid.
    pub(crate) fn approach(&self, point: Vec2) -> (f64, Vec2) {
        match *self {
            Self::Block {
                ref place,
                ref cuboid,
            } => {
                let nearest = cuboid.project_point(place, point, false);
                let offset = nearest.point - point;
                let distance = offset.length();
                let toward = if distance > 1e-9 {
                    offset / distance
                } else {
                    Vec2::Y
                };
                if nearest.is_inside {
                    (-distance, -toward)
                } else {
                    (distance, toward)
                }
            }
            Self::Round { center, radius_in } => {
                let offset = center - point;
                let distance = offset.length();
                let toward = if distance > 1e-9 {
                    offset / distance
                } else {
                    Vec2::Y
                };
                (distance - radius_in, toward)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_grow_clockwise_from_plus_y() {
        let east = heading(90.0_f64.to_radians());
        assert!((east - Vec2::X).length() < 1e-12);
        assert!((bearing(Vec2::X).to_degrees() - 90.0).abs() < 1e-12);
        assert!((clockwise(Vec2::Y) - Vec2::X).length() < 1e-12);
        assert!((wrap_deg(270.0) - -90.0).abs() < 1e-12);
        assert!((wrap_deg(-180.0) - 180.0).abs() < 1e-12);
    }

    #[test]
    fn start_pose_is_the_origin_of_the_frame() {
        let frame = Frame::new(Pose {
            x_in: 100.0,
            y_in: 50.0,
            theta_deg: 90.0,
        });
        let ahead = frame.pose(Vec2::new(110.0, 50.0), 90.0_f64.to_radians());
        assert!(ahead.x_in.abs() < 1e-9 && (ahead.y_in - 10.0).abs() < 1e-9);
        assert!(ahead.theta_deg.abs() < 1e-9);
        let right = frame.point(Vec2::new(100.0, 40.0));
        assert!((right - Vec2::new(10.0, 0.0)).length() < 1e-9);
    }

    #[test]
    fn distance_to_a_turned_block_is_to_its_corner() {
        let block = Solid::block(Vec2::new(0.0, 20.0), Vec2::new(2.0, 2.0), 45.0);
        let (distance, toward) = block.approach(Vec2::ZERO);
        assert!((distance - (20.0 - 2.0_f64.sqrt())).abs() < 1e-9);
        assert!((toward - Vec2::Y).length() < 1e-9);
    }
}
