//! The fields of a robot's own lines, each with its newest value, history and age; the chosen field as a plot.

use groundwave_lines::{Role, Value};
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::raster::{Ink, Raster};
use super::text::First;
use super::{Screen, columns, put, split_bottom, split_right};
use crate::model::fields::{Known, words};
use crate::model::{Panel, age};

/// Width of a name and a value in the list, columns.
const NAME_COLUMNS: usize = 16;
const VALUE_COLUMNS: usize = 16;

/// Width of the age of a stale value, columns.
const AGE_COLUMNS: usize = 8;

/// Minimum width for a plot beside the list.
const BESIDE_WIDTH: u16 = 110;

/// Minimum and usual height of a plot under the list, with its time axis.
const PLOT_ROWS_MIN: u16 = 5;
const PLOT_ROWS: u16 = 9;

impl Screen<'_> {
    pub(super) fn fields(&self, buffer: &mut Buffer, area: Rect) {
        let fields = self.facts.fields.all();
        let chosen = self.ui.field.min(fields.len().saturating_sub(1));
        let rows = fields.len() as u16 + 1;
        let (list, plot) = if area.width >= BESIDE_WIDTH {
            split_right(area, area.width / 2)
        } else {
            let free = area.height.saturating_sub(rows.min(area.height / 2));
            split_bottom(
                area,
                if free < PLOT_ROWS_MIN {
                    0
                } else {
                    free.min(area.height / 2).max(PLOT_ROWS.min(free))
                },
            )
        };
        let width = usize::from(list.width);
        let mut lines: Vec<_> = (0..)
            .zip(fields)
            .map(|(n, known)| self.field_line(known, n == chosen, width))
            .collect();
        if lines.is_empty() {
            lines.push(Line::styled("no value yet", self.theme.dim));
        }
        let turned = self.ui.page != 0;
        let shown = usize::from(list.height.saturating_sub(1)).max(1);
        // The page of the chosen field, unless the operator turned the pages.
        let skipped = if turned { 0 } else { chosen / shown * shown };
        let note = Span::styled(self.fields_note(), self.theme.dim);
        self.pages(
            buffer,
            list,
            (Panel::Fields, "fields"),
            Some(note),
            &lines[skipped..],
            First::Top,
        );
        if let Some(known) = fields.get(chosen).filter(|_| plot.height >= PLOT_ROWS_MIN) {
            self.field_plot(buffer, plot, known);
        }
    }

    fn fields_note(&self) -> String {
        let fields = &self.facts.fields;
        let counts = [(fields.damaged, "damaged"), (fields.lost, "lost")];
        let counts = counts.iter().filter(|(count, _)| *count > 0);
        let words: Vec<_> = counts
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        words.join(", ")
    }

    fn field_line(&self, known: &Known, is_chosen: bool, width: usize) -> Line<'static> {
        let theme = &self.theme;
        let is_stale = known.age(self.now) >= known.stale_after();
        let style = if is_stale { theme.dim } else { theme.strong };
        let name_style = if is_chosen { theme.lit } else { theme.plain };
        let unit = known.field.unit.as_deref().unwrap_or_default();
        let value = format!("{} {unit}", known.words());
        let name_columns = NAME_COLUMNS.min(width / 3);
        let room = width.saturating_sub(name_columns + VALUE_COLUMNS + AGE_COLUMNS + 3);
        let sparkline = match known.value {
            Value::Number(_) => self.sparkline(known, room),
            Value::Text(_) => " ".repeat(room),
        };
        let age = if is_stale {
            format!(
                " {} {}",
                theme.glyphs.stale,
                age::words(known.age(self.now))
            )
        } else {
            String::new()
        };
        let fitted = |text: &str, width: usize| {
            let cut = self.cut(Line::raw(text.to_owned()), width);
            let text: String = cut.spans.iter().map(|span| span.content.as_ref()).collect();
            let gap = width.saturating_sub(columns(&text));
            text + &" ".repeat(gap)
        };
        let is_text = matches!(known.value, Value::Text(_));
        let value_columns = VALUE_COLUMNS + if is_text { room + 1 } else { 0 };
        let mut spans = vec![
            Span::styled(fitted(&known.field.name, name_columns), name_style),
            Span::raw(" "),
            Span::styled(fitted(value.trim_end(), value_columns), style),
        ];
        if !is_text {
            spans.push(Span::raw(" "));
            spans.push(Span::styled(sparkline, theme.trail));
        }
        spans.push(Span::styled(age, theme.warning));
        Line::from(spans)
    }

    /// The history of a field over the plots' time, as a sparkline.
    fn sparkline(&self, known: &Known, width: usize) -> String {
        let steps = known.series.columns(self.plot_span(), self.now, width);
        let (low, high) = range(&steps);
        let glyphs = self.theme.glyphs.column;
        let glyph = |step: &Option<(f32, f32)>| match step {
            None => " ",
            Some((least, greatest)) => {
                let share = (f32::midpoint(*least, *greatest) - low) / (high - low);
                let last = glyphs.len() - 1;
                let level = if high > low {
                    share * last as f32
                } else {
                    last as f32 / 2.0
                };
                glyphs[(level.round() as usize).min(last)]
            }
        };
        steps.iter().map(glyph).collect()
    }

    /// Draws the history of a field with its range and time axis.
    fn field_plot(&self, buffer: &mut Buffer, area: Rect, known: &Known) {
        let unit = known.field.unit.as_deref().unwrap_or_default();
        let name = format!("{} {unit}", known.field.name);
        let window = self.plot_window_words();
        let note = Span::styled(window, self.theme.dim);
        let below = self.panel(buffer, area, name.trim_end(), Some(note));
        let (below, axis) = split_bottom(below, 1);
        let picture = super::plots::split_picture(below).1;
        let dots = usize::from(picture.width) * 2;
        let steps = known.series.columns(self.plot_span(), self.now, dots);
        let (low, high) = range(&steps);
        let height = f64::from(picture.height) * 4.0 - 1.0;
        let y = |value: f32| {
            let share = f64::from((value - low) / (high - low));
            let share = if high > low { share } else { 0.5 };
            (height - share * height).round()
        };
        let mut raster = Raster::new(picture);
        self.shade_outages(&mut raster, picture);
        super::plots::draw_trace(&mut raster, &steps, Ink::Trail, y);
        raster.draw(buffer, picture, &self.theme);
        let label = Rect {
            width: picture.x.saturating_sub(below.x),
            ..below
        };
        let mut say = |row: u16, end: f32| {
            let text = Line::styled(words(end.into()), self.theme.dim);
            put(
                buffer,
                label,
                row,
                &self.cut(text, usize::from(label.width)),
            );
        };
        if high.is_finite() && low.is_finite() {
            say(0, high);
            say(below.height.saturating_sub(1), low);
        }
        self.time_labels(buffer, super::plots::split_picture(axis).1);
    }

    /// Mode and battery by the roles of fields, for the status row.
    pub(super) fn roles_at_a_glance(&self) -> Vec<Span<'static>> {
        let mut spans = Vec::new();
        for role in [Role::Mode, Role::Battery] {
            let Some(known) = self.facts.fields.of(role) else {
                continue;
            };
            let is_stale = known.age(self.now) >= known.stale_after();
            let style = if is_stale {
                self.theme.dim
            } else {
                self.theme.strong
            };
            let old = self.old_mark(known.age(self.now), known.stale_after());
            let text = match (role, known.standard()) {
                (Role::Battery, Some(volts)) => format!("{volts:.1} V"),
                _ => known.words(),
            };
            spans.push(Span::styled(format!("  {old}{text}"), style));
        }
        spans
    }
}

/// Minimum and maximum of all columns; not finite without a value.
fn range(columns: &[Option<(f32, f32)>]) -> (f32, f32) {
    let known = columns.iter().flatten();
    known.fold(
        (f32::INFINITY, f32::NEG_INFINITY),
        |(low, high), (least, greatest)| (low.min(*least), high.max(*greatest)),
    )
}
