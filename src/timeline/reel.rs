//! Finds moments: by time, by line, by landmark.

use super::hunt::Hunt;
use super::keyframes::Keyframes;
use super::way::{Near, go_on, run};
use crate::event::Moment;
use crate::model::Facts;
use crate::travel::Landmark;

/// A state that goes forward in time, thing by thing.
pub trait Cursor: Clone {
    /// Where it takes what happens next from.
    type Supply;

    /// What is known at its moment.
    fn facts(&self) -> &Facts;

    /// When the last thing happened.
    fn at(&self) -> Moment;

    /// When the next thing happens; `None` at the end.
    fn next_at(&self, supply: &mut Self::Supply) -> Option<Moment>;

    /// Lets the next thing happen.
    fn step(&mut self, supply: &mut Self::Supply);

    /// A state that knows nothing of what happened long before a moment and so is there at once; `None`
    /// where no state is ever far away.
    fn afresh(&self, supply: &mut Self::Supply, at: Moment) -> Option<Self>;

    /// When the line of a number came, and how many lines came before that moment, as far as the supply tells without
    /// being read.
    fn about_line(supply: &mut Self::Supply, number: u64) -> Option<(Moment, u64)>;

    /// Whether there may be a landmark of a kind from one moment until another, as far as the supply tells without
    /// being read.
    fn may_hold(supply: &mut Self::Supply, landmark: Landmark, from: Moment, until: Moment)
    -> bool;
}

/// Going somewhere takes no more things than this before something less than exact is shown.
pub const STEPS_MAX: usize = 4096;

/// Where no kept state is near, a jump goes through so many times as many things before it waits for what is being read.
const HUNTS: usize = 4;

/// What became of a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// It is here.
    At(Moment),
    /// There is none.
    Nowhere,
    /// Nobody has read as far as it may be.
    NotYet,
}

/// All that can be shown of a capture or a session.
pub struct Reel<C: Cursor> {
    supply: C::Supply,
    frames: Keyframes<C>,
    /// States that lack nothing, of what was gone through lately.
    near: Near<C>,
    shown: C,
    /// On its way to the shown moment with everything that happened before, while `shown` lacks that.
    chase: Option<C>,
    /// A search where nobody has read yet.
    hunt: Option<Hunt<C>>,
    /// Keyframes reach to the end.
    is_complete: bool,
}

impl<C: Cursor> Reel<C> {
    /// A reel that shows a first moment, before which nothing happened.
    #[must_use]
    pub fn new(supply: C::Supply, first: C, spacing: Moment) -> Self {
        let mut frames = Keyframes::new(spacing);
        frames.push(first.at(), first.clone());
        Self {
            supply,
            frames,
            near: Near::default(),
            shown: first,
            chase: None,
            hunt: None,
            is_complete: false,
        }
    }

    /// What is known at the shown moment.
    #[must_use]
    pub fn facts(&self) -> &Facts {
        self.shown.facts()
    }

    /// When the last thing shown happened.
    #[must_use]
    pub fn at(&self) -> Moment {
        self.shown.at()
    }

    /// Where things come from.
    #[must_use]
    pub const fn supply(&self) -> &C::Supply {
        &self.supply
    }

    /// Where things come from.
    pub const fn supply_mut(&mut self) -> &mut C::Supply {
        &mut self.supply
    }

    /// Number of the newest line shown; `None` while that is not known.
    #[must_use]
    pub fn packet(&self) -> Option<u64> {
        self.chase.is_none().then(|| self.facts().tally().lines)
    }

    /// Whether what happened long before the shown moment is missing from it.
    #[must_use]
    pub const fn is_partial(&self) -> bool {
        self.chase.is_some()
    }

    /// When the next thing happens.
    pub fn next_at(&mut self) -> Option<Moment> {
        self.shown.next_at(&mut self.supply)
    }

    /// Takes a state of the reel, newer than those it has.
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

    /// Everything has been read: its states are here.
    pub const fn complete(&mut self) {
        self.is_complete = true;
    }

    /// Forgets states that are not needed to show a moment or later; returns the oldest that is left.
    pub fn forget_before(&mut self, at: Moment) -> Option<&C> {
        let has_gone = self.frames.forget_before(at);
        let (oldest_at, oldest) = self.frames.get(0).filter(|_| has_gone)?;
        // One of the same moment may stand before what is forgotten.
        self.near.states.retain(|near| near.at() > *oldest_at);
        Some(oldest)
    }

