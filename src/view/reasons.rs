//! The enlarged ladder: the readings and the last minute of each layer, and the latest changes with their reasons.

use groundwave_protocol::status_codes::Layer;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put, split_top};
use crate::model::log::{Entry, Subject};
use crate::model::motors::Holder;
use crate::model::why;

/// First column of the readings: after key, glyph, name and state.
const COLUMN: u16 = 33;

/// Minimum and maximum width of the readings beside the last minute, columns.
const COLUMNS: [u16; 2] = [26, 40];

/// Width of the time and the share at the right, columns.
const RIGHT_COLUMNS: u16 = 22;

/// Width of the last minute, columns of six seconds each.
const MINUTE_COLUMNS: u16 = 10;

impl Screen<'_> {
    /// Draws the readings and the last minute beside the rungs, and the latest changes below. `taken` contains the widths of the rungs.
    pub(super) fn reasons(&self, buffer: &mut Buffer, area: Rect, taken: &[usize]) {
        let Some(state) = self.facts.robot.state_in_mode() else {
            return;
        };
        let layers = Layer::ALL.map(Some).into_iter().chain([None]);
        let (rungs, below) = split_top(area, layers.clone().count() as u16);
        let room = area.width.saturating_sub(COLUMN + RIGHT_COLUMNS);
        let [least, greatest] = COLUMNS;
        let beside = room.saturating_sub(MINUTE_COLUMNS + 4);
        let readings = Rect {
            x: area.x + COLUMN,
            width: beside.clamp(least, greatest).min(room),
            ..rungs
        };
        let minute = Rect {
            x: readings.right() + 2,
            width: MINUTE_COLUMNS,
            ..rungs
        };
        let has_minute = minute.right() + RIGHT_COLUMNS <= area.right();
        for ((row, layer), taken) in (0..).zip(layers).zip(taken) {
            if layer.is_some_and(|layer| self.facts.robot.lacks(layer)) {
                continue;
            }
            if let Some(layer) = layer {
                let text = why::reads(layer, &state.value, &self.facts.robot);
                let line = Line::styled(text, self.theme.dim);
                let x = readings.x.max(area.x + *taken as u16 + 1);
                let width = readings.right().saturating_sub(x);
                let line = self.cut(line, usize::from(width));
                put(
                    buffer,
                    Rect {
                        x,
                        width,
                        ..readings
                    },
                    row,
                    &line,
                );
            }
            if has_minute {
                let holder = layer.map_or(Holder::Prowl, Holder::Layer);
                let line = Line::styled(self.last_minute(holder), self.theme.trail);
                put(buffer, minute, row, &line);
            }
        }
        self.changes(buffer, below);
    }

    /// A holder's shares of the last minute as columns.
    fn last_minute(&self, holder: Holder) -> String {
        let glyphs = self.theme.glyphs;
        let shares = self.facts.motors.recent(holder);
        let first = shares.len().saturating_sub(MINUTE_COLUMNS.into());
        let column = |share: &f64| match (share * 8.0).ceil() as usize {
            0 => " ",
            eighths => glyphs.column[eighths.min(8) - 1],
        };
        shares[first..].iter().map(column).collect()
    }

    /// The latest changes of the holder and bumps, the newest first.
    fn changes(&self, buffer: &mut Buffer, area: Rect) {
        if area.height < 3 {
            return;
        }
        let heading = Line::styled("before, newest first", self.theme.dim);
        put(buffer, area, 1, &heading);
        let is_change =
            |entry: &&Entry| matches!(entry.subject, Subject::Behaviour | Subject::Bump);
        let changes = self.facts.log.newest_first().filter(is_change);
        for (row, entry) in (2..area.height).zip(changes) {
            let (glyph, style) = self.mark(entry);
            let s = entry.at.as_secs();
            let line = Line::from(vec![
                Span::styled(format!("{:02}:{:02} ", s / 60, s % 60), self.theme.dim),
                Span::styled(format!("{glyph} {}", entry.text), style),
            ]);
            put(buffer, area, row, &self.cut(line, usize::from(area.width)));
        }
    }
}
