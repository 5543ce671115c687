//! Converts keys to changes of the screen and to effects.

use std::sync::Arc;

use crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use groundwave_protocol::Waypoint;
use groundwave_protocol::arq::DRIVE_LEVEL;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};

use super::draft::Edit;
use super::keys::{Action, Context};
use super::news::Passing;
use super::palette::Palette;
use super::playback::NO_ROBOT;
use super::ui::{Overlay, Question, Then};
use super::{Facts, Purpose, SIZE_MIN, TextEntry, Ui, trace, words};
use crate::event::{Effect, Failure, Level, Moment, Shortfall, SuggestionStatus};
use crate::playback::Control;
use crate::request::Request;
use crate::route;

impl Ui {
    pub(super) fn take_key(&mut self, facts: &Facts, now: Moment, key: KeyEvent) -> Vec<Effect> {
        if let Some(effects) = self.take_escape_and(facts, now, key) {
            return effects;
        }
        let keys = &self.config.keys;
        // Redraw and suspend work in every context, and the prompt wherever characters are keys.
        let types = matches!(self.context(), Context::Text | Context::Palette);
        let everywhere = |action: &Action| match action {
            Action::Redraw | Action::Suspend => true,
            Action::AskCommand => !types,
            _ => false,
        };
        let action = keys
            .action(self.context(), key)
            .or_else(|| keys.action(Context::Dashboard, key).filter(everywhere));
        if key.kind == KeyEventKind::Release {
            return match (&mut self.overlay, action) {
                (Overlay::Drive(stick), Some(Action::Push { ahead, right })) => {
                    stick.release(ahead, right).into_iter().collect()
                }
                _ => Vec::new(),
            };
        }
        self.aside = None;
        self.passing = None;
        if self.is_too_small() {
            let stop = key.code == KeyCode::Char(' ');
            return match action {
                _ if stop => self.act(facts, now, Action::Stop, false),
                Some(action @ (Action::Stop | Action::Quit)) => self.act(facts, now, action, false),
                _ => Vec::new(),
            };
        }
        if let Some(action) = action {
            let repeated = key.kind == KeyEventKind::Repeat;
            let effects = self.act(facts, now, action, repeated);
            return if action == Action::Confirm {
                effects
            } else {
                self.ask_from_the_past(action, effects)
            };
        }
        if let Overlay::Drive(_) = self.overlay {
            let words = "hand drive: <drive/push-ahead..> drive, <drive/stop> stops, <drive/leave-drive> lets go; other \
                         keys do nothing";
            self.pass_on(now, Passing::Words(self.with_keys(words)));
        }
        if let KeyCode::Char(c) = key.code
            && !key
                .modifiers
                .intersects(KeyModifiers::CONTROL | KeyModifiers::ALT)
        {
            self.take_text(&c.to_string());
        }
        Vec::new()
    }

    /// Takes Esc and a key that arrive together, which read as Alt and a key; Alt has no bindings. Of the second
    /// key only STOP counts, because the operator may have pressed Alt.
    fn take_escape_and(
        &mut self,
        facts: &Facts,
        now: Moment,
        key: KeyEvent,
    ) -> Option<Vec<Effect>> {
        let can_follow = matches!(
            key.code,
            KeyCode::Char(_) | KeyCode::Enter | KeyCode::Backspace | KeyCode::Tab
        );
        if !can_follow || !key.modifiers.contains(KeyModifiers::ALT) {
            return None;
        }
        if key.kind == KeyEventKind::Release {
            return Some(Vec::new());
        }
        let mut effects = self.take_key(facts, now, KeyCode::Esc.into());
        let key = KeyEvent {
            modifiers: key.modifiers - KeyModifiers::ALT,
            ..key
        };
        if self.is_stop(key) {
            effects.extend(self.act(facts, now, Action::Stop, false));
        }
        Some(effects)
    }

    /// Whether the key is STOP where no text is typed.
    pub(crate) fn is_stop(&self, key: KeyEvent) -> bool {
        self.config.keys.action(Context::Dashboard, key) == Some(Action::Stop)
    }

