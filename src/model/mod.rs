//! What the screen says: everything known about the robot, the link and the operator's wishes.
//!
//! [`Model::update`] is the only way it changes: facts in, wishes out. It has no clock and does no
//! I/O; its size does not grow with the length of a session.

pub(crate) mod age;
pub(crate) mod alarms;
pub(crate) mod chart;
pub(crate) mod draft;
pub(crate) mod drive;
pub(crate) mod editor;
mod facts;
pub(crate) mod failsafe;
pub(crate) mod ghost;
mod history;
mod input;
pub mod keys;
pub(crate) mod ledger;
pub(crate) mod link;
pub(crate) mod log;
pub(crate) mod motors;
pub(crate) mod news;
pub(crate) mod palette;
mod panels;
pub(crate) mod plots;
mod pointer;
mod prompt;
pub(crate) mod robot;
pub(crate) mod runs;
mod text_entry;
pub(crate) mod trace;
mod trail;
mod travel;
pub(crate) mod why;
pub(crate) mod words;

#[cfg(test)]
pub(crate) mod testing;
#[cfg(test)]
mod tests;

use std::time::Duration;

use groundwave_protocol::life::Life;

use crate::event::{Effect, Event, Moment, Recording};
use crate::request::Request;
use crate::travel::Playback;
use alarms::Alarms;
pub use alarms::Limits;
use chart::Chart;
use drive::Stick;
use editor::Editor;
use keys::{Context, Keymap};
use ledger::Ledger;
use link::Link;
use log::{Log, Subject};
use motors::Motors;
use news::Passing;
use palette::Palette;
pub(crate) use panels::Large;
use plots::Plots;
use robot::Robot;
use runs::Runs;
use text_entry::Typed;
pub(crate) use text_entry::{Caret, Purpose, TextEntry};
use travel::Counted;

/// How the dashboard is to look, fixed for a session.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// Colours.
    pub colors: Colors,
    /// Nothing but ASCII on the screen.
    pub ascii: bool,
    /// How to see the raw line from another terminal, told above the keys; `None` where there is no way.
    pub raw_copy: Option<String>,
    /// The capture on show; `None` in a live session.
    pub capture: Option<String>,
    /// Ring the bell for alarms and songs.
    pub bell: bool,
    /// Ask the terminal for the mouse.
    pub mouse: bool,
    /// What every key does.
    pub keys: Keymap,
    /// When there is an alarm.
    pub limits: Limits,
    /// Since 1970 at the beginning of the session; `None` shows no clock.
    pub unix: Option<Duration>,
}

/// Colours of the screen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Colors {
    /// For a dark background.
    #[default]
    Dark,
    /// For a light background.
    Light,
    /// Black, white and yellow.
    HighContrast,
    /// None: `NO_COLOR`.
    Mono,
}

/// A panel that shares its place with others where the screen is small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Panel {
    #[default]
    Sensors,
    /// The robot seen from above.
    Body,
    Plots,
    Commands,
    Log,
    Link,
    Alarms,
}

impl Panel {
    /// What it is called where it is chosen.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Sensors => "sensors",
            Self::Body => "above",
            Self::Plots => "plots",
            Self::Commands => "commands",
            Self::Log => "log",
            Self::Link => "link",
            Self::Alarms => "alarms",
        }
    }

    /// In the order of the Tab key.
    pub(crate) const ALL: [Self; 7] = [
        Self::Sensors,
        Self::Body,
        Self::Plots,
        Self::Commands,
        Self::Log,
        Self::Link,
        Self::Alarms,
    ];
}

/// Columns and rows below which there is no room for a dashboard: only STOP and leaving work then, for nobody sees
/// what else a key would do.
pub(crate) const SIZE_MIN: (u16, u16) = (80, 24);

/// What lies over the panels and takes the keyboard.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Overlay {
    #[default]
    None,
    Help,
    Question(Question),
    Text(TextEntry),
    Drive(Stick),
    Palette(Palette),
    /// Which kind of moment to jump to.
    Jump {
        forward: bool,
    },
    /// One value and the columns it comes from: its place in [`trace::FIELDS`].
    Trace(usize),
    /// Why it does what it does at the shown moment.
    Why,
    /// The list of runs, or two of them over each other.
    Runs(Runs),
}

