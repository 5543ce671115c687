//! The operator's view of the facts: all state that follows from keys.

use std::sync::Arc;
use std::time::Duration;

use super::alarms::Attended;
use super::automatic::Automatic;
use super::chosen_panel::Large;
use super::config::Config;
use super::drive::Stick;
use super::editor::Editor;
use super::facts::{Change, Facts};
use super::keys::Context;
use super::map::MapView;
use super::news::Passing;
use super::palette::Palette;
use super::panel::Panel;
use super::plots::WINDOWS;
use super::runs::Runs;
use super::search::Search;
use super::text_entry::{TextEntry, Typed};
use super::tour::Tour;
use super::waits::Begun;
use crate::event::{CommandId, CommandStatus, Effect, Event, Level, Moment, Notice, NoticeCode};
use crate::parameter_file::ParameterFile;
use crate::playback::Playback;
use crate::request::Request;

/// A window over the panels that gets the keys.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) enum Overlay {
    #[default]
    None,
    Help,
    Question(Question),
    Text(TextEntry),
    Drive(Stick),
    Palette(Palette),
    /// The choice of a mode.
    Modes,
    /// The choice of a landmark to jump to.
    Jump {
        forward: bool,
    },
    /// A value and its columns: an index into [`trace::FIELDS`].
    Trace(usize),
    /// The reasons for the robot's behaviour.
    Why,
    /// The list of runs, or two runs over each other.
    Runs(Runs),
    /// A text found in the log.
    Search(Search),
}

/// A yes-or-no question.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Question {
    pub(crate) text: String,
    pub(super) then: Then,
}

/// Action after the answer "yes".
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Then {
    Send(Vec<Request>),
    Drive,
    /// Overwrite a file.
    Save(Effect),
    /// End the session and replay this capture.
    Replay(String),
}

/// The operator's choices and input.
#[derive(Clone, Debug)]
pub struct Ui {
    pub(crate) config: Arc<Config>,
    /// Whether to ring the bell for alarms and songs.
    pub(crate) bell: bool,
    pub(crate) panel: Panel,
    /// Number of pages turned in the chosen panel; the view wraps around.
    pub(crate) page: i32,
    pub(crate) enlarged: Option<Large>,
    /// Index of the chosen field of the robot's own lines.
    pub(crate) field: usize,
    /// Number of pages turned in the help.
    pub(crate) help_page: i32,
    pub(crate) overlay: Overlay,
    pub(super) typed: Typed,
    /// The list of runs to return to from a comparison.
    pub(super) behind: Option<Runs>,
    pub(crate) map: MapView,
    /// The route editor, while it is open.
    pub(crate) editor: Option<Editor>,
    /// Index of the plots' window in [`WINDOWS`].
    pub(crate) plot_window: usize,
    pub(super) size: (u16, u16),
    /// State of playback; `None` while the screen shows the present.
    pub(crate) playback: Option<Playback>,
    /// The operator's answers to alarms.
    pub(crate) attended: Attended,
    /// Index of the alarm that the key shelved last.
    pub(super) last_shelved: Option<usize>,
    /// Index in the table of the alarm that the arrows chose.
    pub(crate) alarm: Option<usize>,
    /// Message shown until the next key while the screen shows another moment.
    pub(crate) aside: Option<(Level, String)>,
    /// Feedback to the last key, and its time.
    pub(super) passing: Option<(Moment, Passing)>,
    pub(super) tour: Tour,
    /// The moment of the mark that is being named.
    pub(super) marked_at: Moment,
    pub(super) waits: Vec<Begun>,
    pub(super) automatic: Automatic,
    /// Index of the chosen parameter, while the screen of parameters is open.
    pub(crate) parameters: Option<usize>,
    /// The file that the screen of parameters compares with the robot's parameters.
    pub(crate) compared: Option<ParameterFile>,
    /// Notices for the log.
    notices: Vec<Effect>,
    revision: u64,
}