    /// Whether the terminal is too small to show the effect of keys; `false` while its size is unknown.
    const fn is_too_small(&self) -> bool {
        let (width, height) = self.size;
        (width > 0 && width < SIZE_MIN.0) || (height > 0 && height < SIZE_MIN.1)
    }

    /// Takes pasted text: into an open prompt (first line only), otherwise as a route for the draft.
    pub(super) fn take_paste(&mut self, text: &str) -> bool {
        if self.is_too_small() {
            return false;
        }
        // Terminals send line ends as the Enter key does.
        let text = text.replace("\r\n", "\n").replace('\r', "\n");
        if self.overlay == Overlay::None {
            let route = route::parse("pasted", &text).map_err(|error| error.to_string());
            self.take_route("pasted", route);
            return true;
        }
        self.take_text(&text)
    }

    fn take_text(&mut self, text: &str) -> bool {
        let mut lines = text.lines().filter(|line| !line.trim().is_empty());
        let line = lines.next().unwrap_or_else(|| text.trim_matches('\n'));
        match &mut self.overlay {
            Overlay::Text(entry) => entry.insert(line),
            Overlay::Palette(palette) => palette.append(line),
            _ => return false,
        }
        true
    }

    pub(super) fn act(
        &mut self,
        facts: &Facts,
        now: Moment,
        action: Action,
        repeated: bool,
    ) -> Vec<Effect> {
        match action {
            Action::Stop => return vec![self.stop()],
            Action::AskMode => self.open_modes(facts),
            Action::Mode(mode) => {
                self.overlay = Overlay::None;
                return vec![Effect::Send(Request::Mode(mode))];
            }
            Action::ToggleLayer(layer) => return self.toggle(facts, layer),
            Action::Scan => return vec![Effect::Send(Request::Scan)],
            Action::AcceptSuggestion => return self.accept_suggestion(facts, now),
            Action::ResetPose => self.ask_for(ORIGIN),
            Action::ClearList => self.ask_for(Request::Route(Vec::new())),
            Action::SendDraft => return self.send_draft(),
            Action::CancelCommands => {
                self.give_up_waits();
                return vec![Effect::CancelCommands];
            }
            Action::AskCommand => {
                let end = self.let_go();
                self.overlay = Overlay::Text(TextEntry::new(Purpose::Command));
                return end;
            }
            Action::AskRouteFile => {
                self.overlay = Overlay::Text(TextEntry::new(Purpose::RouteFile));
            }
            Action::AskPalette => self.overlay = Overlay::Palette(Palette::default()),
            Action::ShowParameters => return self.open_parameters(facts),
            Action::EditRoute => self.open_editor(),
            Action::Route(action) => return self.edit_route(facts, action),
            Action::Help => self.open_help(0),
            Action::Trace => self.overlay = Overlay::Trace(0),
            Action::NextValue(steps) => self.trace(|at| trace::step(at, steps)),
            Action::NextLine(steps) => self.trace(|at| trace::next_line(at, steps)),
            Action::Why => self.overlay = Overlay::Why,
            Action::EnterDrive => self.ask_to_drive(facts),
            Action::NextPanel => {
                self.next_panel(facts);
                self.pass_on(now, Passing::Panels);
            }
            Action::Show(panel) => self.show_offered(facts, now, panel),
            Action::Enlarge => self.enlarge_next(),
            Action::TurnPage(pages) => self.turn_page(pages),
            Action::NextPlotWindow => self.next_plot_window(now),
            Action::AcknowledgeAlarms => return self.acknowledge_all(facts, now),
            Action::AcknowledgeAlarm => return self.acknowledge_one(facts, now),
            Action::ShelveAlarm => return self.shelve_one(facts, now),
            Action::ToggleBell => self.toggle_bell(now),
            Action::ToggleRecording => return vec![Effect::ToggleRecording],
            Action::AskMoment => self.overlay = Overlay::Text(TextEntry::new(Purpose::Moment)),
            Action::AskSearch => self.overlay = Overlay::Text(TextEntry::new(Purpose::Search)),
            Action::Find(steps) => self.find(facts, steps),
            Action::Copy => return self.copy(facts, now),
            Action::NextTheme => self.next_theme(now),
            Action::Mark => return self.mark(now),
            Action::AskJump { forward } => self.overlay = Overlay::Jump { forward },
            Action::Playback(_)
            | Action::Speed(_)
            | Action::JumpTo(_)
            | Action::JumpAgain { .. } => {
                return self.act_on_time(action);
            }
            Action::Suspend => return vec![Effect::Suspend],
            Action::Quit => {
                let drives = matches!(self.overlay, Overlay::Drive(_));
                let end = drives.then_some(Effect::DriveEnd);
                return end.into_iter().chain([Effect::Quit]).collect();
            }
            Action::Redraw => return vec![Effect::Redraw],
            Action::MoveCursor { .. }
            | Action::AddWaypoint
            | Action::UndoDraft
            | Action::RedoDraft
            | Action::DiscardDraft
            | Action::Pan { .. }
            | Action::Zoom(_)
            | Action::Follow
            | Action::ToggleTruth => self.act_on_map(facts, action),
            Action::Push { .. }
            | Action::Faster(_)
            | Action::LeaveDrive
            | Action::Close
            | Action::Confirm
            | Action::Submit
            | Action::CompareRun
            | Action::Choose(_)
            | Action::ReadParameters
            | Action::SaveParameters
            | Action::DefaultParameter
            | Action::CompareParameters
            | Action::LoadParameters
            | Action::WriteParameters
            | Action::EraseCharacter
            | Action::EraseAll
            | Action::Caret(_)
            | Action::Complete
            | Action::Recall(_) => return self.act_on_overlay(facts, now, action, repeated),
        }
        Vec::new()
    }

