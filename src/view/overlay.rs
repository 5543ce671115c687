//! Windows over the panels: a question, the list of keys, a long error.

use ratatui::buffer::{Buffer, CellWidth};
use ratatui::layout::{Margin, Rect};
use ratatui::symbols::border;
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, Clear, Paragraph, Widget, Wrap};

use super::text::wrap;
use super::{Screen, put, split_bottom};
use crate::model::keys::{Action, Context};
use crate::model::{Overlay, Question, TextEntry};
use crate::request::dashboard_listing;

const QUESTION_COLUMNS: u16 = 56;
const QUESTION_ROWS: u16 = 7;

/// Width of a key's label in the help, columns.
const LABEL_COLUMNS: usize = 8;

const HELP_COLUMNS: u16 = 80;

/// Width of a command in the help, columns.
const COMMAND_COLUMNS: usize = 18;

/// A further context in the help: heading, context, the action that begins it, and a filter of the actions to show.
type Elsewhere = (&'static str, Context, Action, fn(Action) -> bool);

/// Further contexts in the help, one row each.
const ELSEWHERE: [Elsewhere; 3] = [
    ("modes", Context::Modes, Action::AskMode, |action| {
        matches!(action, Action::Mode(_))
    }),
    ("driving", Context::Drive, Action::EnterDrive, |_| true),
    ("typing", Context::Text, Action::AskCommand, |_| true),
];

const ASCII_BORDER: border::Set<'_> = border::Set {
    top_left: "+",
    top_right: "+",
    bottom_left: "+",
    bottom_right: "+",
    vertical_left: "|",
    vertical_right: "|",
    horizontal_top: "-",
    horizontal_bottom: "-",
};