impl Ui {
    /// The view when the dashboard opens.
    #[must_use]
    pub fn new(config: Arc<Config>) -> Self {
        Self {
            bell: config.bell,
            config,
            panel: Panel::default(),
            page: 0,
            enlarged: None,
            field: 0,
            help_page: 0,
            overlay: Overlay::default(),
            typed: Typed::default(),
            behind: None,
            map: MapView::default(),
            editor: None,
            plot_window: 0,
            size: (0, 0),
            playback: None,
            attended: Attended::default(),
            last_shelved: None,
            alarm: None,
            aside: None,
            passing: None,
            tour: Tour::default(),
            marked_at: Moment::ZERO,
            waits: Vec::new(),
            automatic: Automatic::default(),
            parameters: None,
            compared: None,
            notices: Vec::new(),
            revision: 0,
        }
    }

    /// Takes an event and its effect on the facts; returns the operator's requests.
    pub fn update(
        &mut self,
        now: Moment,
        event: Event,
        facts: &Facts,
        change: Change,
    ) -> Vec<Effect> {
        let mut effects = self.expire(now);
        self.attended.expire(now);
        effects.extend(self.wait_on(now, &event));
        effects.extend(self.automate(now, &event, facts));
        let mut changed = true;
        match event {
            Event::Key(key) => effects.extend(self.take_key(facts, now, key)),
            Event::Paste(text) => changed = self.take_paste(&text),
            Event::Pointer { on, gesture } => changed = self.take_pointer(facts, on, gesture),
            Event::Resize { width, height } => {
                changed = self.size != (width, height);
                self.size = (width, height);
            }
            Event::AlarmAnswer(answer) => self.take_answer(facts, now, &answer),
            Event::Files { beginning, files } => changed = self.take_files(&beginning, files),
            Event::RouteLoaded { path, route } => {
                effects.extend(self.take_route(&path, route));
            }
            Event::ParametersLoaded { read } => self.take_parameters(facts, read),
            Event::Saved { kind, path, saved } => self.take_saved(facts, kind, &path, &saved),
            Event::Runs(runs) => changed = self.take_runs(facts, runs),
            Event::Overlaid(overlaid) => changed = self.take_overlaid(overlaid),
            Event::Notice(notice) if self.is_replay() => {
                self.aside = Some((notice.level, notice.text));
            }
            Event::Command {
                id,
                status: CommandStatus::Refused(_) | CommandStatus::Failed(_),
            } => self.recover_draft(facts, id),
            _ => changed = change.is_shown,
        }
        if effects
            .iter()
            .any(|effect| matches!(effect, Effect::Drive { .. }))
        {
            self.automatic.take_drive(now);
        }
        changed |= self.advance_tour(facts, &effects);
        self.leave_empty_panel(facts);
        effects.append(&mut self.notices);
        if change.calls && self.bell && !self.is_attended_alone(facts) {
            effects.push(Effect::Ring);
        }
        if changed || change.is_shown || !effects.is_empty() {
            self.revision += 1;
        }
        effects
    }

    /// Whether an event is shown beside the facts and does not change them, because the log of a capture has its own
    /// time.
    #[must_use]
    pub fn takes_aside(&self, event: &Event) -> bool {
        matches!(event, Event::Notice(_)) && self.is_replay()
    }

    /// Shows another moment, or now.
    pub fn show_moment(&mut self, playback: Option<Playback>) {
        self.playback = playback;
        self.revision += 1;
    }

    /// Revision of the screen; grows with each change. Draw when it differs from the revision drawn last.
    #[must_use]
    pub const fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether the terminal should report the mouse.
    #[must_use]
    pub fn wants_mouse(&self) -> bool {
        self.config.mouse
    }

