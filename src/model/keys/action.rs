//! The actions of keys.

use groundwave_protocol::status_codes::{Layer, Mode};

use crate::model::editor::RouteAction;
use crate::model::{Caret, Panel};
use crate::playback::{Control, Landmark};

/// The action of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Action {
    Stop,
    Mode(Mode),
    ToggleLayer(Layer),
    Scan,
    ResetPose,
    ClearList,
    MoveCursor { east: i16, north: i16 },
    AddWaypoint,
    UndoDraft,
    RedoDraft,
    EditRoute,
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
    EraseCharacter,
    EraseAll,
    Caret(Caret),
    Recall(i8),
    Playback(Control),
    Speed(i8),
    AskMoment,
    AskJump { forward: bool },
    JumpTo(Landmark),
    JumpAgain { forward: bool },
    Redraw,
    Suspend,
    Quit,
}

impl Action {
    /// Whether it shows another moment.
    pub(crate) const fn moves_in_time(self) -> bool {
        matches!(
            self,
            Self::Playback(_) | Self::Speed(_) | Self::AskMoment | Self::AskJump { .. }
        )
    }

    /// Whether it changes the draft on the map.
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

    /// Whether it concerns what a panel shows.
    pub(crate) const fn is_for(self, panel: Panel) -> bool {
        matches!(
            (panel, self),
            (Panel::Sensors, Self::Trace)
                | (Panel::Above, Self::Why)
                | (Panel::Plots, Self::NextPlotWindow)
                | (Panel::Commands, Self::CancelCommands | Self::AskCommand)
                | (Panel::Log, Self::AskJump { .. })
                | (Panel::Link, Self::ToggleRecording)
                | (Panel::Alarms, Self::AcknowledgeAlarms | Self::ToggleBell)
        )
    }

    /// Whether the footer shows it before the others that concern no single panel.
    pub(crate) const COMMON: [Self; 7] = [
        Self::Mode(Mode::Prowl),
        Self::Mode(Mode::GoHome),
        Self::NextPanel,
        Self::EditRoute,
        Self::AskCommand,
        Self::EnterDrive,
        Self::ToggleLayer(Layer::Bumpers),
    ];

    /// Whether it needs a link that can send.
    pub(crate) const fn asks_the_robot(self) -> bool {
        matches!(
            self,
            Self::Stop
                | Self::Mode(_)
                | Self::ToggleLayer(_)
                | Self::Scan
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
