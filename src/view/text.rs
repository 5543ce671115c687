//! Text in rows: cut, wrapped and divided into pages.

use std::ops::Range;

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, columns, put, width_of};
use crate::model::Panel;

/// Which end of a panel's rows is shown first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum First {
    Top,
    Bottom,
}

/// The longest start of a text that fits into `room` columns.
pub(super) fn start_of(text: &str, room: usize) -> &str {
    let ends = text.char_indices().map(|(at, c)| at + c.len_utf8());
    let fits = ends.map(|end| &text[..end]);
    fits.take_while(|start| columns(start) <= room)
        .last()
        .unwrap_or_default()
}

/// Wraps a text at its words into rows of `first` and then `others` columns.
pub(crate) fn wrap(text: &str, first: usize, others: usize) -> Vec<String> {
    rows(text, first, others).map(str::to_owned).collect()
}

/// The ranges of a text that [`wrap`] returns as rows; at least one.
pub(super) fn rows(text: &str, first: usize, others: usize) -> impl Iterator<Item = &str> {
    let mut left = Some(text);
    let mut room = first.max(1);
    std::iter::from_fn(move || {
        let (row, rest) = first_row(left?.trim_start_matches(' '), room);
        left = (!rest.is_empty()).then_some(rest);
        room = others.max(1);
        Some(row)
    })
}

/// The end of the first row of a text, and the start of the next.
fn first_row(text: &str, room: usize) -> (&str, &str) {
    let (mut end, mut taken) = (0, 0);
    loop {
        let rest = text[end..].trim_start_matches(' ');
        let begin = text.len() - rest.len();
        let ends = rest.bytes().position(|byte| byte == b' ');
        let word = &rest[..ends.unwrap_or(rest.len())];
        let wide = begin - end + columns(word);
        if word.is_empty() || end > 0 && taken + wide > room {
            return (&text[..end], rest);
        }
        if wide > room {
            // A character wider than the row gets a separate row.
            let first = word.chars().next().map_or(0, char::len_utf8);
            let fits = start_of(word, room).len().max(first);
            return (&text[..fits], text[fits..].trim_start_matches(' '));
        }
        end = begin + word.len();
        taken += wide;
    }
}

