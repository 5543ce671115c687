//! A simulated house, robot body and radio around the SR04's real program, in virtual time from
//! one seed.
//!
//! [`World`] reads a house drawn in characters. [`Plant`] is that house with the robot's body in
//! it, as the robot's board sees it: motors, encoders, bumper, sonars, infrared, photocells.
//! [`ChannelSpec`] says what the [`Radio`] does to bytes. [`Simulation`] puts the robot's real program between them, one
//! millisecond a step, and [`serve`] runs it against the clock behind a pseudo-terminal or a TCP
//! port.
//!
//! The same seed gives the same run, byte for byte, on every platform.

mod body;
mod channel;
mod dice;
mod geometry;
mod plant;
mod scene;
mod sensors;
pub mod serve;
mod simulation;
mod sound;
mod stuck;
#[cfg(test)]
mod testing;
mod trace;
mod walker;
mod world;

pub use body::Conditions;
pub use channel::{ChannelSpec, ChannelSpecError, Modem, Radio, Squelch};
pub use geometry::Pose;
pub use plant::{LOOK_MS, Plant, TICK_MS, Truth};
pub use simulation::{Simulation, SimulationConfig};
pub use sound::Sound;
pub use sr04_firmware::board::{Duplex, PATIENCE_BYTES};
pub use trace::Trace;
pub use world::{Material, Outline, OutlineKind, Point, World, WorldError};