    fn toggle_bell(&mut self, now: Moment) {
        self.bell = !self.bell;
        let words = if self.bell {
            "the bell rings for alarms and songs"
        } else {
            "the bell is silent"
        };
        self.pass_on(now, Passing::Words(words.to_owned()));
    }

    fn next_theme(&mut self, now: Moment) {
        let config = Arc::make_mut(&mut self.config);
        config.colors = config.colors.next();
        let name = config.colors.name();
        let words = format!("theme {name}; `theme = \"{name}\"` in the configuration keeps it");
        self.pass_on(now, Passing::Words(words));
    }

    /// The effect of STOP; in a replay, which has no robot, it pauses.
    fn stop(&mut self) -> Effect {
        if self.is_replay() {
            return Effect::Playback(Control::TogglePause);
        }
        self.overlay = Overlay::None;
        Effect::Send(Request::Stop)
    }

    fn act_on_map(&mut self, facts: &Facts, action: Action) {
        if self.chooses_fields() && self.act_on_fields(facts, action) {
            return;
        }
        if self.chooses_alarms() && self.act_on_alarms(facts, action) {
            return;
        }
        let robot = facts.chart.pose();
        let map = &mut self.map;
        match action {
            Action::MoveCursor { east, north } => map.move_cursor(robot, east, north),
            Action::AddWaypoint if map.cursor.is_none() => {
                map.move_cursor(robot, 0, 0);
                let text = "the cursor is up: <move-cursor-left..> move it, <add-waypoint> drafts a waypoint there";
                self.note(Level::Info, self.with_keys(text));
            }
            Action::AddWaypoint if !map.add_waypoint(robot) => {
                self.warn("the robot's route holds no more waypoints");
            }
            // "Nothing to undo" needs no message: the map shows this.
            Action::UndoDraft => {
                let _ = map.draft.undo();
            }
            Action::RedoDraft => {
                let _ = map.draft.redo();
            }
            Action::DiscardDraft => {
                let _ = map.draft.edit(Edit::Clear, None);
            }
            Action::Pan { east, north } => map.pan(&facts.chart, f64::from(east), f64::from(north)),
            Action::Zoom(steps) => map.zoom_by(&facts.chart, steps),
            Action::Follow => map.toggle_follow(),
            Action::ToggleTruth => map.truth_hidden = !map.truth_hidden,
            _ => {}
        }
    }

