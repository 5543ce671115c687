//! The simulated radio: 2400 baud 8N1 in each direction, simulated bit by bit where bits can flip.

mod modem;
mod noise;
mod radio;
mod spec;
mod wire;

pub use radio::Radio;
pub use spec::{ChannelSpec, ChannelSpecError, Modem, Squelch};
