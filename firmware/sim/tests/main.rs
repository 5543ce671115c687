//! Tests of the simulator from outside: one binary, one module per subject.

mod cliffs;
mod common;
mod determinism;
mod docking;
mod faults;
mod home;
mod layers;
mod physics;
mod rest;
mod serve;
mod simulation;
mod square;
mod worlds;
