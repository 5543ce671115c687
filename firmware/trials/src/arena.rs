//! The worlds of the trials, and the positions in them that a robot can reach.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use sr04_sim::{Pose, World};

use crate::seeds::Rng;

/// Names and texts of the worlds that only the trials use.
const TRIAL_WORLDS: &[(&str, &str)] = &[
    ("chair", include_str!("../worlds/chair.toml")),
    ("corners", include_str!("../worlds/corners.toml")),
    ("doorway", include_str!("../worlds/doorway.toml")),
    ("floors", include_str!("../worlds/floors.toml")),
    ("gap", include_str!("../worlds/gap.toml")),
    ("hall", include_str!("../worlds/hall.toml")),
    ("snags", include_str!("../worlds/snags.toml")),
    ("stairwell", include_str!("../worlds/stairwell.toml")),
    ("step-in", include_str!("../worlds/step-in.toml")),
    ("two-doors", include_str!("../worlds/two-doors.toml")),
    ("walker", include_str!("../worlds/walker.toml")),
];

/// Step of the grid of positions, inches.
const STEP_IN: f64 = 3.0;

/// Clearance around the robot's centre at a position: half an inch more than needed.
const ROOM_IN: f64 = 6.0;

/// Offsets around a position that must have floor, so that the robot does not start with its bumper over an edge.
const AROUND: [(f64, f64); 8] = [
    (9.0, 0.0),
    (-9.0, 0.0),
    (0.0, 9.0),
    (0.0, -9.0),
    (6.5, 6.5),
    (6.5, -6.5),
    (-6.5, 6.5),
    (-6.5, -6.5),
];

/// A world and the positions that a robot starting in it can reach.
pub(crate) struct Arena {
    pub(crate) world: World,
    places: Vec<(f64, f64)>,
}

impl Arena {
    /// A world, searched from its start.
    pub(crate) fn new(world: World) -> Self {
        let start = world.start();
        let is_free = |(column, row): (i32, i32)| {
            let (x, y) = place(start, (column, row));
            world.clearance_in(x, y) >= ROOM_IN
                && AROUND
                    .iter()
                    .all(|(east, north)| world.has_floor(x + east, y + north))
        };
        let mut seen = std::collections::BTreeSet::from([(0, 0)]);
        let mut open = vec![(0, 0)];
        while let Some((column, row)) = open.pop() {
            for next in [
                (column + 1, row),
                (column - 1, row),
                (column, row + 1),
                (column, row - 1),
            ] {
                if !seen.contains(&next) && is_free(next) {
                    seen.insert(next);
                    open.push(next);
                }
            }
        }
        let places = seen.into_iter().map(|cell| place(start, cell)).collect();
        Self { world, places }
    }

    /// A reachable position with any heading, in inches on the plan.
    pub(crate) fn somewhere(&self, rng: &mut Rng) -> Pose {
        let (x_in, y_in) = self.places[rng.below(self.places.len())];
        Pose {
            x_in,
            y_in,
            theta_deg: rng.between(0.0, 360.0),
        }
    }

    /// Whether the robot has room at a position.
    pub(crate) fn has_room(&self, at: Pose) -> bool {
        self.world.clearance_in(at.x_in, at.y_in) >= ROOM_IN
    }

    /// Distance from a point of the plan that a third of the positions reach or exceed.
    pub(crate) fn farthest_third_in(&self, from: Pose) -> f64 {
        let mut distances_in: Vec<f64> = self
            .places
            .iter()
            .map(|(x_in, y_in)| (x_in - from.x_in).hypot(y_in - from.y_in))
            .collect();
        distances_in.sort_by(f64::total_cmp);
        distances_in[distances_in.len() * 2 / 3]
    }

    /// The world with another start; panics if the robot does not fit there.
    pub(crate) fn started_at(&self, start: Pose) -> World {
        self.world.started_at(start).unwrap_or_else(|| {
            panic!(
                "the robot does not fit at {start:?} in {}",
                self.world.name()
            )
        })
    }
}

/// Converts a pose on the plan to the coordinates of a robot that started at `start`.
pub(crate) fn seen_from(start: Pose, plan: Pose) -> Pose {
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    let (x, y) = (plan.x_in - start.x_in, plan.y_in - start.y_in);
    Pose {
        x_in: x * cos - y * sin,
        y_in: x * sin + y * cos,
        theta_deg: plan.theta_deg - start.theta_deg,
    }
}

/// Converts a pose from the coordinates of a robot that started at `start` to the plan.
pub(crate) fn on_plan(start: Pose, seen: Pose) -> Pose {
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    Pose {
        x_in: start.x_in + seen.x_in * cos + seen.y_in * sin,
        y_in: start.y_in - seen.x_in * sin + seen.y_in * cos,
        theta_deg: seen.theta_deg + start.theta_deg,
    }
}

fn place(start: Pose, (column, row): (i32, i32)) -> (f64, f64) {
    (
        start.x_in + f64::from(column) * STEP_IN,
        start.y_in + f64::from(row) * STEP_IN,
    )
}

/// A trial world or a built-in world by name.
pub(crate) fn arena(name: &'static str) -> Arc<Arena> {
    static ARENAS: Mutex<BTreeMap<&str, Arc<Arena>>> = Mutex::new(BTreeMap::new());
    let mut arenas = ARENAS.lock().unwrap_or_else(PoisonError::into_inner);
    let arena = arenas.entry(name).or_insert_with(|| {
        let ours = TRIAL_WORLDS.iter().find(|(known, _)| *known == name);
        let world = match ours {
            Some((_, text)) => World::parse(name, text),
            None => World::open(name),
        };
        // A test opens each world.
        Arc::new(Arena::new(world.unwrap_or_else(|error| panic!("{error}"))))
    });
    Arc::clone(arena)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversions_between_plan_and_robot_are_inverse() {
        let pose = |x_in, y_in, theta_deg| Pose {
            x_in,
            y_in,
            theta_deg,
        };
        let start = pose(100.0, 50.0, 90.0);
        let seen = seen_from(start, pose(130.0, 50.0, 90.0));
        assert!((seen.y_in - 30.0).abs() < 1e-9 && seen.x_in.abs() < 1e-9);
        let back = on_plan(start, seen);
        assert!((back.x_in - 130.0).abs() < 1e-9 && (back.y_in - 50.0).abs() < 1e-9);
    }

    #[test]
    fn trial_worlds_are_valid() {
        for (name, _) in TRIAL_WORLDS {
            assert!(arena(name).places.len() > 50, "{name}");
        }
    }
}
