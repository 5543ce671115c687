//! The SR04's program, independent of its board.
//!
//! A board reads its pins into [`board::Inputs`], calls [`robot::Robot::tick`] 20 times per second and applies the
//! [`board::Outputs`]. Between ticks it calls [`robot::Robot::infrared_sample`] 250 times per second and transfers bytes to
//! and from the radio. The simulator is one such board.
//!
//! Start reading at [`robot::Robot::tick`], which is the whole program from top to bottom.
//!
//! The program uses no heap, no floats and integers of at most 32 bits: equal inputs give equal telemetry on a host and
//! on an 8-bit microcontroller.
#![no_std]
#![cfg_attr(not(test), deny(clippy::float_arithmetic))]

#[cfg(test)]
extern crate std;

pub mod angle;
pub mod arbiter;
pub mod arm;
pub mod behaviours;
pub mod board;
pub mod cliff;
pub mod drive;
pub mod failsafe;
pub mod infrared;
pub mod memory;
pub mod odometry;
pub mod parameters;
pub mod pid;
pub mod rng;
pub mod robot;
pub mod sensors;
pub mod song;
pub mod telemetry;
pub mod units;
