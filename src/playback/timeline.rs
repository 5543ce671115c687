//! Finds moments: by time, by line, by landmark.

use super::cache::{Cache, go_on, run};
use super::control::Landmark;
use super::cursor::{Cursor, Shortcuts};
use super::keyframes::Keyframes;
use super::search::Search;
use crate::event::Moment;
use crate::model::Facts;

/// Most steps to a moment before an incomplete state is shown meanwhile.
pub const STEPS_MAX: usize = 4096;

/// Most steps between two kept states before a moment among them is searched for like one in the unread part.
const READ_STEPS_MAX: usize = 32_768;

/// How many times as many steps a jump searches the unread part at once.
const SEARCH_FACTOR: usize = 4;

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

/// Every moment of a capture or of a live session that can be shown.
pub struct Timeline<C: Cursor> {
    source: C::Source,
    /// `None` where every state is near.
    shortcuts: Option<&'static Shortcuts<C>>,
    frames: Keyframes<C>,
    cache: Cache<C>,
    shown: C,
    /// The complete state on its way to the shown moment, while `shown` is incomplete.
    catch_up: Option<C>,
    /// The moment to show, until `shown` has reached it.
    behind: Option<Moment>,
    /// A search in the unread part.
    search: Option<Search<C>>,
    /// Keyframes reach to the end.
    is_complete: bool,
}

impl<C: Cursor> Timeline<C> {
    /// A timeline of which every state is kept, standing at its first moment.
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

    /// A timeline of which states are still being read: [`Self::complete`] says when all are kept.
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

    /// When the last step shown happened.
    #[must_use]
    pub fn at(&self) -> Moment {
        self.shown.at()
    }

    /// Where events come from.
    #[must_use]
    pub const fn source(&self) -> &C::Source {
        &self.source
    }

    /// Where events come from.
    pub const fn source_mut(&mut self) -> &mut C::Source {
        &mut self.source
    }

    /// Number of the newest line shown; `None` while it is unknown.
    #[must_use]
    pub fn packet(&self) -> Option<u64> {
        self.catch_up.is_none().then(|| self.facts().tally().lines)
    }

    /// Whether the shown state lacks what happened long before.
    #[must_use]
    pub const fn is_partial(&self) -> bool {
        self.catch_up.is_some()
    }

    /// Whether there is something to do for [`Self::work`] or [`Self::search`].
    #[must_use]
    pub const fn has_work(&self) -> bool {
        self.behind.is_some() || self.is_partial() || self.is_searching()
    }

    /// When the next step happens.
    pub fn next_at(&mut self) -> Option<Moment> {
        self.shown.next_at(&mut self.source)
    }

    /// Keeps a state newer than those kept.
    pub fn keep(&mut self, frame: C) {
        self.frames.push(frame.at(), frame);
    }

    /// Whether a state is wanted at a moment.
    #[must_use]
    pub fn wants(&self, at: Moment) -> bool {
        self.frames.wants(at)
    }

    /// The oldest moment that can be shown.
    #[must_use]
    pub fn oldest_at(&self) -> Option<Moment> {
        self.frames.get(0).map(|(at, _)| *at)
    }

    /// All states have been read and kept.
    pub const fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Forgets states that are not needed to show `at` or later; returns the oldest left if any went.
    pub fn forget_before(&mut self, at: Moment) -> Option<&C> {
        let has_gone = self.frames.forget_before(at);
        has_gone.then(|| self.oldest_left()).flatten()
    }

    /// Forgets the oldest state unless it is the only one; returns the oldest left.
    pub fn forget_oldest(&mut self) -> Option<&C> {
        self.frames.forget_oldest();
        self.oldest_left()
    }

    fn oldest_left(&mut self) -> Option<&C> {
        let (oldest_at, oldest) = self.frames.get(0)?;
        // A cached state of the same moment may stand before forgotten events.
        self.cache.states.retain(|state| state.at() > *oldest_at);
        Some(oldest)
    }

