//! The log, newest at the bottom.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::{Screen, put};
use crate::event::Level;
use crate::model::log::{Entry, Subject};

impl Screen<'_> {
    pub(super) fn log(&self, buffer: &mut Buffer, area: Rect) {
        let below = self.panel(buffer, area, "log", None);
        let rows = usize::from(below.height);
        let newest: Vec<&Entry> = self.model.log.newest_first().take(rows).collect();
        for (row, entry) in (0..).zip(newest.into_iter().rev()) {
            put(buffer, below, row, &self.log_line(entry));
        }
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
            (Level::Info, Subject::Link | Subject::Station) => (glyphs.dot, theme.plain),
        }
    }

    fn log_line(&self, entry: &Entry) -> Line<'_> {
        let theme = &self.theme;
        let (glyph, style) = self.mark(entry);
        let s = entry.at.as_secs();
        let times = match entry.times {
            1 => String::new(),
            times => format!(" {}{times}", theme.glyphs.times),
        };
        let text = format!("{glyph} {}{times}", entry.text);
        Line::from(vec![
            Span::styled(format!("{:02}:{:02} ", s / 60, s % 60), theme.dim),
            Span::styled(text, style),
        ])
    }
}
