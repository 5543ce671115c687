//! The log, newest at the bottom.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::Screen;
use super::text::{First, wrap};
use crate::event::Level;
use crate::model::Panel;
use crate::model::log::{Entry, Subject};

impl Screen<'_> {
    pub(super) fn log(&self, buffer: &mut Buffer, area: Rect) {
        let mut entries: Vec<&Entry> = self.model.log.newest_first().collect();
        entries.reverse();
        let width = usize::from(area.width);
        let lines: Vec<Line<'_>> = entries
            .into_iter()
            .flat_map(|entry| self.log_lines(entry, width))
            .collect();
        self.pages(
            buffer,
            area,
            (Panel::Log, "log"),
            None,
            &lines,
            First::Bottom,
        );
    }

    /// The glyph and the style of an entry.
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

    /// An entry with its time; how often it happened comes first, where it is never cut.
    fn log_lines(&self, entry: &Entry, width: usize) -> Vec<Line<'static>> {
        let theme = &self.theme;
        let (glyph, style) = self.mark(entry);
        let s = entry.at.as_secs();
        let at = format!("{:02}:{:02} ", s / 60, s % 60);
        let times = match entry.times {
            1 => String::new(),
            times => format!("{}{times} ", theme.glyphs.times),
        };
        let text = format!("{glyph} {times}{}", entry.text);
        let indent = at.len() + 2;
        let mut rows = wrap(
            &text,
            width.saturating_sub(at.len()),
            width.saturating_sub(indent),
        )
        .into_iter();
        let first = Line::from(vec![
            Span::styled(at, theme.dim),
            Span::styled(rows.next().unwrap_or_default(), style),
        ]);
        let more = rows.map(|row| Line::styled(format!("{:indent$}{row}", ""), style));
        [first].into_iter().chain(more).collect()
    }
}
