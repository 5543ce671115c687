//! Maps of the floor from a robot's telemetry lines alone.
//!
//! [`LocalMap`] takes lines A in the order in which they were received and knows where obstacles stand around the robot.
//! It reads no clock and no file, and equal lines give equal maps.

mod grid;
mod local;
mod pose;
mod sensors;

pub use local::LocalMap;