    /// Shows a moment: everything that happened until then, it included.
    pub fn seek(&mut self, at: Moment) {
        let mut cursor = self.exact_before(at);
        if self.near.run(&mut cursor, &mut self.supply, at, STEPS_MAX) {
            self.show(cursor);
            return;
        }
        match cursor.afresh(&mut self.supply, at) {
            Some(mut fresh) if fresh.at() > cursor.at() => {
                run(&mut fresh, &mut self.supply, at);
                self.shown = fresh;
                self.chase = Some(cursor);
            }
            _ => {
                self.near.run(&mut cursor, &mut self.supply, at, usize::MAX);
                self.show(cursor);
            }
        }
    }

    /// Lets time pass until a moment.
    pub fn run_to(&mut self, at: Moment) {
        run(&mut self.shown, &mut self.supply, at);
    }

    fn show(&mut self, cursor: C) {
        self.shown = cursor;
        self.chase = None;
    }

    /// The nearest state that lacks nothing and is not after a moment.
    fn exact_before(&self, at: Moment) -> C {
        self.nearest(|cursor| cursor.at() <= at)
            .unwrap_or(&self.shown)
            .clone()
    }

    /// The newest state that lacks nothing of those for which something holds that holds for all before them, too;
    /// the first of all states where it holds for none.
    fn nearest(&self, holds: impl Fn(&C) -> bool) -> Option<&C> {
        let place = self.frames.last_where(&holds).unwrap_or(0);
        let frame = self.frames.get(place).map(|(_, frame)| frame);
        let exact = self.chase.as_ref().unwrap_or(&self.shown);
        let others = self.near.states.iter().chain([exact]);
        let newer = others.filter(|cursor| holds(cursor));
        frame
            .into_iter()
            .chain(newer)
            .max_by_key(|cursor| cursor.at())
    }

    /// Works on what is missing from the shown moment, for so many things; says whether it is there now.
    pub fn work(&mut self, steps: usize) -> bool {
        let Some(mut chase) = self.chase.take() else {
            return false;
        };
        let target = self.shown.at();
        if let Some((at, frame)) = self.frames.before(target).and_then(|n| self.frames.get(n))
            && *at > chase.at()
        {
            chase = frame.clone();
        }
        let is_there = self.near.run(&mut chase, &mut self.supply, target, steps);
        if is_there {
            self.shown = chase;
        } else {
            self.chase = Some(chase);
        }
        is_there
    }

    /// Shows the line after the newest one shown; `false` when there is none.
    pub fn step_forward(&mut self) -> bool {
        let lines = self.facts().tally().lines;
        let mut cursor = self.shown.clone();
        let goes_on = |cursor: &C, _| cursor.facts().tally().lines == lines;
        go_on(&mut cursor, &mut self.supply, usize::MAX, goes_on, |_| {});
        let is_there = cursor.facts().tally().lines > lines;
        if is_there {
            self.shown = cursor;
        }
        is_there
    }

    /// Shows the line before the newest one shown; `false` when there is none.
    pub fn step_back(&mut self) -> bool {
        if self.is_partial() {
            return self.step_back_by_time();
        }
        let lines = self.facts().tally().lines;
        lines > 1 && self.seek_line(lines - 1, usize::MAX) != Found::Nowhere
    }

    /// Where the number of a line is not known, its time says which it is.
    fn step_back_by_time(&mut self) -> bool {
        let Some(line_at) = self.facts().newest_line_at() else {
            return false;
        };
        let Some(mut cursor) = self.shown.afresh(&mut self.supply, line_at) else {
            return false;
        };
        let mut before = None;
        while let Some(at) = cursor.next_at(&mut self.supply).filter(|at| *at < line_at) {
            let lines = cursor.facts().tally().lines;
            cursor.step(&mut self.supply);
            if cursor.facts().tally().lines > lines {
                before = Some((at, cursor.clone()));
            }
        }
        let Some((_, cursor)) = before else {
            return false;
        };
        self.shown = cursor;
        true
    }