impl Screen<'_> {
    /// Draws a panel of rows; if they do not fit, draws the chosen page with its number.
    pub(super) fn pages(
        &self,
        buffer: &mut Buffer,
        area: Rect,
        title: (Panel, &str),
        note: Option<Span<'_>>,
        lines: &[Line<'_>],
        first: First,
    ) {
        let (below, shown) = self.page(buffer, area, title, note, (lines.len(), None), first);
        for (row, line) in (0..).zip(&lines[shown]) {
            put(buffer, below, row, line);
        }
    }

    /// Draws the frame of a panel with a number of rows; returns the area for rows and the range of rows to show, around
    /// a position if one is given.
    pub(super) fn page(
        &self,
        buffer: &mut Buffer,
        area: Rect,
        (panel, title): (Panel, &str),
        note: Option<Span<'_>>,
        (rows, around): (usize, Option<usize>),
        first: First,
    ) -> (Rect, Range<usize>) {
        let height = usize::from(area.height.saturating_sub(1)).max(1);
        let pages = rows.div_ceil(height).max(1);
        let (page, key) = match first {
            First::Top => (self.page_of(panel, pages), "<turn-page-more>"),
            // Older rows are above.
            First::Bottom => (
                (pages - self.page_of(panel, pages)) % pages,
                "<turn-page-less>",
            ),
        };
        let page = around.map_or(page, |row| match first {
            First::Top => row / height,
            First::Bottom => rows.saturating_sub(1 + row) / height,
        });
        let note = note.filter(|note| !note.content.is_empty());
        let note = if pages > 1 {
            let turn = self.with_keys(&format!("{key} {}/{pages}", page + 1));
            let words =
                note.map_or_else(|| turn.clone(), |note| format!("{}  {turn}", note.content));
            // The key that turns the page comes before other notes.
            let short = title.split(':').next().unwrap_or_default();
            let taken = self.titled(panel, short).chars().count() + 8;
            let fits = taken + words.chars().count() <= usize::from(area.width);
            let words = if fits { words } else { turn };
            Some(Span::styled(words, self.theme.dim))
        } else {
            note
        };
        let below = self.panel(buffer, area, &self.titled(panel, title), note);
        let shown = match first {
            First::Top => page * height..rows.min((page + 1) * height),
            First::Bottom => {
                rows.saturating_sub((page + 1) * height)..rows.saturating_sub(page * height)
            }
        };
        (below, shown)
    }

    /// The displayed page of a panel: the first one, unless the operator turned the page.
    pub(super) fn page_of(&self, panel: Panel, pages: usize) -> usize {
        let chosen = if self.ui.panel == panel {
            self.ui.page
        } else {
            0
        };
        chosen.rem_euclid(pages.max(1) as i32) as usize
    }

    /// Cuts a line to a width, with a mark at its end.
    pub(super) fn cut<'l>(&self, line: Line<'l>, width: usize) -> Line<'l> {
        let blanks = line
            .spans
            .iter()
            .rev()
            .flat_map(|span| span.content.chars().rev());
        let blanks = blanks.take_while(|c| *c == ' ').count();
        if width_of(&line.spans) - blanks <= width {
            return line;
        }
        let more = self.theme.glyphs.cut;
        let mut room = width.saturating_sub(columns(more));
        let mut spans: Vec<Span<'l>> = Vec::new();
        for mut span in line.spans {
            let wide = columns(&span.content);
            if wide > room {
                let fits = start_of(&span.content, room).trim_end();
                span.content = (fits.to_owned() + more).into();
                spans.push(span);
                break;
            }
            room -= wide;
            spans.push(span);
        }
        Line::from(spans).style(line.style)
    }

    /// A line with a right-aligned span, which is never cut.
    pub(super) fn with_right<'l>(&self, line: Line<'l>, right: Span<'l>, width: usize) -> Line<'l> {
        let taken = columns(&right.content);
        let mut line = self.cut(line, width.saturating_sub(taken + 1));
        // Spaces at its end leave room for the right span.
        while let Some(last) = line.spans.last_mut() {
            let trimmed = last.content.trim_end().len();
            if trimmed > 0 {
                last.content.to_mut().truncate(trimmed);
                break;
            }
            line.spans.pop();
        }
        let gap = width.saturating_sub(width_of(&line.spans) + taken);
        line.spans.push(Span::raw(" ".repeat(gap)));
        line.spans.push(right);
        line
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Rows hold every character except spaces, in order, and are no wider than allowed unless they are one character.
        #[test]
        fn nothing_is_lost_between_rows(text in "[a-c漢 ]{0,60}", first in 0_usize..12, others in 0_usize..12) {
            let rows = wrap(&text, first, others);
            let solid = |text: &str| text.replace(' ', "");
            prop_assert_eq!(solid(&rows.concat()), solid(&text));
            for (n, row) in rows.iter().enumerate() {
                let room = if n == 0 { first } else { others }.max(1);
                prop_assert!(columns(row) <= room || row.chars().count() == 1, "{:?} in {:?}", row, rows);
                prop_assert_eq!(row.trim_matches(' '), row, "{:?}", rows);
                prop_assert!(!row.is_empty() || rows.len() == 1, "{:?}", rows);
            }
        }
    }

    #[test]
    fn words_stay_whole_where_they_can() {
        assert_eq!(wrap("one two three", 8, 5), ["one two", "three"]);
        assert_eq!(wrap("one", 8, 5), ["one"]);
        assert_eq!(wrap("", 8, 5), [""]);
        assert_eq!(wrap("abcdefghij kl", 4, 3), ["abcd", "efg", "hij", "kl"]);
        assert_eq!(wrap("ab", 0, 0), ["a", "b"]);
        assert_eq!(wrap("漢字漢字 ab", 5, 4), ["漢字", "漢字", "ab"]);
        assert_eq!(wrap("漢", 1, 1), ["漢"]);
        assert_eq!(wrap("漢 a", 1, 1), ["漢", "a"]);
        assert_eq!(wrap("  one   two  ", 9, 9), ["one   two"]);
        assert_eq!(wrap("  one   two  ", 8, 8), ["one", "two"]);
        assert_eq!(wrap("   ", 8, 8), [""]);
    }
}
