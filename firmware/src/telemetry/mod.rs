//! Telemetry: a continuous stream of 80-byte lines.

mod due;
mod events;
mod schedule;
mod transmitter;

pub use events::Events;
pub use schedule::{Kind, Schedule};
pub use transmitter::Transmitter;
