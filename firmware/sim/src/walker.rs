//! People and cats: round bodies that walk a closed path and never push.

use crate::geometry::{Solid, Vec2};
use crate::world::{Material, Obstacle, Walker};

/// Time between two steps of a walker, milliseconds.
pub(crate) const STEP_MS: u64 = 20;

/// Gap in inches that a walker keeps from the robot.
const COURTESY_IN: f64 = 1.0;

/// A walker's position on its path.
#[derive(Clone, Debug)]
pub(crate) struct MovingWalker {
    walker: Walker,
    center: Vec2,
    next: usize,
    pause_left_s: f64,
}

impl MovingWalker {
    pub(crate) fn new(walker: Walker) -> Self {
        let center = walker.path.first().copied().unwrap_or(Vec2::ZERO);
        Self {
            center,
            next: 1,
            pause_left_s: walker.pause_s,
            walker,
        }
    }

    pub(crate) const fn center(&self) -> Vec2 {
        self.center
    }

    pub(crate) const fn radius_in(&self) -> f64 {
        self.walker.kind.radius_in()
    }

    pub(crate) const fn solid(&self) -> Solid {
        Solid::round(self.center, self.radius_in())
    }

    pub(crate) const fn as_obstacle(&self) -> Obstacle {
        Obstacle {
            solid: self.solid(),
            material: Material::Alive,
        }
    }

    /// Takes one step, or waits when the step would bring it too close to the robot.
    pub(crate) fn step(&mut self, robot: Vec2, robot_radius_in: f64) {
        let step_s = STEP_MS as f64 / 1000.0;
        if self.pause_left_s > 0.0 {
            self.pause_left_s -= step_s;
            return;
        }
        let Some(&goal) = self.walker.path.get(self.next) else {
            return;
        };
        let offset = goal - self.center;
        let distance = offset.length();
        let stride = self.walker.speed_in_s * step_s;
        let arrives = distance <= stride;
        let stepped = if arrives {
            goal
        } else {
            self.center + offset * (stride / distance)
        };
        let room = robot_radius_in + self.radius_in() + COURTESY_IN;
        let gap = stepped.distance(robot);
        if gap < room && gap < self.center.distance(robot) {
            return;
        }
        self.center = stepped;
        if arrives {
            self.next = (self.next + 1) % self.walker.path.len();
            self.pause_left_s = self.walker.pause_s;
        }
    }
}
