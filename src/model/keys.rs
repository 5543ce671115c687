//! The keys: one table for dispatch, footer, help, palette and manual.

mod action;
mod map;
mod notation;
mod words;

use crossterm::event::{KeyCode, KeyModifiers};
use groundwave_protocol::status_codes::{Layer, Mode};

use super::panel::Panel;
use super::text_entry::Caret;
use crate::playback::{Control, Landmark};

/// The part of the screen that gets the keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Context {
    /// The dashboard with its panels.
    Dashboard,
    /// The route editor.
    Route,
    /// Driving by hand.
    Drive,
    /// A prompt for a command, a file name or a time.
    Text,
    /// A yes-or-no question.
    Question,
    /// The list of keys.
    Help,
    /// The palette.
    Palette,
    /// The choice of a mode.
    Modes,
    /// The choice of a landmark.
    Jump,
    /// A value and its columns.
    Trace,
    /// The reasons for the robot's behaviour.
    Why,
    /// The list of runs, or two runs compared.
    Runs,
    /// Search in the log.
    Search,
    /// The robot's parameters.
    Parameters,
}

impl Context {
    /// Every context.
    pub(crate) const ALL: [Self; 14] = [
        Self::Dashboard,
        Self::Route,
        Self::Drive,
        Self::Text,
        Self::Question,
        Self::Help,
        Self::Palette,
        Self::Modes,
        Self::Jump,
        Self::Trace,
        Self::Why,
        Self::Runs,
        Self::Search,
        Self::Parameters,
    ];

    /// Name of the context in the configuration.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Dashboard => "dashboard",
            Self::Route => "route",
            Self::Drive => "drive",
            Self::Text => "text",
            Self::Question => "question",
            Self::Help => "help-screen",
            Self::Palette => "palette",
            Self::Modes => "modes",
            Self::Jump => "jump",
            Self::Trace => "trace-window",
            Self::Why => "why-window",
            Self::Runs => "runs-window",
            Self::Search => "search",
            Self::Parameters => "parameters",
        }
    }
}

pub(crate) use action::{Action, Group, RouteAction};
pub(crate) use map::Row;
pub use map::{KeyMistake, Keymap, Rebinding};

/// One row of the table.
#[derive(Clone, Copy, Debug)]
struct Binding {
    context: Context,
    /// The keys, as the help shows them.
    label: &'static str,
    keys: &'static [(KeyCode, KeyModifiers)],
    action: Action,
    /// Description for the help; empty if another row describes the action.
    help: &'static str,
    /// Description for the footer; empty if the footer does not show the action.
    footer: &'static str,
}

const fn plain(c: char) -> (KeyCode, KeyModifiers) {
    (KeyCode::Char(c), KeyModifiers::NONE)
}

const fn ctrl(c: char) -> (KeyCode, KeyModifiers) {
    (KeyCode::Char(c), KeyModifiers::CONTROL)
}

const fn bare(code: KeyCode) -> (KeyCode, KeyModifiers) {
    (code, KeyModifiers::NONE)
}

const fn shift(code: KeyCode) -> (KeyCode, KeyModifiers) {
    (code, KeyModifiers::SHIFT)
}

const fn row(
    context: Context,
    label: &'static str,
    keys: &'static [(KeyCode, KeyModifiers)],
    action: Action,
    help: &'static str,
    footer: &'static str,
) -> Binding {
    Binding {
        context,
        label,
        keys,
        action,
        help,
        footer,
    }
}

use Context::{
    Dashboard, Drive, Help, Jump, Modes, Palette, Parameters, Question, Route, Runs, Search, Text,
    Trace, Why,
};

