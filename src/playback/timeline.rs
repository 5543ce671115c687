//! Finds moments: by time in this file, by line in `lines`, by landmark in `landmarks`.

mod landmarks;
mod lines;

use super::cache::{Cache, run};
use super::cursor::{Cursor, Shortcuts};
use super::keyframes::Keyframes;
use super::search::{Found, Search};
use crate::event::Moment;
use crate::model::Facts;

/// Maximum number of steps of a jump before other inputs are handled. The compass takes 20 to 40 us of a step.
pub const STEPS_MAX: usize = 2048;

/// Maximum number of steps of a seek: 20 ms. If more are needed, an incomplete state is shown meanwhile.
const SEEK_STEPS_MAX: usize = 512;

/// Maximum number of steps between two keyframes; a moment between more distant ones is searched for as in the unread part.
const READ_STEPS_MAX: usize = 32_768;

/// The moments of a capture or of a live session that can be shown.
pub struct Timeline<C: Cursor> {
    source: C::Source,
    /// Functions that start reading the source at any time; `None` if keyframes are dense.
    shortcuts: Option<&'static Shortcuts<C>>,
    frames: Keyframes<C>,
    cache: Cache<C>,
    shown: C,
    /// The complete state, which steps toward the shown moment while `shown` is incomplete.
    catch_up: Option<C>,
    /// The moment to show, until `shown` has reached it.
    behind: Option<Moment>,
    /// The search in the unread part.
    search: Option<Search<C>>,
    /// Whether keyframes reach to the end.
    is_complete: bool,
}

impl<C: Cursor> Timeline<C> {
    /// A timeline with keyframes up to its end, at its first moment.
    #[must_use]
    pub fn new(source: C::Source, first: C, spacing: Moment) -> Self {
        let mut frames = Keyframes::new(spacing);
        frames.push(first.at(), first.clone());
        Self {
            source,
            shortcuts: None,
            frames,
            cache: Cache::default(),
            shown: first,
            catch_up: None,
            behind: None,
            search: None,
            is_complete: true,
        }
    }

    /// A timeline whose keyframes are still being read; call [`Self::complete`] when all are kept.
    #[must_use]
    pub fn unread(
        source: C::Source,
        shortcuts: &'static Shortcuts<C>,
        first: C,
        spacing: Moment,
    ) -> Self {
        Self {
            shortcuts: Some(shortcuts),
            is_complete: false,
            ..Self::new(source, first, spacing)
        }
    }

    /// The facts at the shown moment.
    #[must_use]
    pub fn facts(&self) -> &Facts {
        self.shown.facts()
    }

    /// Time of the last displayed step.
    #[must_use]
    pub fn at(&self) -> Moment {
        self.shown.at()
    }

    /// Source of the events.
    #[must_use]
    pub const fn source(&self) -> &C::Source {
        &self.source
    }

    /// Source of the events.
    pub const fn source_mut(&mut self) -> &mut C::Source {
        &mut self.source
    }