    fn act_on_overlay(
        &mut self,
        facts: &Facts,
        now: Moment,
        action: Action,
        repeated: bool,
    ) -> Vec<Effect> {
        if self.context() == Context::Parameters {
            return self.act_on_parameters(facts, action);
        }
        let is_looking = self.is_looking();
        match (action, &mut self.overlay) {
            (Action::Push { ahead, right }, Overlay::Drive(stick)) => {
                return vec![stick.push(now, ahead, right, repeated)];
            }
            (Action::Faster(steps), Overlay::Drive(stick)) => stick.faster(steps),
            (Action::LeaveDrive, _) => return self.let_go(),
            (Action::Close, Overlay::None) if is_looking => {
                return vec![Effect::Playback(Control::StopSearch)];
            }
            (Action::Close, Overlay::None) if self.map.cursor.is_some() => self.map.cursor = None,
            (Action::Close, Overlay::None) if self.enlarged.is_some() => self.enlarged = None,
            (Action::Close, Overlay::None) => self.end_tour(),
            (Action::Close, _) => self.put_away(),
            (Action::EraseCharacter, Overlay::Text(entry)) => entry.erase(),
            (Action::EraseAll, Overlay::Text(entry)) => entry.clear(),
            (Action::Caret(to), Overlay::Text(entry)) => entry.move_caret(to),
            (Action::Complete, Overlay::Text(_)) => return self.complete(facts),
            (Action::Recall(steps), Overlay::Text(entry)) => entry.recall(&self.typed, steps),
            (Action::EraseCharacter, Overlay::Palette(palette)) => palette.erase(1),
            (Action::EraseAll, Overlay::Palette(palette)) => palette.erase(usize::MAX),
            (Action::Choose(steps), Overlay::Palette(palette)) => {
                let mut palette = palette.clone();
                let found = palette.found(self, facts);
                palette.choose(&found, steps);
                self.overlay = Overlay::Palette(palette);
            }
            (Action::Choose(steps), Overlay::Runs(runs)) => runs.choose(steps),
            (Action::Submit, Overlay::Runs(_)) => return self.replay_run(),
            (Action::CompareRun, Overlay::Runs(_)) => return self.pick_run(),
            (Action::Submit, Overlay::Palette(palette)) => {
                let palette = palette.clone();
                return self.pick(facts, now, &palette);
            }
            (Action::Submit, Overlay::Text(entry)) => {
                let entry = entry.clone();
                return self.submit(facts, now, entry);
            }
            (Action::Confirm, Overlay::Question(question)) => {
                let then = question.then.clone();
                self.overlay = Overlay::None;
                return self.go_ahead(then);
            }
            _ => {}
        }
        Vec::new()
    }

    /// Ends driving by hand, if active; the robot stays in mode user until another command.
    fn let_go(&mut self) -> Vec<Effect> {
        if !matches!(self.overlay, Overlay::Drive(_)) {
            return Vec::new();
        }
        self.overlay = Overlay::None;
        let text = "it stands in mode user: <modes/mode-prowl> prowls, <modes/mode-go-home> goes home, <enter-drive> drives on";
        self.note(Level::Info, self.with_keys(text));
        vec![Effect::DriveEnd]
    }

    /// Sends the commands of the present suggestion.
    pub(super) fn accept_suggestion(&mut self, facts: &Facts, now: Moment) -> Vec<Effect> {
        let offered = facts.suggestion(now).filter(|_| self.playback.is_none());
        let Some(suggestion) = offered else {
            self.warn("there is no suggestion now");
            return Vec::new();
        };
        self.automatic.take_suggested(suggestion, false);
        let accepted = suggestion.event(SuggestionStatus::Accepted);
        let requests = suggestion.requests.iter().cloned();
        [Effect::Suggestion(accepted)]
            .into_iter()
            .chain(requests.map(Effect::Send))
            .collect()
    }

    pub(super) fn ask_or_send(&mut self, request: Request) -> Vec<Effect> {
        if request.is_hazardous() {
            self.ask_for(request);
            return Vec::new();
        }
        vec![Effect::Send(request)]
    }