impl Screen<'_> {
    pub(super) fn overlay(&self, buffer: &mut Buffer, area: Rect) {
        if let Some(chosen) = self.ui.parameters {
            self.parameters(buffer, area, chosen);
        }
        match &self.ui.overlay {
            Overlay::Question(question) => self.question(buffer, area, question),
            Overlay::Help => self.help(buffer, area),
            Overlay::Palette(palette) => self.palette(buffer, area, palette),
            Overlay::Why => self.why_window(buffer, area),
            Overlay::Runs(runs) => self.runs_window(buffer, area, runs),
            Overlay::Text(entry) => self.long_error(buffer, area, entry),
            Overlay::None
            | Overlay::Drive(_)
            | Overlay::Modes
            | Overlay::Jump { .. }
            | Overlay::Search(_)
            | Overlay::Trace(_) => {}
        }
    }

    /// Whether a window may cover the map.
    pub(super) const fn is_covered(&self) -> bool {
        self.ui.parameters.is_some()
            || matches!(
                self.ui.overlay,
                Overlay::Question(_)
                    | Overlay::Help
                    | Overlay::Palette(_)
                    | Overlay::Why
                    | Overlay::Runs(_)
            )
    }

    /// Draws the error of the typed text over the rows above if it is longer than one row.
    fn long_error(&self, buffer: &mut Buffer, area: Rect, entry: &TextEntry) {
        let width = usize::from(area.width);
        let error = entry.error.as_deref().unwrap_or_default();
        let rows = wrap(error, width, width);
        if rows.len() < 2 {
            return;
        }
        let (above, _) = split_bottom(area, 1);
        let (_, here) = split_bottom(above, rows.len() as u16);
        Clear.render(here, buffer);
        for (row, text) in (0..here.height).zip(rows) {
            put(buffer, here, row, &Line::styled(text, self.theme.warning));
        }
    }

    fn question(&self, buffer: &mut Buffer, area: Rect, question: &Question) {
        let inner = self.window(buffer, area, (QUESTION_COLUMNS, QUESTION_ROWS), " confirm ");
        Paragraph::new(question.text.as_str())
            .wrap(Wrap { trim: true })
            .render(inner, buffer);
        let key = |action| {
            let label = self.ui.config.keys.label(Context::Question, action);
            Span::styled(label, self.theme.key)
        };
        let answers = Line::from(vec![
            key(Action::Confirm),
            Span::raw(" yes   "),
            key(Action::Close),
            Span::raw(" no   "),
            key(Action::Stop),
            Span::raw(" STOP"),
        ]);
        put(buffer, inner, inner.height.saturating_sub(1), &answers);
    }

    fn help(&self, buffer: &mut Buffer, area: Rect) {
        let of = if self.ui.editor.is_some() {
            Context::Route
        } else {
            Context::Dashboard
        };
        let keymap = &self.ui.config.keys;
        let blocks = self.help_blocks(of);
        let elsewhere: Vec<_> = ELSEWHERE
            .iter()
            .filter(|(_, _, begins, _)| self.ui.offers(self.facts, *begins))
            .collect();
        let others = elsewhere.len() as u16;
        let inside = area.height.saturating_sub(2);
        let first = usize::from(inside.saturating_sub(others).max(1));
        let later = usize::from(inside.max(1));
        // As low as two columns allow, otherwise on several pages.
        let whole = (1..first).map(|rows| flow(&blocks, rows, rows));
        let whole = whole.into_iter().find(|columns| columns.len() <= 2);
        let columns = whole.unwrap_or_else(|| flow(&blocks, first, later));
        let pages_of_keys = columns.len().div_ceil(2).max(1);
        let pages = pages_of_keys + 1;
        let page = self.ui.help_page.rem_euclid(pages as i32) as usize;
        let shown: Vec<_> = columns.into_iter().skip(2 * page).take(2).collect();
        let rows = shown.iter().map(Vec::len).max().unwrap_or_default() as u16;
        let height = if page == pages_of_keys {
            dashboard_listing().count() as u16
        } else if page == 0 {
            rows + others
        } else {
            rows
        };
        let (what, next) = match page {
            _ if page + 1 == pages => ("commands, typed after <ask-command>", "keys"),
            _ if page + 2 == pages => ("keys", "commands"),
            _ => ("keys", "more"),
        };
        let (more, back) = ("<help-screen/turn-page-more>", "<help-screen/close>");
        let title = keymap.with_keys(&format!(
            " {what} ({}/{pages}); {more}: {next}; {back}: back ",
            page + 1
        ));
        let inner = self.window(buffer, area, (HELP_COLUMNS, height + 2), &title);
        if page == pages_of_keys {
            self.commands_help(buffer, inner);
            return;
        }
        let width = inner.width / 2;
        for (column, lines) in (0..).zip(shown) {
            let half = Rect {
                x: inner.x + column * width,
                width: width.saturating_sub(1),
                ..inner
            };
            for (row, line) in (0..).zip(lines) {
                put(buffer, half, row, &self.cut(line, usize::from(half.width)));
            }
        }
        let elsewhere = elsewhere.into_iter().filter(|_| page == 0);
        for (row, (when, context, _, shows)) in (rows..).zip(elsewhere) {
            let mut spans = vec![Span::styled(
                format!("{when:<LABEL_COLUMNS$}"),
                self.theme.dim,
            )];
            spans.extend(self.named_keys(*context, *shows));
            put(buffer, inner, row, &Line::from(spans));
        }
    }

    /// The keys of a context; for the dashboard, one block for each heading.
    fn help_blocks(&self, of: Context) -> Vec<Vec<Line<'_>>> {
        let mut blocks = vec![Vec::new()];
        let mut heading = None;
        for row in self.ui.config.keys.rows() {
            let is_offered = self.ui.offers(self.facts, row.action);
            if row.context != of || row.help.is_empty() || !is_offered {
                continue;
            }
            let group = row.action.group();
            if of == Context::Dashboard && heading.replace(group) != Some(group) {
                blocks.push(vec![Line::styled(group.name(), self.theme.title)]);
            }
            let label = format!("{} ", row.label);
            let line = Line::from(vec![
                Span::styled(format!("{label:<LABEL_COLUMNS$}"), self.theme.key),
                Span::raw(self.with_keys(&row.help)),
            ]);
            if let Some(block) = blocks.last_mut() {
                block.push(line);
            }
        }
        blocks.retain(|block| !block.is_empty());
        blocks
    }

    fn commands_help(&self, buffer: &mut Buffer, area: Rect) {
        for (row, (words, does)) in (0..).zip(dashboard_listing()) {
            let line = Line::from(vec![
                Span::styled(format!("{words:<COMMAND_COLUMNS$}"), self.theme.key),
                Span::raw(self.with_keys(does)),
            ]);
            put(buffer, area, row, &self.cut(line, usize::from(area.width)));
        }
    }

    /// Draws an empty framed window in the middle; returns its inside.
    pub(super) fn window(
        &self,
        buffer: &mut Buffer,
        area: Rect,
        size: (u16, u16),
        title: &str,
    ) -> Rect {
        let (width, height) = (size.0.min(area.width), size.1.min(area.height));
        let window = Rect {
            x: area.x + (area.width - width) / 2,
            y: area.y + (area.height - height) / 2,
            width,
            height,
        };
        Clear.render(window, buffer);
        for y in window.top()..window.bottom() {
            let left = window.x.checked_sub(1).map(|x| (x, y));
            // A terminal cannot draw half of a wide character.
            if let Some(cell) = left.and_then(|place| buffer.cell_mut(place))
                && cell.symbol().cell_width() > 1
            {
                cell.set_symbol(" ");
            }
        }
        let borders = if self.theme.glyphs.ascii {
            ASCII_BORDER
        } else {
            border::ROUNDED
        };
        Block::bordered()
            .border_set(borders)
            .border_style(self.theme.rule)
            .title(Span::styled(title, self.theme.title))
            .render(window, buffer);
        window.inner(Margin::new(2, 1))
    }
}

