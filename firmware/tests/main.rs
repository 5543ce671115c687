//! Tests of the robot's program from outside: one binary with a module per subject.

mod common;
mod errands;
mod guards;
mod hand;
mod layers;
mod parameters;
mod telemetry;
mod turns;
mod uplink;
mod wheels;
