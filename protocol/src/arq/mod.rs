//! Delivery of commands, as pure state machines after CCSDS COP-1: the robot's [`Farm`] and the ground's [`Fop`].

mod farm;
mod fop;
mod lists;
mod pacer;
mod quality;
mod status;
mod transfer;

pub use farm::{Action, Farm};
pub use fop::{Config, Duplex, Fop, FopEvent, Task};
pub use lists::Lists;
pub use status::{CommandStatus, Failure};
