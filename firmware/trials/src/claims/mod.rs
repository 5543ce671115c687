//! The claims, one file per part of the robot.

mod battery;
mod behaviour;
mod bumpers;
mod cliff;
mod crowded;
mod dead_reckoning;
mod edges;
mod encoder;
mod home;
mod hooks;
mod infrared;
mod modes;
mod motion;
mod odometry;
mod passages;
mod photo;
mod pid;
mod prowl;
mod rotation;
mod sonar;
mod user;
mod whole;

use crate::claim::Experiment;

/// All experiments in the order of the table.
pub(crate) fn all() -> Vec<&'static Experiment> {
    [
        pid::ALL,
        odometry::ALL,
        encoder::ALL,
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
        edges::ALL,
        whole::ALL,
        crowded::ALL,
        passages::ALL,
    ]
    .concat()
}
