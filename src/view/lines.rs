//! Lines on the page: where they go, and how many columns they take.

#[cfg(test)]
use std::cell::RefCell;

use ratatui::buffer::{Buffer, CellWidth};
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

#[cfg(test)]
thread_local! {
    /// Words that were cut off without a mark of it, for tests that there are none.
    pub(super) static CLIPPED: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Whether each of its characters takes one column for itself, as nearly everything does that is ever drawn: looking up what
/// joins and how wide it is would be most of what a frame costs.
fn is_plain(text: &str) -> bool {
    text.bytes().all(|byte| matches!(byte, b' '..=b'~')) || text.chars().all(is_plain_character)
}

/// ASCII, and what the themes draw with.
const fn is_plain_character(character: char) -> bool {
    matches!(
        character,
        ' '..='~'
            | '°'
            | '·'
            | '×'
            | '‖'
            | '…'
            | '∘'
            | '⌂'
            | '\u{2500}'..='\u{25fc}'
            | '✓'..='✖'
            | '\u{2800}'..='\u{28ff}'
    )
}

/// Columns that a text takes: wide characters take two.
pub(super) fn columns(text: &str) -> usize {
    if is_plain(text) {
        return text.chars().count();
    }
    let text = Span::raw(text);
    let graphemes = text.styled_graphemes(Style::new());
    graphemes
        .map(|grapheme| usize::from(grapheme.symbol.cell_width()))
        .sum()
}

/// Columns that a line or a part of one takes.
pub(super) fn width_of(spans: &[Span<'_>]) -> usize {
    spans.iter().map(|span| columns(&span.content)).sum()
}

/// Writes a line into a row of an area, clipped to it: whoever may have more to say than fits cuts it with a mark.
pub(super) fn put(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let area = area.intersection(buffer.area);
    if row >= area.height {
        return;
    }
    #[cfg(test)]
    note_clipped(line, area.width);
    let (mut x, y) = (area.x, area.y + row);
    for span in &line.spans {
        let room = area.right() - x;
        if room == 0 {
            return;
        }
        let style = line.style.patch(span.style);
        if is_plain(&span.content) {
            let begin = buffer.index_of(x, y);
            let cells = &mut buffer.content[begin..begin + usize::from(room)];
            for (cell, character) in cells.iter_mut().zip(span.content.chars()) {
                cell.set_char(character).set_style(style);
                x += 1;
            }
        } else {
            (x, _) = buffer.set_stringn(x, y, &span.content, room.into(), style);
        }
    }
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

/// Writes a line flush right.
pub(super) fn put_right(buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>) {
    let width = (width_of(&line.spans) as u16).min(area.width);
    let x = area.right() - width;
    put(buffer, Rect { x, width, ..area }, row, line);
}

/// Draws the same in every place of an area.
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
    use ratatui::style::Stylize;

    use super::*;

    /// Beside anything that may stand beside it, each is a character of one column.
    #[test]
    fn a_plain_character_joins_with_no_other() {
        let all = (0..0x3_0000).filter_map(char::from_u32);
        let plain: Vec<char> = all.filter(|c| is_plain_character(*c)).collect();
        assert!(plain.len() > 600, "{}", plain.len());
        for &one in &plain {
            for other in [' ', 'a', '─', '▶', '✔', '⠁'] {
                let text: String = [one, other, one].iter().collect();
                let line = Line::raw(text.as_str());
                assert_eq!(line.width(), 3, "{text:?}");
                let graphemes = line.styled_graphemes(Style::new()).count();
                assert_eq!(graphemes, 3, "{text:?}");
            }
        }
    }

    proptest! {
        /// What the library writes, in as many columns.
        #[test]
        fn lines_are_put_as_the_library_puts_them(
            spans in prop::collection::vec("[ -~]{0,6}|[─▶°⠁a]{0,6}|[漢e\u{301}\tﾊﾟ a]{0,4}", 0..4),
            (x, width) in (0_u16..20, 0_u16..24),
        ) {
            let styles = [Style::new().red(), Style::new().bold().on_blue(), Style::new().not_bold()];
            let spans = spans.iter().zip(styles).map(|(text, style)| Span::styled(text, style));
            let line = spans.collect::<Line<'_>>().italic();
            let mut wide = Buffer::empty(Rect::new(0, 0, 99, 1));
            let (end, _) = wide.set_line(0, 0, &line, 99);
            prop_assert_eq!(width_of(&line.spans), usize::from(end));
            let page = Rect::new(0, 0, 20, 2);
            let (mut ours, mut theirs) = (Buffer::empty(page), Buffer::empty(page));
            let area = Rect::new(x, 0, width, 2).intersection(page);
            put(&mut ours, area, 1, &line);
            theirs.set_line(area.x, 1, &line, area.width);
            prop_assert_eq!(ours, theirs);
        }
    }
}
