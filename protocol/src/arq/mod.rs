//! Both ends of command delivery, as pure state machines after CCSDS COP-1: the robot's [`Farm`] and
//! the ground's [`fop::Fop`].

mod farm;
mod lists;

pub use farm::{Action, Farm};
pub use lists::Lists;
