//! Maps of the floor from a robot's telemetry lines alone.
//!
//! [`LocalMap`] takes lines A in the order in which they were received and knows where obstacles stand around the robot; [`DriveMap`]
//! keeps those along a whole drive.
//! [`Compass`] finds from the directions of walls, and from walls that it sees again, how far the odometer is off, and why; [`Compass::route`] plans a route over the
//! floor that was seen, and [`Compass::floor_map`] is that floor for other programs; [`Mapper`] makes it of a whole session, and [`HouseMap`] of several. None reads a clock or a file, and equal lines give equal results.

mod compass;
mod floor;
mod floor_map;
mod grid;
mod house_map;
mod local;
mod mapper;
mod plan;
mod pose;
mod sensors;
mod trail;
mod unvisited;

pub use compass::{
    Compass, CorrectedPose, Ellipse, Interval, NoPlace, NoRoute, PlannedRoute, Wheels,
};
pub use floor_map::{FloorCell, FloorMap};
pub use grid::CELL_IN;
pub use house_map::{HouseMap, Placement};
pub use local::{DriveMap, LocalMap};
pub use mapper::{Mapper, NoMap, SessionMap};
