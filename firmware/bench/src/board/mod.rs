//! The whole board of the Mega in the emulator: its pins in a simulated house, its radio at an operator or a real ground
//! station.

mod at_pins;
mod by_hand;
mod checks;
mod emulator;
mod house;
mod mirror;
mod station;
mod watched;

pub(crate) use by_hand::by_hand;
pub(crate) use checks::{Programs, bare, display, lockstep, power_lost, resets, saturated};
pub(crate) use station::{half_duplex, station};
