//! The chosen panel, its page, and the enlarged part of the screen.

use super::{Overlay, Ui};

/// A panel; on a small screen one is shown at a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Panel {
    #[default]
    Sensors,
    /// The robot seen from above.
    Above,
    Plots,
    Commands,
    Log,
    Link,
    Alarms,
}

impl Panel {
    /// Its name in the list of panels; names and keys of all must fit a row of 80 columns.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Sensors => "sensors",
            Self::Above => "above",
            Self::Plots => "plots",
            Self::Commands => "commands",
            Self::Log => "log",
            Self::Link => "link",
            Self::Alarms => "alarms",
        }
    }

    /// Every panel, in the order of the Tab key.
    pub(crate) const ALL: [Self; 7] = [
        Self::Sensors,
        Self::Above,
        Self::Plots,
        Self::Commands,
        Self::Log,
        Self::Link,
        Self::Alarms,
    ];
}

/// Least columns and rows of the dashboard; on a smaller terminal only STOP and quit
/// work.
pub(crate) const SIZE_MIN: (u16, u16) = (80, 24);

/// The enlarged part of the screen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Large {
    /// The chosen panel.
    Panel,
    Map,
    Ladder,
}

impl Ui {
    pub(super) fn trace(&mut self, to: impl FnOnce(usize) -> usize) {
        if let Overlay::Trace(at) = &mut self.overlay {
            *at = to(*at);
        }
    }

    pub(super) fn next_panel(&mut self) {
        let at = Panel::ALL
            .iter()
            .position(|panel| *panel == self.panel)
            .unwrap_or(0);
        self.panel = Panel::ALL[(at + 1) % Panel::ALL.len()];
        self.page = 0;
    }

    /// Chooses a panel; toggles its enlargement if it is chosen already.
    pub(super) fn show(&mut self, panel: Panel) {
        let is_seen = matches!(self.enlarged, None | Some(Large::Panel));
        if self.panel == panel && is_seen {
            self.enlarged = self.enlarged.is_none().then_some(Large::Panel);
        } else {
            self.panel = panel;
            self.enlarged = self.enlarged.map(|_| Large::Panel);
        }
        self.page = 0;
    }

    /// Whether the key for closing puts the cursor or an enlarged part away.
    pub(crate) const fn can_put_away(&self) -> bool {
        self.map.cursor.is_some() || self.enlarged.is_some()
    }

    /// Enlarges panel, map and ladder in turn, then nothing.
    pub(super) const fn enlarge_next(&mut self) {
        self.enlarged = match self.enlarged {
            None => Some(Large::Panel),
            Some(Large::Panel) => Some(Large::Map),
            Some(Large::Map) => Some(Large::Ladder),
            Some(Large::Ladder) => None,
        };
    }

    pub(super) const fn turn_page(&mut self, pages: i32) {
        let turned = match self.overlay {
            Overlay::Help => &mut self.help_page,
            _ => &mut self.page,
        };
        *turned = turned.wrapping_add(pages);
    }
}
