//! What a three-dimensional view shows besides the robot's axes.

use super::geometry::{BASE, M_PER_IN, ODOM, Place, odom, put_timestamp, triple, upright};
use super::newest::Newest;
use crate::protobuf::Protobuf;

/// The robot's shell, metres.
const RADIUS_M: f64 = 5.5 * M_PER_IN;
const HEIGHT_M: f64 = 8.0 * M_PER_IN;

/// The arrow on it: across its shaft; along its head and across it.
const SHAFT_DIAMETER_M: f64 = 0.02;
const HEAD_M: f64 = 0.05;

/// Bumps that are shown: the newest.
const BUMPS_MAX: usize = 64;

/// Everything goes out again after so long: a viewer that jumps somewhere looks for the latest message.
const AGE_MAX_NS: u64 = 30_000_000_000;

/// Red, green, blue and how opaque.
type Color = [f64; 4];

const BODY: Color = [0.35, 0.55, 0.85, 0.6];
const NOSE: Color = [0.95, 0.95, 0.95, 0.9];
const WAYPOINT: Color = [0.3, 0.8, 0.4, 0.9];
const TARGET: Color = [0.95, 0.75, 0.2, 0.9];
const BUMP: Color = [0.9, 0.25, 0.2, 0.9];

/// Where a `SceneEntity` has its spheres.
const SPHERES: u32 = 9;

/// The robot's body, the waypoints it holds, the one it drives to, and where it bumped.
#[derive(Debug, Default)]
pub(super) struct Scene {
    /// Spheres.
    bumps: Newest,
    waypoints: Vec<(f64, f64)>,
    target: Option<(f64, f64)>,
    has_changed: bool,
    sent_ns: Option<u64>,
}

impl Scene {
    pub(super) fn handle_bump(&mut self, place: Place) {
        let at_m = place.ahead(RADIUS_M);
        self.bumps
            .push(BUMPS_MAX, SPHERES, |to| sphere(to, at_m, 0.06, BUMP));
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

    /// Whether everything is due: it has changed, or was told long ago.
    pub(super) fn poll(&mut self, now_ns: u64) -> bool {
        let is_old = |sent_ns| now_ns.saturating_sub(sent_ns) >= AGE_MAX_NS;
        let is_due = self.has_changed || self.sent_ns.is_none_or(is_old);
        if is_due {
            self.has_changed = false;
            self.sent_ns = Some(now_ns);
        }
        is_due
    }

    /// A `SceneUpdate`.
    pub(super) fn encode(&self, now_ns: u64, to: &mut Vec<u8>) {
        let mut entity = |frame: &str, id: &str, fill: &dyn Fn(&mut Vec<u8>)| {
            to.message(2, |to| {
                put_timestamp(to, now_ns);
                to.string(2, frame);
                to.string(3, id);
                // It stays where it is in its frame.
                to.uint32(5, 1);
                fill(to);
            });
        };
        entity(BASE, "robot", &robot);
        entity(ODOM, "waypoints", &|to| self.route(to));
        entity(ODOM, "bumps", &|to| self.bumps.encode(to));
    }

    fn route(&self, to: &mut Vec<u8>) {
        for &at_m in &self.waypoints {
            to.message(SPHERES, |to| sphere(to, at_m, 0.08, WAYPOINT));
        }
        if let Some(at_m) = self.target {
            to.message(SPHERES, |to| sphere(to, at_m, 0.12, TARGET));
        }
        if self.waypoints.len() > 1 {
            to.message(11, |to| line(to, &self.waypoints));
        }
    }
}

/// A cylinder and an arrow that looks ahead.
fn robot(to: &mut Vec<u8>) {
    to.message(7, |to| {
        to.message(1, |to| upright(to, [0.0, 0.0, HEIGHT_M]));
        to.double(2, RADIUS_M);
        to.double(3, SHAFT_DIAMETER_M);
        to.double(4, HEAD_M);
        to.double(5, HEAD_M);
        to.message(6, |to| color(to, NOSE));
    });
    to.message(10, |to| {
        to.message(1, |to| upright(to, [0.0, 0.0, HEIGHT_M / 2.0]));
        to.message(2, |to| {
            triple(to, [2.0 * RADIUS_M, 2.0 * RADIUS_M, HEIGHT_M]);
        });
        // As wide at the bottom as at the top.
        to.double(3, 1.0);
        to.double(4, 1.0);
        to.message(5, |to| color(to, BODY));
    });
}

/// From waypoint to waypoint, of the same width on the screen however far away.
fn line(to: &mut Vec<u8>, waypoints_m: &[(f64, f64)]) {
    to.message(2, |to| upright(to, [0.0; 3]));
    to.double(3, 2.0);
    to.uint32(4, 1);
    for &(x_m, y_m) in waypoints_m {
        to.message(5, |to| triple(to, [x_m, y_m, 0.0]));
    }
    to.message(6, |to| color(to, WAYPOINT));
}

fn sphere(to: &mut Vec<u8>, (x_m, y_m): (f64, f64), size_m: f64, of: Color) {
    to.message(1, |to| upright(to, [x_m, y_m, size_m / 2.0]));
    to.message(2, |to| triple(to, [size_m; 3]));
    to.message(3, |to| color(to, of));
}

fn color(to: &mut Vec<u8>, color: Color) {
    for (tag, part) in (1..).zip(color) {
        to.nonzero(tag, part);
    }
}
