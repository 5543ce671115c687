//! The SR04's real program in a simulated house with a simulated body and radio, in virtual time from one seed.
//!
//! [`World`] is a house, read from a floor plan drawn in characters. [`Plant`] is the house and the robot's body as
//! the robot's board sees them: motors, encoders, bumper, sonars, infrared, photocells. [`Radio`] carries bytes
//! with the faults of a [`ChannelSpec`]. [`Simulation`] connects them to the robot's program, one millisecond a step.
//! [`serve`] runs a simulation in real time behind a pseudo-terminal or a TCP port.
//!
//! The same seed gives the same run, byte for byte, on every platform.

mod body;
mod channel;
mod check;
mod dimensions;
mod faults;
mod generate;
mod geometry;
mod library;
mod plant;
mod rng;
mod scene;
mod sensors;
pub mod serve;
mod simulation;
mod sound;
mod stuck;
#[cfg(test)]
mod testing;
mod time;
mod trace;
mod walker;
mod world;

pub use body::Conditions;
pub use channel::{ChannelSpec, ChannelSpecError, Modem, Radio, Squelch};
pub use faults::Faults;
pub use geometry::Pose;
pub use plant::{Plant, Truth};
pub use simulation::{Simulation, SimulationConfig};
pub use sound::Sound;
pub use sr04_firmware::board::{Duplex, HC_12_PATIENCE_BYTES, PATIENCE_BYTES};
pub use time::{SAMPLE_MS, TICK_MS};
pub use trace::Trace;
pub use world::{Material, Outline, OutlineKind, Point, World, WorldError};
