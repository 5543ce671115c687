//! Looks for a landmark where nobody has read yet.
//!
//! What a state lacks that is there at once is enough to see what is new after it. It is gone through in windows, and
//! those in which there is none, as the capture tells without being read, are left out.

use super::reel::{Cursor, Found};
use crate::event::Moment;
use crate::travel::Landmark;

/// The first window; each is twice as long as the one before.
const SPAN_MIN: Moment = Moment::from_mins(1);

/// The longest.
const SPAN_MAX: Moment = Moment::from_hours(1);

/// To leave a window out takes as long as going through so many things, at most.
const SKIP_STEPS: usize = 512;

/// A search that can be interrupted.
pub(super) struct Hunt<C> {
    landmark: Landmark,
    way: Way,
    /// Where the next window begins, or ends when it goes back.
    edge: Moment,
    span: Moment,
    window: Option<Window<C>>,
    /// The state at which the window before ended, while that is where the next begins.
    reached: Option<C>,
}

/// Which way it goes.
#[derive(Clone, Copy)]
enum Way {
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

impl<C: Cursor> Hunt<C> {
    /// For the first after a moment.
    pub(super) const fn ahead(landmark: Landmark, after: Moment) -> Self {
        let from = after.saturating_add(Moment::from_nanos(1));
        Self::new(landmark, Way::Ahead, from)
    }

    /// For the last before a moment and not before another.
    pub(super) const fn back(landmark: Landmark, before: Moment, back_to: Moment) -> Self {
        Self::new(landmark, Way::Back(back_to), before)
    }

    const fn new(landmark: Landmark, way: Way, edge: Moment) -> Self {
        Self {
            landmark,
            way,
            edge,
            span: SPAN_MIN,
            window: None,
            reached: None,
        }
    }

    pub(super) const fn landmark(&self) -> Landmark {
        self.landmark
    }

    /// How far back it goes; `None` when it goes ahead.
    pub(super) const fn back_to(&self) -> Option<Moment> {
        match self.way {
            Way::Ahead => None,
            Way::Back(back_to) => Some(back_to),
        }
    }

    /// Goes through so many things. Any state says how one is made that is there at once.
    pub(super) fn go_on(&mut self, any: &C, supply: &mut C::Supply, steps: usize) -> Found {
        let mut left = steps;
        loop {
            let Some(mut window) = self.window.take() else {
                if left == 0 {
                    return Found::NotYet;
                }
                left = left.saturating_sub(SKIP_STEPS);
                if !self.open_next(any, supply) {
                    return Found::Nowhere;
                }
                continue;
            };
            let goes_back = self.back_to().is_some();
            while let Some(at) = window
                .cursor
                .next_at(supply)
                .filter(|at| *at < window.until)
            {
                if left == 0 {
                    self.window = Some(window);
                    return Found::NotYet;
                }
                left -= 1;
                let counted = window.cursor.facts().tally().of(self.landmark);
                window.cursor.step(supply);
                let is_one = window.cursor.facts().tally().of(self.landmark) > counted;
                if is_one && at >= window.from {
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
                if window.cursor.next_at(supply).is_none() {
                    return Found::Nowhere;
                }
                self.reached = Some(window.cursor);
            }
        }
    }

    /// Opens the next window, if there may be one in it; `false` when there is no window any more.
    fn open_next(&mut self, any: &C, supply: &mut C::Supply) -> bool {
        let (from, until) = match self.way {
            Way::Ahead => (self.edge, self.edge.saturating_add(self.span)),
            Way::Back(back_to) => (self.edge.saturating_sub(self.span).max(back_to), self.edge),
        };
        if from >= until {
            return false;
        }
        self.edge = match self.way {
            Way::Ahead => until,
            Way::Back(_) => from,
        };
        self.span = SPAN_MAX.min(self.span * 2);
        let reached = self.reached.take();
        if !C::may_hold(supply, self.landmark, from, until) {
            return true;
        }
        let Some(cursor) = reached.or_else(|| any.afresh(supply, from)) else {
            return false;
        };
        self.window = Some(Window {
            cursor,
            from,
            until,
            found: None,
        });
        true
    }
}
