//! The last lines: the one that says it all, and the keys.

use groundwave_protocol::letters::Mode;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::status::file_name;
use super::{Screen, put, put_right};
use crate::model::keys::{self, Action, Context};
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
        let room = usize::from(area.width);
        let long = self.hint_line(false);
        let line = if long.width() <= room {
            long
        } else {
            self.hint_line(true)
        };
        put(buffer, area, 0, &line);
    }

    fn hint_line(&self, short: bool) -> Line<'_> {
        let theme = &self.theme;
        let link = &self.model.link;
        let separator = format!(" {} ", theme.glyphs.dot);
        let mut facts = Vec::new();
        if link.newest_raw().is_some() {
            let unit = if short { "/s" } else { " lines/s" };
            facts.push(format!("{:.1}{unit}", link.lines_per_s(self.now)));
        }
        if let Some(loss) = link.loss(self.now) {
            facts.push(format!("loss {:.1} %", loss * 100.0));
        }
        let recording = &self.model.recording;
        let places = [&recording.tee, &recording.mcap].into_iter().flatten();
        let places: Vec<&str> = places
            .map(|path| if short { file_name(path) } else { path })
            .collect();
        if places.is_empty() && !short {
            facts.push("not recorded".to_owned());
        }
        if !places.is_empty() {
            let recorded = if short { "" } else { "recorded in " };
            facts.push(format!("{recorded}{}", places.join(", ")));
        }
        facts.extend(self.model.config.hint.clone());
        let keys: &[(&str, &str)] = if self.model.context() != Context::Dashboard {
            &[]
        } else if link.replay.is_some() {
            &[("k", " pauses, "), ("< >", " slower and faster")]
        } else if link.can_send {
            &[("h", " sends it home")]
        } else {
            &[]
        };
        let mut spans = vec![Span::styled(facts.join(&separator), theme.plain)];
        if !facts.is_empty() && !keys.is_empty() {
            spans.push(Span::raw(separator));
        }
        for (key, does) in keys {
            spans.push(Span::styled(*key, theme.key));
            spans.push(Span::raw(*does));
        }
        Line::from(spans)
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
            let state = self.model.robot.state.map(|state| state.value.mode);
            let words = if state == Some(Mode::User) {
                format!(" HAND DRIVE {} in/s ", stick.speed_in_s)
            } else {
                " HAND DRIVE: the robot is not in mode user yet ".to_owned()
            };
            spans.push(Span::styled(words, theme.alarm));
            spans.push(Span::raw("  "));
        }
        let context = self.model.context();
        let always = self.named_keys(context, |action| ALWAYS_SEEN.contains(&action));
        let always_width: usize = always.iter().map(Span::width).sum();
        let mut room = usize::from(area.width).saturating_sub(always_width);
        room = room.saturating_sub(spans.iter().map(Span::width).sum());
        for pair in self
            .named_keys(context, |action| !ALWAYS_SEEN.contains(&action))
            .chunks(2)
        {
            let width: usize = pair.iter().map(Span::width).sum();
            if width > room {
                break;
            }
            room -= width;
            spans.extend_from_slice(pair);
        }
        put(buffer, area, 0, &Line::from(spans));
        put_right(buffer, area, 0, &Line::from(always));
    }

    /// The keys of a context that the footer names: label and meaning, two spans each.
    fn named_keys(&self, context: Context, wanted: fn(Action) -> bool) -> Vec<Span<'static>> {
        let named = keys::TABLE.iter().filter(|binding| {
            binding.context == context && !binding.footer.is_empty() && wanted(binding.action)
        });
        named
            .flat_map(|binding| {
                [
                    Span::styled(binding.label, self.theme.key),
                    Span::styled(format!(" {}  ", binding.footer), self.theme.dim),
                ]
            })
            .collect()
    }
}

/// Named at the right end of the footer however narrow it is.
const ALWAYS_SEEN: &[Action] = &[Action::Help, Action::Quit];

const COMMAND_HELP: &str =
    "stop, mode M, enable L,L, disable L,L, goto X Y, route FILE, clear, scan, help";
