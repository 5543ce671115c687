//! Shows any moment again: of a capture, or of a live session's remembered past.
//!
//! The state at a moment is the nearest earlier keyframe plus the events since, taken in order; nothing is undone. Keyframes
//! ([`keyframes`]) hold only facts and are thinned out as time passes, so that memory is bounded. A [`timeline`] finds
//! moments in the states of a capture ([`capture`]) or of a live session ([`live`]). A [`player`] plays a timeline
//! at any speed, controlled by the operator (`control`).
//!
//! This module reads no clock and no file: the host's time is a parameter, and a capture is a
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
    Control, Landmark, MARK_REACH, MARKS_MAX, Mark, POSITION_HELP, Playback, Position,
    PositionError, SPEED_MAX, SPEED_MIN, Tally, clock_words,
};
pub use live::{EventHistory, LivePlayer, LiveState};
pub use player::Player;
pub use timeline::Timeline;
