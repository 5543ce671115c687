//! The operations of a state that a timeline uses: stepping forward, and starting in a capture at any time.

use super::control::Landmark;
use crate::event::Moment;
use crate::model::Facts;

/// A state that advances in time, step by step.
pub trait Cursor: Clone + 'static {
    /// Source of the events.
    type Source;

    /// The facts at the current moment.
    fn facts(&self) -> &Facts;

    /// The state with everything that landmarks follow from, but without an estimate of the pose: it steps ten times as fast.
    #[must_use]
    fn for_search(self) -> Self;

    /// Time of the last step.
    fn at(&self) -> Moment;

    /// Time of the next step; `None` at the end.
    fn next_at(&self, source: &mut Self::Source) -> Option<Moment>;

    /// Takes the next step.
    fn step(&mut self, source: &mut Self::Source);
}

/// A moment, and the number of lines before it.
pub type LinePlace = (Moment, u64);

/// Functions that start reading a source at any time without reading the earlier part.
pub struct Shortcuts<C: Cursor> {
    /// Makes a state shortly before a moment from any state of the source; the new state lacks events long before.
    pub fresh: fn(&C, &mut C::Source, Moment) -> C,
    /// Estimates the place of a line by its number, from the index.
    pub about_line: fn(&mut C::Source, u64) -> Option<LinePlace>,
    /// Whether there may be a landmark between two moments, by the index.
    pub may_hold: fn(&mut C::Source, Landmark, Moment, Moment) -> bool,
}