    /// Shows a moment: everything that happened until then, inclusive. After many steps [`Self::work`] goes on.
    pub fn seek(&mut self, at: Moment) {
        let mut cursor = self.exact_before(at);
        if self.cache.run(&mut cursor, &mut self.source, at, STEPS_MAX) {
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

    /// Advances to a moment. After many steps [`Self::work`] continues.
    pub fn run_to(&mut self, at: Moment) {
        // Where every state is near there are no more steps than in a live session of an hour.
        let steps = self.shortcuts.map_or(usize::MAX, |_| STEPS_MAX);
        self.run(at, steps);
    }

    /// Runs to a moment in at most `steps` steps; says whether it is reached.
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

    /// The nearest complete state not after a moment.
    fn exact_before(&self, at: Moment) -> C {
        self.nearest(|cursor| cursor.at() <= at)
            .unwrap_or(&self.shown)
            .clone()
    }

    /// The newest complete state for which `holds`, which must hold for all before it, too; the first state where it
    /// holds for none.
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

    /// Brings the shown state to its moment, then completes it, in at most `steps` steps; says whether it is there, or
    /// complete, now.
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

    /// Shows the line after the newest one shown.
    pub fn step_forward(&mut self) -> Found {
        let lines = self.facts().tally().lines;
        let mut cursor = self.shown.clone();
        let goes_on = |cursor: &C, _| cursor.facts().tally().lines == lines;
        let is_decided = go_on(&mut cursor, &mut self.source, STEPS_MAX, goes_on, |_| {});
        if cursor.facts().tally().lines > lines {
            let at = cursor.at();
            self.shown = cursor;
            self.behind = None;
            return Found::At(at);
        }
        if is_decided {
            Found::Nowhere
        } else {
            Found::NotYet
        }
    }

    /// Shows the line before the newest one shown.
    pub fn step_back(&mut self) -> Found {
        if self.is_partial() {
            return self.step_back_by_time();
        }
        match self.facts().tally().lines {
            0 | 1 => Found::Nowhere,
            lines => self.seek_line(lines - 1, READ_STEPS_MAX),
        }
    }

    /// Finds the line before by time, where its number is unknown.
    fn step_back_by_time(&mut self) -> Found {
        let Some(line_at) = self.facts().newest_line_at() else {
            return Found::Nowhere;
        };
        let Some(shortcuts) = self.shortcuts else {
            return Found::Nowhere;
        };
        let mut cursor = (shortcuts.fresh)(&self.shown, &mut self.source, line_at);
        let mut before = None;
        let mut steps = READ_STEPS_MAX;
        while let Some(at) = cursor.next_at(&mut self.source).filter(|at| *at < line_at) {
            if steps == 0 {
                return Found::NotYet;
            }
            steps -= 1;
            let lines = cursor.facts().tally().lines;
            cursor.step(&mut self.source);
            if cursor.facts().tally().lines > lines {
                before = Some((at, cursor.clone()));
            }
        }
        let Some((at, cursor)) = before else {
            return Found::Nowhere;
        };
        self.shown = cursor;
        self.behind = None;
        Found::At(at)
    }

    /// Shows the line of a number, from 1. In the unread part at most `beyond` steps after the newest state are taken.
    pub fn seek_line(&mut self, number: u64, beyond: usize) -> Found {
        let lines = |cursor: &C| cursor.facts().tally().lines;
        let place = self.frames.last_where(|frame| lines(frame) < number);
        if place.is_none() {
            return Found::Nowhere;
        }
        let nearest = self.nearest(|cursor| lines(cursor) < number);
        let mut cursor = nearest.unwrap_or(&self.shown).clone();
        let is_newest = place.is_none_or(|place| self.frames.get(place + 1).is_none());
        let reach = self.reach(is_newest, beyond);
        let source = &mut self.source;
        go_on(
            &mut cursor,
            source,
            reach,
            |cursor, _| lines(cursor) < number,
            |cursor| self.cache.keep(cursor),
        );
        if lines(&cursor) >= number {
            let at = cursor.at();
            self.show(cursor);
            return Found::At(at);
        }
        self.missed(&cursor)
    }

    /// Shows the line of a number at its place in the unread part, estimated by the index; returns its moment, `None`
    /// where there is no estimate.
    pub fn seek_about_line(&mut self, number: u64) -> Option<Moment> {
        let shortcuts = self.shortcuts?;
        let (from, before) = (shortcuts.about_line)(&mut self.source, number)?;
        let lines = |cursor: &C| cursor.facts().tally().lines;
        let mut fresh = (shortcuts.fresh)(&self.shown, &mut self.source, from);
        let source = &mut self.source;
        go_on(
            &mut fresh,
            source,
            READ_STEPS_MAX,
            |_, next| next < from,
            |_| {},
        );
        let wanted = lines(&fresh).saturating_add(number.checked_sub(before)?);
        let goes_on = |cursor: &C, _| lines(cursor) < wanted;
        go_on(&mut fresh, source, STEPS_MAX, goes_on, |_| {});
        let at = fresh.at();
        if lines(&fresh) < wanted {
            return None;
        }
        let cursor = self.exact_before(at);
        self.show(fresh);
        self.catch_up = Some(cursor);
        Some(at)
    }

    /// The first landmark of a kind after a moment. In the unread part at most `beyond` steps are taken at once;
    /// [`Self::search`] continues.
    pub fn find_next(&mut self, landmark: Landmark, after: Moment, beyond: usize) -> Found {
        let found = self.find_next_read(landmark, after, beyond);
        self.or_search(found, beyond, |shortcuts| {
            Search::ahead(landmark, after, shortcuts)
        })
    }

    /// The last landmark of a kind before a moment, likewise.
    pub fn find_last(&mut self, landmark: Landmark, before: Moment, beyond: usize) -> Found {
        let found = self.find_last_read(landmark, before, beyond);
        let kept = self.frames.before(Moment::MAX);
        let kept = kept.and_then(|place| self.frames.get(place));
        let kept_at = kept.map_or(Moment::ZERO, |(at, _)| *at);
        self.or_search(found, beyond, |shortcuts| {
            Search::back(landmark, before, kept_at, shortcuts)
        })
    }

    fn or_search(
        &mut self,
        found: Found,
        beyond: usize,
        search: impl FnOnce(&'static Shortcuts<C>) -> Search<C>,
    ) -> Found {
        if found != Found::NotYet {
            self.search = None;
        } else if let Some(shortcuts) = self.shortcuts.filter(|_| beyond > 0) {
            self.search = Some(search(shortcuts));
            return self.search(beyond.saturating_mul(SEARCH_FACTOR));
        }
        found
    }

    /// Continues the search of the unread part, in at most `steps` steps.
    pub fn search(&mut self, steps: usize) -> Found {
        let Some(mut search) = self.search.take() else {
            return Found::NotYet;
        };
        match search.go_on(&self.shown, &mut self.source, steps) {
            Found::NotYet => self.search = Some(search),
            Found::At(at) => return Found::At(at),
            Found::Nowhere => {
                return match (search.back_to(), search.landmark()) {
                    // Kept states know everything before them.
                    (Some(kept_at), sought) => self.find_last_read(sought, kept_at, usize::MAX),
                    // How long an alarm's cause has lasted is certain only after reading everything.
                    (None, Landmark::Alarm) => Found::NotYet,
                    (None, _) => Found::Nowhere,
                };
            }
        }
        Found::NotYet
    }

    /// Whether a search of the unread part is under way.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        self.search.is_some()
    }

    /// Ends the search.
    pub fn stop_search(&mut self) {
        self.search = None;
    }

    fn find_next_read(&mut self, landmark: Landmark, after: Moment, beyond: usize) -> Found {
        let mut place = self.frames.before(after).unwrap_or(0);
        while let Some((_, frame)) = self.frames.get(place) {
            let end = self.frames.get(place + 1);
            let count = |cursor: &C| cursor.facts().tally().of(landmark);
            if end.is_none_or(|(_, end)| count(end) > count(frame)) {
                let until = end.map(|(at, _)| *at);
                let mut cursor = match self.nearest(|cursor| cursor.at() <= after) {
                    Some(near) if near.at() > frame.at() => near.clone(),
                    _ => frame.clone(),
                };
                let mut steps = self.reach(until.is_none(), beyond);
                let last = until.unwrap_or(Moment::MAX);
                while let Some(at) = cursor.next_at(&mut self.source).filter(|at| *at <= last) {
                    if steps == 0 {
                        return Found::NotYet;
                    }
                    steps -= 1;
                    let before = count(&cursor);
                    cursor.step(&mut self.source);
                    if at > after && count(&cursor) > before {
                        return Found::At(at);
                    }
                }
                if until.is_none() {
                    return self.missed(&cursor);
                }
            }
            place += 1;
        }
        Found::Nowhere
    }

    fn find_last_read(&mut self, landmark: Landmark, before: Moment, beyond: usize) -> Found {
        let count = |cursor: &C| cursor.facts().tally().of(landmark);
        let mut places = 0..=self.frames.before(before).unwrap_or(0);
        while let Some(place) = places.next_back() {
            let Some((_, frame)) = self.frames.get(place) else {
                break;
            };
            let end = self.frames.get(place + 1);
            if end.is_some_and(|(at, end)| *at < before && count(end) == count(frame)) {
                continue;
            }
            let last = end.map_or(before, |(at, _)| before.min(*at));
            let mut steps = self.reach(end.is_none(), beyond);
            let mut cursor = frame.clone();
            let mut found = None;
            while let Some(at) = cursor.next_at(&mut self.source).filter(|at| *at <= last) {
                if at >= before {
                    break;
                }
                if steps == 0 {
                    return Found::NotYet;
                }
                steps -= 1;
                let counted = count(&cursor);
                cursor.step(&mut self.source);
                if count(&cursor) > counted {
                    found = Some(at);
                }
            }
            if let Some(at) = found {
                return Found::At(at);
            }
        }
        Found::Nowhere
    }

    /// Most steps to search from a state.
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
