//! The robot's data on the map: trail, marks and the simulator's true state.

use std::collections::VecDeque;

use groundwave_mapping::LocalMap;
use groundwave_protocol::status_codes::{Bump, Drive, Infrared};
use groundwave_protocol::telemetry::{SEQUENCE_MODULUS, StateLine};

use super::bounds::Bounds;
use super::robot::{Reading, detects, touches};
use super::trail::Trail;
use crate::event::{Moment, Truth};

const MARKS_MAX: usize = 256;

/// Radius of the robot, inches.
pub(crate) const ROBOT_RADIUS_IN: f64 = 5.5;

/// Minimum distance between two marks of a kind, inches.
const MARK_SPACING_IN: f64 = 6.0;

/// Time without a pose after which the trail has a gap, if lines have no sequence.
const SILENCE: Moment = Moment::from_secs(2);

/// Time in which a robot can send a hundred short lines. The sequence does not show a loss of so many.
const HUNDRED_LINES: Moment = Moment::from_secs(5);

/// Maximum number of lines by which a late or repeated line is behind the newest.
const LATE_LINES_MAX: u8 = 5;

/// Distance between two lines above which the position has jumped, inches.
const JUMP_IN: f64 = 60.0;

/// Maximum distance of the robot from the middle of the picture at the operator's scale, inches.
const FOLLOW_SLACK_IN: f64 = 24.0;

/// The place of a contact or a detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Mark {
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
}

/// Minimum margin shown around the robot, its route and its target, inches; larger if the rooms are known.
const MARGIN_IN: f64 = 72.0;
const ROOMS_MARGIN_IN: f64 = 108.0;

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

/// The map's facts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Chart {
    pub(crate) trail: Trail,
    pub(crate) bumps: VecDeque<Mark>,
    pub(crate) infrareds: VecDeque<Mark>,
    /// Obstacles that the sensors found around the robot.
    pub(crate) obstacles: LocalMap,
    pub(crate) truth: Truth,
    pub(crate) bounds: Bounds,
    pose: Option<Reading<Pose>>,
    /// The part of the floor around the robot, its route and its target; `None` before a pose.
    pub(super) followed: Option<Bounds>,
    /// Middle of the picture at the operator's scale; near the robot.
    pub(super) near: (f64, f64),
    was_touching: bool,
    /// Arrival time and sequence of the newest line.
    newest: Option<(Moment, u8)>,
    /// Whether lines were lost since the newest line A.
    is_interrupted: bool,
}

impl Chart {
    /// Takes the sequence of any line; lost lines before it are a gap in the trail.
    pub(super) fn take_sequence(&mut self, now: Moment, sequence: u8) {
        let Some((at, newest)) = self.newest else {
            self.newest = Some((now, sequence));
            return;
        };
        let ahead = (sequence + SEQUENCE_MODULUS - newest) % SEQUENCE_MODULUS;
        if ahead == 0 || ahead >= SEQUENCE_MODULUS - LATE_LINES_MAX {
            return;
        }
        self.is_interrupted |= ahead > 1 || now.saturating_sub(at) >= HUNDRED_LINES;
        self.newest = Some((now, sequence));
    }

    /// Takes the loss of the link.
    pub(super) const fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Takes a line A; returns the place of a new contact.
    pub(super) fn take_state(&mut self, now: Moment, state: &StateLine) -> Option<(f64, f64)> {
        if state.drive == Drive::OdometerReset {
            self.start_afresh();
        }
        let pose = Pose::of(state);
        self.take_pose(now, pose);
        if detects(state.infrared) {
            for right_deg in infrared_directions(state.infrared) {
                let (x_in, y_in) = pose.ahead(*right_deg, 2.0 * ROBOT_RADIUS_IN);
                add_mark(&mut self.infrareds, x_in, y_in);
            }
        }
        self.obstacles.take(state);
        let touching = touches(state.bump);
        let began = touching && !self.was_touching;
        self.was_touching = touching;
        began.then(|| self.take_bump(pose, bump_direction(state.bump)))
    }

    /// Takes a contact in a direction, degrees to the right of straight ahead; returns its place.
    pub(super) fn take_bump(&mut self, pose: Pose, right_deg: f64) -> (f64, f64) {
        let (x_in, y_in) = pose.ahead(right_deg, ROBOT_RADIUS_IN);
        add_mark(&mut self.bumps, x_in, y_in);
        (x_in, y_in)
    }

    /// Takes a pose.
    pub(super) fn take_pose(&mut self, now: Moment, pose: Pose) {
        let is_interrupted = std::mem::take(&mut self.is_interrupted);
        let joined = self.pose.is_some_and(|last| {
            let moved_in = (pose.x_in - last.value.x_in).hypot(pose.y_in - last.value.y_in);
            // Lines of a robot's own have no sequence.
            let is_silent = self.newest.is_none() && last.age(now) >= SILENCE;
            !is_interrupted && !is_silent && moved_in < JUMP_IN
        });
        self.trail.push(pose.x_in, pose.y_in, joined);
        self.bounds.include(pose.x_in, pose.y_in);
        self.pose = Some(Reading {
            value: pose,
            at: now,
        });
        self.stay_near(pose);
    }

    /// Clears trail and marks, because the robot's frame has a new origin.
    pub(super) fn start_afresh(&mut self) {
        self.trail = Trail::default();
        self.bumps.clear();
        self.infrareds.clear();
        self.obstacles = LocalMap::default();
        self.pose = None;
        self.followed = None;
        self.was_touching = false;
        self.newest = None;
        self.is_interrupted = false;
    }

    /// Follows the robot and its next points.
    pub(super) fn follow(&mut self, ahead: impl Iterator<Item = (f64, f64)>) {
        let Some(pose) = self.pose() else {
            return;
        };
        let mut needed = Bounds::at((pose.x_in, pose.y_in));
        for (x_in, y_in) in ahead {
            needed = needed.union(Bounds::at((x_in, y_in)));
            self.bounds.include(x_in, y_in);
        }
        let margin_in = if self.truth.walls.is_empty() {
            MARGIN_IN
        } else {
            ROOMS_MARGIN_IN
        };
        self.followed = Some(needed.followed_from(self.followed, margin_in));
    }

    fn stay_near(&mut self, pose: Pose) {
        let (x_in, y_in) = self.near;
        let strayed_in = (pose.x_in - x_in).abs().max((pose.y_in - y_in).abs());
        if strayed_in > FOLLOW_SLACK_IN {
            self.near = (pose.x_in, pose.y_in);
        }
    }

    pub(super) fn take_truth(&mut self, truth: Truth) {
        for point in truth.walls.iter().flatten() {
            self.bounds = self.bounds.union(Bounds::at(*point));
        }
        self.truth = truth;
    }

    /// The rectangle around the simulator's walls, the robot's positions and its routes; `None` without walls.
    pub(crate) fn plan(&self) -> Option<Bounds> {
        (!self.truth.walls.is_empty()).then_some(self.bounds)
    }

    /// The latest reported pose and its moment.
    pub(crate) const fn reported(&self) -> Option<Reading<Pose>> {
        self.pose
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
