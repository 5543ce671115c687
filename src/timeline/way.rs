//! The way from a state to a moment, and states that are kept of it.

use std::collections::VecDeque;

use super::reel::Cursor;
use crate::event::Moment;

/// Of what is gone through on the way to a moment a state is kept every so many things: what lies near the moment is
/// there at once, however far apart the states of the whole are.
const NEAR_STEPS: usize = 512;

/// The newest so many of these are kept.
const NEAR_MAX: usize = 16;

/// States of what was gone through lately.
pub(super) struct Near<C> {
    pub(super) states: VecDeque<C>,
}

impl<C> Default for Near<C> {
    fn default() -> Self {
        Self {
            states: VecDeque::new(),
        }
    }
}

impl<C: Cursor> Near<C> {
    pub(super) fn keep(&mut self, cursor: &C) {
        if self.states.len() == NEAR_MAX {
            self.states.pop_front();
        }
        self.states.push_back(cursor.clone());
    }

    /// As [`run`], and keeps states on the way.
    pub(super) fn run(
        &mut self,
        cursor: &mut C,
        supply: &mut C::Supply,
        until: Moment,
        steps: usize,
    ) -> bool {
        let goes_on = |_: &C, next| next <= until;
        go_on(cursor, supply, steps, goes_on, |cursor| self.keep(cursor))
    }
}

/// Lets everything happen up to a moment.
pub(super) fn run<C: Cursor>(cursor: &mut C, supply: &mut C::Supply, until: Moment) {
    go_on(
        cursor,
        supply,
        usize::MAX,
        |_, next| next <= until,
        |_: &C| {},
    );
}

/// Lets things happen while the state and the moment of the next thing allow it; `false` when there were more things
/// than that. Every [`NEAR_STEPS`] the state is shown to `pass`.
pub(super) fn go_on<C: Cursor>(
    cursor: &mut C,
    supply: &mut C::Supply,
    steps: usize,
    goes_on: impl Fn(&C, Moment) -> bool,
    mut pass: impl FnMut(&C),
) -> bool {
    let mut done = 0;
    while cursor
        .next_at(supply)
        .is_some_and(|next| goes_on(cursor, next))
    {
        if done == steps {
            return false;
        }
        cursor.step(supply);
        done += 1;
        if done % NEAR_STEPS == 0 {
            pass(cursor);
        }
    }
    true
}
