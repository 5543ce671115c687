//! Tests of the protocol from outside: one binary, one module per subject.

mod c_robot;
mod damage;
mod decoder;
mod delivery;
mod faults;
mod fuzz;
mod receiver;
mod reckoning;
mod repair;
mod replay;
mod robots;
mod search;
mod truth;
mod vectors;
mod world;
