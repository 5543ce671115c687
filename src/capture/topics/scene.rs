//! What a three-dimensional view shows besides the robot's axes.

use std::collections::VecDeque;

use foxglove::messages::{
    ArrowPrimitive, Color, CylinderPrimitive, LinePrimitive, SceneEntity, SceneUpdate,
    SpherePrimitive, Vector3, line_primitive,
};

use super::geometry::{BASE, M_PER_IN, ODOM, Place, odom, point, timestamp, upright};

/// The robot's shell, metres.
const RADIUS_M: f64 = 5.5 * M_PER_IN;
const HEIGHT_M: f64 = 8.0 * M_PER_IN;

/// Bumps that are shown: the newest.
const BUMPS_MAX: usize = 64;

/// Everything goes out again after so long: a viewer that jumps somewhere looks for the latest message.
const AGE_MAX_NS: u64 = 30_000_000_000;

const BODY: Color = color(0.35, 0.55, 0.85, 0.6);
const NOSE: Color = color(0.95, 0.95, 0.95, 0.9);
const WAYPOINT: Color = color(0.3, 0.8, 0.4, 0.9);
const TARGET: Color = color(0.95, 0.75, 0.2, 0.9);
const BUMP: Color = color(0.9, 0.25, 0.2, 0.9);

const fn color(r: f64, g: f64, b: f64, a: f64) -> Color {
    Color { r, g, b, a }
}

/// The robot's body, the waypoints it holds, the one it drives to, and where it bumped.
#[derive(Debug, Default)]
pub(super) struct Scene {
    bumps: VecDeque<(f64, f64)>,
    waypoints: Vec<(f64, f64)>,
    target: Option<(f64, f64)>,
    has_changed: bool,
    sent_ns: Option<u64>,
}

impl Scene {
    pub(super) fn handle_bump(&mut self, place: Place) {
        if self.bumps.len() == BUMPS_MAX {
            self.bumps.pop_front();
        }
        self.bumps.push_back(place.ahead(RADIUS_M));
        self.has_changed = true;
    }

    /// The waypoints of the list that the robot has verified, inches as it says them.
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

    pub(super) const fn tell_anew(&mut self) {
        self.has_changed = true;
    }

    /// The robot reckons from elsewhere now: what was marked is not where it was.
    pub(super) fn forget(&mut self) {
        self.bumps.clear();
        self.has_changed = true;
    }

    /// Everything, when it has changed or was told long ago.
    pub(super) fn poll(&mut self, now_ns: u64) -> Option<SceneUpdate> {
        let is_old = |sent_ns| now_ns.saturating_sub(sent_ns) >= AGE_MAX_NS;
        if !self.has_changed && !self.sent_ns.is_none_or(is_old) {
            return None;
        }
        self.has_changed = false;
        self.sent_ns = Some(now_ns);
        let entity = |id: &str, frame: &str| SceneEntity {
            timestamp: Some(timestamp(now_ns)),
            frame_id: frame.to_owned(),
            id: id.to_owned(),
            frame_locked: true,
            ..SceneEntity::default()
        };
        let bumps = SceneEntity {
            spheres: self
                .bumps
                .iter()
                .map(|&at| sphere(at, 0.06, BUMP))
                .collect(),
            ..entity("bumps", ODOM)
        };
        Some(SceneUpdate {
            deletions: Vec::new(),
            entities: vec![
                robot(entity("robot", BASE)),
                self.route(entity("waypoints", ODOM)),
                bumps,
            ],
        })
    }

    fn route(&self, entity: SceneEntity) -> SceneEntity {
        let waypoints = self.waypoints.iter().map(|&at| sphere(at, 0.08, WAYPOINT));
        let target = self.target.iter().map(|&at| sphere(at, 0.12, TARGET));
        let line = LinePrimitive {
            r#type: line_primitive::Type::LineStrip as i32,
            pose: Some(upright(0.0, 0.0, 0.0)),
            thickness: 2.0,
            scale_invariant: true,
            points: self
                .waypoints
                .iter()
                .map(|&(x_m, y_m)| point(x_m, y_m, 0.0))
                .collect(),
            color: Some(WAYPOINT),
            ..LinePrimitive::default()
        };
        SceneEntity {
            spheres: waypoints.chain(target).collect(),
            lines: if self.waypoints.len() > 1 {
                vec![line]
            } else {
                Vec::new()
            },
            ..entity
        }
    }
}

fn robot(entity: SceneEntity) -> SceneEntity {
    SceneEntity {
        cylinders: vec![CylinderPrimitive {
            pose: Some(upright(0.0, 0.0, HEIGHT_M / 2.0)),
            size: Some(Vector3 {
                x: 2.0 * RADIUS_M,
                y: 2.0 * RADIUS_M,
                z: HEIGHT_M,
            }),
            bottom_scale: 1.0,
            top_scale: 1.0,
            color: Some(BODY),
        }],
        arrows: vec![ArrowPrimitive {
            pose: Some(upright(0.0, 0.0, HEIGHT_M)),
            shaft_length: RADIUS_M,
            shaft_diameter: 0.02,
            head_length: 0.05,
            head_diameter: 0.05,
            color: Some(NOSE),
        }],
        ..entity
    }
}

fn sphere((x_m, y_m): (f64, f64), size_m: f64, color: Color) -> SpherePrimitive {
    SpherePrimitive {
        pose: Some(upright(x_m, y_m, size_m / 2.0)),
        size: Some(Vector3 {
            x: size_m,
            y: size_m,
            z: size_m,
        }),
        color: Some(color),
    }
}