/// Arranges blocks in columns, two per page, with an empty line between blocks. Columns of the first page have `first` rows, others
/// `later`. Only a block higher than a column is divided.
fn flow<'l>(blocks: &[Vec<Line<'l>>], first: usize, later: usize) -> Vec<Vec<Line<'l>>> {
    let mut columns: Vec<Vec<Line<'l>>> = vec![Vec::new()];
    for block in blocks {
        let room = |columns: &[Vec<Line<'l>>]| if columns.len() <= 2 { first } else { later };
        let taken = columns.last().map_or(0, Vec::len);
        if taken > 0 && taken + 1 + block.len() > room(&columns) {
            columns.push(Vec::new());
        } else if let Some(column) = columns.last_mut().filter(|column| !column.is_empty()) {
            column.push(Line::default());
        }
        for line in block {
            let room = room(&columns);
            if columns.last().is_some_and(|column| column.len() >= room) {
                columns.push(Vec::new());
            }
            if let Some(column) = columns.last_mut() {
                column.push(line.clone());
            }
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::event::Moment;
    use crate::model::{Config, Model, Shown};

    #[test]
    fn every_command_fits_a_row_of_80_columns() {
        let model = Model::new(Config::default());
        for (words, does) in dashboard_listing() {
            let does = model.ui.with_keys(does);
            assert!(words.len() < COMMAND_COLUMNS && does.len() <= 58, "{words}");
        }
    }

    #[test]
    fn a_window_over_wide_characters_has_its_border() {
        let model = Model::new(Config::default());
        let mut page = Buffer::empty(Rect::new(0, 0, 80, 24));
        for y in 0..24 {
            page.set_string(0, y, "漢".repeat(40), ratatui::style::Style::new());
        }
        let area = page.area;
        let inner =
            Screen::of(Shown::from(&model), Moment::ZERO).window(&mut page, area, (21, 5), "");
        let border = inner.x - 2;
        assert_eq!(page[(border, inner.y)].symbol(), "│");
        assert_eq!(page[(border - 1, inner.y)].symbol(), " ");
        assert_eq!(page[(border - 1, 0)].symbol(), "漢");
    }
}
