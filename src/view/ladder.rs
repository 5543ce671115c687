//! The subsumption ladder: the layer that controls the motors, the reason, and the layers that it suppresses.

use groundwave_protocol::status_codes::{Layer, LayerState};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::{Line, Span};

use super::text::wrap;
use super::{Screen, columns, put, put_right, split_top, width_of};
use crate::event::Moment;
use crate::model::age;
use crate::model::keys::{Action, Context};
use crate::model::motors::{self, Holder};
use crate::model::robot::{COUNTERS_STALE, STATE_STALE};
use crate::model::{Large, why, words};

/// Height of the panel: title, three rows of text, eight layers and prowl.
pub(super) const ROWS: u16 = 1 + WORDS_ROWS + 9;

const WORDS_ROWS: u16 = 3;

/// Minimum width for bars of the shares.
const BARS_WIDTH: u16 = 52;

/// Width of a share's figures, columns.
const SHARE_COLUMNS: usize = 6;

/// Width of a share's bar, columns.
const BAR_CELLS: usize = 8;

struct Rung {
    /// Label of the key that enables or disables the layer.
    key: String,
    glyph: &'static str,
    name: String,
    says: String,
    style: Style,
    share: Option<f64>,
    /// Time of the layer's latest change.
    since: Option<Moment>,
}

