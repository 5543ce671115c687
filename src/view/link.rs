//! The link in figures, and the robot's behaviour without it.

use groundwave_captures::words::counted;
use groundwave_protocol::status_codes::Link;
use groundwave_protocol::telemetry::AbilitiesLine;
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
const WIDE: u16 = 58;

const NAME_COLUMNS: usize = 10;

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
            .map(|(letter, says)| ("failsafe", says, self.failsafe_style(letter)));
        if link.has_only_own_lines() {
            let fields = &self.facts.fields;
            let down = format!(
                "{:.1} lines a second, {} damaged, {} lost by sequence",
                link.lines_per_s(self.now),
                fields.damaged,
                fields.lost
            );
            return vec![("received", down, theme.plain)];
        }
        let Some(statistics) = link.statistics() else {
            let nothing = ("", "nothing measured yet".to_owned(), theme.dim);
            return [nothing].into_iter().chain(alone).collect();
        };
        let (down, up) = (statistics.airtime_down_pct, statistics.airtime_up_pct);
        let [crc, shape, field] = statistics.damaged.kinds();
        let is_whole = crc + shape + field == 0;
        let mut received = format!("loss {}", statistics.loss.share());
        if is_whole {
            received += ", none damaged";
        }
        let mut rows = vec![("received", received, theme.plain)];
        if !is_whole {
            let kinds = format!("{crc} checksum, {shape} shape, {field} value");
            rows.push(("damaged", kinds, theme.plain));
        }
        let types = statistics.damaged.types_words();
        if !types.is_empty() {
            rows.push(("of types", types, theme.plain));
        }
        if let Some(names) = statistics.other.names() {
            let lines = statistics.other.other_lines;
            let other = format!("{names}: {}, kept apart", counted(lines, "line"));
            rows.push(("others", other, theme.warning));
        }
        if let Some(robot) = self.facts.robot.abilities {
            rows.push(("level", level_words(&robot), theme.plain));
        } else if self.facts.robot.is_deaf {
            let says = "1: shows itself, cannot hear".to_owned();
            rows.push(("level", says, theme.plain));
        }
        let acks_per_s = link.acks_per_s(self.now);
        if acks_per_s > 0.0 {
            let lines_per_s = link.lines_per_s(self.now);
            let rates = format!("{lines_per_s:.1} lines + {acks_per_s:.1} short (K) a second");
            rows.push(("rate", rates, theme.plain));
        }
        if let Some(Resync {
            last_bytes,
            mean_bytes,
            worst_bytes,
            ..
        }) = statistics.resync
        {
            let says = format!("in {last_bytes} B, mean {mean_bytes:.0}, worst {worst_bytes}");
            rows.push(("regained", says, theme.plain));
        }
        if !link.is_receive_only() {
            rows.push(self.sent_row(statistics));
            if let Some(Confirmation {
                last_s,
                mean_s,
                worst_s,
                ..
            }) = statistics.confirmation
            {
                let says = format!("in {last_s:.1} s, mean {mean_s:.1}, worst {worst_s:.1}");
                rows.push(("confirmed", says, theme.plain));
            }
        }
        let share = |pct: Option<f64>| {
            pct.map_or_else(|| "unknown".to_owned(), |pct| format!("{pct:.0} %"))
        };
        let airtime = if down.is_none() || link.is_receive_only() {
            share(down)
        } else {
            format!("{} down, {} up", share(down), share(up))
        };
        if width < WIDE {
            rows.push(("airtime", airtime, theme.plain));
        } else {
            for (name, says, _) in &mut rows {
                match *name {
                    "received" => *says = format!("{says}; airtime {}", share(down)),
                    "sent" => *says = format!("{says}; airtime {}", share(up)),
                    _ => {}
                }
            }
        }
        rows.extend(alone);
        rows
    }

    fn sent_row(&self, statistics: &Statistics) -> (&'static str, String, Style) {
        let frames = format!(
            "{}, {} repeated",
            counted(statistics.frames, "frame"),
            statistics.frames_again
        );
        match statistics.not_taken_bytes {
            0 => ("sent", frames, self.theme.plain),
            bytes => (
                "sent",
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

/// The abilities of a robot, from its line I.
fn level_words(robot: &AbilitiesLine) -> String {
    let capacity = robot.capacity;
    match robot.level {
        1 => "1 of 5: cannot hear".to_owned(),
        2 => "2 of 5: commands, no routes".to_owned(),
        3 => format!("3 of 5: routes of up to {capacity}, no hand drive"),
        4 => format!("4 of 5: routes of up to {capacity}, no parameters"),
        _ => format!("5 of 5: routes of up to {capacity}"),
    }
}
