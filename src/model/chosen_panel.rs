//! The chosen panel, its page, and the enlarged part of the screen.

use super::keys::Action;
use super::news::Passing;
use super::panel::Panel;
use super::{Facts, Overlay, Ui};
use crate::event::Moment;

/// Minimum number of columns and rows of the dashboard; on a smaller terminal only STOP and quit
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

    pub(super) fn next_panel(&mut self, facts: &Facts) {
        let at = Panel::ALL.iter().position(|panel| *panel == self.panel);
        let others = Panel::ALL.iter().cycle().skip(at.unwrap_or(0) + 1);
        let mut offered = others.filter(|panel| facts.offers(**panel));
        self.panel = offered.next().copied().unwrap_or_default();
        self.page = 0;
    }

    /// Chooses another panel if the chosen one has no content for this robot.
    pub(super) fn leave_empty_panel(&mut self, facts: &Facts) {
        if !facts.offers(self.panel) {
            self.panel = if facts.link.has_only_own_lines() {
                Panel::Fields
            } else {
                Panel::default()
            };
            self.page = 0;
        }
    }

    /// Whether the arrows choose a field.
    pub(super) fn chooses_fields(&self) -> bool {
        self.panel == Panel::Fields && self.map.cursor.is_none()
    }

    /// Acts on the panel of fields, which gets the arrows and Enter unless the map has a cursor; returns whether it did.
    pub(super) fn act_on_fields(&mut self, facts: &Facts, action: Action) -> bool {
        match action {
            Action::MoveCursor { north, .. } => {
                let last = facts.fields.all().len().saturating_sub(1);
                let chosen = self.field.min(last);
                self.field = chosen.saturating_add_signed((-north).into()).min(last);
            }
            Action::AddWaypoint => self.show(Panel::Fields),
            _ => return false,
        }
        true
    }

    /// Chooses a panel, if it has content for this robot.
    pub(super) fn show_offered(&mut self, facts: &Facts, now: Moment, panel: Panel) {
        if facts.offers(panel) {
            self.show(panel);
            self.pass_on(now, Passing::Panels);
        } else {
            self.warn(&format!(
                "nothing from this robot for panel {}",
                panel.name()
            ));
        }
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

    /// Whether the key for closing removes the cursor or restores an enlarged part.
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
        // Pages of alarms follow the chosen one.
        self.alarm = None;
    }
}
