//! The newest line as received, under a ruler: each value can be traced to its columns.

use groundwave_protocol::LINE_BYTES;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::{Screen, put};
use crate::model::trace::{FIELDS, Field};
use crate::model::{Overlay, age, printable};
use groundwave_captures::words::counted;

const RULER: &str =
    "1...5...10...15...20...25...30...35...40...45...50...55...60...65...70...75...80";

impl Screen<'_> {
    pub(super) fn raw(&self, buffer: &mut Buffer, area: Rect) {
        if let Some(field) = self.traced() {
            put(buffer, area, 0, &self.lit(field));
            return;
        }
        let line = match self.facts.link.newest_raw() {
            Some(raw) => Line::styled(printable(raw), self.theme.plain),
            None => match &self.facts.fields.newest {
                Some(text) => self.own_line(text, area),
                None => self.no_line_yet(),
            },
        };
        put(buffer, area, 0, &line);
    }

    /// A line of the robot's own.
    fn own_line(&self, text: &str, area: Rect) -> Line<'static> {
        let text = text.replace('\t', " ");
        self.cut(Line::styled(text, self.theme.plain), area.width.into())
    }

    /// The traced value.
    fn traced(&self) -> Option<&'static Field> {
        match self.ui.overlay {
            Overlay::Trace(at) => FIELDS.get(at),
            _ => None,
        }
    }

    /// The newest line with the traced value, its columns highlighted.
    fn lit(&self, field: &Field) -> Line<'static> {
        let theme = &self.theme;
        let letter = char::from(field.line_type.letter());
        let Some(raw) = self.facts.link.newest_of(field.line_type) else {
            return Line::styled(format!("no line {letter} yet"), theme.dim);
        };
        let text = printable(&raw.value);
        let (first, last) = field.columns;
        let part = |from: usize, to: usize| text.get(from..to).unwrap_or_default().to_owned();
        Line::from(vec![
            Span::styled(part(0, first - 1), theme.dim),
            Span::styled(part(first - 1, last), theme.lit),
            Span::styled(part(last, text.len()), theme.dim),
        ])
    }

    /// The traced value as text.
    pub(super) fn trace_words(&self) -> Option<Line<'static>> {
        let field = self.traced()?;
        let letter = char::from(field.line_type.letter());
        let (first, last) = field.columns;
        let columns = if first == last {
            format!("column {first}")
        } else {
            format!("columns {first}-{last}")
        };
        let says = match self.facts.link.newest_of(field.line_type) {
            Some(raw) => {
                let text = printable(&raw.value);
                let value = text.get(first - 1..last).unwrap_or_default();
                let age = age::words(raw.age(self.now));
                format!("`{value}`, {age} old")
            }
            None => "none came yet".to_owned(),
        };
        let text = format!("{}: line {letter}, {columns}: {says}", field.name);
        Some(Line::styled(text, self.theme.strong))
    }

    fn no_line_yet(&self) -> Line<'static> {
        match (self.facts.link.bytes(), self.instead_of_lines()) {
            (0, _) => Line::styled("no line yet", self.theme.dim),
            (bytes, Some(words)) => Line::styled(
                format!("{}, {words}", counted(bytes, "byte")),
                self.theme.warning,
            ),
            (bytes, None) => Line::styled(
                format!("{}, no line yet", counted(bytes, "byte")),
                self.theme.dim,
            ),
        }
    }

    pub(super) fn raw_with_ruler(&self, buffer: &mut Buffer, area: Rect) {
        let below = self.panel(buffer, area, "raw: the newest line", None);
        if self.facts.link.has_only_own_lines() {
            self.raw(buffer, below);
            let fields = &self.facts.fields;
            let words = format!(
                "{}, {} damaged",
                counted(fields.lines, "line"),
                fields.damaged
            );
            put(buffer, below, 1, &Line::styled(words, self.theme.dim));
            return;
        }
        put(buffer, below, 0, &Line::styled(RULER, self.theme.dim));
        let row = Rect {
            y: below.y + 1.min(below.height),
            height: below.height.saturating_sub(1),
            ..below
        };
        self.raw(buffer, row);
        let counters = self.facts.link.counters();
        let beside = |rect: Rect| Rect {
            x: rect.x + LINE_BYTES as u16 + 2,
            width: rect.width.saturating_sub(LINE_BYTES as u16 + 2),
            ..rect
        };
        let damaged = counters.damaged.total();
        let acks = match counters.ack_lines - counters.other_ack_lines {
            0 => String::new(),
            lines => format!(" + {lines} K"),
        };
        let lines = counted(counters.lines - counters.other_lines, "line");
        let words = format!("{lines}{acks}, {damaged} damaged");
        put(buffer, beside(row), 0, &Line::styled(words, self.theme.dim));
    }
}
