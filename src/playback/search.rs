//! Searches for a landmark in the unread part of a capture.
//!
//! The search goes through windows of growing length. A window starts from a fresh state, which is enough to find
//! landmarks within it. Windows without the landmark, by the capture's index, are skipped unread.

use super::control::Landmark;
use super::cursor::{Cursor, Shortcuts};
use crate::event::Moment;

/// Length of the first window; each window is twice as long as the previous one.
const SPAN_MIN: Moment = Moment::from_mins(1);

/// Maximum length of a window.
const SPAN_MAX: Moment = Moment::from_hours(1);

/// Number of steps counted for a skipped window: its lines are read, but not taken.
const SKIP_STEPS: usize = 1024;

/// Result of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// The landmark is at this moment.
    At(Moment),
    /// There is no such landmark.
    Nowhere,
    /// The landmark may be in the unread part.
    NotYet,
}

impl Found {
    /// Whether the landmark has been found.
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
    /// Beginning of the next window, or its end if the search goes back.
    edge: Moment,
    span: Moment,
    window: Option<Window<C>>,
    /// The state at the end of the previous window, if the next window begins there.
    reached: Option<C>,
}

#[derive(Clone, Copy)]
enum Direction {
    /// Search forward, to the end.
    Ahead,
    /// Search backward, to this moment.
    Back(Moment),
}

/// A time range that is searched.
struct Window<C> {
    cursor: C,
    from: Moment,
    /// End of the window; excluded.
    until: Moment,
    found: Option<Moment>,
}

impl<C: Cursor> Search<C> {
    /// Searches for the first landmark after a moment.
    pub(super) const fn ahead(
        landmark: Landmark,
        after: Moment,
        shortcuts: &'static Shortcuts<C>,
    ) -> Self {
        let from = after.saturating_add(Moment::from_nanos(1));
        Self::new(landmark, Direction::Ahead, from, shortcuts)
    }

    /// Searches for the last landmark before a moment, back to `back_to`.
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

    /// The moment at which to stop; `None` for a forward search.
    pub(super) const fn back_to(&self) -> Option<Moment> {
        match self.direction {
            Direction::Ahead => None,
            Direction::Back(back_to) => Some(back_to),
        }
    }

    /// Continues the search, in at most `steps` steps; `any` is any state of the capture.
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

    /// Opens the next window in which the index does not rule out the landmark; returns `false` if no window is left.
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
