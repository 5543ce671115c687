//! Tests of the wire from outside: one binary, one module a subject.

mod c_robot;
mod damage;
mod decoder;
mod delivery;
mod faults;
mod fuzz;
mod receiver;
mod reckoning;
mod replay;
mod search;
mod vectors;
mod world;
