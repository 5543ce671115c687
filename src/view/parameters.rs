//! The screen of the robot's parameters.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put, split_bottom};
use crate::model::words::{parameter_number, parameter_unit};
use crate::request::{known_default, known_parameters};

/// Preferred width of the window, columns.
const WIDTH: u16 = 100;

/// Height of the frame, the heading and the meaning of the chosen parameter, rows.
const ROWS_BESIDE: u16 = 5;

impl Screen<'_> {
    pub(super) fn parameters(&self, buffer: &mut Buffer, area: Rect, chosen: usize) {
        let theme = &self.theme;
        // The hint and the keys stay visible.
        let (above, _) = split_bottom(area, 2);
        let heard = self.facts.parameters.heard();
        let compared = self.ui.compared.as_ref();
        let differences = compared.and_then(|file| file.differences(heard).ok());
        let differences = differences.unwrap_or_default();
        let title = match (heard.first(), compared) {
            (Some(first), _) if self.facts.parameters.is_partial() => {
                format!(" parameters: {} of {} heard ", heard.len(), first.count)
            }
            (Some(_), Some(file)) if differences.is_empty() => {
                format!(" parameters: as in {} ", file.name())
            }
            (Some(_), Some(file)) => {
                let count = differences.len();
                format!(" parameters: {count} not as in {} ", file.name())
            }
            (Some(_), None) => " parameters ".to_owned(),
            (None, _) => " parameters: none heard yet ".to_owned(),
        };
        let height = (heard.len() as u16).saturating_add(ROWS_BESIDE);
        let inner = self.window(buffer, above, (WIDTH, height), &title);
        let width = usize::from(inner.width);
        let (list, below) = split_bottom(inner, 2);
        let heading = row("  ", ["name", "value", "", "range", "default"], "");
        put(buffer, list, 0, &Line::styled(heading, theme.dim));
        let rows = usize::from(list.height.saturating_sub(1)).max(1);
        let skipped = chosen.saturating_sub(rows - 1);
        for (at, (place, line)) in (1..).zip(heard.iter().enumerate().skip(skipped).take(rows)) {
            let number = |value| parameter_number(value, line.unit.as_str());
            let default = known_default(line.name.as_str()).map(i32::from);
            let is_saved = line.value == line.kept;
            let differs = differences.iter().find(|d| d.robot.name == line.name);
            let note = match differs {
                Some(differs) => format!("file: {}", number(differs.wanted)),
                None if is_saved => String::new(),
                None => format!("saved: {}", number(line.kept)),
            };
            let (mark, style) = match place {
                _ if place == chosen => (theme.glyphs.holds, theme.holder),
                _ if !is_saved || differs.is_some() => (" ", theme.strong),
                _ => (" ", theme.plain),
            };
            let columns = [
                line.name.as_str(),
                &number(line.value),
                parameter_unit(line),
                &format!("{} to {}", number(line.least), number(line.most)),
                &default.map(number).unwrap_or_default(),
            ];
            let line = Line::styled(row(&format!("{mark} "), columns, &note), style);
            put(buffer, list, at, &self.cut(line, width));
        }
        let name = heard.get(chosen).map(|line| line.name.as_str());
        let about = name.and_then(|name| known_parameters().find(|(known, _)| *known == name));
        let about = about.map(|(_, about)| about).unwrap_or_default();
        let files = self.with_keys("files: <parameters/compare-parameters> compare, <parameters/load-parameters> load, <parameters/write-parameters> write");
        let more = heard.len().saturating_sub(rows);
        let files = match more {
            0 => files,
            more => format!("{more} more with the arrows; {files}"),
        };
        put(buffer, below, 0, &Line::styled(files, theme.dim));
        put(
            buffer,
            below,
            1,
            &self.cut(Line::from(Span::styled(about, theme.plain)), width),
        );
    }
}

fn row(mark: &str, [name, value, unit, range, default]: [&str; 5], note: &str) -> String {
    format!("{mark}{name:<18}{value:>7} {unit:<6}{range:<18}{default:>7}  {note}")
}
