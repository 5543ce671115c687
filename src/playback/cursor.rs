//! The operations of a state that a timeline uses: to step forward, and to enter a capture anywhere.

use super::control::Landmark;
use crate::event::Moment;
use crate::model::Facts;

/// A state that goes forward in time, step by step.
pub trait Cursor: Clone + 'static {
    /// Where its events come from.
    type Source;

    /// The facts at its moment.
    fn facts(&self) -> &Facts;

    /// When the last step happened.
    fn at(&self) -> Moment;

    /// When the next step happens; `None` at the end.
    fn next_at(&self, source: &mut Self::Source) -> Option<Moment>;

    /// Takes the next step.
    fn step(&mut self, source: &mut Self::Source);
}

/// A moment, and the number of lines before it.
pub type LinePlace = (Moment, u64);

/// How to enter a source anywhere without reading what lies before.
pub struct Shortcuts<C: Cursor> {
    /// A state shortly before a moment that lacks what happened long before; any state of the source makes one.
    pub fresh: fn(&C, &mut C::Source, Moment) -> C,
    /// The place of the line of a number, by the index; may be inexact.
    pub about_line: fn(&mut C::Source, u64) -> Option<LinePlace>,
    /// Whether a landmark may lie between two moments, by the index.
    pub may_hold: fn(&mut C::Source, Landmark, Moment, Moment) -> bool,
}
