//! The dashboard's facts ([`Facts`]) and the operator's view of them ([`Ui`]).
//!
//! Facts follow from events alone, and playback keeps them. All other state follows from keys. The model takes events and
//! returns effects. It has no clock and does no I/O, and its size does not grow with the length of a session.

pub(crate) mod age;
pub(crate) mod alarms;
mod attend;
mod automatic;
pub(crate) mod bounds;
pub(crate) mod chart;
mod chosen_panel;
mod completion;
mod config;
mod copied;
pub(crate) mod draft;
pub(crate) mod drive;
pub(crate) mod editor;
mod facts;
pub(crate) mod failsafe;
pub(crate) mod fields;
pub(crate) mod ghost;
pub(crate) mod ground;
mod history;
mod input;
pub mod keys;
pub(crate) mod ledger;
pub(crate) mod link;
pub(crate) mod log;
pub(crate) mod map;
pub(crate) mod motors;
pub(crate) mod news;
pub(crate) mod palette;
pub(crate) mod panel;
mod parameters;
mod planned;
mod playback;
pub(crate) mod plots;
mod pointer;
mod prompt;
mod reported_parameters;
pub(crate) mod robot;
pub(crate) mod runs;
pub(crate) mod search;
mod tally;
mod text_entry;
mod tour;
pub(crate) mod trace;
mod trail;
mod ui;
mod unseen;
mod waits;
pub(crate) mod why;
pub(crate) mod words;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use crate::event::{Effect, Event, Moment};
pub use alarms::{AlarmSetting, Limits, Operand, Severity};
pub use attend::JOINED_LATER;
pub(crate) use chosen_panel::{Large, SIZE_MIN};
pub use config::{Advise, Colors, Config, MapLines, Marker};
pub(crate) use copied::printable;
pub use facts::{Change, Facts};
pub(crate) use panel::Panel;
pub(crate) use text_entry::{Purpose, TextEntry};
pub(crate) use tour::TourStep;
pub use ui::Ui;
pub(crate) use ui::{Overlay, Question};

/// Facts and their view together, for tests, benches and pictures. The program keeps them apart: [`crate::playback`] holds the
/// facts of each moment, and the view shows one moment.
#[derive(Clone, Debug)]
pub struct Model {
    /// The facts.
    pub facts: Facts,
    /// The operator's view of the facts.
    pub ui: Ui,
}

impl Model {
    /// A model before the first event.
    #[must_use]
    pub fn new(config: Config) -> Self {
        let config = Arc::new(config);
        Self {
            facts: Facts::new(Arc::clone(&config)),
            ui: Ui::new(config),
        }
    }

    /// Takes an event; returns the operator's requests.
    pub fn update(&mut self, now: Moment, event: Event) -> Vec<Effect> {
        let change = if self.ui.takes_aside(&event) {
            Change::default()
        } else {
            self.facts.update(now, &event)
        };
        let effects = self.ui.update(now, event, &self.facts, change);
        let (notices, effects): (Vec<_>, Vec<_>) = effects
            .into_iter()
            .partition(|effect| matches!(effect, Effect::Notice(_)));
        for effect in notices {
            if let Effect::Notice(notice) = effect {
                self.update(now, Event::Notice(notice));
            }
        }
        effects
    }

    /// Latest time for the next [`Event::Tick`].
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let timeouts = [self.facts.poll_timeout(), self.ui.poll_timeout()];
        timeouts.into_iter().flatten().min()
    }
}

/// All state that the screen shows.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The facts at the moment on the screen.
    pub facts: &'a Facts,
    /// The facts as of now; the same as `facts` unless the screen shows the past of a live session.
    pub present: &'a Facts,
    /// The operator's view of the facts.
    pub ui: &'a Ui,
}

impl<'a> From<&'a Model> for Shown<'a> {
    fn from(model: &'a Model) -> Self {
        Self {
            facts: &model.facts,
            present: &model.facts,
            ui: &model.ui,
        }
    }
}

impl Shown<'_> {
    /// Time at which the screen changes without an event, because displayed ages change: every second while the newest
    /// line is young, later every ten seconds, and when news expires. `None` if time stands still (after the end of
    /// a session) or playback determines it.
    #[must_use]
    pub fn redraw_at(&self, now: Moment) -> Option<Moment> {
        if self.ui.playback.is_some() {
            return None;
        }
        let link = &self.facts.link;
        let alarms = self.facts.alarms.next_tick(&self.ui.attended, now);
        let minute = self.ui.next_minute(now);
        let moving = alarms.into_iter().chain(minute);
        link.next_tick(now)
            .into_iter()
            .chain(moving.filter(|_| !link.is_frozen()))
            .chain(self.news_until(now))
            .min()
    }
}
