//! The robot's data on the map: trail, marks and the simulator's true state.

use std::collections::VecDeque;

use groundwave_protocol::status_codes::{Bump, Drive, Infrared};
use groundwave_protocol::telemetry::StateLine;

use super::robot::{Reading, detects, touches};
use super::trail::Trail;
use crate::event::{Moment, Truth};

const MARKS_MAX: usize = 256;

/// Radius of the robot, inches.
pub(crate) const ROBOT_RADIUS_IN: f64 = 5.5;

/// Least distance between two marks of a kind, inches.
const MARK_SPACING_IN: f64 = 6.0;

/// Time without a line after which the trail has a gap.
const GAP_AFTER: Moment = Moment::from_secs(2);

/// A greater distance between two lines is a jump, inches.
const JUMP_IN: f64 = 60.0;

/// Step by which the known bounds grow, inches, so that the picture does not creep.
const BOUNDS_STEP_IN: f64 = 24.0;

/// Distance the followed robot may stray from the middle, inches.
const FOLLOW_SLACK_IN: f64 = 24.0;

/// The place of a contact or a detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mark {
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
}

/// A position and heading of the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pose {
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
    pub(crate) theta_deg: f64,
}

impl Pose {
    pub(crate) fn of(state: &StateLine) -> Self {
        Self {
            x_in: f64::from(state.x_tenths_in) / 10.0,
            y_in: f64::from(state.y_tenths_in) / 10.0,
            theta_deg: f64::from(state.theta_deg),
        }
    }

    /// The point at a distance in a direction, degrees to the right of straight ahead.
    pub(crate) fn ahead(&self, right_deg: f64, distance_in: f64) -> (f64, f64) {
        let (sin, cos) = (self.theta_deg + right_deg).to_radians().sin_cos();
        (self.x_in + distance_in * sin, self.y_in + distance_in * cos)
    }
}

/// A rectangle on the floor, inches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: (f64, f64),
    pub(crate) max: (f64, f64),
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            min: (-2.0 * BOUNDS_STEP_IN, -2.0 * BOUNDS_STEP_IN),
            max: (2.0 * BOUNDS_STEP_IN, 2.0 * BOUNDS_STEP_IN),
        }
    }
}

impl Bounds {
    pub(super) fn include(&mut self, x_in: f64, y_in: f64) {
        let down = |value: f64| (value / BOUNDS_STEP_IN).floor() * BOUNDS_STEP_IN;
        let up = |value: f64| (value / BOUNDS_STEP_IN).ceil() * BOUNDS_STEP_IN;
        if x_in < self.min.0 {
            self.min.0 = down(x_in);
        }
        if y_in < self.min.1 {
            self.min.1 = down(y_in);
        }
        if x_in > self.max.0 {
            self.max.0 = up(x_in);
        }
        if y_in > self.max.1 {
            self.max.1 = up(y_in);
        }
    }

    /// Width and height, inches.
    pub(crate) fn extent(&self) -> (f64, f64) {
        (self.max.0 - self.min.0, self.max.1 - self.min.1)
    }

    /// The smallest rectangle around both.
    pub(super) const fn union(self, other: Self) -> Self {
        Self {
            min: (self.min.0.min(other.min.0), self.min.1.min(other.min.1)),
            max: (self.max.0.max(other.max.0), self.max.1.max(other.max.1)),
        }
    }

    pub(super) fn middle(&self) -> (f64, f64) {
        (
            f64::midpoint(self.min.0, self.max.0),
            f64::midpoint(self.min.1, self.max.1),
        )
    }
}

/// The map's facts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chart {
    pub(crate) trail: Trail,
    pub(crate) bumps: VecDeque<Mark>,
    pub(crate) infrareds: VecDeque<Mark>,
    pub(crate) truth: Truth,
    pub(crate) bounds: Bounds,
    pose: Option<Reading<Pose>>,
    /// Middle of the picture while it follows the robot.
    pub(super) followed: (f64, f64),
    was_touching: bool,
}

impl Chart {
    /// Takes a line A; returns the place of a new contact.
    pub(super) fn take_state(&mut self, now: Moment, state: &StateLine) -> Option<(f64, f64)> {
        if state.drive == Drive::OdometerReset {
            self.start_afresh();
        }
        let pose = Pose::of(state);
        let joined = self.pose.is_some_and(|last| {
            let moved_in = (pose.x_in - last.value.x_in).hypot(pose.y_in - last.value.y_in);
            last.age(now) < GAP_AFTER && moved_in < JUMP_IN
        });
        self.trail.push(pose.x_in, pose.y_in, joined);
        self.bounds.include(pose.x_in, pose.y_in);
        self.pose = Some(Reading {
            value: pose,
            at: now,
        });
        self.follow(pose);
        if detects(state.infrared) {
            for right_deg in infrared_directions(state.infrared) {
                let (x_in, y_in) = pose.ahead(*right_deg, 2.0 * ROBOT_RADIUS_IN);
                add_mark(&mut self.infrareds, x_in, y_in);
            }
        }
        let touching = touches(state.bump);
        let began = touching && !self.was_touching;
        self.was_touching = touching;
        began.then(|| {
            let (x_in, y_in) = pose.ahead(bump_direction(state.bump), ROBOT_RADIUS_IN);
            add_mark(&mut self.bumps, x_in, y_in);
            (x_in, y_in)
        })
    }

    /// Clears trail and marks: the robot's frame has a new origin.
    pub(super) fn start_afresh(&mut self) {
        self.trail = Trail::default();
        self.bumps.clear();
        self.infrareds.clear();
        self.pose = None;
        self.was_touching = false;
    }

    fn follow(&mut self, pose: Pose) {
        let (x_in, y_in) = self.followed;
        let strayed_in = (pose.x_in - x_in).abs().max((pose.y_in - y_in).abs());
        if strayed_in > FOLLOW_SLACK_IN {
            self.followed = (pose.x_in, pose.y_in);
        }
    }

    pub(super) fn take_truth(&mut self, truth: Truth) {
        for &(x_in, y_in) in truth.walls.iter().flatten() {
            self.bounds.include(x_in, y_in);
        }
        self.truth = truth;
    }

    /// The latest reported pose.
    pub(crate) fn pose(&self) -> Option<Pose> {
        self.pose.map(|pose| pose.value)
    }
}

fn add_mark(marks: &mut VecDeque<Mark>, x_in: f64, y_in: f64) {
    let known = marks
        .iter()
        .rev()
        .take(8)
        .any(|mark| (mark.x_in - x_in).hypot(mark.y_in - y_in) < MARK_SPACING_IN);
    if known {
        return;
    }
    if marks.len() == MARKS_MAX {
        marks.pop_front();
    }
    marks.push_back(Mark { x_in, y_in });
}

const fn bump_direction(bump: Bump) -> f64 {
    match bump {
        Bump::Left => -45.0,
        Bump::LeftCenter => -22.5,
        Bump::Right => 45.0,
        Bump::RightCenter => 22.5,
        _ => 0.0,
    }
}

const fn infrared_directions(infrared: Infrared) -> &'static [f64] {
    match infrared {
        Infrared::Left => &[-45.0],
        Infrared::Right => &[45.0],
        Infrared::Both => &[-45.0, 45.0],
        Infrared::None | Infrared::Jammed | Infrared::NotFitted => &[],
    }
}
