//! Tests of the robot's program from outside: one binary with a module per subject.

mod autonomy;
mod common;
mod guards;
mod layers;
mod manual_driving;
mod parameters;
mod telemetry;
mod turns;
mod uplink;
mod wheels;
