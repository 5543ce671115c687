//! The log, newest at the bottom.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::{First, rows};
use super::{Screen, put};
use crate::event::Level;
use crate::model::log::{Entry, Subject};
use crate::model::search::Search;
use crate::model::{Overlay, Panel};

/// Width of a glyph and a space.
const MARK_COLUMNS: usize = 2;

/// Maximum width of an entry's count.
const TIMES_COLUMNS: usize = 12;

impl Screen<'_> {
    pub(super) fn log(&self, buffer: &mut Buffer, area: Rect) {
        let width = usize::from(area.width);
        let newest = self.facts.log.numbered();
        let mut entries: Vec<_> = newest
            .map(|(number, entry)| (number, entry, self.rows_of(entry, width)))
            .collect();
        entries.reverse();
        let rows = entries.iter().map(|(.., rows)| rows).sum();
        let found = self.search().map(|search| {
            let before = entries.iter().filter(|(number, ..)| *number < search.at);
            before.map(|(.., rows)| rows).sum()
        });
        let title = (Panel::Log, "log");
        let (below, shown) = self.page(buffer, area, title, None, (rows, found), First::Bottom);
        let mut place = 0;
        for (number, entry, rows) in entries {
            let begin = place;
            place += rows;
            // Entries of other pages are only measured.
            if begin >= shown.end || place <= shown.start {
                continue;
            }
            for (place, mut line) in (begin..).zip(self.log_lines(entry, width)) {
                if let Some(search) = self.search() {
                    line = self.with_matches(line, &search.text, number == search.at);
                }
                if shown.contains(&place) {
                    put(buffer, below, (place - shown.start) as u16, &line);
                }
            }
        }
    }

    fn search(&self) -> Option<&Search> {
        match &self.ui.overlay {
            Overlay::Search(search) => Some(search),
            _ => None,
        }
    }

    /// The text searched and the number of entries with it, for the hint row.
    pub(super) fn search_words(&self) -> Option<Line<'static>> {
        let search = self.search()?;
        let found = self.facts.log.numbered();
        let found: Vec<u64> = found
            .filter(|(_, entry)| entry.contains(&search.text))
            .map(|(number, _)| number)
            .collect();
        let place = found.iter().position(|number| *number == search.at)? + 1;
        let words = format!(
            "`{}`: {place} of {}, newest first",
            search.text,
            found.len()
        );
        Some(Line::styled(words, self.theme.strong))
    }

    /// Highlights a text in a row of the log; of the found entry also its time.
    fn with_matches(&self, line: Line<'static>, text: &str, is_found: bool) -> Line<'static> {
        let text = text.to_ascii_lowercase();
        let mut spans: Vec<Span<'static>> = Vec::new();
        for (n, span) in line.spans.into_iter().enumerate() {
            if n == 0 && is_found && span.style == self.theme.dim {
                spans.push(Span::styled(span.content, self.theme.lit));
                continue;
            }
            let style = span.style;
            let content = span.content.into_owned();
            let lower = content.to_ascii_lowercase();
            let mut end = 0;
            for (at, _) in lower.match_indices(&text) {
                spans.push(Span::styled(content[end..at].to_owned(), style));
                end = at + text.len();
                spans.push(Span::styled(content[at..end].to_owned(), self.theme.lit));
            }
            spans.push(Span::styled(content[end..].to_owned(), style));
        }
        Line::from(spans)
    }

    /// Height of an entry in rows.
    fn rows_of(&self, entry: &Entry, width: usize) -> usize {
        let minutes = entry.at.as_secs() / 60;
        let time = minutes.checked_ilog10().map_or(2, |log| log.max(1) + 1) as usize + ":00 ".len();
        let times = if entry.times == 1 { 0 } else { TIMES_COLUMNS };
        // A character has at least as many bytes as columns.
        if time + MARK_COLUMNS + times + entry.text.len() <= width {
            1
        } else {
            let text = self.log_text(entry);
            let (first, others) = room_beside(time, width);
            rows(&text, first, others).count()
        }
    }

    /// Glyph and style of an entry.
    pub(super) fn mark(&self, entry: &Entry) -> (&'static str, Style) {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        match (entry.level, entry.subject) {
            (Level::Alarm, _) => (glyphs.bad, theme.alarm),
            (_, Subject::Bump) => (glyphs.bump, theme.holder),
            (Level::Warning, _) => ("!", theme.warning),
            (Level::Info, Subject::Behaviour) => (glyphs.holds, theme.plain),
            (Level::Info, Subject::Robot) => ("\"", theme.strong),
            (Level::Info, Subject::Command) => (glyphs.done, theme.plain),
            (Level::Info, Subject::Link | Subject::Station | Subject::Alarm) => {
                (glyphs.dot, theme.plain)
            }
        }
    }

    /// The rows of an entry: time, count, text. The count is never cut.
    fn log_lines(&self, entry: &Entry, width: usize) -> Vec<Line<'static>> {
        let (_, style) = self.mark(entry);
        let s = entry.at.as_secs();
        let at = format!("{:02}:{:02} ", s / 60, s % 60);
        let text = self.log_text(entry);
        let (first, others) = room_beside(at.len(), width);
        let indent = at.len() + MARK_COLUMNS;
        let mut rows = rows(&text, first, others);
        let first = Line::from(vec![
            Span::styled(at, self.theme.dim),
            Span::styled(rows.next().unwrap_or_default().to_owned(), style),
        ]);
        let more = rows.map(|row| Line::styled(format!("{:indent$}{row}", ""), style));
        [first].into_iter().chain(more).collect()
    }

    /// The text of an entry without its time.
    fn log_text(&self, entry: &Entry) -> String {
        let (glyph, _) = self.mark(entry);
        match entry.times {
            1 => [glyph, " ", &entry.text].concat(),
            times => format!("{glyph} {}{times} {}", self.theme.glyphs.times, entry.text),
        }
    }
}

/// Width of an entry's text in its first row and in those below.
const fn room_beside(time: usize, width: usize) -> (usize, usize) {
    (
        width.saturating_sub(time),
        width.saturating_sub(time + MARK_COLUMNS),
    )
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::event::Moment;
    use crate::model::{Config, Model, Shown};

    proptest! {
        /// Measuring an entry gives the number of rows that drawing it takes.
        #[test]
        fn rows_are_counted_as_they_are_drawn(
            text in "[a-z ]{0,80}|[漢字 a]{0,20}",
            s in prop_oneof![0_u64..100_000, 0_u64..1_000_000_000],
            times in prop_oneof![Just(1), any::<u32>()],
            width in 0_usize..100,
        ) {
            let model = Model::new(Config::default());
            let screen = Screen::of(Shown::from(&model), Moment::ZERO);
            let entry = Entry {
                at: Moment::from_secs(s),
                level: Level::Info,
                subject: Subject::Bump,
                text,
                times,
            };
            prop_assert_eq!(screen.rows_of(&entry, width), screen.log_lines(&entry, width).len());
        }
    }
}
