//! Finds moments by line.

use super::super::cache::go_on;
use super::super::cursor::Cursor;
use super::super::search::Found;
use super::{READ_STEPS_MAX, STEPS_MAX, Timeline};
use crate::event::Moment;

impl<C: Cursor> Timeline<C> {
    /// Shows the line after the newest displayed line.
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

    /// Shows the line before the newest displayed line.
    pub fn step_back(&mut self) -> Found {
        if self.is_partial() {
            return self.step_back_by_time();
        }
        match self.facts().tally().lines {
            0 | 1 => Found::Nowhere,
            lines => self.seek_line(lines - 1, READ_STEPS_MAX),
        }
    }

    /// Shows the previous line, found by time because its number is unknown.
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

    /// Shows the line with a number, from 1. In the unread part, at most `beyond` steps after the newest keyframe are taken.
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

    /// Shows the line with a number at its estimated place in the unread part, from the index; returns its time, `None`
    /// without an estimate.
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
}
