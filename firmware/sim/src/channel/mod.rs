//! The radio: 2400 baud 8N1 each way, bit by bit where a bit can flip.

mod noise;
mod spec;
mod wire;

pub use spec::{ChannelSpec, ChannelSpecError};

pub(crate) use wire::Wire;