impl Screen<'_> {
    pub(super) fn ladder(&self, buffer: &mut Buffer, area: Rect) {
        let note = self.ladder_note(area.width >= 46);
        let below = self.panel(buffer, area, "who holds the motors", Some(note));
        let (sentence, rungs) = split_top(below, WORDS_ROWS);
        self.put_sentence(buffer, sentence);
        if self.facts.robot.state.is_none() {
            return;
        }
        let layers = Layer::ALL.map(|layer| self.rung(layer));
        let key_columns = layers.iter().map(|rung| columns(&rung.key)).max();
        let mut taken = Vec::new();
        for (row, mut rung) in (0..).zip(layers.into_iter().chain([self.prowl_rung()])) {
            rung.key = format!("{:1$}", rung.key, key_columns.unwrap_or_default());
            taken.push(self.draw_rung(buffer, rungs, row, &rung));
        }
        if self.ui.enlarged == Some(Large::Ladder) {
            self.reasons(buffer, rungs, &taken);
        }
    }

    /// The time for which the holder has controlled the motors, or a warning.
    fn ladder_note(&self, wide: bool) -> Span<'static> {
        let motors = &self.facts.motors;
        let Some(holder) = motors.holder() else {
            return Span::raw("");
        };
        let stale = self.facts.robot.state.map(|state| state.age(self.now));
        if let Some(stale) = self.staleness(stale, STATE_STALE) {
            return Span::styled(stale, self.theme.warning);
        }
        if motors.thrashes(self.now) {
            return Span::styled("~ layers thrash", self.theme.warning);
        }
        let since = age::words(holder.age(self.now));
        let shares = if wide { ", % won" } else { "" };
        Span::styled(format!("for {since}{shares}"), self.theme.dim)
    }

    /// Whether the robot's state is stale.
    pub(super) fn is_stale(&self) -> bool {
        self.facts
            .robot
            .state
            .is_none_or(|state| state.age(self.now) >= STATE_STALE)
    }

    /// Whether the counters behind the shares are stale.
    fn are_shares_stale(&self) -> bool {
        let counters = self.facts.robot.counters;
        self.is_stale() || counters.is_some_and(|line| line.age(self.now) >= COUNTERS_STALE)
    }

    /// Draws the holder and the reason; a mark at the end shows that the text was cut.
    fn put_sentence(&self, buffer: &mut Buffer, area: Rect) {
        let (Some(state), Some(holder)) =
            (self.facts.robot.state_in_mode(), self.facts.motors.holder())
        else {
            let nothing = Line::styled("no data from the robot yet", self.theme.dim);
            put(buffer, area, 0, &nothing);
            return;
        };
        let (plain, strong) = if self.is_stale() {
            (self.theme.dim, self.theme.dim)
        } else {
            (self.theme.plain, self.theme.holder)
        };
        let why = why::why(holder.value, &state.value, &self.facts.robot, self.now);
        let suppressed: Vec<String> = motors::suppressed(holder.value, &state.value)
            .into_iter()
            .map(|holder| words::holder(holder).to_uppercase())
            .collect();
        let rest = match (&suppressed[..], holder.value) {
            ([], _) => format!(": {why}"),
            (names, Holder::Layer(Layer::Bumpers)) => {
                format!(": {why}; suppress {}", names.join(", "))
            }
            (names, _) => format!(": {why}; suppresses {}", names.join(", ")),
        };
        let holds = words::holds(holder.value);
        let width = usize::from(area.width);
        let rows = wrap(&format!("{holds}{rest}"), width, width);
        let last = usize::from(area.height).saturating_sub(1);
        let mut named = holds.chars().count();
        for (row, text) in (0..).zip(rows.iter().take(last + 1)) {
            let (head, tail): (String, String) = {
                let at = text
                    .char_indices()
                    .nth(named)
                    .map_or(text.len(), |(at, _)| at);
                (text[..at].to_owned(), text[at..].to_owned())
            };
            named = named.saturating_sub(text.chars().count() + 1);
            let mut line = Line::from(vec![Span::styled(head, strong), Span::styled(tail, plain)]);
            if usize::from(row) == last && rows.len() > last + 1 {
                line.push_span(Span::styled(" ".repeat(width) + ".", plain));
                line = self.cut(line, width);
            }
            put(buffer, area, row, &line);
        }
    }

    fn rung(&self, layer: Layer) -> Rung {
        let theme = &self.theme;
        let glyphs = theme.glyphs;
        let facts = self.facts;
        let holder = Holder::Layer(layer);
        let held_by = facts.motors.holder().map(|held| held.value);
        let holds = held_by == Some(holder);
        let state = facts
            .robot
            .state_in_mode()
            .map_or(LayerState::Off, |state| state.value.layers.get(layer));
        let forbidden = facts
            .robot
            .allowed()
            .is_some_and(|allowed| !allowed.contains(layer));
        let suppressed = facts
            .robot
            .state_in_mode()
            .zip(held_by)
            .is_some_and(|(state, by)| motors::suppressed(by, &state.value).contains(&holder));
        let (glyph, says, style) = if facts.robot.lacks(layer) {
            (glyphs.missing, "not fitted", theme.rule)
        } else if holds {
            (glyphs.holds, "HOLDS", theme.holder)
        } else if forbidden {
            (glyphs.forbidden, "not allowed", theme.dim)
        } else {
            match state {
                LayerState::Raised | LayerState::Holds if suppressed => {
                    (glyphs.raised, "suppressed", theme.raised)
                }
                LayerState::Raised | LayerState::Holds => {
                    (glyphs.raised, "triggered", theme.raised)
                }
                LayerState::Quiet => (glyphs.quiet, "quiet", theme.plain),
                LayerState::Off if layer == Layer::User => (glyphs.quiet, "idle", theme.plain),
                LayerState::Off => (glyphs.off, "off", theme.dim),
            }
        };
        let says = match facts
            .ledger
            .asked_of(layer, facts.robot.status.map(|status| status.at))
        {
            Some(true) => format!("{says}, enabling"),
            Some(false) => format!("{says}, disabling"),
            None => says.to_owned(),
        };
        let style = if self.is_stale() { theme.dim } else { style };
        Rung {
            key: self
                .ui
                .config
                .keys
                .label(Context::Dashboard, Action::ToggleLayer(layer)),
            glyph,
            name: named(holder, holds),
            says,
            style,
            share: facts.motors.share(holder),
            since: if facts.robot.lacks(layer) || self.is_stale() {
                None
            } else {
                facts.motors.since(layer)
            },
        }
    }

    fn prowl_rung(&self) -> Rung {
        let theme = &self.theme;
        let facts = self.facts;
        let holder = facts.motors.holder().map(|held| held.value);
        let mode = facts.robot.mode();
        let holds = holder == Some(Holder::Prowl);
        let (glyph, says, style) = match mode {
            _ if holds => (theme.glyphs.holds, "HOLDS", theme.holder),
            Some(mode) if motors::prowls(mode) => (theme.glyphs.raised, "suppressed", theme.raised),
            _ => (theme.glyphs.off, "not in this mode", theme.dim),
        };
        let style = if self.is_stale() { theme.dim } else { style };
        Rung {
            key: String::new(),
            glyph,
            name: named(Holder::Prowl, holds),
            says: says.to_owned(),
            style,
            share: facts.motors.share(Holder::Prowl),
            since: None,
        }
    }

    /// Draws a rung; returns the columns of its text at the left.
    fn draw_rung(&self, buffer: &mut Buffer, area: Rect, row: u16, rung: &Rung) -> usize {
        let theme = &self.theme;
        let line = Line::from(vec![
            Span::styled(format!("{} ", rung.key), theme.dim),
            Span::styled(
                format!("{} {:<15}{}", rung.glyph, rung.name, rung.says),
                rung.style,
            ),
        ]);
        put(buffer, area, row, &line);
        let left = width_of(&line.spans);
        self.draw_since(buffer, area, row, &line, rung);
        let old = if self.are_shares_stale() {
            theme.glyphs.stale
        } else {
            ""
        };
        let taken = left + " 100 %".len() + old.chars().count();
        let Some(share) = rung
            .share
            .filter(|share| *share > 0.0 && taken <= usize::from(area.width))
        else {
            return left;
        };
        let mut spans = Vec::new();
        if area.width >= BARS_WIDTH {
            spans.push(Span::styled(self.bar(share, BAR_CELLS), rung.style));
        }
        let figures = format!("{old}{:>1$.0} %", share * 100.0, 4 - old.chars().count());
        spans.push(Span::styled(figures, rung.style));
        put_right(buffer, area, row, &Line::from(spans));
        left
    }

    /// Draws the time of the latest change if there is room between text and share.
    fn draw_since(&self, buffer: &mut Buffer, area: Rect, row: u16, line: &Line<'_>, rung: &Rung) {
        let Some(since) = rung.since else {
            return;
        };
        let words = age::words(self.now.saturating_sub(since));
        let share_columns = if area.width >= BARS_WIDTH {
            BAR_CELLS + SHARE_COLUMNS
        } else {
            SHARE_COLUMNS
        };
        let words = Line::styled(words, self.theme.dim);
        let room = usize::from(area.width).saturating_sub(share_columns + 1);
        if width_of(&line.spans) + 1 + width_of(&words.spans) <= room {
            let here = Rect {
                width: room as u16,
                ..area
            };
            put_right(buffer, here, row, &words);
        }
    }

    /// A bar of `cells` columns, filled to `share` (0 to 1).
    pub(super) fn bar(&self, share: f64, cells: usize) -> String {
        let eighths = (share.clamp(0.0, 1.0) * (cells * 8) as f64).round() as usize;
        let full = self.theme.glyphs.bar[7].repeat(eighths / 8);
        let part = match eighths % 8 {
            0 => "",
            n => self.theme.glyphs.bar[n - 1],
        };
        let drawn = eighths.div_ceil(8);
        format!("{full}{part}{:1$}", "", cells - drawn)
    }
}

fn named(holder: Holder, holds: bool) -> String {
    let name = words::holder(holder);
    if holds {
        name.to_uppercase()
    } else {
        name.to_owned()
    }
}
