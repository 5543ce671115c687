//! The last line: the keys, or what is being typed.

use groundwave_protocol::letters::Mode;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put, put_right};
use crate::model::keys::{Action, Context};
use crate::model::{Overlay, Purpose};

impl Screen<'_> {
    pub(super) fn keys(&self, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        if let Overlay::Text(entry) = &self.model.overlay {
            let prompt = match entry.purpose {
                Purpose::Command => ":",
                Purpose::RouteFile => "route file: ",
                Purpose::SaveRoute => "save as: ",
                Purpose::Moment => "go to: ",
            };
            let keys = Line::from(self.keys_beside_prompt(area.width));
            let taken = prompt.len() + 1 + keys.width();
            let room = usize::from(area.width).saturating_sub(taken);
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
            put_right(buffer, area, 0, &keys);
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
        if let Overlay::Jump { forward } = self.model.overlay {
            let words = if forward {
                "to the next "
            } else {
                "to the last "
            };
            spans.push(Span::styled(words, theme.strong));
        }
        let context = self.model.context();
        let always = self.named_keys(context, |action| ALWAYS_SEEN.contains(&action));
        let always_width: usize = always.iter().map(Span::width).sum();
        let mut room = usize::from(area.width).saturating_sub(always_width);
        room = room.saturating_sub(spans.iter().map(Span::width).sum());
        // Whoever looks at another moment moves in time first of all.
        let mut others = Vec::new();
        if self.model.playback.is_some() {
            others.extend(self.named_keys(context, |action| action == Action::Stop));
            others.extend(self.named_keys(context, Action::moves_in_time));
            others.extend(self.named_keys(context, |action| {
                let is_named = action == Action::Stop || action.moves_in_time();
                !is_named && !ALWAYS_SEEN.contains(&action)
            }));
        } else {
            others = self.named_keys(context, |action| !ALWAYS_SEEN.contains(&action));
        }
        for pair in others.chunks(2) {
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

    /// The keys of the prompt, STOP first, as many as leave room to type.
    fn keys_beside_prompt(&self, width: u16) -> Vec<Span<'static>> {
        let mut room = usize::from(width).saturating_sub(TYPING_COLUMNS);
        let mut spans = vec![Span::raw("  ")];
        for pair in self.named_keys(Context::Text, |_| true).chunks(2) {
            let width: usize = pair.iter().map(Span::width).sum();
            if width > room {
                break;
            }
            room -= width;
            spans.extend_from_slice(pair);
        }
        spans
    }

    /// The keys of a context that the footer names: label and meaning, two spans each. What would ask
    /// something of a robot that cannot be asked is not offered.
    pub(super) fn named_keys(
        &self,
        context: Context,
        wanted: fn(Action) -> bool,
    ) -> Vec<Span<'static>> {
        let deaf = self.model.link.is_receive_only();
        let named = self.model.config.keys.rows().filter(|binding| {
            binding.context == context
                && !binding.footer.is_empty()
                && wanted(binding.action)
                && !(deaf && binding.action.asks_the_robot())
        });
        named
            .flat_map(|binding| {
                [
                    Span::styled(binding.label.to_string(), self.theme.key),
                    Span::styled(format!(" {}  ", binding.footer), self.theme.dim),
                ]
            })
            .collect()
    }
}

/// Named at the right end of the footer however narrow it is.
const ALWAYS_SEEN: &[Action] = &[Action::Help, Action::Quit];

/// Columns of the prompt row that its keys leave free.
const TYPING_COLUMNS: usize = 34;
