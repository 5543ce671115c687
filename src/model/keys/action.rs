//! The actions of keys.

use groundwave_protocol::status_codes::{Layer, Mode};

use crate::model::panel::Panel;
use crate::model::text_entry::Caret;
use crate::playback::{Control, Landmark};

/// The action of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    Stop,
    AskMode,
    Mode(Mode),
    ToggleLayer(Layer),
    Scan,
    AcceptSuggestion,
    ResetPose,
    ClearList,
    MoveCursor { east: i16, north: i16 },
    AddWaypoint,
    UndoDraft,
    RedoDraft,
    EditRoute,
    ShowParameters,
    ReadParameters,
    SaveParameters,
    DefaultParameter,
    CompareParameters,
    LoadParameters,
    WriteParameters,
    Route(RouteAction),
    DiscardDraft,
    SendDraft,
    AskRouteFile,
    AskCommand,
    AskPalette,
    Choose(i8),
    CancelCommands,
    Pan { east: i8, north: i8 },
    Zoom(i8),
    Follow,
    ToggleTruth,
    ToggleRecording,
    NextPanel,
    Show(Panel),
    Enlarge,
    TurnPage(i32),
    NextPlotWindow,
    AcknowledgeAlarms,
    AcknowledgeAlarm,
    ShelveAlarm,
    ToggleBell,
    Trace,
    NextValue(i8),
    NextLine(i8),
    Why,
    EnterDrive,
    Push { ahead: i8, right: i8 },
    Faster(i8),
    LeaveDrive,
    Help,
    Close,
    Confirm,
    Submit,
    CompareRun,
    EraseCharacter,
    EraseAll,
    Caret(Caret),
    Complete,
    Recall(i8),
    Playback(Control),
    Mark,
    Speed(i8),
    AskMoment,
    AskSearch,
    Find(i8),
    Copy,
    NextTheme,
    AskJump { forward: bool },
    JumpTo(Landmark),
    JumpAgain { forward: bool },
    Redraw,
    Suspend,
    Quit,
}

/// A group of actions of the dashboard, under one heading of the help.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Group {
    Robot,
    Route,
    Map,
    Panels,
    Time,
    Program,
}

impl Group {
    /// Name of the group.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Route => "route",
            Self::Map => "map",
            Self::Panels => "panels",
            Self::Time => "time",
            Self::Program => "program",
        }
    }
}

impl Action {
    /// Group of the action in the help of the dashboard.
    pub(crate) const fn group(self) -> Group {
        match self {
            Self::AddWaypoint
            | Self::UndoDraft
            | Self::RedoDraft
            | Self::EditRoute
            | Self::DiscardDraft
            | Self::SendDraft
            | Self::AskRouteFile
            | Self::ClearList
            | Self::Route(_) => Group::Route,
            Self::MoveCursor { .. }
            | Self::Follow
            | Self::Zoom(_)
            | Self::Pan { .. }
            | Self::ToggleTruth => Group::Map,
            Self::NextPanel
            | Self::Show(_)
            | Self::Enlarge
            | Self::TurnPage(_)
            | Self::NextPlotWindow
            | Self::AcknowledgeAlarms
            | Self::AcknowledgeAlarm
            | Self::ShelveAlarm
            | Self::ToggleBell
            | Self::Trace
            | Self::Why
            | Self::AskSearch
            | Self::Copy => Group::Panels,
            Self::Playback(_)
            | Self::Mark
            | Self::Speed(_)
            | Self::AskMoment
            | Self::AskJump { .. }
            | Self::ToggleRecording => Group::Time,
            Self::Help
            | Self::Close
            | Self::NextTheme
            | Self::Redraw
            | Self::Suspend
            | Self::Quit => Group::Program,
            _ => Group::Robot,
        }
    }

    /// Whether the action shows another moment, or marks this one.
    pub(crate) const fn moves_in_time(self) -> bool {
        matches!(
            self,
            Self::Playback(_)
                | Self::Mark
                | Self::Speed(_)
                | Self::AskMoment
                | Self::AskJump { .. }
        )
    }

    /// Whether the action changes the draft on the map.
    pub(crate) const fn drafts(self) -> bool {
        matches!(
            self,
            Self::MoveCursor { .. }
                | Self::AddWaypoint
                | Self::UndoDraft
                | Self::SendDraft
                | Self::EditRoute
        )
    }

    /// Whether the action applies to the content of a panel.
    pub(crate) const fn is_for(self, panel: Panel) -> bool {
        matches!(
            (panel, self),
            (Panel::Sensors, Self::Trace)
                | (Panel::Above, Self::Why)
                | (Panel::Plots | Panel::Fields, Self::NextPlotWindow)
                | (Panel::Commands, Self::CancelCommands | Self::AskCommand)
                | (Panel::Log, Self::AskJump { .. } | Self::AskSearch)
                | (Panel::Link, Self::ToggleRecording)
                | (
                    Panel::Alarms,
                    Self::AcknowledgeAlarms
                        | Self::AcknowledgeAlarm
                        | Self::ShelveAlarm
                        | Self::ToggleBell
                )
        )
    }

    /// Actions that the footer shows before other actions without a panel.
    pub(crate) const COMMON: [Self; 6] = [
        Self::AskMode,
        Self::NextPanel,
        Self::EditRoute,
        Self::AskCommand,
        Self::EnterDrive,
        Self::ToggleLayer(Layer::Bumpers),
    ];

    /// Whether the action needs a robot that uses Groundwave's protocol.
    pub(crate) const fn needs_protocol(self) -> bool {
        self.drafts() && !matches!(self, Self::MoveCursor { .. })
            || matches!(
                self,
                Self::AskMode
                    | Self::ToggleLayer(_)
                    | Self::Scan
                    | Self::AcceptSuggestion
                    | Self::ResetPose
                    | Self::ClearList
                    | Self::AddWaypoint
                    | Self::UndoDraft
                    | Self::AskRouteFile
                    | Self::EnterDrive
                    | Self::Trace
                    | Self::Why
            )
    }

    /// Whether the action needs a link that can send.
    pub(crate) const fn asks_the_robot(self) -> bool {
        matches!(
            self,
            Self::Stop
                | Self::AskMode
                | Self::Mode(_)
                | Self::ToggleLayer(_)
                | Self::Scan
                | Self::AcceptSuggestion
                | Self::ResetPose
                | Self::ClearList
                | Self::SendDraft
                | Self::Route(RouteAction::Send)
                | Self::CancelCommands
                | Self::AskCommand
                | Self::EnterDrive
        )
    }
}

/// Action of a key in the route editor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RouteAction {
    Append,
    Insert,
    AppendAtRobot,
    Delete,
    Clear,
    Undo,
    Redo,
    Select(isize),
    Step { east: i8, north: i8, fine: bool },
    Whole,
    Rotate(i16),
    Mirror,
    Scale(i8),
    Reverse,
    TakeRobots,
    Send,
    AskToLoad,
    AskToSave,
    Leave,
}
