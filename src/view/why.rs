//! The "why" window: the facts behind the robot's behaviour at the shown moment.

use groundwave_protocol::status_codes::{Layer, LayerState};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::wrap;
use super::{Screen, put};
use crate::model::age;
use crate::model::log::Subject;
use crate::model::motors;
use crate::model::robot::{STATE_STALE, ordered_wheels_in_s};
use crate::model::{why, words};

const COLUMNS: u16 = 78;

/// Width of the window's frame, columns.
const FRAME_COLUMNS: u16 = 4;

/// Greatest height of the window, rows.
const ROWS_MAX: u16 = 22;

const NAME_COLUMNS: usize = 12;

/// Number of earlier log entries shown.
const BEFORE: usize = 6;

impl Screen<'_> {
    pub(super) fn why_window(&self, buffer: &mut Buffer, area: Rect) {
        let s = self.now.as_secs();
        let title = format!(" why, at {:02}:{:02} ", s / 60, s % 60);
        let room = usize::from(COLUMNS.min(area.width).saturating_sub(FRAME_COLUMNS));
        let room = room.saturating_sub(NAME_COLUMNS);
        let mut lines = Vec::new();
        for (name, text, style) in self.why_facts() {
            for (n, words) in wrap(&text, room, room).into_iter().enumerate() {
                let name = if n == 0 { name } else { "" };
                lines.push(Line::from(vec![
                    Span::styled(format!("{name:<NAME_COLUMNS$}"), self.theme.dim),
                    Span::styled(words, style),
                ]));
            }
        }
        let height = (lines.len() as u16 + 2).min(ROWS_MAX);
        let inner = self.window(buffer, area, (COLUMNS, height), &title);
        for (row, line) in (0..inner.height).zip(&lines) {
            put(buffer, inner, row, line);
        }
    }

    fn why_facts(&self) -> Vec<(&'static str, String, Style)> {
        let theme = &self.theme;
        let Some(state) = self.facts.robot.state_in_mode() else {
            return vec![("", "no data from the robot yet".to_owned(), theme.dim)];
        };
        let heard = age::words(state.age(self.now));
        let state_age = state.age(self.now);
        let state = state.value;
        let mut facts = Vec::new();
        if state_age >= STATE_STALE {
            let old = format!("{} by its last line, {heard} ago", theme.glyphs.stale);
            facts.push(("stale", old, theme.warning));
        }
        if let Some(holder) = self.facts.motors.holder() {
            let since = age::words(holder.age(self.now));
            let text = format!(
                "{}, for {since}: {}",
                words::holds(holder.value),
                why::why(holder.value, &state, &self.facts.robot, self.now)
            );
            facts.push(("holder", text, theme.holder));
        }
        let held = self.facts.motors.holder().map(|holder| holder.value);
        let suppressed: Vec<_> = held
            .map(|holder| motors::suppressed(holder, &state))
            .unwrap_or_default()
            .into_iter()
            .map(words::holder)
            .collect();
        facts.push(("suppressed", or_none(&suppressed), theme.plain));
        let in_state = |wanted| {
            let layers = Layer::ALL.into_iter().skip(1);
            let layers = layers.filter(|layer| state.layers.get(*layer) == wanted);
            or_none(&layers.map(words::layer).collect::<Vec<_>>())
        };
        facts.push(("quiet", in_state(LayerState::Quiet), theme.plain));
        facts.push(("off", in_state(LayerState::Off), theme.dim));
        let [left, right] = ordered_wheels_in_s(&state);
        let text = format!(
            "mode {}; wheels requested {left:+} {right:+}, measured {:+} {:+} in/s; drive {}",
            words::mode(state.mode),
            state.wheel_left_in_s,
            state.wheel_right_in_s,
            words::drive(state.drive)
        );
        facts.push(("drives", text, theme.plain));
        let text = format!(
            "{}; infrared {}; sonar {} left, {} right; {}; arm {}",
            match why::bump(state.bump) {
                touched if touched.contains("bumper") => touched.to_owned(),
                other => format!("bumper {other}"),
            },
            words::infrared(state.infrared),
            why::range(state.sonar_left_in),
            why::range(state.sonar_right_in),
            words::cliff(state.cliff),
            why::arm(state.arm)
        );
        facts.push(("senses", text, theme.plain));
        let command = match self.facts.ledger.newest() {
            Some(entry) => {
                let (_, says, _) = self.fate(entry);
                let ago = age::words(self.now.saturating_sub(entry.asked_at));
                format!("{}, {ago} ago: {says}", entry.request)
            }
            None => "none in this session".to_owned(),
        };
        facts.push(("command", command, theme.plain));
        let raised = self.facts.alarms.all(&self.ui.attended);
        let raised = raised.filter_map(|shown| {
            let raised = shown.raised?;
            raised.over_at.is_none().then_some(&*shown.rule.name)
        });
        let alarms = or_none(&raised.collect::<Vec<_>>());
        facts.push(("alarms", alarms, theme.plain));
        let entries = self.facts.log.newest_first();
        let before: Vec<_> = entries
            .filter(|entry| entry.subject != Subject::Station)
            .take(BEFORE)
            .collect();
        for (n, entry) in before.into_iter().rev().enumerate() {
            let name = if n == 0 { "before" } else { "" };
            let (glyph, style) = self.mark(entry);
            let ago = age::words(self.now.saturating_sub(entry.at));
            facts.push((name, format!("{glyph} {ago} ago: {}", entry.text), style));
        }
        facts
    }
}

fn or_none(names: &[&str]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}
