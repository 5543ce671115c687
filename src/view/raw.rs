//! The newest line as it came from the radio, under a ruler: any value can be traced to its columns.

use groundwave_protocol::LINE_BYTES;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::Line;

use super::{Screen, put};

const RULER: &str =
    "1...5...10...15...20...25...30...35...40...45...50...55...60...65...70...75...80";

impl Screen<'_> {
    pub(super) fn raw(&self, buffer: &mut Buffer, area: Rect) {
        let line = match self.model.link.newest_raw() {
            Some(raw) => Line::styled(printable(raw), self.theme.plain),
            None => self.no_line_yet(),
        };
        put(buffer, area, 0, &line);
    }

    fn no_line_yet(&self) -> Line<'static> {
        match (self.model.link.bytes(), self.instead_of_lines()) {
            (0, _) => Line::styled("no line yet", self.theme.dim),
            (bytes, Some(words)) => {
                Line::styled(format!("{bytes} bytes, {words}"), self.theme.warning)
            }
            (bytes, None) => Line::styled(format!("{bytes} bytes, no line yet"), self.theme.dim),
        }
    }

    pub(super) fn raw_with_ruler(&self, buffer: &mut Buffer, area: Rect) {
        let below = self.panel(buffer, area, "raw: the newest line", None);
        put(buffer, below, 0, &Line::styled(RULER, self.theme.dim));
        let row = Rect {
            y: below.y + 1.min(below.height),
            height: below.height.saturating_sub(1),
            ..below
        };
        self.raw(buffer, row);
        let counters = self.model.link.counters();
        let beside = |rect: Rect| Rect {
            x: rect.x + LINE_BYTES as u16 + 2,
            width: rect.width.saturating_sub(LINE_BYTES as u16 + 2),
            ..rect
        };
        let rejected = counters.crc_rejected + counters.shape_rejected + counters.field_rejected;
        let words = format!("{} lines, {rejected} rejected", counters.lines);
        put(buffer, beside(row), 0, &Line::styled(words, self.theme.dim));
    }
}

fn printable(raw: &[u8; LINE_BYTES]) -> String {
    raw.iter()
        .map(|&byte| match byte {
            b' '..=b'~' => char::from(byte),
            _ => ' ',
        })
        .collect()
}