    /// Number of the newest displayed line, from 1; `None` while unknown.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        self.catch_up.is_none().then(|| self.facts().tally().lines)
    }

    /// Whether the displayed state lacks events long before it.
    #[must_use]
    pub const fn is_partial(&self) -> bool {
        self.catch_up.is_some()
    }

    /// Whether [`Self::work`] or [`Self::search`] must be called.
    #[must_use]
    pub const fn has_work(&self) -> bool {
        self.behind.is_some() || self.is_partial() || self.is_searching()
    }

    /// Time of the next step.
    pub fn next_at(&mut self) -> Option<Moment> {
        self.shown.next_at(&mut self.source)
    }

    /// Adds a keyframe, which must be newer than the others.
    pub fn keep(&mut self, frame: C) {
        self.frames.push(frame.at(), frame);
    }

    /// Whether a keyframe is due at a moment.
    #[must_use]
    pub fn wants(&self, at: Moment) -> bool {
        self.frames.wants(at)
    }

    /// The oldest moment that can be shown.
    #[must_use]
    pub fn oldest_at(&self) -> Option<Moment> {
        self.frames.get(0).map(|(at, _)| *at)
    }

    /// Sets that all keyframes have been read.
    pub const fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Drops keyframes that are not needed to show `at` or later; returns the oldest remaining one if any was dropped.
    pub fn forget_before(&mut self, at: Moment) -> Option<&C> {
        let has_gone = self.frames.forget_before(at);
        has_gone.then(|| self.oldest_left()).flatten()
    }

    /// Drops the oldest keyframe unless it is the only one; returns the oldest remaining one.
    pub fn forget_oldest(&mut self) -> Option<&C> {
        self.frames.forget_oldest();
        self.oldest_left()
    }

    fn oldest_left(&mut self) -> Option<&C> {
        let (oldest_at, oldest) = self.frames.get(0)?;
        // A cached state of the same moment may precede dropped events.
        self.cache.states.retain(|state| state.at() > *oldest_at);
        Some(oldest)
    }

    /// Shows the state at a moment, including its events. If many steps are needed, [`Self::work`] continues.
    pub fn seek(&mut self, at: Moment) {
        let mut cursor = self.exact_before(at);
        if self
            .cache
            .run(&mut cursor, &mut self.source, at, SEEK_STEPS_MAX)
        {
            self.show(cursor);
            return;
        }
        let shortcuts = self.shortcuts;
        match shortcuts.map(|to| (to.fresh)(&cursor, &mut self.source, at)) {
            Some(fresh) if fresh.at() > cursor.at() => {
                self.show(fresh);
                self.catch_up = Some(cursor);
            }
            _ => self.show(cursor),
        }
        self.run_to(at);
    }

    /// Advances to a moment. If many steps are needed, [`Self::work`] continues.
    pub fn run_to(&mut self, at: Moment) {
        // With dense keyframes, there are no more steps than in a live session of an hour.
        let steps = self.shortcuts.map_or(usize::MAX, |_| STEPS_MAX);
        self.run(at, steps);
    }

    /// Runs to a moment in at most `steps` steps; returns whether it is reached.
    fn run(&mut self, at: Moment, steps: usize) -> bool {
        let is_there = run(&mut self.shown, &mut self.source, at, steps);
        self.behind = (!is_there).then_some(at);
        is_there
    }

    fn show(&mut self, cursor: C) {
        self.shown = cursor;
        self.catch_up = None;
        self.behind = None;
    }

    /// The latest complete state at or before a moment.
    fn exact_before(&self, at: Moment) -> C {
        self.nearest(|cursor| cursor.at() <= at)
            .unwrap_or(&self.shown)
            .clone()
    }

    /// The newest complete state for which `holds` is true (it must also be true for all earlier states); the first state if it
    /// is true for none.
    fn nearest(&self, holds: impl Fn(&C) -> bool) -> Option<&C> {
        let place = self.frames.last_where(&holds).unwrap_or(0);
        let frame = self.frames.get(place).map(|(_, frame)| frame);
        let exact = self.catch_up.as_ref().unwrap_or(&self.shown);
        let others = self.cache.states.iter().chain([exact]);
        let newer = others.filter(|cursor| holds(cursor));
        frame
            .into_iter()
            .chain(newer)
            .max_by_key(|cursor| cursor.at())
    }

    /// Advances the shown state to its moment, then completes it, in at most `steps` steps; returns whether it has now reached the moment or
    /// become complete.
    pub fn work(&mut self, steps: usize) -> bool {
        if let Some(at) = self.behind {
            return self.run(at, steps);
        }
        let Some(mut catch_up) = self.catch_up.take() else {
            return false;
        };
        let target = self.shown.at();
        if let Some((at, frame)) = self.frames.before(target).and_then(|n| self.frames.get(n))
            && *at > catch_up.at()
        {
            catch_up = frame.clone();
        }
        let is_there = self
            .cache
            .run(&mut catch_up, &mut self.source, target, steps);
        if is_there {
            self.shown = catch_up;
        } else {
            self.catch_up = Some(catch_up);
        }
        is_there
    }

    /// Maximum number of steps to search from a state.
    const fn reach(&self, is_newest: bool, beyond: usize) -> usize {
        if self.is_complete || !is_newest {
            READ_STEPS_MAX
        } else {
            beyond
        }
    }

    /// The result of a search that ended at a state without success.
    fn missed(&mut self, cursor: &C) -> Found {
        match cursor.next_at(&mut self.source) {
            Some(_) => Found::NotYet,
            None => Found::Nowhere,
        }
    }
}
