//! The claims, one file per part of the robot.

mod battery;
mod behaviour;
mod bumpers;
mod cliff;
mod dead_reckoning;
mod home;
mod hooks;
mod infrared;
mod modes;
mod motion;
pub(crate) mod odometry;
mod photo;
mod pid;
mod prowl;
mod rotation;
mod sonar;
mod user;
mod whole;

use crate::claim::{Experiment, Reading};

/// All experiments in the order of the table.
pub(crate) fn all() -> Vec<&'static Experiment> {
    [
        pid::ALL,
        odometry::ALL,
        user::ALL,
        bumpers::ALL,
        hooks::ALL,
        rotation::ALL,
        infrared::ALL,
        sonar::ALL,
        photo::ALL,
        motion::ALL,
        dead_reckoning::ALL,
        home::ALL,
        battery::ALL,
        prowl::ALL,
        modes::ALL,
        behaviour::ALL,
        cliff::ALL,
        whole::ALL,
    ]
    .concat()
}

/// A reading of success or failure.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial gives an optional reading per claim"
)]
fn success(is_so: bool) -> Option<Reading> {
    Some(Reading::Success(is_so))
}

/// A reading of a measured value.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial gives an optional reading per claim"
)]
fn value(value: f64) -> Option<Reading> {
    Some(Reading::Value(value))
}

/// Cost of an ablation in percentage points: the same trial with a part and without it.
fn loss(with: bool, without: bool) -> Option<Reading> {
    value(100.0 * (f64::from(u8::from(with)) - f64::from(u8::from(without))))
}
