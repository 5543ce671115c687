//! The radio: 2400 baud 8N1 each way, bit by bit where a bit can flip.

mod modem;
mod noise;
mod radio;
mod spec;
mod wire;

pub use radio::Radio;
pub use spec::{ChannelSpec, ChannelSpecError, Modem, Squelch};