/// A question that is answered with yes or no.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Question {
    pub(crate) text: String,
    then: Then,
}

/// What a yes leads to.
#[derive(Clone, Debug, PartialEq)]
enum Then {
    Send(Vec<Request>),
    Drive,
    /// Write the draft over the file of this name.
    SaveRoute(String),
}

/// The state of the dashboard.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) config: Config,
    pub(crate) link: Link,
    pub(crate) robot: Robot,
    pub(crate) motors: Motors,
    pub(crate) chart: Chart,
    pub(crate) ledger: Ledger,
    pub(crate) log: Log,
    pub(crate) alarms: Alarms,
    pub(crate) plots: Plots,
    pub(crate) recording: Recording,
    pub(crate) panel: Panel,
    /// Pages turned over in the chosen panel; the view goes round.
    pub(crate) page: i32,
    pub(crate) enlarged: Option<Large>,
    /// Pages turned over in the help.
    pub(crate) help_page: i32,
    pub(crate) overlay: Overlay,
    typed: Typed,
    /// What is seen again when a comparison is put away.
    behind: Option<Runs>,
    /// The route editor, while it is open.
    pub(crate) editor: Option<Editor>,
    size: (u16, u16),
    life: Life,
    /// What there was to jump to so far.
    counted: Counted,
    /// Where the screen stands in time, unless it shows now.
    pub(crate) playback: Option<Playback>,
    /// What calls now, and when now is, while another moment of a live session is shown.
    pub(crate) alarms_now: Option<(Box<Alarms>, Moment)>,
    /// Alarms of a capture until here have been seen.
    seen_until: Option<Moment>,
    /// Told to the operator while the screen shows another moment, until the next key.
    pub(crate) aside: Option<String>,
    /// The robot sings or calls, and the bell has not rung for it.
    calls: bool,
    /// Told in passing, and since when.
    passing: Option<(Moment, Passing)>,
    revision: u64,
}

impl Model {
    /// A dashboard that knows nothing yet.
    #[must_use]
    pub fn new(config: Config) -> Self {
        Self {
            config,
            link: Link::default(),
            robot: Robot::default(),
            motors: Motors::default(),
            chart: Chart::default(),
            ledger: Ledger::default(),
            log: Log::default(),
            alarms: Alarms::default(),
            plots: Plots::default(),
            recording: Recording::default(),
            panel: Panel::default(),
            page: 0,
            enlarged: None,
            typed: Typed::default(),
            behind: None,
            help_page: 0,
            overlay: Overlay::default(),
            editor: None,
            size: (0, 0),
            life: Life::default(),
            counted: Counted::default(),
            playback: None,
            alarms_now: None,
            seen_until: None,
            aside: None,
            calls: false,
            passing: None,
            revision: 0,
        }
    }

