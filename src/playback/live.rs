//! The past of a live session, as far as memory holds it.

use std::collections::VecDeque;

use groundwave_lines::{Content, OwnLine};
use groundwave_protocol::telemetry::Line;

use super::control::{Control, Mark, Playback};
use super::cursor::Cursor;
use super::player::Player;
use super::timeline::Timeline;
use crate::event::{Event, LinkEvent, Moment, Notice, NoticeCode};
use crate::model::{Change, Facts};
use crate::request::Request;
use crate::statistics::Statistics;

/// Maximum length of a live session's remembered past.
pub const REMEMBERED: Moment = Moment::from_hours(1);

/// Maximum memory for events, bytes; a robot at 2400 baud causes a quarter of this in an hour.
pub(super) const BYTES_MAX: usize = 16 * 1024 * 1024;

/// Number of bytes of events after which an extra keyframe is made, so that older events can be dropped early.
const STATE_BYTES: usize = BYTES_MAX / 4;

/// Time between two keyframes.
pub const SPACING: Moment = Moment::from_secs(30);

/// The remembered events in order, numbered from the beginning of the session.
#[derive(Clone, Debug, Default)]
pub struct EventHistory {
    events: VecDeque<(Moment, Event)>,
    bytes: usize,
    /// Number of bytes of the events since the newest keyframe.
    unkept_bytes: usize,
    /// Number of events dropped before the first remembered event.
    forgotten: u64,
}

impl EventHistory {
    /// Adds an event.
    pub fn push(&mut self, at: Moment, event: Event) {
        let bytes = bytes(&event);
        self.bytes += bytes;
        self.unkept_bytes += bytes;
        self.events.push_back((at, event));
    }

    /// Number of events so far, including dropped ones.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.forgotten + self.events.len() as u64
    }

    /// Drops the events before a number; returns whether there were any.
    pub fn forget_before(&mut self, number: u64) -> bool {
        let count = number.saturating_sub(self.forgotten) as usize;
        let gone = self.events.drain(..count.min(self.events.len()));
        self.bytes -= gone.map(|(_, event)| bytes(&event)).sum::<usize>();
        self.forgotten += count as u64;
        count > 0
    }

    fn get(&self, number: u64) -> Option<&(Moment, Event)> {
        let place = number.checked_sub(self.forgotten)?;
        self.events.get(place as usize)
    }
}

/// Memory of a remembered event, bytes.
fn bytes(event: &Event) -> usize {
    let heap = match event {
        Event::Line { .. } | Event::Repaired(_) => size_of::<Line>(),
        Event::Own(line) => line.text.len() + samples(line),
        Event::Statistics(_) => size_of::<Statistics>(),
        Event::Notice(notice) => notice.text.len(),
        Event::Link(LinkEvent::Lost { reason }) => reason.len(),
        Event::Asked {
            request: Request::Route(waypoints),
            ..
        } => size_of_val(&waypoints[..]),
        _ => 0,
    };
    size_of::<(Moment, Event)>() + heap
}

fn samples(line: &OwnLine) -> usize {
    match &line.content {
        Content::Values(samples) => size_of_val(&samples[..]),
        Content::Text | Content::Damaged => 0,
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
    /// The state before event number `next`.
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

    fn for_search(mut self) -> Self {
        self.facts.end_estimate();
        self
    }

    fn at(&self) -> Moment {
        self.at
    }

    fn next_at(&self, history: &mut EventHistory) -> Option<Moment> {
        history.get(self.next).map(|(at, _)| *at)
    }

    /// Takes the next event; a line includes the other events of its moment.
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
            if matches!(
                after,
                Some(Event::Line { .. } | Event::Ack(_) | Event::Own(_))
            ) {
                break;
            }
        }
    }
}

/// The facts of a live session, and a player of its past.
pub struct LivePlayer {
    facts: Facts,
    player: Player<LiveState>,
    /// Whether the screen shows the past.
    shows_past: bool,
    /// Time at which the displayed past was last advanced.
    advanced_at: Moment,
}

impl LivePlayer {
    /// A session that begins with the given facts, `unix` after 1970.
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

    /// The current facts.
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

    /// Memory used by the remembered events, bytes.
    #[cfg(test)]
    pub(super) fn remembered_bytes(&self) -> usize {
        let history = self.player.timeline().source();
        history.events.iter().map(|(_, event)| bytes(event)).sum()
    }

    /// State of playback; `None` while the screen shows the present.
    #[must_use]
    pub fn playback(&self) -> Option<Playback> {
        self.shows_past.then(|| self.player.playback())
    }

    /// Takes an event and remembers it; returns its effect on the screen.
    pub fn take(&mut self, now: Moment, event: &Event) -> Change {
        // The passing of time raises alarms.
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

    /// Makes a keyframe if one is due, and drops old events and keyframes.
    fn keep(&mut self, now: Moment) {
        let timeline = self.player.timeline_mut();
        if timeline.wants(now) || timeline.source().unkept_bytes >= STATE_BYTES {
            let next = timeline.source().count();
            timeline.keep(LiveState::new(self.facts.clone(), now, next));
            timeline.source_mut().unkept_bytes = 0;
        }
        let oldest = now.saturating_sub(REMEMBERED);
        if let Some(next) = timeline.forget_before(oldest).map(LiveState::next) {
            timeline.source_mut().forget_before(next);
        }
        while timeline.source().bytes > BYTES_MAX {
            let next = timeline.forget_oldest().map_or(0, LiveState::next);
            if !timeline.source_mut().forget_before(next) {
                break;
            }
        }
        self.stretch(now);
    }

    /// Sets the time span that can be shown: from the oldest remembered moment until now.
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

    /// Time of the next call of [`Self::advance`]; `None` while the screen shows the present. While playback is paused, once a second, because the displayed age grows.
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

    /// Adds the text of a mark.
    pub fn add_noted_mark(&mut self, at: Moment, text: String) {
        self.player.add_noted_mark(at, text);
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
            Control::Mark(_) => {
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

    /// The player's message as a line for the log, while the playback line is hidden.
    fn note(&self) -> Option<Event> {
        let (level, text) = self.player.playback().note?;
        Some(Event::Notice(Notice::new(
            NoticeCode::Playback,
            level,
            text,
        )))
    }

    fn return_to_present(&mut self) {
        self.player.rest();
        self.shows_past = false;
    }
}
