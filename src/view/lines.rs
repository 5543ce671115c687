//! Writing lines into a buffer, and their width in columns.

#[cfg(test)]
use std::cell::RefCell;

use ratatui::buffer::{Buffer, CellWidth};
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

#[cfg(test)]
thread_local! {
    /// Texts clipped without a mark; tests assert that there are none.
    pub(super) static CLIPPED: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Width of a text in columns.
pub(super) fn columns(text: &str) -> usize {
    let text = Span::raw(text);
    let graphemes = text.styled_graphemes(Style::new());
    graphemes
        .map(|grapheme| usize::from(grapheme.symbol.cell_width()))
        .sum()
}

/// Width of a line or of a part of one, in columns.
pub(super) fn width_of(spans: &[Span<'_>]) -> usize {
    spans.iter().map(|span| columns(&span.content)).sum()
}

/// Writes a line into a row of an area, clipped. A line that may be too long must first be cut with a mark.
pub(super) fn put(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let area = area.intersection(buffer.area);
    if row >= area.height {
        return;
    }
    #[cfg(test)]
    note_clipped(line, area.width);
    buffer.set_line(area.x, area.y + row, line, area.width);
}

#[cfg(test)]
fn note_clipped(line: &Line<'_>, width: u16) {
    let text: String = line
        .spans
        .iter()
        .map(|span| span.content.as_ref())
        .collect();
    if Line::raw(text.trim_end()).width() > usize::from(width) {
        CLIPPED.with_borrow_mut(|clipped| clipped.push(text));
    }
}

/// Writes a line right-aligned.
pub(super) fn put_right(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let width = (width_of(&line.spans) as u16).min(area.width);
    let x = area.right() - width;
    put(buffer, Rect { x, width, ..area }, row, line);
}

/// Fills an area with one symbol.
pub(super) fn fill(buffer: &mut Buffer, area: Rect, symbol: &str, style: Style) {
    let area = area.intersection(buffer.area);
    for row in area.rows().filter(|row| !row.is_empty()) {
        let begin = buffer.index_of(row.x, row.y);
        for cell in &mut buffer.content[begin..begin + usize::from(row.width)] {
            cell.set_symbol(symbol).set_style(style);
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_width_of_a_line_is_that_of_its_cells(
            spans in prop::collection::vec("[ -~]{0,6}|[─▶°⠁a]{0,6}|[漢e\u{301}\tﾊﾟ a]{0,4}", 0..4),
        ) {
            let line: Line<'_> = spans.iter().map(Span::raw).collect();
            let mut wide = Buffer::empty(Rect::new(0, 0, 99, 1));
            let (end, _) = wide.set_line(0, 0, &line, 99);
            prop_assert_eq!(width_of(&line.spans), usize::from(end));
        }
    }
}
