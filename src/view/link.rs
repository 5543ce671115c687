//! The link in figures, and the robot's behaviour without it.

use groundwave_protocol::status_codes::Link;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::plots::OF_LINK;
use super::text::First;
use super::{Screen, split_top};
use crate::model::link::SILENT_AFTER;
use crate::model::{Panel, failsafe};
use crate::statistics::{Confirmation, Resync, Statistics};

/// Minimum height of the panel beside others, rows.
pub(super) const ROWS_MIN: u16 = 5;

/// Minimum height with plots under the figures, rows.
pub(super) const ROWS_PLOTS: u16 = 11;

const TITLE: &str = "link: totals; airtime over 20 s";

/// Minimum width for two figures in a row.
const TWO_COLUMNS: u16 = 58;

const NAME_COLUMNS: usize = 7;

impl Screen<'_> {
    pub(super) fn link(&self, buffer: &mut Buffer, area: Rect) {
        let line = |(name, says, style): (&str, String, Style)| {
            let line = Line::from(vec![
                Span::styled(format!("{name:<NAME_COLUMNS$}"), self.theme.dim),
                Span::styled(says, style),
            ]);
            self.cut(line, usize::from(area.width))
        };
        let age = self.facts.link.newest_age(self.now);
        let note = self.staleness(age, SILENT_AFTER);
        let note = note.map(|note| Span::styled(note, self.theme.warning));
        let lines: Vec<_> = self.link_rows(area.width).into_iter().map(line).collect();
        let (rows, below) = split_top(area, 1 + lines.len() as u16);
        self.pages(buffer, rows, (Panel::Link, TITLE), note, &lines, First::Top);
        if !self.facts.link.has_only_own_lines() {
            self.plots_below(buffer, below, &OF_LINK);
        }
    }

    /// Height that the panel would fill, with its title.
    pub(super) fn link_height(&self, width: u16) -> u16 {
        1 + self.link_rows(width).len() as u16
    }

    fn link_rows(&self, width: u16) -> Vec<(&'static str, String, Style)> {
        let theme = &self.theme;
        let link = &self.facts.link;
        let alone = failsafe::standing(&self.facts.robot, &self.facts.ledger)
            .map(|(letter, says)| ("alone", says, self.failsafe_style(letter)));
        if link.has_only_own_lines() {
            let fields = &self.facts.fields;
            let down = format!(
                "{:.1} lines a second, {} damaged, {} lost by sequence",
                link.lines_per_s(self.now),
                fields.damaged,
                fields.lost
            );
            return vec![("down", down, theme.plain)];
        }
        let Some(statistics) = link.statistics() else {
            let nothing = ("", "nothing measured yet".to_owned(), theme.dim);
            return [nothing].into_iter().chain(alone).collect();
        };
        let air = |pct: f64| format!("{pct:.0} % air, ");
        let mut down = format!(
            "{}loss {}",
            air(statistics.airtime_down_pct),
            statistics.loss.share()
        );
        let [crc, shape, field] = statistics.damaged.kinds();
        let errors = format!("{crc} CRC, {shape} shape, {field} field");
        let mut rows = Vec::new();
        if width >= TWO_COLUMNS {
            down = format!("{down}; {errors}");
            rows.push(("down", down, theme.plain));
        } else {
            rows.push(("down", down, theme.plain));
            rows.push(("errors", errors, theme.plain));
        }
        let types = statistics.damaged.types_words();
        if !types.is_empty() {
            rows.push(("damaged", format!(" {types}"), theme.plain));
        }
        if let Some(id) = statistics.other.other_robot {
            let lines = statistics.other.other_lines;
            let other = format!("robot {id}: {lines} lines, kept apart");
            rows.push(("others", other, theme.warning));
        }
        let acks_per_s = link.acks_per_s(self.now);
        if acks_per_s > 0.0 {
            let packets_per_s = link.lines_per_s(self.now);
            let rates = format!("{packets_per_s:.1} lines + {acks_per_s:.1} short (K) a second");
            rows.push(("rate", rates, theme.plain));
        }
        let resync = match statistics.resync {
            Some(Resync {
                last_bytes,
                mean_bytes,
                worst_bytes,
                ..
            }) => format!("{last_bytes} B last, {mean_bytes:.0} mean, {worst_bytes} worst"),
            None => "none needed".to_owned(),
        };
        rows.push(("resync", resync, theme.plain));
        if !link.is_receive_only() {
            rows.push(self.up_row(statistics, &air(statistics.airtime_up_pct)));
            let answer = match statistics.confirmation {
                Some(Confirmation {
                    last_s,
                    mean_s,
                    worst_s,
                    ..
                }) => format!("{last_s:.1} s last, {mean_s:.1} mean, {worst_s:.1} worst"),
                None => "none yet".to_owned(),
            };
            rows.push(("answer", answer, theme.plain));
        }
        rows.extend(alone);
        rows
    }

    fn up_row(&self, statistics: &Statistics, air: &str) -> (&'static str, String, Style) {
        let frames = format!(
            "{air}{} frames, {} repeated",
            statistics.frames, statistics.frames_again
        );
        match statistics.not_taken_bytes {
            0 => ("up", frames, self.theme.plain),
            bytes => (
                "up",
                format!("{bytes} B NOT TAKEN, {frames}"),
                self.theme.warning,
            ),
        }
    }

    const fn failsafe_style(&self, letter: Link) -> Style {
        match letter {
            Link::Failsafe => self.theme.alarm,
            Link::Armed | Link::Ok => self.theme.plain,
        }
    }
}
