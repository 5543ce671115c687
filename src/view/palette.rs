//! The command palette: the typed text and its matches.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put, put_right, width_of};
use crate::model::palette::Palette;

const COLUMNS: u16 = 72;
const ROWS: u16 = 16;

impl Screen<'_> {
    pub(super) fn palette(&self, buffer: &mut Buffer, area: Rect, palette: &Palette) {
        let theme = &self.theme;
        let inner = self.window(buffer, area, (COLUMNS, ROWS), " commands ");
        let prompt = Line::from(vec![
            Span::styled("find: ", theme.key),
            Span::styled(palette.text.as_str(), theme.strong),
            Span::styled(theme.glyphs.text_cursor, theme.key),
        ]);
        put(buffer, inner, 0, &prompt);
        let found = palette.found(self.ui, self.facts);
        if found.is_empty() {
            let nothing = Line::styled("no match", theme.dim);
            put(buffer, inner, 1, &nothing);
            return;
        }
        let rows = usize::from(inner.height.saturating_sub(1)).max(1);
        let chosen = palette.chosen(&found);
        if chosen.is_none() {
            let words = self.with_keys("No match. Closest (<palette/choose-less..> choose):");
            put_right(buffer, inner, 0, &Line::styled(words, theme.dim));
        }
        let first = chosen.unwrap_or_default().saturating_sub(rows - 1);
        for (row, (place, entry)) in (1..).zip(found.iter().enumerate().skip(first).take(rows)) {
            let (mark, style) = if Some(place) == chosen {
                (theme.glyphs.holds, theme.holder)
            } else {
                (" ", theme.plain)
            };
            let line = Line::styled(format!("{mark} {}", entry.title), style);
            let key = Line::styled(format!(" {}", entry.key), theme.key);
            let room = usize::from(inner.width).saturating_sub(width_of(&key.spans));
            put(buffer, inner, row, &self.cut(line, room));
            put_right(buffer, inner, row, &key);
        }
    }
}
