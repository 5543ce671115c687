//! Objects for a three-dimensional view.

use std::collections::VecDeque;

use foxglove::messages::{
    ArrowPrimitive, Color, CylinderPrimitive, LinePrimitive, Point3, SceneEntity, SceneUpdate,
    SpherePrimitive, line_primitive,
};

use super::geometry::{BASE, M_PER_IN, ODOM, Place, odom, timestamp, upright, vector};

/// Radius and height of the robot's shell, metres.
const RADIUS_M: f64 = 5.5 * M_PER_IN;
const HEIGHT_M: f64 = 8.0 * M_PER_IN;

/// Size of the arrow on the shell, metres: diameter of the shaft, length and diameter of the head.
const SHAFT_DIAMETER_M: f64 = 0.02;
const HEAD_M: f64 = 0.05;

/// Maximum number of bumps shown; the newest are kept.
const BUMPS_MAX: usize = 64;

/// Maximum age of the last message, nanoseconds. A viewer that jumps to a moment shows the latest message before it.
const AGE_MAX_NS: u64 = 30_000_000_000;

const BODY: Color = color([0.35, 0.55, 0.85, 0.6]);
const NOSE: Color = color([0.95, 0.95, 0.95, 0.9]);
const WAYPOINT: Color = color([0.3, 0.8, 0.4, 0.9]);
const TARGET: Color = color([0.95, 0.75, 0.2, 0.9]);
const BUMP: Color = color([0.9, 0.25, 0.2, 0.9]);

/// The robot's body, its route, the waypoint that it drives to, and its bumps.
#[derive(Debug, Default)]
pub(super) struct Scene {
    bumps: VecDeque<SpherePrimitive>,
    waypoints: Vec<(f64, f64)>,
    target: Option<(f64, f64)>,
    has_changed: bool,
    sent_ns: Option<u64>,
}

impl Scene {
    pub(super) fn handle_bump(&mut self, place: Place) {
        let at_m = place.ahead(RADIUS_M);
        if self.bumps.len() == BUMPS_MAX {
            self.bumps.pop_front();
        }
        self.bumps.push_back(sphere(at_m, 0.06, BUMP));
        self.has_changed = true;
    }

    /// Sets the confirmed route, in the robot's inches.
    pub(super) fn set_waypoints(&mut self, points_in: impl Iterator<Item = (i32, i32)>) {
        self.waypoints.clear();
        self.waypoints
            .extend(points_in.map(|(x_in, y_in)| odom(x_in.into(), y_in.into())));
        self.has_changed = true;
    }

    pub(super) fn set_target(&mut self, target_in: Option<(i16, i16)>) {
        let target = target_in.map(|(x_in, y_in)| odom(x_in.into(), y_in.into()));
        self.has_changed |= target != self.target;
        self.target = target;
    }

    /// Removes places after an odometer reset, because their frame is no longer valid.
    pub(super) fn forget(&mut self) {
        self.bumps.clear();
        self.has_changed = true;
    }

    /// Whether the scene is due: it has changed, or the last message is too old.
    pub(super) fn poll(&mut self, now_ns: u64) -> bool {
        let is_old = |sent_ns| now_ns.saturating_sub(sent_ns) >= AGE_MAX_NS;
        let is_due = self.has_changed || self.sent_ns.is_none_or(is_old);
        if is_due {
            self.has_changed = false;
            self.sent_ns = Some(now_ns);
        }
        is_due
    }

    pub(super) fn message(&self, now_ns: u64) -> SceneUpdate {
        let entity = |frame: &str, id: &str| SceneEntity {
            timestamp: Some(timestamp(now_ns)),
            frame_id: frame.to_owned(),
            id: id.to_owned(),
            // The body does not move in its own frame.
            frame_locked: true,
            ..SceneEntity::default()
        };
        let robot = SceneEntity {
            arrows: vec![nose()],
            cylinders: vec![body()],
            ..entity(BASE, "robot")
        };
        let points = self.waypoints.iter();
        let spheres = points.map(|&at_m| sphere(at_m, 0.08, WAYPOINT));
        let target = self.target.map(|at_m| sphere(at_m, 0.12, TARGET));
        let line = (self.waypoints.len() > 1).then(|| line(&self.waypoints));
        let route = SceneEntity {
            spheres: spheres.chain(target).collect(),
            lines: line.into_iter().collect(),
            ..entity(ODOM, "waypoints")
        };
        let bumps = SceneEntity {
            spheres: self.bumps.iter().copied().collect(),
            ..entity(ODOM, "bumps")
        };
        SceneUpdate {
            deletions: Vec::new(),
            entities: vec![robot, route, bumps],
        }
    }
}

/// An arrow that points ahead.
fn nose() -> ArrowPrimitive {
    ArrowPrimitive {
        pose: Some(upright([0.0, 0.0, HEIGHT_M])),
        shaft_length: RADIUS_M,
        shaft_diameter: SHAFT_DIAMETER_M,
        head_length: HEAD_M,
        head_diameter: HEAD_M,
        color: Some(NOSE),
    }
}

/// The robot's shell.
fn body() -> CylinderPrimitive {
    CylinderPrimitive {
        pose: Some(upright([0.0, 0.0, HEIGHT_M / 2.0])),
        size: Some(vector([2.0 * RADIUS_M, 2.0 * RADIUS_M, HEIGHT_M])),
        // Equal radii: a cylinder, not a cone.
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(BODY),
    }
}

/// A line through the waypoints; its width on the screen does not depend on the distance.
fn line(waypoints_m: &[(f64, f64)]) -> LinePrimitive {
    let points = waypoints_m.iter().map(|&(x, y)| Point3 { x, y, z: 0.0 });
    LinePrimitive {
        r#type: line_primitive::Type::LineStrip as i32,
        pose: Some(upright([0.0; 3])),
        thickness: 2.0,
        scale_invariant: true,
        points: points.collect(),
        color: Some(WAYPOINT),
        ..LinePrimitive::default()
    }
}

fn sphere((x_m, y_m): (f64, f64), size_m: f64, color: Color) -> SpherePrimitive {
    SpherePrimitive {
        pose: Some(upright([x_m, y_m, size_m / 2.0])),
        size: Some(vector([size_m; 3])),
        color: Some(color),
    }
}

/// A colour of red, green, blue and opacity.
const fn color([r, g, b, a]: [f64; 4]) -> Color {
    Color { r, g, b, a }
}