    /// Latest time for the next [`Event::Tick`]: when a lease on the motors, the time of a shelved alarm or a wait ends.
    #[must_use]
    pub fn poll_timeout(&self) -> Option<Moment> {
        let lease = match &self.overlay {
            Overlay::Drive(stick) => stick.next_expiry(),
            _ => None,
        };
        let expiries = [lease, self.attended.next_expiry(), self.waits_until()];
        expiries.into_iter().flatten().min()
    }

    /// The current time of day, `22:17Z`; `None` if no clock is shown.
    pub(crate) fn clock(&self, now: Moment) -> Option<String> {
        let unix = self.config.unix.filter(|_| self.playback.is_none())?;
        Some(self.times_of_day(unix + now, |h, m, _| format!("{h:02}:{m:02}")))
    }

    /// A time since 1970 as text: in UTC and, if configured, in local time.
    pub(crate) fn times_of_day(
        &self,
        unix: Moment,
        words: impl Fn(u64, u64, u64) -> String,
    ) -> String {
        let at = |s: u64| words(s / 3600 % 24, s / 60 % 60, s % 60);
        let utc = at(unix.as_secs());
        match self.config.local_offset_s {
            None => format!("{utc}Z"),
            Some(ahead) => {
                let local = unix.as_secs().saturating_add_signed(ahead.into());
                format!("{utc}Z, {} local", at(local))
            }
        }
    }

    /// Time at which the clock shows another minute.
    pub(super) fn next_minute(&self, now: Moment) -> Option<Moment> {
        let unix = self.config.unix?;
        let minute = Duration::from_mins((unix + now).as_secs() / 60 + 1);
        minute.checked_sub(unix)
    }

    /// The part of the screen that gets the keys.
    pub(crate) const fn context(&self) -> Context {
        match self.overlay {
            Overlay::None if self.parameters.is_some() => Context::Parameters,
            Overlay::None if self.editor.is_some() => Context::Route,
            Overlay::None => Context::Dashboard,
            Overlay::Help => Context::Help,
            Overlay::Question(_) => Context::Question,
            Overlay::Text(_) => Context::Text,
            Overlay::Drive(_) => Context::Drive,
            Overlay::Palette(_) => Context::Palette,
            Overlay::Modes => Context::Modes,
            Overlay::Jump { .. } => Context::Jump,
            Overlay::Trace(_) => Context::Trace,
            Overlay::Why => Context::Why,
            Overlay::Runs(_) => Context::Runs,
            Overlay::Search(_) => Context::Search,
        }
    }

    /// Adds a line to the log.
    pub(super) fn note(&mut self, level: Level, text: impl Into<String>) {
        let notice = Notice::new(NoticeCode::Operator, level, text);
        self.notices.push(Effect::Notice(notice));
    }

    /// Warns in the log and, while the screen shows another moment, beside it.
    pub(super) fn warn(&mut self, text: &str) {
        self.note(Level::Warning, text);
        self.aside = Some((Level::Warning, text.to_owned()));
    }

    /// A text with key names in place of action names; see [`Keymap::with_keys`](super::keys::Keymap::with_keys).
    pub(crate) fn with_keys(&self, text: &str) -> String {
        self.config.keys.with_keys(text)
    }

    /// Makes a route that did not arrive the draft again, so that the operator can send it again.
    fn recover_draft(&mut self, facts: &Facts, id: CommandId) {
        // The route of another program is not the operator's draft.
        if let Some(Request::Route(waypoints)) = facts.ledger.own_request(id)
            && self.map.draft.waypoints().is_empty()
        {
            self.map.take_draft(waypoints);
        }
    }

    pub(super) fn next_plot_window(&mut self, now: Moment) {
        self.plot_window = (self.plot_window + 1) % WINDOWS.len();
        let words = format!("plots show the last {}", WINDOWS[self.plot_window].0);
        self.pass_on(now, Passing::Words(words));
    }

    fn expire(&mut self, now: Moment) -> Vec<Effect> {
        match &mut self.overlay {
            Overlay::Drive(stick) => stick.expire(now).into_iter().collect(),
            _ => Vec::new(),
        }
    }
}
