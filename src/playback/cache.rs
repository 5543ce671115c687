//! Replay cache: recently passed states, for moments near the displayed one.

use std::collections::VecDeque;

use super::cursor::Cursor;
use crate::event::Moment;

/// Number of steps between two cached states.
const CACHE_STEPS: usize = 512;

/// Maximum number of states in the cache; the oldest is dropped first.
const CACHE_MAX: usize = 16;

/// Recently passed complete states.
pub(super) struct Cache<C> {
    pub(super) states: VecDeque<C>,
}

impl<C> Default for Cache<C> {
    fn default() -> Self {
        Self {
            states: VecDeque::new(),
        }
    }
}

impl<C: Cursor> Cache<C> {
    pub(super) fn keep(&mut self, cursor: &C) {
        if self.states.len() == CACHE_MAX {
            self.states.pop_front();
        }
        self.states.push_back(cursor.clone());
    }

    /// Runs to a moment in at most `steps` steps and caches states on the way; returns `false` if more steps are needed.
    pub(super) fn run(
        &mut self,
        cursor: &mut C,
        source: &mut C::Source,
        until: Moment,
        steps: usize,
    ) -> bool {
        let goes_on = |_: &C, next| next <= until;
        go_on(cursor, source, steps, goes_on, |cursor| self.keep(cursor))
    }
}

/// Runs to a moment in at most `steps` steps; returns `false` if more steps are needed.
pub(super) fn run<C: Cursor>(
    cursor: &mut C,
    source: &mut C::Source,
    until: Moment,
    steps: usize,
) -> bool {
    go_on(cursor, source, steps, |_, next| next <= until, |_: &C| {})
}

/// Advances while `goes_on` (given the state and the time of the next step) allows the next step; returns `false` if more than `steps`
/// steps are needed. Passes the state to `pass` every [`CACHE_STEPS`] steps.
pub(super) fn go_on<C: Cursor>(
    cursor: &mut C,
    source: &mut C::Source,
    steps: usize,
    goes_on: impl Fn(&C, Moment) -> bool,
    mut pass: impl FnMut(&C),
) -> bool {
    let mut done = 0;
    while cursor
        .next_at(source)
        .is_some_and(|next| goes_on(cursor, next))
    {
        if done == steps {
            return false;
        }
        cursor.step(source);
        done += 1;
        if done % CACHE_STEPS == 0 {
            pass(cursor);
        }
    }
    true
}
