//! The claims, one file a part of the robot.

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

/// All of them, in the order of the table.
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

/// Whether it came out as claimed.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial lists what it read, or nothing"
)]
fn success(is_so: bool) -> Option<Reading> {
    Some(Reading::Success(is_so))
}

/// A measured value.
#[expect(
    clippy::unnecessary_wraps,
    reason = "a trial lists what it read, or nothing"
)]
fn value(value: f64) -> Option<Reading> {
    Some(Reading::Value(value))
}

/// What an ablation costs, in points of percent: the same trial with a part and without it.
fn loss(with: bool, without: bool) -> Option<Reading> {
    value(100.0 * (f64::from(u8::from(with)) - f64::from(u8::from(without))))
}
