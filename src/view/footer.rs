//! The last lines: the one that says it all, and the keys.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put};
use crate::model::keys::{self, Context};
use crate::model::{Overlay, Purpose};

impl Screen<'_> {
    /// Rate, loss, where it is recorded, how to see it raw, the way home.
    pub(super) fn hint(&self, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        if let Overlay::Text(entry) = &self.model.overlay {
            let help = match (&entry.error, entry.purpose) {
                (Some(error), _) => Line::styled(error.clone(), theme.warning),
                (None, Purpose::Command) => Line::styled(COMMAND_HELP, theme.dim),
                (None, Purpose::RouteFile) => Line::styled(
                    "a route file: one X,Y in inches a line, # comments",
                    theme.dim,
                ),
            };
            put(buffer, area, 0, &help);
            return;
        }
        let link = &self.model.link;
        let separator = format!(" {} ", theme.glyphs.dot);
        let mut facts = Vec::new();
        if link.newest_raw().is_some() {
            facts.push(format!("{:.1} lines/s", link.lines_per_s(self.now)));
        }
        if let Some(loss) = link.loss(self.now) {
            facts.push(format!("loss {:.1} %", loss * 100.0));
        }
        let recording = &self.model.recording;
        let places: Vec<&str> = [&recording.tee, &recording.mcap]
            .into_iter()
            .flatten()
            .map(String::as_str)
            .collect();
        if !places.is_empty() {
            facts.push(format!("recorded in {}", places.join(", ")));
        }
        facts.extend(self.model.config.hint.clone());
        let mut spans = vec![Span::styled(facts.join(&separator), theme.plain)];
        if link.can_send {
            if !facts.is_empty() {
                spans.push(Span::raw(separator));
            }
            spans.push(Span::styled("h", theme.key));
            spans.push(Span::raw(" sends it home"));
        }
        put(buffer, area, 0, &Line::from(spans));
    }

    pub(super) fn keys(&self, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        if let Overlay::Text(entry) = &self.model.overlay {
            let prompt = match entry.purpose {
                Purpose::Command => ":",
                Purpose::RouteFile => "route file: ",
            };
            let room = usize::from(area.width).saturating_sub(prompt.len() + 1);
            let length = entry.text.chars().count();
            let seen: String = entry
                .text
                .chars()
                .skip(length.saturating_sub(room))
                .collect();
            let line = Line::from(vec![
                Span::styled(prompt, theme.key),
                Span::styled(seen, theme.strong),
                Span::styled(theme.glyphs.text_cursor, theme.key),
            ]);
            put(buffer, area, 0, &line);
            return;
        }
        let mut spans = Vec::new();
        if let Overlay::Drive(stick) = &self.model.overlay {
            let words = format!(" HAND DRIVE {} in/s ", stick.speed_in_s);
            spans.push(Span::styled(words, theme.alarm));
            spans.push(Span::raw("  "));
        }
        spans.extend(self.footer(self.model.context()));
        put(buffer, area, 0, &Line::from(spans));
    }

    fn footer(&self, context: Context) -> Vec<Span<'static>> {
        let named = keys::TABLE
            .iter()
            .filter(|binding| binding.context == context && !binding.footer.is_empty());
        let mut spans = Vec::new();
        for binding in named {
            spans.push(Span::styled(binding.label, self.theme.key));
            spans.push(Span::styled(
                format!(" {}  ", binding.footer),
                self.theme.dim,
            ));
        }
        spans
    }
}

const COMMAND_HELP: &str = "stop | mode M | enable L,L | disable L,L | goto X Y | route FILE | clear | set-pose X Y T | reset-pose | scan";
