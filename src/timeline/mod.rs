//! Any moment again: of a capture, and of a live session as far back as it is remembered.
//!
//! What happened is replayed into a model, never shown backwards: a moment is the nearest earlier state
//! that was kept, and what happened since. Which states are kept ([`keyframes`]) thins out as time goes on,
//! so that memory is bounded; a [`reel`] finds moments among them. A capture's state is a [`scene`], a live
//! session's a [`past`]; a [`player`] lets time pass in either, at any speed, and obeys the operator.
//!
//! Nothing here reads a clock or a file: the host's time is a parameter, and a capture is a
//! [`SeekableReader`](crate::capture::index::SeekableReader).

mod hunt;
pub mod keyframes;
pub mod past;
pub mod player;
mod quest;
pub mod reel;
pub mod scene;
mod way;

#[cfg(test)]
mod tests;

pub use past::{History, Past};
pub use player::Player;
pub use reel::Reel;
pub use scene::{Finding, Scene, survey};