    /// Takes what happened; returns what the operator wants done about it.
    pub fn update(&mut self, now: Moment, event: Event) -> Vec<Effect> {
        let mut effects = self.expire(now);
        let mut changed = match event {
            Event::Line { line, raw } => {
                self.link.take_line(now, &raw);
                self.take_line(now, &line);
                true
            }
            Event::Ack(line) => {
                self.counted.take_ack(line.ack);
                let restarted = self.life.take_boot(line.ack.boot);
                if restarted {
                    self.take_restart(now);
                }
                restarted
            }
            Event::Counters(counters) => {
                self.link.take_counters(now, &counters);
                // The lines that changed the totals say so themselves; rejects can wait for a line, unless
                // there is none.
                counters.lines == 0
            }
            // Drawn with the next line: whoever looks for figures can wait for it.
            Event::Statistics(statistics) => {
                self.link.take_statistics(*statistics);
                false
            }
            Event::Link(link) => {
                self.take_link(now, &link);
                true
            }
            Event::Command { id, step } => {
                self.take_step(now, id, &step);
                true
            }
            Event::Reception { reception, since } => {
                self.link.take_reception(reception, since);
                true
            }
            Event::Asked { id, by } => {
                self.take_asker(now, id, &by);
                true
            }
            Event::Recording(recording) => self.take_recording(now, recording),
            Event::RouteLoaded { path, route } => {
                effects.extend(self.take_route(now, &path, route));
                true
            }
            Event::RouteSaved { path, saved } => {
                self.take_saved(now, &path, &saved);
                true
            }
            Event::Runs(runs) => self.take_runs(runs),
            Event::Overlaid(overlaid) => self.take_overlaid(overlaid),
            Event::Playback(playback) => self.take_playback(playback),
            Event::Truth(truth) => {
                self.chart.take_truth(truth);
                true
            }
            // The log of a capture on show is of then.
            Event::Notice { text, .. } if self.is_replay() => {
                self.aside = Some(text);
                true
            }
            Event::Notice { level, text } => {
                self.log.add(now, level, Subject::Station, text);
                true
            }
            Event::Key(key) => {
                effects.extend(self.take_key(now, key));
                true
            }
            Event::Paste(text) => self.take_paste(now, &text),
            Event::Pointer { on, gesture } => self.take_pointer(on, gesture),
            Event::Resize { width, height } => {
                let changed = self.size != (width, height);
                self.size = (width, height);
                changed
            }
            // Marks are the player's.
            Event::Mark(_) | Event::Tick => false,
        };
        changed |= self.watch_alarms(now);
        if std::mem::take(&mut self.calls) && self.config.bell {
            effects.push(Effect::Ring);
        }
        if changed || !effects.is_empty() {
            self.revision += 1;
        }
        effects
    }

    /// Grows whenever an update changed what the screen shows: draw when it differs from the revision
    /// that was drawn last.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// When the screen changes although nothing happens, because ages do: every second while the newest
    /// line is young, later every ten, and when something is no longer news; `None` while time stands still, as
    /// after the end of a session.
    #[must_use]
    pub fn redraw_at(&self, now: Moment) -> Option<Moment> {
        let ages = self.link.next_tick(now);
        let alarm = self
            .alarms
            .next_tick(now)
            .filter(|_| !self.link.is_frozen());
        ages.into_iter()
            .chain(alarm)
            .chain(self.news_until(now))
            .chain(self.next_minute(now))
            .min()
    }

    /// The time of day, since midnight UTC; `None` where no clock is shown.
    pub(crate) fn time_of_day(&self, now: Moment) -> Option<Duration> {
        let unix = self.config.unix.filter(|_| self.playback().is_none())?;
        Some(Duration::from_secs((unix + now).as_secs() % 86_400))
    }

    /// When the clock shows another minute.
    fn next_minute(&self, now: Moment) -> Option<Moment> {
        let unix = self.config.unix.filter(|_| !self.link.is_frozen())?;
        let minute = Duration::from_mins((unix + now).as_secs() / 60 + 1);
        minute.checked_sub(unix)
    }

    /// When to send [`Event::Tick`] at the latest: a lease on the motors ends then,
    /// or something has been wrong for so long that it is an alarm.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let lease = match &self.overlay {
            Overlay::Drive(stick) => stick.next_expiry(),
            _ => None,
        };
        let alarm = self.alarms.next_due(&self.config.limits);
        lease
            .into_iter()
            .chain(alarm.filter(|_| !self.link.is_frozen()))
            .min()
    }

    /// Where the keyboard goes.
    pub(crate) const fn context(&self) -> Context {
        match self.overlay {
            Overlay::None if self.editor.is_some() => Context::Route,
            Overlay::None => Context::Dashboard,
            Overlay::Help => Context::Help,
            Overlay::Question(_) => Context::Question,
            Overlay::Text(_) => Context::Text,
            Overlay::Drive(_) => Context::Drive,
            Overlay::Palette(_) => Context::Palette,
            Overlay::Jump { .. } => Context::Jump,
            Overlay::Trace(_) => Context::Trace,
            Overlay::Why => Context::Why,
            Overlay::Runs(_) => Context::Runs,
        }
    }

    fn expire(&mut self, now: Moment) -> Vec<Effect> {
        match &mut self.overlay {
            Overlay::Drive(stick) => stick.expire(now).into_iter().collect(),
            _ => Vec::new(),
        }
    }
}
