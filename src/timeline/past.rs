//! A live session's state, and the events that it is made from, as far back as they are remembered.

use std::collections::VecDeque;

use super::reel::Cursor;
use crate::event::{Event, Moment};
use crate::model::Facts;
use crate::travel::Landmark;

/// So much of a live session is remembered.
pub const REMEMBERED: Moment = Moment::from_hours(1);

/// And no more events than so many: a robot on 2400 baud makes a fourth of that in an hour.
const EVENTS_MAX: usize = 65_536;

/// States are kept so far apart.
pub const SPACING: Moment = Moment::from_secs(30);

/// Events in their order.
#[derive(Clone, Debug, Default)]
pub struct History {
    events: VecDeque<(Moment, Event)>,
    /// Events forgotten before the first of them.
    forgotten: u64,
}

impl History {
    /// Takes what happened.
    pub fn push(&mut self, at: Moment, event: Event) {
        self.events.push_back((at, event));
    }

    /// Whether so much is remembered that the oldest has to go.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.events.len() > EVENTS_MAX
    }

    /// When the event before which a quarter of them lies happened.
    #[must_use]
    pub fn quarter_at(&self) -> Option<Moment> {
        self.events.get(EVENTS_MAX / 4).map(|(at, _)| *at)
    }

    /// Events that ever were.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.forgotten + self.events.len() as u64
    }

    /// Forgets those before the one of a number.
    pub fn forget_before(&mut self, number: u64) {
        let count = number.saturating_sub(self.forgotten) as usize;
        self.events.drain(..count.min(self.events.len()));
        self.forgotten += count as u64;
    }

    fn get(&self, number: u64) -> Option<&(Moment, Event)> {
        let place = number.checked_sub(self.forgotten)?;
        self.events.get(place as usize)
    }
}

/// The facts at a moment of a live session.
#[derive(Clone, Debug)]
pub struct Past {
    facts: Facts,
    at: Moment,
    /// Number of the next event.
    next: u64,
}

impl Past {
    /// The facts as they are, before the event of a number.
    #[must_use]
    pub const fn new(facts: Facts, at: Moment, next: u64) -> Self {
        Self { facts, at, next }
    }

    /// Number of the event that happens next.
    #[must_use]
    pub const fn next(&self) -> u64 {
        self.next
    }
}

impl Cursor for Past {
    type Supply = History;

    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn at(&self) -> Moment {
        self.at
    }

    fn next_at(&self, history: &mut History) -> Option<Moment> {
        history.get(self.next).map(|(at, _)| *at)
    }

    /// A line comes with what the station said about it in the same moment.
    fn step(&mut self, history: &mut History) {
        let Some((now, _)) = history.get(self.next) else {
            return;
        };
        self.at = *now;
        while let Some((at, event)) = history.get(self.next)
            && at == now
        {
            self.facts.update(*at, event);
            self.next += 1;
            let after = history.get(self.next).map(|(_, event)| event);
            if matches!(after, Some(Event::Line { .. } | Event::Ack(_))) {
                break;
            }
        }
    }

    fn afresh(&self, _: &mut History, _: Moment) -> Option<Self> {
        None
    }

    fn about_line(_: &mut History, _: u64) -> Option<(Moment, u64)> {
        None
    }

    fn may_hold(_: &mut History, _: Landmark, _: Moment, _: Moment) -> bool {
        true
    }
}
