//! Shows any moment again: of a capture, and of a live session as far back as it is remembered.
//!
//! A moment is the nearest earlier kept state plus the events since, taken in their order; nothing is undone. Kept
//! states ([`keyframes`]) hold facts only and thin out as time passes, so that memory is bounded. A [`timeline`] finds
//! moments among them: the states of a capture ([`capture`]) or of a live session ([`live`]). A [`player`] plays either
//! at any speed, under the operator's `control`.
//!
//! Nothing here reads a clock or a file: the host's time is a parameter, and a capture is a
//! [`SeekableReader`](crate::capture::index::SeekableReader).

mod cache;
pub mod capture;
mod control;
pub mod cursor;
pub mod keyframes;
pub mod live;
pub mod player;
mod search;
mod target;
pub mod timeline;

#[cfg(test)]
mod tests;

pub use capture::{CaptureState, Finding, read_through};
pub use control::{
    Control, Landmark, MARKER_REACH, MARKERS_MAX, Mark, POSITION_HELP, Playback, Position,
    PositionError, SPEED_MAX, SPEED_MIN, Tally, clock_words,
};
pub use live::{EventHistory, LivePlayer, LiveState};
pub use player::Player;
pub use timeline::Timeline;
