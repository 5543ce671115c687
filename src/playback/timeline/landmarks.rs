//! Finds moments by landmark.

use super::super::control::Landmark;
use super::super::cursor::{Cursor, Shortcuts};
use super::super::search::{Found, Search};
use super::Timeline;
use crate::event::Moment;

/// Factor of the steps for which a jump searches the unread part in one call.
const SEARCH_FACTOR: usize = 4;

impl<C: Cursor> Timeline<C> {
    /// The first landmark of a kind after a moment. In the unread part, at most `beyond` steps are taken in one call;
    /// [`Self::search`] continues.
    pub fn find_next(&mut self, landmark: Landmark, after: Moment, beyond: usize) -> Found {
        let found = self.find_next_read(landmark, after, beyond);
        self.or_search(found, beyond, |shortcuts| {
            Search::ahead(landmark, after, shortcuts)
        })
    }

    /// The last landmark of a kind before a moment; limited to `beyond` steps, as [`Self::find_next`].
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
                    // Keyframes contain the counts of all earlier landmarks.
                    (Some(kept_at), sought) => self.find_last_read(sought, kept_at, usize::MAX),
                    // The duration of an alarm's cause is certain only after reading everything.
                    (None, Landmark::Alarm) => Found::NotYet,
                    (None, _) => Found::Nowhere,
                };
            }
        }
        Found::NotYet
    }

    /// Whether a search of the unread part is in progress.
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
                    Some(near) if near.at() > frame.at() => near.clone().for_search(),
                    _ => frame.clone().for_search(),
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
            let mut cursor = frame.clone().for_search();
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
}
