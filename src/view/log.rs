//! The log, newest at the bottom.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::{First, rows};
use super::{Screen, put};
use crate::event::Level;
use crate::model::Panel;
use crate::model::log::{Entry, Subject};

/// Width of a glyph and a space.
const MARK_COLUMNS: usize = 2;

/// Maximum width of an entry's count.
const TIMES_COLUMNS: usize = 12;

impl Screen<'_> {
    pub(super) fn log(&self, buffer: &mut Buffer, area: Rect) {
        let width = usize::from(area.width);
        let newest = self.facts.log.newest_first();
        let mut entries: Vec<_> = newest
            .map(|entry| (entry, self.rows_of(entry, width)))
            .collect();
        entries.reverse();
        let rows = entries.iter().map(|(_, rows)| rows).sum();
        let title = (Panel::Log, "log");
        let (below, shown) = self.page(buffer, area, title, None, rows, First::Bottom);
        let mut place = 0;
        for (entry, rows) in entries {
            let begin = place;
            place += rows;
            // Entries of other pages are only measured.
            if begin >= shown.end || place <= shown.start {
                continue;
            }
            for (place, line) in (begin..).zip(self.log_lines(entry, width)) {
                if shown.contains(&place) {
                    put(buffer, below, (place - shown.start) as u16, &line);
                }
            }
        }
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
