//! The past of a live session, as far back as it is remembered.

use std::collections::VecDeque;

use super::control::{Control, Mark, Playback};
use super::cursor::Cursor;
use super::player::Player;
use super::timeline::Timeline;
use crate::event::{Event, Level, Moment, Notice, NoticeCode};
use crate::model::{Change, Facts};

/// How far back a live session is remembered.
pub const REMEMBERED: Moment = Moment::from_hours(1);

/// Most events remembered; a robot on 2400 baud causes a quarter of that in an hour.
const EVENTS_MAX: usize = 65_536;

/// Time between two kept states.
pub const SPACING: Moment = Moment::from_secs(30);

/// Events in their order, counted from the beginning of the session.
#[derive(Clone, Debug, Default)]
pub struct EventHistory {
    events: VecDeque<(Moment, Event)>,
    /// Events forgotten before the first remembered one.
    forgotten: u64,
}

impl EventHistory {
    /// Adds an event.
    pub fn push(&mut self, at: Moment, event: Event) {
        self.events.push_back((at, event));
    }

    /// Whether the oldest events must be dropped.
    #[must_use]
    pub fn is_full(&self) -> bool {
        self.events.len() > EVENTS_MAX
    }

    /// When the event after the oldest quarter happened.
    #[must_use]
    pub fn quarter_at(&self) -> Option<Moment> {
        self.events.get(EVENTS_MAX / 4).map(|(at, _)| *at)
    }

    /// Number of events so far, forgotten ones included.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.forgotten + self.events.len() as u64
    }

    /// Forgets the events before a number.
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
pub struct LiveState {
    facts: Facts,
    at: Moment,
    /// Number of the next event.
    next: u64,
}

impl LiveState {
    /// Facts before the event of number `next`.
    #[must_use]
    pub const fn new(facts: Facts, at: Moment, next: u64) -> Self {
        Self { facts, at, next }
    }

    /// Number of the next event.
    #[must_use]
    pub const fn next(&self) -> u64 {
        self.next
    }
}

impl Cursor for LiveState {
    type Source = EventHistory;

    fn facts(&self) -> &Facts {
        &self.facts
    }

    fn at(&self) -> Moment {
        self.at
    }

    fn next_at(&self, history: &mut EventHistory) -> Option<Moment> {
        history.get(self.next).map(|(at, _)| *at)
    }

    /// A line comes with the other events of its moment.
    fn step(&mut self, history: &mut EventHistory) {
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
}

/// The facts of a live session, and a player of its past.
pub struct LivePlayer {
    facts: Facts,
    player: Player<LiveState>,
    /// The screen shows the past.
    shows_past: bool,
    /// When the past on the screen was last advanced.
    advanced_at: Moment,
}

impl LivePlayer {
    /// A session that begins with these facts, `unix` after 1970.
    #[must_use]
    pub fn new(facts: Facts, now: Moment, unix: Option<Moment>) -> Self {
        let first = LiveState::new(facts.clone(), now, 0);
        let timeline = Timeline::new(EventHistory::default(), first, SPACING);
        Self {
            facts,
            player: Player::of_session(timeline, unix),
            shows_past: false,
            advanced_at: now,
        }
    }

    /// The present facts.
    #[must_use]
    pub const fn present(&self) -> &Facts {
        &self.facts
    }

    /// The facts at the moment on the screen, and that moment.
    #[must_use]
    pub fn shown(&self, now: Moment) -> (&Facts, Moment) {
        if self.shows_past {
            (self.player.facts(), self.player.at())
        } else {
            (&self.facts, now)
        }
    }

    /// Where the screen stands in the past; `None` when it shows now.
    #[must_use]
    pub fn playback(&self) -> Option<Playback> {
        self.shows_past.then(|| self.player.playback())
    }

    /// Takes an event and remembers it; returns what it changed on the screen.
    pub fn take(&mut self, now: Moment, event: &Event) -> Change {
        // Time alone raises alarms.
        let is_due = self.facts.poll_timeout().is_some_and(|at| at <= now);
        let change = self.facts.update(now, event);
        if Facts::takes(event) || is_due {
            let history = self.player.timeline_mut().source_mut();
            history.push(now, event.clone());
        }
        self.keep(now);
        Change {
            is_shown: change.is_shown && !self.shows_past,
            ..change
        }
    }

    /// Keeps a state if one is due, and drops old events and states.
    fn keep(&mut self, now: Moment) {
        let timeline = self.player.timeline_mut();
        let history = timeline.source();
        let mut oldest = now.saturating_sub(REMEMBERED);
        if history.is_full() {
            oldest = oldest.max(history.quarter_at().unwrap_or(oldest));
        }
        if timeline.wants(now) {
            let next = history.count();
            timeline.keep(LiveState::new(self.facts.clone(), now, next));
        }
        if let Some(next) = timeline.forget_before(oldest).map(LiveState::next) {
            timeline.source_mut().forget_before(next);
        }
        self.stretch(now);
    }

    /// Sets the span that can be shown: from the oldest remembered moment until now.
    fn stretch(&mut self, now: Moment) {
        let from = self.player.timeline().oldest_at().unwrap_or(now);
        self.player.set_span(from, now);
    }

    /// Advances the playback of the past; returns whether the screen changes.
    pub fn advance(&mut self, now: Moment) -> bool {
        if !self.shows_past {
            return false;
        }
        self.stretch(now);
        self.advanced_at = now;
        let plays = !self.player.is_paused();
        self.player.advance(now);
        if plays && self.player.is_at_end() {
            self.return_to_present();
        }
        true
    }

    /// When to call [`Self::advance`]: the age of the moment shown changes every second.
    pub fn wake_at(&mut self) -> Option<Moment> {
        if !self.shows_past {
            return None;
        }
        let plays = self.player.wake_at();
        Some(plays.unwrap_or(self.advanced_at + Moment::from_secs(1)))
    }

    /// Shows another moment; returns the player's note for the log, and the mark for the recording.
    pub fn handle(&mut self, now: Moment, control: Control) -> Vec<Event> {
        let note = self.go(now, control);
        let marked = self.player.take_marked().map(|(at, is_set)| {
            let ago = now.saturating_sub(at);
            Event::Mark(Mark { ago, is_set })
        });
        note.into_iter().chain(marked).collect()
    }

    fn go(&mut self, now: Moment, control: Control) -> Option<Event> {
        self.stretch(now);
        if self.shows_past {
            self.player.handle(now, control);
            if control == Control::Newest {
                self.return_to_present();
            }
            return None;
        }
        self.advanced_at = now;
        self.player.rest();
        match control {
            Control::Speed(_) | Control::Newest | Control::StopSearch => None,
            Control::Mark => {
                self.player.handle(now, control);
                self.note()
            }
            Control::TogglePause => {
                self.player.handle(now, Control::Newest);
                self.shows_past = true;
                None
            }
            _ => {
                self.shows_past = self.player.leave_newest(now, control);
                if self.shows_past { None } else { self.note() }
            }
        }
    }

    /// The player's note as a line for the log, while the playback line is hidden.
    fn note(&self) -> Option<Event> {
        let text = self.player.playback().note?;
        Some(Event::Notice(Notice::new(
            NoticeCode::Playback,
            Level::Info,
            text,
        )))
    }

    fn return_to_present(&mut self) {
        self.player.rest();
        self.shows_past = false;
    }
}