/// Every key. STOP is the first row of each context: Space, or Ctrl-S where Space is a character.
#[rustfmt::skip]
const TABLE: &[Binding] = &[
    row(Dashboard, "Space", &[plain(' '), ctrl('s')], Action::Stop, "STOP (Ctrl-S while typing)", "STOP"),
    row(Dashboard, "m", &[plain('m')], Action::AskMode, "modes: prowl, home, dock, ..", "modes"),
    row(Dashboard, "1-7", &[plain('1')], Action::ToggleLayer(Layer::Bumpers), "allow a layer, or forbid it", "layers"),
    row(Dashboard, "2", &[plain('2')], Action::ToggleLayer(Layer::Rotation), "", ""),
    row(Dashboard, "3", &[plain('3')], Action::ToggleLayer(Layer::Infrared), "", ""),
    row(Dashboard, "4", &[plain('4')], Action::ToggleLayer(Layer::Sonar), "", ""),
    row(Dashboard, "5", &[plain('5')], Action::ToggleLayer(Layer::Photo), "", ""),
    row(Dashboard, "6", &[plain('6')], Action::ToggleLayer(Layer::Motion), "", ""),
    row(Dashboard, "7", &[plain('7')], Action::ToggleLayer(Layer::DeadReckoning), "", ""),
    row(Dashboard, "0", &[plain('0')], Action::ToggleLayer(Layer::User), "the same for driving by hand", ""),
    row(Dashboard, "d", &[plain('d')], Action::EnterDrive, "drive by hand (asks)", "drive"),
    row(Dashboard, "v", &[plain('v')], Action::Scan, "look around once", ""),
    row(Dashboard, "Ctrl-Y", &[ctrl('y')], Action::AcceptSuggestion, "accept the suggestion", ""),
    row(Dashboard, "O", &[plain('O')], Action::ResetPose, "make this the origin (asks)", ""),
    row(Dashboard, "P", &[plain('P')], Action::ShowParameters, "the robot's parameters", ""),
    row(Dashboard, "x", &[plain('x')], Action::CancelCommands, "cancel unfinished commands", "give up"),
    row(Dashboard, ":", &[plain(':')], Action::AskCommand, "type a command, in any window", "command"),
    row(Dashboard, "Ctrl-P", &[ctrl('p')], Action::AskPalette, "find a key or command", "find"),
    row(Dashboard, "w", &[plain('w'), bare(KeyCode::Enter)], Action::AddWaypoint, "draft a waypoint (Enter)", "add"),
    row(Dashboard, "u", &[plain('u'), bare(KeyCode::Backspace)], Action::UndoDraft, "undo a change", "undo"),
    row(Dashboard, "Ctrl-R", &[ctrl('r')], Action::RedoDraft, "redo a change", ""),
    row(Dashboard, "e", &[plain('e')], Action::EditRoute, "edit the draft in a list", "edit"),
    row(Dashboard, "U", &[plain('U')], Action::DiscardDraft, "discard the draft", ""),
    row(Dashboard, "S", &[plain('S')], Action::SendDraft, "send the draft; <modes/mode-prowl> drives it", "send"),
    row(Dashboard, "r", &[plain('r')], Action::AskRouteFile, "load a route file as draft", "load"),
    row(Dashboard, "C", &[plain('C')], Action::ClearList, "clear the sent route (asks)", ""),
    row(Dashboard, "arrows", &[bare(KeyCode::Left), plain('h')], Action::MoveCursor { east: -1, north: 0 }, "move the cursor (also hjkl)", "move"),
    row(Dashboard, "", &[bare(KeyCode::Right), plain('l')], Action::MoveCursor { east: 1, north: 0 }, "", ""),
    row(Dashboard, "", &[bare(KeyCode::Up), plain('k')], Action::MoveCursor { east: 0, north: 1 }, "", ""),
    row(Dashboard, "", &[bare(KeyCode::Down), plain('j')], Action::MoveCursor { east: 0, north: -1 }, "", ""),
    row(Dashboard, "f", &[plain('f')], Action::Follow, "follow, or show all", ""),
    row(Dashboard, "+ -", &[plain('+'), plain('=')], Action::Zoom(1), "zoom", ""),
    row(Dashboard, "", &[plain('-'), plain('_')], Action::Zoom(-1), "", ""),
    row(Dashboard, "HJKL", &[plain('H'), shift(KeyCode::Left)], Action::Pan { east: -1, north: 0 }, "look elsewhere", ""),
    row(Dashboard, "", &[plain('L'), shift(KeyCode::Right)], Action::Pan { east: 1, north: 0 }, "", ""),
    row(Dashboard, "", &[plain('K'), shift(KeyCode::Up)], Action::Pan { east: 0, north: 1 }, "", ""),
    row(Dashboard, "", &[plain('J'), shift(KeyCode::Down)], Action::Pan { east: 0, north: -1 }, "", ""),
    row(Dashboard, "t", &[plain('t')], Action::ToggleTruth, "the simulator's truth", ""),
    row(Dashboard, "Tab", &[bare(KeyCode::Tab)], Action::NextPanel, "choose the next panel", "panel"),
    row(Dashboard, "F2-F9", &[bare(KeyCode::F(2))], Action::Show(Panel::Sensors), "show a panel; again: larger", ""),
    row(Dashboard, "", &[bare(KeyCode::F(3))], Action::Show(Panel::Above), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(4))], Action::Show(Panel::Plots), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(5))], Action::Show(Panel::Commands), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(6))], Action::Show(Panel::Log), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(7))], Action::Show(Panel::Link), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(8))], Action::Show(Panel::Alarms), "", ""),
    row(Dashboard, "", &[bare(KeyCode::F(9))], Action::Show(Panel::Fields), "", ""),
    row(Dashboard, "z", &[plain('z')], Action::Enlarge, "enlarge panel, map, ladder", "enlarge"),
    row(Dashboard, "PgUp", &[bare(KeyCode::PageUp), plain('[')], Action::TurnPage(-1), "PgDn, or [ ]: turn the pages", "pages"),
    row(Dashboard, "", &[bare(KeyCode::PageDown), plain(']')], Action::TurnPage(1), "", ""),
    row(Dashboard, "T", &[plain('T')], Action::NextPlotWindow, "plots: longer period", "longer"),
    row(Dashboard, "A", &[plain('A')], Action::AcknowledgeAlarms, "acknowledge alarms", "ack"),
    row(Dashboard, "E", &[plain('E')], Action::AcknowledgeAlarm, "acknowledge one alarm", "ack one"),
    row(Dashboard, "Z", &[plain('Z')], Action::ShelveAlarm, "shelve an alarm for a time", "shelve"),
    row(Dashboard, "b", &[plain('b')], Action::ToggleBell, "bell for alarms: on, or off", "bell"),
    row(Dashboard, "i", &[plain('i')], Action::Trace, "trace a value to its columns", "trace"),
    row(Dashboard, "/", &[plain('/')], Action::AskSearch, "search the log", "search"),
    row(Dashboard, "c", &[plain('c')], Action::Copy, "copy the newest line", ""),
    row(Dashboard, "y", &[plain('y')], Action::Why, "explain the robot's actions", "why"),
    row(Dashboard, "R", &[plain('R')], Action::ToggleRecording, "record, or stop recording", "record"),
    row(Dashboard, "p", &[plain('p')], Action::Playback(Control::TogglePause), "pause, or continue", "pause"),
    row(Dashboard, ", .", &[plain(',')], Action::Playback(Control::Step { forward: false }), "a line back, a line forward", "line"),
    row(Dashboard, "", &[plain('.')], Action::Playback(Control::Step { forward: true }), "", ""),
    row(Dashboard, "< >", &[plain('<')], Action::Speed(-1), "slower, faster", "speed"),
    row(Dashboard, "", &[plain('>')], Action::Speed(1), "", ""),
    row(Dashboard, "g", &[plain('g')], Action::AskMoment, "go to 12:30, +30s, #12", "go to"),
    row(Dashboard, "n N", &[plain('n')], Action::AskJump { forward: true }, "next alarm, bump, ..", "next"),
    row(Dashboard, "", &[plain('N')], Action::AskJump { forward: false }, "", ""),
    row(Dashboard, "a", &[plain('a')], Action::Mark, "add a mark, or remove it", "mark"),
    row(Dashboard, "o", &[plain('o')], Action::Playback(Control::Loop), "loop from here, to here", "loop"),
    row(Dashboard, "G", &[plain('G'), bare(KeyCode::End)], Action::Playback(Control::Newest), "now, or the end (End)", "newest"),
    row(Dashboard, "Home", &[bare(KeyCode::Home)], Action::Playback(Control::Oldest), "to the beginning", ""),
    row(Dashboard, "?", &[plain('?'), bare(KeyCode::F(1))], Action::Help, "these keys", "keys"),
    row(Dashboard, "Esc", &[bare(KeyCode::Esc)], Action::Close, "hide the cursor", "back"),
    row(Dashboard, "Ctrl-T", &[ctrl('t')], Action::NextTheme, "the next theme (colours)", ""),
    row(Dashboard, "Ctrl-L", &[ctrl('l')], Action::Redraw, "redraw the screen", ""),
    row(Dashboard, "Ctrl-Z", &[ctrl('z')], Action::Suspend, "Unix: shell; fg returns", ""),
    row(Dashboard, "q", &[plain('q'), ctrl('c')], Action::Quit, "leave; a real robot continues", "quit"),
    row(Route, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Route, "arrows", &[bare(KeyCode::Left), plain('h')], Action::Route(RouteAction::Step { east: -1, north: 0, fine: false }), "move the waypoint by 6 in", "move"),
    row(Route, "", &[bare(KeyCode::Right), plain('l')], Action::Route(RouteAction::Step { east: 1, north: 0, fine: false }), "", ""),
    row(Route, "", &[bare(KeyCode::Up), plain('k')], Action::Route(RouteAction::Step { east: 0, north: 1, fine: false }), "", ""),
    row(Route, "", &[bare(KeyCode::Down), plain('j')], Action::Route(RouteAction::Step { east: 0, north: -1, fine: false }), "", ""),
    row(Route, "HJKL", &[plain('H'), shift(KeyCode::Left)], Action::Route(RouteAction::Step { east: -1, north: 0, fine: true }), "by 1 in", ""),
    row(Route, "", &[plain('L'), shift(KeyCode::Right)], Action::Route(RouteAction::Step { east: 1, north: 0, fine: true }), "", ""),
    row(Route, "", &[plain('K'), shift(KeyCode::Up)], Action::Route(RouteAction::Step { east: 0, north: 1, fine: true }), "", ""),
    row(Route, "", &[plain('J'), shift(KeyCode::Down)], Action::Route(RouteAction::Step { east: 0, north: -1, fine: true }), "", ""),
    row(Route, "n b", &[plain('n'), bare(KeyCode::Tab), bare(KeyCode::PageDown)], Action::Route(RouteAction::Select(1)), "next or previous waypoint", "next"),
    row(Route, "", &[plain('b'), bare(KeyCode::BackTab), bare(KeyCode::PageUp)], Action::Route(RouteAction::Select(-1)), "", ""),
    row(Route, "w", &[plain('w'), bare(KeyCode::Enter)], Action::Route(RouteAction::Append), "add one after it", "add"),
    row(Route, "i", &[plain('i')], Action::Route(RouteAction::Insert), "insert one before it", "insert"),
    row(Route, "p", &[plain('p')], Action::Route(RouteAction::AppendAtRobot), "add one at the robot", "here"),
    row(Route, "x", &[plain('x'), bare(KeyCode::Delete)], Action::Route(RouteAction::Delete), "delete it", "delete"),
    row(Route, "u", &[plain('u'), bare(KeyCode::Backspace)], Action::Route(RouteAction::Undo), "undo a change", "undo"),
    row(Route, "Ctrl-R", &[ctrl('r')], Action::Route(RouteAction::Redo), "redo a change", ""),
    row(Route, "g", &[plain('g')], Action::Route(RouteAction::Whole), "<route/route-step-left..> move one, or all", "all"),
    row(Route, "< >", &[plain('<')], Action::Route(RouteAction::Rotate(-15)), "turn the route by 15 degrees", "turn"),
    row(Route, "", &[plain('>')], Action::Route(RouteAction::Rotate(15)), "", ""),
    row(Route, ", .", &[plain(',')], Action::Route(RouteAction::Rotate(-1)), "by 1 degree", ""),
    row(Route, "", &[plain('.')], Action::Route(RouteAction::Rotate(1)), "", ""),
    row(Route, "+ -", &[plain('+'), plain('=')], Action::Route(RouteAction::Scale(1)), "larger, smaller", ""),
    row(Route, "", &[plain('-'), plain('_')], Action::Route(RouteAction::Scale(-1)), "", ""),
    row(Route, "m", &[plain('m')], Action::Route(RouteAction::Mirror), "mirror it, east for west", ""),
    row(Route, "R", &[plain('R')], Action::Route(RouteAction::Reverse), "reverse the order", ""),
    row(Route, "y", &[plain('y')], Action::Route(RouteAction::TakeRobots), "copy the robot's route", ""),
    row(Route, "U", &[plain('U')], Action::Route(RouteAction::Clear), "discard it", ""),
    row(Route, "r", &[plain('r')], Action::Route(RouteAction::AskToLoad), "load a file", ""),
    row(Route, "s", &[plain('s')], Action::Route(RouteAction::AskToSave), "save it to a file", "save"),
    row(Route, "S", &[plain('S')], Action::Route(RouteAction::Send), "send it to the robot", "send"),
    row(Route, "?", &[plain('?'), bare(KeyCode::F(1))], Action::Help, "these keys", "keys"),
    row(Route, "Esc", &[bare(KeyCode::Esc), plain('e'), plain('q')], Action::Route(RouteAction::Leave), "leave; the draft stays", "done"),
    row(Route, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Drive, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Drive, "arrows", &[bare(KeyCode::Up), plain('k')], Action::Push { ahead: 1, right: 0 }, "", "hold to drive"),
    row(Drive, "", &[bare(KeyCode::Down), plain('j')], Action::Push { ahead: -1, right: 0 }, "", ""),
    row(Drive, "", &[bare(KeyCode::Left), plain('h')], Action::Push { ahead: 0, right: -1 }, "", ""),
    row(Drive, "", &[bare(KeyCode::Right), plain('l')], Action::Push { ahead: 0, right: 1 }, "", ""),
    row(Drive, "+ -", &[plain('+'), plain('=')], Action::Faster(1), "", "speed"),
    row(Drive, "", &[plain('-'), plain('_')], Action::Faster(-1), "", ""),
    row(Drive, "Esc", &[bare(KeyCode::Esc), plain('d'), plain('q')], Action::LeaveDrive, "", "let go"),
    row(Drive, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Text, "Ctrl-S", &[ctrl('s')], Action::Stop, "", "STOP"),
    row(Text, "Enter", &[bare(KeyCode::Enter)], Action::Submit, "", "do it"),
    row(Text, "Esc", &[bare(KeyCode::Esc)], Action::Close, "", "cancel"),
    row(Text, "", &[bare(KeyCode::Backspace), ctrl('h')], Action::EraseCharacter, "", ""),
    row(Text, "Ctrl-U", &[ctrl('u')], Action::EraseAll, "", ""),
    row(Text, "Tab", &[bare(KeyCode::Tab)], Action::Complete, "", "complete"),
    row(Text, "Up", &[bare(KeyCode::Up)], Action::Recall(-1), "", "recall"),
    row(Text, "", &[bare(KeyCode::Down)], Action::Recall(1), "", ""),
    row(Text, "", &[bare(KeyCode::Left)], Action::Caret(Caret::Left), "", ""),
    row(Text, "", &[bare(KeyCode::Right)], Action::Caret(Caret::Right), "", ""),
    row(Text, "", &[bare(KeyCode::Home)], Action::Caret(Caret::Start), "", ""),
    row(Text, "", &[bare(KeyCode::End)], Action::Caret(Caret::End), "", ""),
    row(Text, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Question, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Question, "y", &[plain('y')], Action::Confirm, "", "yes"),
    row(Question, "n", &[plain('n'), plain('q'), bare(KeyCode::Esc)], Action::Close, "", "no"),
    row(Question, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Modes, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Modes, "p", &[plain('p')], Action::Mode(Mode::Prowl), "", "prowl"),
    row(Modes, "h", &[plain('h')], Action::Mode(Mode::GoHome), "", "home"),
    row(Modes, "w", &[plain('w')], Action::Mode(Mode::Wander), "", "wander"),
    row(Modes, "r", &[plain('r')], Action::Mode(Mode::Reactive), "", "reactive"),
    row(Modes, "s", &[plain('s')], Action::Mode(Mode::Passive), "", "passive"),
    row(Modes, "d", &[plain('d')], Action::Mode(Mode::Forage), "", "dock"),
    row(Modes, "Esc", &[bare(KeyCode::Esc), plain('m'), plain('q')], Action::Close, "", "back"),
    row(Modes, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Jump, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Jump, "a", &[plain('a')], Action::JumpTo(Landmark::Alarm), "", "alarm"),
    row(Jump, "b", &[plain('b')], Action::JumpTo(Landmark::Bump), "", "bump"),
    row(Jump, "v", &[plain('v')], Action::JumpTo(Landmark::Behaviour), "", "layer"),
    row(Jump, "c", &[plain('c')], Action::JumpTo(Landmark::Command), "", "command"),
    row(Jump, "m", &[plain('m')], Action::JumpTo(Landmark::Marker), "", "mark"),
    row(Jump, "n", &[plain('n')], Action::JumpAgain { forward: true }, "", "as before"),
    row(Jump, "", &[plain('N')], Action::JumpAgain { forward: false }, "", ""),
    row(Jump, "Esc", &[bare(KeyCode::Esc), plain('q')], Action::Close, "", "back"),
    row(Jump, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Help, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Help, "Esc", &[bare(KeyCode::Esc), plain('?'), plain('q'), bare(KeyCode::Enter), bare(KeyCode::F(1))], Action::Close, "", "back"),
    row(Help, "PgDn", &[bare(KeyCode::PageDown), bare(KeyCode::Tab), bare(KeyCode::Down), plain('j')], Action::TurnPage(1), "", "next page"),
    row(Help, "", &[bare(KeyCode::PageUp), bare(KeyCode::Up), plain('k')], Action::TurnPage(-1), "", ""),
    row(Help, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Palette, "Ctrl-S", &[ctrl('s')], Action::Stop, "", "STOP"),
    row(Palette, "Enter", &[bare(KeyCode::Enter)], Action::Submit, "", "do it"),
    row(Palette, "arrows", &[bare(KeyCode::Up), ctrl('p')], Action::Choose(-1), "", "choose"),
    row(Palette, "", &[bare(KeyCode::Down), ctrl('n'), bare(KeyCode::Tab)], Action::Choose(1), "", ""),
    row(Palette, "Esc", &[bare(KeyCode::Esc)], Action::Close, "", "cancel"),
    row(Palette, "", &[bare(KeyCode::Backspace), ctrl('h')], Action::EraseCharacter, "", ""),
    row(Palette, "Ctrl-U", &[ctrl('u')], Action::EraseAll, "", "erase"),
    row(Palette, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Trace, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Trace, "arrows", &[bare(KeyCode::Right), plain('l'), bare(KeyCode::Tab)], Action::NextValue(1), "", "value and line"),
    row(Trace, "", &[bare(KeyCode::Left), plain('h')], Action::NextValue(-1), "", ""),
    row(Trace, "", &[bare(KeyCode::Down), plain('j')], Action::NextLine(1), "", ""),
    row(Trace, "", &[bare(KeyCode::Up), plain('k')], Action::NextLine(-1), "", ""),
    row(Trace, "c", &[plain('c'), plain('y')], Action::Copy, "", "copy"),
    row(Trace, "Esc", &[bare(KeyCode::Esc), plain('i'), plain('q')], Action::Close, "", "back"),
    row(Trace, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Why, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Why, "Esc", &[bare(KeyCode::Esc), plain('y'), plain('q'), bare(KeyCode::Enter)], Action::Close, "", "back"),
    row(Why, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Runs, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Runs, "arrows", &[bare(KeyCode::Up), plain('k')], Action::Choose(-1), "", "choose"),
    row(Runs, "", &[bare(KeyCode::Down), plain('j'), bare(KeyCode::Tab)], Action::Choose(1), "", ""),
    row(Runs, "Enter", &[bare(KeyCode::Enter)], Action::Submit, "", "replay"),
    row(Runs, "c", &[plain('c')], Action::CompareRun, "", "compare"),
    row(Runs, ":", &[plain(':')], Action::AskCommand, "", "command"),
    row(Runs, "Esc", &[bare(KeyCode::Esc), plain('q')], Action::Close, "", "back"),
    row(Runs, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Parameters, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Parameters, "arrows", &[bare(KeyCode::Up), plain('k')], Action::Choose(-1), "", "choose"),
    row(Parameters, "", &[bare(KeyCode::Down), plain('j'), bare(KeyCode::Tab)], Action::Choose(1), "", ""),
    row(Parameters, "Enter", &[bare(KeyCode::Enter)], Action::Submit, "", "change"),
    row(Parameters, "d", &[plain('d')], Action::DefaultParameter, "", "default"),
    row(Parameters, "s", &[plain('s')], Action::SaveParameters, "", "save"),
    row(Parameters, "r", &[plain('r')], Action::ReadParameters, "", "read"),
    row(Parameters, "c", &[plain('c')], Action::CompareParameters, "", ""),
    row(Parameters, "l", &[plain('l')], Action::LoadParameters, "", ""),
    row(Parameters, "w", &[plain('w')], Action::WriteParameters, "", ""),
    row(Parameters, ":", &[plain(':')], Action::AskCommand, "", "command"),
    row(Parameters, "Esc", &[bare(KeyCode::Esc), plain('q')], Action::Close, "", "back"),
    row(Parameters, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
    row(Search, "Space", &[plain(' '), ctrl('s')], Action::Stop, "", "STOP"),
    row(Search, "n", &[plain('n'), bare(KeyCode::Enter), bare(KeyCode::Up), plain('k')], Action::Find(1), "", "older"),
    row(Search, "N", &[plain('N'), bare(KeyCode::Down), plain('j')], Action::Find(-1), "", "newer"),
    row(Search, "/", &[plain('/')], Action::AskSearch, "", "search"),
    row(Search, "c", &[plain('c'), plain('y')], Action::Copy, "", "copy"),
    row(Search, "Esc", &[bare(KeyCode::Esc), plain('q')], Action::Close, "", "back"),
    row(Search, "Ctrl-C", &[ctrl('c')], Action::Quit, "", ""),
];

#[cfg(test)]
mod tests;