    /// Shows the line of a number, from 1, at its moment. While the reel is not complete, so many things behind its
    /// newest state are looked through.
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
        let supply = &mut self.supply;
        go_on(
            &mut cursor,
            supply,
            reach,
            |cursor, _| lines(cursor) < number,
            |cursor| self.near.keep(cursor),
        );
        if lines(&cursor) >= number {
            let at = cursor.at();
            self.show(cursor);
            return Found::At(at);
        }
        self.missed(&cursor)
    }

    /// Shows the line of a number where nobody has read yet, as far as the capture tells where it is: another one is
    /// shown where it tells no more than about where. Says when the line is; `None` where nothing tells.
    pub fn seek_about_line(&mut self, number: u64) -> Option<Moment> {
        let (from, before) = C::about_line(&mut self.supply, number)?;
        let lines = |cursor: &C| cursor.facts().tally().lines;
        let mut fresh = self.shown.afresh(&mut self.supply, from)?;
        let supply = &mut self.supply;
        go_on(
            &mut fresh,
            supply,
            usize::MAX,
            |_, next| next < from,
            |_| {},
        );
        let wanted = lines(&fresh).saturating_add(number.checked_sub(before)?);
        let goes_on = |cursor: &C, _| lines(cursor) < wanted;
        go_on(&mut fresh, supply, STEPS_MAX, goes_on, |_| {});
        let at = fresh.at();
        if lines(&fresh) < wanted {
            return None;
        }
        self.chase = Some(self.exact_before(at));
        self.shown = fresh;
        Some(at)
    }

    /// The first of a kind after a moment, found as [`Self::seek_line`] finds a line; where nobody has read yet it is
    /// looked for from the moment on, which [`Self::hunt`] goes on with.
    pub fn find_next(&mut self, landmark: Landmark, after: Moment, beyond: usize) -> Found {
        let found = self.find_next_read(landmark, after, beyond);
        self.or_hunt(found, beyond, || Hunt::ahead(landmark, after))
    }

    /// The last of a kind before a moment, likewise.
    pub fn find_last(&mut self, landmark: Landmark, before: Moment, beyond: usize) -> Found {
        let found = self.find_last_read(landmark, before, beyond);
        let kept = self.frames.before(Moment::MAX);
        let kept = kept.and_then(|place| self.frames.get(place));
        let kept_at = kept.map_or(Moment::ZERO, |(at, _)| *at);
        self.or_hunt(found, beyond, || Hunt::back(landmark, before, kept_at))
    }

    fn or_hunt(&mut self, found: Found, beyond: usize, hunt: impl FnOnce() -> Hunt<C>) -> Found {
        if found != Found::NotYet {
            self.hunt = None;
        } else if beyond > 0 {
            self.hunt = Some(hunt());
            return self.hunt(beyond.saturating_mul(HUNTS));
        }
        found
    }

    /// Goes on with the search where nobody has read yet, through so many things.
    pub fn hunt(&mut self, steps: usize) -> Found {
        let Some(mut hunt) = self.hunt.take() else {
            return Found::NotYet;
        };
        match hunt.go_on(&self.shown, &mut self.supply, steps) {
            Found::NotYet => self.hunt = Some(hunt),
            Found::At(at) => return Found::At(at),
            Found::Nowhere => {
                return match (hunt.back_to(), hunt.landmark()) {
                    // What is kept knows all before it.
                    (Some(kept_at), sought) => self.find_last_read(sought, kept_at, usize::MAX),
                    // What has been wrong for how long is known for certain by who has read everything.
                    (None, Landmark::Alarm) => Found::NotYet,
                    (None, _) => Found::Nowhere,
                };
            }
        }
        Found::NotYet
    }

    /// Whether a search goes on where nobody has read yet.
    #[must_use]
    pub const fn is_hunting(&self) -> bool {
        self.hunt.is_some()
    }

    /// Gives the search up.
    pub fn give_up(&mut self) {
        self.hunt = None;
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
                while let Some(at) = cursor.next_at(&mut self.supply).filter(|at| *at <= last) {
                    if steps == 0 {
                        return Found::NotYet;
                    }
                    steps -= 1;
                    let before = count(&cursor);
                    cursor.step(&mut self.supply);
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
            while let Some(at) = cursor.next_at(&mut self.supply).filter(|at| *at <= last) {
                if at >= before {
                    break;
                }
                if steps == 0 {
                    return Found::NotYet;
                }
                steps -= 1;
                let counted = count(&cursor);
                cursor.step(&mut self.supply);
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

    /// How many things are worth going through from a state on in search of something.
    const fn reach(&self, is_newest: bool, beyond: usize) -> usize {
        if self.is_complete || !is_newest {
            usize::MAX
        } else {
            beyond
        }
    }

    /// What it means that a search ended without success where a state stands now.
    fn missed(&mut self, cursor: &C) -> Found {
        match cursor.next_at(&mut self.supply) {
            Some(_) => Found::NotYet,
            None => Found::Nowhere,
        }
    }
}
