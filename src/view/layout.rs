//! The layout of the panels.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;

use super::pointer::Mark;
use super::{Screen, above, ladder, link, sensors, split_bottom, split_right, split_top};
use crate::model::{Large, Panel};

/// Minimum size for the full layout.
pub(super) const WIDTH_FULL: u16 = 110;
pub(super) const HEIGHT_FULL: u16 = 34;

/// Minimum size for the layout with every panel.
const WIDTH_ALL: u16 = 170;
const HEIGHT_ALL: u16 = 44;

/// Width of the third column: robot from above, plots and alarms.
const THIRD_COLUMNS: u16 = 50;

/// Height of the log above the link's figures, and its minimum on a low screen.
const LOG_ROWS: u16 = 5;
const LOG_ROWS_MIN: u16 = 3;

impl Screen<'_> {
    pub(super) fn panels(&self, buffer: &mut Buffer, area: Rect, is_full: bool) {
        // A route being edited stays visible.
        let enlarged = self.ui.enlarged;
        match enlarged.filter(|_| self.ui.editor.is_none()) {
            Some(Large::Panel) => self.draw_panel(buffer, area, self.ui.panel),
            Some(Large::Map) => self.map(buffer, area),
            Some(Large::Ladder) => self.ladder(buffer, area),
            None if self.facts.link.has_only_own_lines() => self.own_panels(buffer, area),
            None if is_full => self.all_panels(buffer, area),
            None => self.some_panels(buffer, area),
        }
    }

    fn all_panels(&self, buffer: &mut Buffer, area: Rect) {
        let is_wide = area.width >= WIDTH_ALL && area.height >= HEIGHT_ALL;
        let (area, third) = if is_wide {
            split_right(area, THIRD_COLUMNS)
        } else {
            (area, Rect::default())
        };
        let band_rows = (area.height.saturating_sub(ladder::ROWS + sensors::ROWS)).clamp(7, 18);
        let (upper, lower) = split_bottom(area, band_rows);
        let right_columns = (area.width * 2 / 5).clamp(46, 72);
        let (map, right) = split_right(upper, right_columns);
        // If the right side is high enough, the link is there, with plots.
        let is_link_above = is_wide
            && self.ui.editor.is_none()
            && right.height >= ladder::ROWS + sensors::ROWS + link::ROWS_PLOTS;
        let (commands, log) = if is_link_above {
            // The map takes the rows that commands do not need.
            let left = Rect {
                width: map.width,
                ..area
            };
            let rows = self.commands_height(left.width).min(band_rows);
            let (map, commands) = split_bottom(left, rows);
            self.map(buffer, map);
            let log = Rect {
                x: right.x,
                width: right.width,
                ..lower
            };
            (commands, log)
        } else {
            self.map(buffer, map);
            split_right(lower, area.width / 2)
        };
        if let Some(editor) = &self.ui.editor {
            self.route(buffer, right, editor);
        } else {
            let (ladder, mut sensors) = split_top(right, ladder::ROWS);
            self.ladder(buffer, ladder);
            if is_link_above {
                let link;
                (sensors, link) = split_top(sensors, sensors::ROWS);
                self.draw_panel(buffer, link, Panel::Link);
            }
            match self.ui.panel {
                panel @ (Panel::Above | Panel::Plots | Panel::Alarms) if !is_wide => {
                    self.draw_panel(buffer, sensors, panel);
                }
                Panel::Fields => self.draw_panel(buffer, sensors, Panel::Fields),
                _ => self.draw_panel(buffer, sensors, Panel::Sensors),
            }
        }
        self.draw_panel(buffer, commands, Panel::Commands);
        let link_rows = self.link_height(log.width);
        let link_rows_min = link_rows.min(link::ROWS_MIN);
        if is_link_above {
            self.draw_panel(buffer, log, Panel::Log);
        } else if log.height >= link_rows_min + LOG_ROWS_MIN {
            let beside_log = log.height.saturating_sub(LOG_ROWS).max(link_rows_min);
            let (log, link) = split_bottom(log, link_rows.min(beside_log));
            self.draw_panel(buffer, log, Panel::Log);
            self.draw_panel(buffer, link, Panel::Link);
        } else if self.ui.panel == Panel::Link {
            self.draw_panel(buffer, log, Panel::Link);
        } else {
            self.draw_panel(buffer, log, Panel::Log);
        }
        if is_wide {
            let (above, third) = split_top(third, above::ROWS);
            self.draw_panel(buffer, above, Panel::Above);
            // One row each while none is raised, and a title.
            let alarm_rows = 1 + self.facts.alarms.rules().len() as u16;
            let (plots, alarms) = split_bottom(third, alarm_rows.min(third.height / 2));
            self.draw_panel(buffer, plots, Panel::Plots);
            self.draw_panel(buffer, alarms, Panel::Alarms);
        }
    }

    /// Draws the panels of a robot with lines of its own: no ladder and sensors, and a map only if the robot reports its position.
    fn own_panels(&self, buffer: &mut Buffer, area: Rect) {
        let rest = if self.facts.chart.pose().is_some() {
            let (map, rest) = split_right(area, (area.width / 2).clamp(40, 90));
            self.map(buffer, map);
            rest
        } else {
            area
        };
        let lower_rows = match rest.height {
            ..20 => 0,
            20..30 => 7,
            _ => 11,
        };
        let (upper, lower) = split_bottom(rest, lower_rows);
        let beside: &[Panel] = match rest.width {
            ..100 => &[Panel::Log],
            100..160 => &[Panel::Commands, Panel::Log],
            _ => &[Panel::Commands, Panel::Log, Panel::Link, Panel::Alarms],
        };
        // A robot without command strings is sent STOP alone.
        let has_commands = !self.ui.config.own_commands.is_empty()
            || self.facts.ledger.entries().next().is_some()
            || self.ui.panel == Panel::Commands;
        let beside = match beside {
            [Panel::Commands, rest @ ..] if !has_commands => rest,
            beside => beside,
        };
        let is_below = lower_rows > 0 && beside.contains(&self.ui.panel);
        let first = if is_below {
            Panel::Fields
        } else {
            self.ui.panel
        };
        self.draw_panel(buffer, upper, first);
        let mut right = lower;
        for (n, panel) in beside.iter().enumerate() {
            let here;
            let others = (beside.len() - n - 1) as u16;
            (here, right) = split_right(right, right.width / (others + 1) * others);
            if lower_rows > 0 {
                self.draw_panel(buffer, here, *panel);
            }
        }
    }

    fn some_panels(&self, buffer: &mut Buffer, area: Rect) {
        let right_columns = (area.width * 2 / 5).clamp(40, 60);
        let (map, right) = split_right(area, right_columns);
        self.map(buffer, map);
        if let Some(editor) = &self.ui.editor {
            self.route(buffer, right, editor);
            return;
        }
        let (ladder, mut rest) = split_top(right, ladder::ROWS);
        self.ladder(buffer, ladder);
        let first = Panel::ALL
            .iter()
            .position(|panel| *panel == self.ui.panel)
            .unwrap_or(0);
        let order = Panel::ALL.iter().cycle().skip(first).take(Panel::ALL.len());
        let order: Vec<_> = order.filter(|panel| self.facts.offers(**panel)).collect();
        for (place, panel) in order.iter().enumerate() {
            if place > 0 && rest.height < 5 {
                break;
            }
            let last = place + 1 == order.len();
            let rows = if last || rest.height < sensors::ROWS + 5 {
                rest.height
            } else {
                sensors::ROWS
            };
            let (here, below) = split_top(rest, rows);
            self.draw_panel(buffer, here, **panel);
            rest = below;
        }
    }

    fn draw_panel(&self, buffer: &mut Buffer, area: Rect, panel: Panel) {
        self.claim(area, Mark::Panel(panel));
        match panel {
            Panel::Sensors => self.sensors(buffer, area),
            Panel::Commands => self.commands(buffer, area),
            Panel::Log => self.log(buffer, area),
            Panel::Link => self.link(buffer, area),
            Panel::Above => self.above(buffer, area),
            Panel::Plots => self.plots(buffer, area),
            Panel::Alarms => self.alarms(buffer, area),
            Panel::Fields => self.fields(buffer, area),
        }
    }
}
