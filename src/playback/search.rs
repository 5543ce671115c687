//! Looks for a landmark in the unread part of a capture.
//!
//! The search goes through windows of growing length. A window starts from a fresh state, which is enough to see what is
//! new in it; windows without the landmark, by the capture's index, are skipped unread.

use super::control::Landmark;
use super::cursor::{Cursor, Shortcuts};
use crate::event::Moment;

/// Length of the first window; each is twice as long as the one before.
const SPAN_MIN: Moment = Moment::from_mins(1);

/// Length of the longest window.
const SPAN_MAX: Moment = Moment::from_hours(1);

/// Steps that skipping a window counts for.
const SKIP_STEPS: usize = 512;

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// At this moment.
    At(Moment),
    /// It does not exist.
    Nowhere,
    /// It may lie in the unread part.
    NotYet,
}

impl Found {
    /// Whether it has been found.
    #[must_use]
    pub const fn is_there(self) -> bool {
        matches!(self, Self::At(_))
    }
}

/// A search that can be interrupted.
pub(super) struct Search<C: Cursor> {
    landmark: Landmark,
    direction: Direction,
    shortcuts: &'static Shortcuts<C>,
    /// Where the next window begins, or ends when the search goes back.
    edge: Moment,
    span: Moment,
    window: Option<Window<C>>,
    /// The state at the end of the previous window, if the next window begins there.
    reached: Option<C>,
}

#[derive(Clone, Copy)]
enum Direction {
    /// To the end.
    Ahead,
    /// To this moment.
    Back(Moment),
}

/// A time that is looked through.
struct Window<C> {
    cursor: C,
    from: Moment,
    /// Not included.
    until: Moment,
    found: Option<Moment>,
}

impl<C: Cursor> Search<C> {
    /// Looks for the first after a moment.
    pub(super) const fn ahead(
        landmark: Landmark,
        after: Moment,
        shortcuts: &'static Shortcuts<C>,
    ) -> Self {
        let from = after.saturating_add(Moment::from_nanos(1));
        Self::new(landmark, Direction::Ahead, from, shortcuts)
    }

    /// Looks for the last before a moment and not before `back_to`.
    pub(super) const fn back(
        landmark: Landmark,
        before: Moment,
        back_to: Moment,
        shortcuts: &'static Shortcuts<C>,
    ) -> Self {
        Self::new(landmark, Direction::Back(back_to), before, shortcuts)
    }

    const fn new(
        landmark: Landmark,
        direction: Direction,
        edge: Moment,
        shortcuts: &'static Shortcuts<C>,
    ) -> Self {
        Self {
            landmark,
            direction,
            shortcuts,
            edge,
            span: SPAN_MIN,
            window: None,
            reached: None,
        }
    }

    pub(super) const fn landmark(&self) -> Landmark {
        self.landmark
    }

    /// The moment to stop at; `None` when the search goes ahead.
    pub(super) const fn back_to(&self) -> Option<Moment> {
        match self.direction {
            Direction::Ahead => None,
            Direction::Back(back_to) => Some(back_to),
        }
    }

    /// Takes at most `steps` steps; `any` is any state of the capture.
    pub(super) fn go_on(&mut self, any: &C, source: &mut C::Source, steps: usize) -> Found {
        let mut left = steps;
        loop {
            let Some(mut window) = self.window.take() else {
                if left == 0 {
                    return Found::NotYet;
                }
                left = left.saturating_sub(SKIP_STEPS);
                if !self.open_next(any, source) {
                    return Found::Nowhere;
                }
                continue;
            };
            let goes_back = self.back_to().is_some();
            while let Some(at) = window
                .cursor
                .next_at(source)
                .filter(|at| *at < window.until)
            {
                if left == 0 {
                    self.window = Some(window);
                    return Found::NotYet;
                }
                left -= 1;
                let counted = window.cursor.facts().tally().of(self.landmark);
                window.cursor.step(source);
                let is_new = window.cursor.facts().tally().of(self.landmark) > counted;
                if is_new && at >= window.from {
                    window.found = Some(at);
                    if !goes_back {
                        break;
                    }
                }
            }
            if let Some(at) = window.found {
                return Found::At(at);
            }
            if !goes_back {
                if window.cursor.next_at(source).is_none() {
                    return Found::Nowhere;
                }
                self.reached = Some(window.cursor);
            }
        }
    }

    /// Opens the next window, unless the index rules the landmark out in it; `false` when no window is left.
    fn open_next(&mut self, any: &C, source: &mut C::Source) -> bool {
        let (from, until) = match self.direction {
            Direction::Ahead => (self.edge, self.edge.saturating_add(self.span)),
            Direction::Back(back_to) => {
                (self.edge.saturating_sub(self.span).max(back_to), self.edge)
            }
        };
        if from >= until {
            return false;
        }
        self.edge = match self.direction {
            Direction::Ahead => until,
            Direction::Back(_) => from,
        };
        self.span = SPAN_MAX.min(self.span * 2);
        let reached = self.reached.take();
        if !(self.shortcuts.may_hold)(source, self.landmark, from, until) {
            return true;
        }
        let cursor = reached.unwrap_or_else(|| (self.shortcuts.fresh)(any, source, from));
        self.window = Some(Window {
            cursor,
            from,
            until,
            found: None,
        });
        true
    }
}
