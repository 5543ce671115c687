//! The last row: the keys, or the text being typed.

use groundwave_protocol::status_codes::Mode;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::lines::columns;
use super::text::start_of;
use super::{Screen, put, put_right, width_of};
use crate::model::keys::RouteAction;
use crate::model::keys::{Action, Context, Row};
use crate::model::runs::Runs;
use crate::model::{Large, Overlay, Purpose};

impl Screen<'_> {
    pub(super) fn keys(&self, buffer: &mut Buffer, area: Rect) {
        let theme = &self.theme;
        if let Overlay::Text(entry) = &self.ui.overlay {
            let prompt = match entry.purpose {
                Purpose::Command => ":",
                Purpose::RouteFile => "route file: ",
                Purpose::SaveRoute => "save as: ",
                Purpose::Moment => "go to: ",
                Purpose::Search => "/",
                Purpose::Mark => "mark: ",
            };
            let keys = Line::from(self.keys_beside_prompt(area.width));
            let taken = prompt.len() + 1 + width_of(&keys.spans);
            let room = usize::from(area.width).saturating_sub(taken);
            let (before, behind) = entry.parts();
            // The text before the caret matters more than the text after it.
            let room_before = room - columns(behind).min(room / 4);
            let mut ends = before.char_indices().map(|(at, _)| &before[at..]);
            let before = ends.find(|end| columns(end) <= room_before);
            let before = before.unwrap_or_default();
            let behind = start_of(behind, room - columns(before));
            let line = Line::from(vec![
                Span::styled(prompt, theme.key),
                Span::styled(before, theme.strong),
                Span::styled(theme.glyphs.text_cursor, theme.key),
                Span::styled(behind, theme.strong),
            ]);
            put(buffer, area, 0, &line);
            put_right(buffer, area, 0, &keys);
            return;
        }
        let mut spans = Vec::new();
        if let Overlay::Drive(stick) = &self.ui.overlay {
            let state = self.facts.robot.state.map(|state| state.value.mode);
            let words = if state == Some(Mode::User) {
                format!(" HAND DRIVE {} in/s ", stick.speed_in_s)
            } else {
                " HAND DRIVE: not in mode user yet ".to_owned()
            };
            spans.push(Span::styled(words, theme.alarm));
            spans.push(Span::raw("  "));
        }
        if let Overlay::Jump { forward } = self.ui.overlay {
            let words = if forward {
                "to the next "
            } else {
                "to the last "
            };
            spans.push(Span::styled(words, theme.strong));
        }
        let context = self.ui.context();
        let mut always: Vec<Span<'_>> = self
            .named_rows(context)
            .filter(|row| ALWAYS_SEEN.contains(&row.action) && self.does_something(row))
            .flat_map(|row| self.named(row))
            .collect();
        if let Some(last) = always.last_mut() {
            last.content = last.content.trim_end().to_owned().into();
        }
        let always_width = width_of(&always);
        let mut room = usize::from(area.width).saturating_sub(always_width);
        room = room.saturating_sub(width_of(&spans));
        for pair in self.others(context).chunks(2) {
            let width = width_of(pair);
            if width <= room {
                room -= width;
                spans.extend_from_slice(pair);
            }
        }
        put(buffer, area, 0, &Line::from(spans));
        put_right(buffer, area, 0, &Line::from(always));
    }

    /// The keys, most important first, as far as there is room.
    fn others(&self, context: Context) -> Vec<Span<'static>> {
        let mut rows: Vec<_> = self
            .named_rows(context)
            .filter(|row| !ALWAYS_SEEN.contains(&row.action))
            .filter(|row| self.does_something(row))
            .collect();
        rows.sort_by_cached_key(|row| {
            // A draft is begun with the cursor; the footer offers sending it rather than editing it.
            let step = match row.action {
                Action::MoveCursor { .. } => 0,
                Action::EditRoute => 2,
                Action::UndoDraft => 3,
                _ => 1,
            };
            (self.place_in_footer(row.action), step)
        });
        rows.into_iter().flat_map(|row| self.named(row)).collect()
    }

    /// Whether an action has an effect: a window to close, a command to cancel, a draft to send.
    fn does_something(&self, row: &Row) -> bool {
        let facts = self.facts;
        match (row.context, row.action) {
            (Context::Dashboard, Action::Close) => self.ui.can_put_away(),
            (Context::Dashboard, Action::CancelCommands) => facts.ledger.is_busy(),
            (Context::Dashboard, Action::UndoDraft | Action::SendDraft) => self.is_drafting(),
            (Context::Runs, Action::Choose(_) | Action::Submit | Action::CompareRun) => {
                matches!(&self.ui.overlay, Overlay::Runs(Runs::Listed { list, .. }) if !list.runs.is_empty())
            }
            _ => true,
        }
    }

    /// Whether a route is drafted on the map.
    fn is_drafting(&self) -> bool {
        self.ui.map.cursor.is_some() || !self.ui.map.draft.waypoints().is_empty()
    }

    /// Position of an action in the footer: STOP, the keys of the chosen panel, then general keys.
    fn place_in_footer(&self, action: Action) -> usize {
        let facts = self.facts;
        let common = Action::COMMON.iter().position(|known| *known == action);
        match action {
            Action::Stop => 0,
            // Keys of an open window come first.
            Action::AskCommand if self.ui.context() != Context::Dashboard => usize::MAX,
            // While the screen shows the past, keys that move in time come first.
            _ if self.ui.playback.is_some() && action.moves_in_time() => 1,
            Action::CancelCommands if facts.ledger.is_busy() => 2,
            Action::Enlarge if self.ui.enlarged.is_some() => 2,
            _ if self.ui.map.cursor.is_some() && action.drafts() => 3,
            _ if action.is_for(self.ui.panel) => 4,
            _ if self.is_drafting() && action.drafts() => 5,
            _ => 6 + common.unwrap_or(Action::COMMON.len()),
        }
    }

    /// The keys of the prompt, STOP first, as far as there is room beside the text.
    fn keys_beside_prompt(&self, width: u16) -> Vec<Span<'static>> {
        let mut room = usize::from(width).saturating_sub(TYPING_COLUMNS);
        let mut spans = vec![Span::raw("  ")];
        for pair in self.named_keys(Context::Text, |_| true).chunks(2) {
            let width = width_of(pair);
            if width > room {
                break;
            }
            room -= width;
            spans.extend_from_slice(pair);
        }
        spans
    }

    /// The keys of a context for the footer: two spans each, label and meaning.
    pub(super) fn named_keys(
        &self,
        context: Context,
        wanted: fn(Action) -> bool,
    ) -> Vec<Span<'static>> {
        let rows = self.named_rows(context).filter(|row| wanted(row.action));
        rows.flat_map(|row| self.named(row)).collect()
    }

    /// The rows of actions that are possible with this robot; commands only on a link that can send.
    fn named_rows(&self, context: Context) -> impl Iterator<Item = &Row> {
        self.ui.config.keys.rows().filter(move |row| {
            let is_named = !row.footer.is_empty() && !row.label.is_empty();
            row.context == context && is_named && self.ui.offers(self.facts, row.action)
        })
    }

    fn named(&self, row: &Row) -> [Span<'static>; 2] {
        let does = match row.action {
            Action::Enlarge => match self.ui.enlarged {
                None => row.footer,
                Some(Large::Panel) => "map",
                Some(Large::Map) => "ladder",
                Some(Large::Ladder) => "back",
            },
            _ => row.footer,
        };
        [
            Span::styled(row.labels.clone(), self.theme.key),
            Span::styled(format!(" {does}  "), self.theme.dim),
        ]
    }
}

/// Keys at the right end of the footer at any width.
const ALWAYS_SEEN: &[Action] = &[
    Action::Help,
    Action::Quit,
    Action::Close,
    Action::LeaveDrive,
    Action::Route(RouteAction::Leave),
];

/// Number of columns of the prompt row kept free for text.
const TYPING_COLUMNS: usize = 34;
