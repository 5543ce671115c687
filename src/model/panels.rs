//! Which panel is looked at, how much of it, and which value of the line.

use super::{Model, Overlay, Panel};

/// What has the place of all panels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Large {
    /// The chosen one.
    Panel,
    Map,
    Ladder,
}

impl Model {
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

    /// Chooses a panel; the one that is chosen already is enlarged, or no longer.
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

    /// Enlarges one thing after the other, and then none.
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