    pub(super) fn open_help(&mut self, page: i32) {
        self.help_page = page;
        self.overlay = Overlay::Help;
    }

    fn open_modes(&mut self, facts: &Facts) {
        if self.is_replay() {
            self.aside = Some((Level::Warning, NO_ROBOT.to_owned()));
        } else if facts.link.is_receive_only() {
            self.warn("no mode can be sent: the link is receive-only");
        } else {
            self.overlay = Overlay::Modes;
        }
    }

    /// Asks before something is sent to the robot.
    pub(super) fn ask(&mut self, text: String, then: Then) {
        if self.is_replay() {
            self.aside = Some((Level::Warning, NO_ROBOT.to_owned()));
            return;
        }
        let text = self.said_of_the_past(text);
        self.overlay = Overlay::Question(Question { text, then });
    }

    fn ask_for(&mut self, request: Request) {
        let (text, then) = match &request {
            Request::Mode(Mode::User) => (self.with_keys(DRIVE_QUESTION), Then::Drive),
            Request::Route(_) => (
                "Clear the robot's route?".to_owned(),
                Then::Send(vec![request]),
            ),
            Request::Pose {
                position,
                theta_deg,
            } => (
                format!(
                    "Tell the robot that it is at ({}, {}), heading {theta_deg}? Its trail starts afresh, and it looks for its dock from there.",
                    position.x_in, position.y_in
                ),
                Then::Send(vec![request]),
            ),
            other => {
                let takes = other
                    .turns_off()
                    .map(|part| format!(" This turns {part} off."));
                let text = format!("Send `{other}`?{}", takes.unwrap_or_default());
                (text, Then::Send(vec![request]))
            }
        };
        self.ask(text, then);
    }

    fn ask_to_drive(&mut self, facts: &Facts) {
        let level = facts.robot.abilities.map(|robot| robot.level);
        if !facts.link.can_send {
            self.warn("cannot drive: the link is receive-only");
        } else if let Some(level) = level.filter(|level| *level < DRIVE_LEVEL) {
            let needs = Failure::BeyondLevel(Shortfall {
                has: level.into(),
                needs: DRIVE_LEVEL.into(),
            });
            self.warn(&format!("hand drive: {needs}"));
        } else {
            self.ask_for(Request::Mode(Mode::User));
        }
    }

    /// Toggles a layer: the opposite of the pending command, else of the robot's
    /// report.
    fn toggle(&mut self, facts: &Facts, layer: Layer) -> Vec<Effect> {
        let name = words::layer(layer);
        let Some(allowed) = facts.robot.allowed() else {
            self.warn("the robot's layers are not known yet");
            return Vec::new();
        };
        if facts.robot.lacks(layer) {
            self.warn(&format!("{name} is not fitted on this robot"));
            return Vec::new();
        }
        let is_allowed = facts
            .ledger
            .asked_of(layer, facts.robot.status.map(|status| status.at))
            .unwrap_or_else(|| allowed.contains(layer));
        let mask = LayerMask::NONE.with(layer);
        self.ask_or_send(if is_allowed {
            Request::Disable(mask)
        } else {
            Request::Enable(mask)
        })
    }

    pub(super) fn send_draft(&mut self) -> Vec<Effect> {
        if self.map.draft.waypoints().is_empty() {
            let text = self.with_keys("no draft yet: move the cursor, press <add-waypoint>");
            self.warn(&text);
            return Vec::new();
        }
        self.map.cursor = None;
        match Request::route(self.map.draft.take()) {
            Ok(request) => vec![Effect::Send(request)],
            Err(error) => {
                self.warn(&error.to_string());
                Vec::new()
            }
        }
    }
}

/// The command that makes the robot's place the origin.
const ORIGIN: Request = Request::Pose {
    position: Waypoint { x_in: 0, y_in: 0 },
    theta_deg: 0,
};

const DRIVE_QUESTION: &str = "Drive by hand? The <drive/push-ahead..> move the robot while you hold them; letting go stops it.";
