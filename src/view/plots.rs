//! Figures over time. A gap in the telemetry is a gap in the plot.
//!
//! Left and right are told apart without colours: the left one is drawn through, the right one in dots, and each has its
//! letter at its newest end. What was asked for is fainter dots still. Where there is only ASCII they are letters.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::raster::{Ink, Raster};
use super::{Screen, put, put_right, split_right, split_top};
use crate::event::Moment;
use crate::model::Panel;
use crate::model::plots::{Trace, WINDOWS};
use crate::model::robot::{STATE_STALE, STATUS_STALE};

/// Columns of names and figures at the left.
const LABEL_COLUMNS: u16 = 15;

/// Rows of a plot without which it says nothing.
const ROWS_MIN: u16 = 3;

const ROWS_MAX: u16 = 9;

/// Columns right of the plots, for the letters of their traces.
const LETTER_COLUMNS: u16 = 2;

/// From so many columns up the time has closer labels.
const CLOSE_LABELS_WIDTH: u16 = 44;

/// Seconds from one label of the time to the next for each window: far apart, and close.
const LABELS_EVERY_S: [[u64; 2]; WINDOWS.len()] =
    [[30, 15], [300, 120], [3600, 1800], [43_200, 21_600]];

struct Plot {
    name: &'static str,
    unit: &'static str,
    /// Lower end, and the least that the upper end may be.
    low: i16,
    high: i16,
    /// Figures are shown divided by this.
    divisor: i16,
    traces: &'static [(&'static str, Trace, Ink)],
}

/// What was ordered lies under what was measured; left under right.
const PLOTS: [Plot; 5] = [
    Plot {
        name: "wheels",
        unit: "in/s",
        low: -12,
        high: 12,
        divisor: 1,
        traces: &[
            ("", Trace::OrderLeft, Ink::Wall),
            ("", Trace::OrderRight, Ink::Wall),
            ("L", Trace::WheelLeft, Ink::Left),
            ("R", Trace::WheelRight, Ink::Right),
        ],
    },
    Plot {
        name: "sonar",
        unit: "in",
        low: 0,
        high: 60,
        divisor: 1,
        traces: &[
            ("L", Trace::SonarLeft, Ink::Left),
            ("R", Trace::SonarRight, Ink::Right),
        ],
    },
    Plot {
        name: "darkness",
        unit: "%",
        low: 0,
        high: 100,
        divisor: 1,
        traces: &[
            ("L", Trace::DarkLeft, Ink::Left),
            ("R", Trace::DarkRight, Ink::Right),
        ],
    },
    Plot {
        name: "battery",
        unit: "V",
        low: 105,
        high: 138,
        divisor: 10,
        traces: &[("", Trace::Battery, Ink::Trail)],
    },
    Plot {
        name: "loss",
        unit: "%",
        low: 0,
        high: 20,
        divisor: 1,
        traces: &[("", Trace::Loss, Ink::Trail)],
    },
];

impl Screen<'_> {
    pub(super) fn plots(&self, buffer: &mut Buffer, area: Rect) {
        let room = area.height.saturating_sub(2);
        let together = (room / ROWS_MIN).clamp(1, PLOTS.len() as u16);
        let pages = PLOTS.len().div_ceil(usize::from(together));
        let page = self.page_of(Panel::Plots, pages);
        let turn = if pages > 1 {
            format!("  <turn-page-more> {}/{pages}", page + 1)
        } else {
            String::new()
        };
        let (window, _) = WINDOWS[self.ui.plot_window];
        let note = self.told(&format!("<next-plot-window>: {window}{turn}"));
        let note = Span::styled(note, self.theme.dim);
        let title = self.titled(Panel::Plots, "plots");
        let mut below = self.panel(buffer, area, &title, Some(note));
        let rows = (room / together).min(ROWS_MAX);
        let shown = PLOTS.iter().skip(page * usize::from(together));
        for plot in shown.take(usize::from(together)) {
            let (here, rest) = split_top(below, rows);
            self.plot(buffer, here, plot);
            below = rest;
        }
        // What is left is the axis and perhaps some free rows.
        let (axis, _) = split_top(below, 1);
        let (_, axis) = split_picture(axis);
        self.time_labels(buffer, axis);
    }

    fn plot(&self, buffer: &mut Buffer, area: Rect, plot: &Plot) {
        let (label, picture) = split_picture(area);
        let dots = usize::from(picture.width) * 2;
        let plots = &self.facts.plots;
        let traces: Vec<_> = plot
            .traces
            .iter()
            .map(|&(letter, trace, ink)| {
                (
                    letter,
                    plots.columns(trace, self.ui.plot_window, self.now, dots),
                    ink,
                )
            })
            .collect();
        let seen = || traces.iter().flat_map(|(_, columns, _)| columns).flatten();
        let high = seen().map(|&(_, greatest)| greatest).max();
        let high = high.unwrap_or(plot.high).max(plot.high);
        let low = seen().map(|&(least, _)| least).min();
        let low = low.unwrap_or(plot.low).min(plot.low);
        let height = f64::from(picture.height) * 4.0 - 1.0;
        let y = |value: i16| {
            let share = f64::from(value) - f64::from(low);
            (height - share / (f64::from(high) - f64::from(low)).max(1.0) * height).round()
        };
        let mut raster = Raster::new(picture);
        let mut letters = vec![String::new(); usize::from(picture.height)];
        for (letter, columns, ink) in &traces {
            draw_trace(&mut raster, columns, *ink, y);
            let newest = columns.iter().rev().flatten().next();
            let row = newest.map(|&(_, value)| (y(value) / 4.0) as usize);
            if let Some(at) = row.and_then(|row| letters.get_mut(row)) {
                at.push_str(letter);
            }
        }
        raster.draw(buffer, picture, &self.theme);
        let beside = Rect {
            x: picture.right(),
            width: LETTER_COLUMNS,
            ..picture
        };
        for (row, letters) in (0..).zip(letters) {
            put(
                buffer,
                beside,
                row,
                &Line::styled(letters, self.theme.strong),
            );
        }
        self.plot_label(buffer, label, plot, (low, high));
    }

    /// What it is, the newest figures and how far the plot reaches.
    fn plot_label(&self, buffer: &mut Buffer, area: Rect, plot: &Plot, (low, high): (i16, i16)) {
        let theme = &self.theme;
        let figure = |value: i16| match plot.divisor {
            1 => value.to_string(),
            divisor => format!("{:.1}", f64::from(value) / f64::from(divisor)),
        };
        let named = plot
            .traces
            .iter()
            .filter(|(letter, ..)| !letter.is_empty() || plot.traces.len() == 1);
        let mut is_stale = false;
        let newest: Vec<String> = named
            .map(|(letter, trace, _)| {
                let Some((at, value)) = self.facts.plots.newest(*trace) else {
                    return format!("{letter} none").trim().to_owned();
                };
                let stale_after = match trace {
                    Trace::Battery => STATUS_STALE,
                    _ => STATE_STALE,
                };
                is_stale |= self.now.saturating_sub(at) >= stale_after;
                format!("{letter} {}", figure(value)).trim().to_owned()
            })
            .collect();
        let name = format!("{} {}", plot.name, plot.unit);
        put(buffer, area, 0, &Line::styled(name, theme.plain));
        let mut words = newest.join(" ");
        let mut style = theme.strong;
        if is_stale {
            words = format!("{} {words}", theme.glyphs.stale);
            style = theme.dim;
        }
        put(buffer, area, 1, &Line::styled(words, style));
        let range = format!("{} to {}", figure(low), figure(high));
        let last = area.height.saturating_sub(1).max(2);
        put(buffer, area, last, &Line::styled(range, theme.dim));
    }

    /// How long ago, under the plots.
    fn time_labels(&self, buffer: &mut Buffer, area: Rect) {
        let chosen = self.ui.plot_window;
        let (_, window) = WINDOWS[chosen];
        let is_close = usize::from(area.width >= CLOSE_LABELS_WIDTH);
        let every = Moment::from_secs(LABELS_EVERY_S[chosen][is_close]);
        let mut ago = window;
        while ago > Moment::ZERO {
            let share = 1.0 - ago.as_secs_f64() / window.as_secs_f64();
            let column = (share * f64::from(area.width)).round() as u16;
            let here = Rect {
                x: area.x + column,
                width: area.width.saturating_sub(column),
                ..area
            };
            let words = format!("|-{}", length_words(ago));
            put(buffer, here, 0, &Line::styled(words, self.theme.dim));
            ago = ago.saturating_sub(every);
        }
        put_right(buffer, area, 0, &Line::styled("now|", self.theme.dim));
    }
}

/// The labels' columns and the picture's, with room for letters right of it.
fn split_picture(area: Rect) -> (Rect, Rect) {
    let (label, picture) = split_right(area, area.width.saturating_sub(LABEL_COLUMNS));
    let width = picture.width.saturating_sub(LETTER_COLUMNS);
    (label, Rect { width, ..picture })
}

/// A line through what is known. Where it is level, a trace that is not the left one of a pair is only dots.
fn draw_trace(
    raster: &mut Raster,
    columns: &[Option<(i16, i16)>],
    ink: Ink,
    y: impl Fn(i16) -> f64,
) {
    let every = match ink {
        Ink::Right => 2,
        Ink::Wall => 4,
        _ => 1,
    };
    let mut last = None;
    for (n, column) in columns.iter().enumerate() {
        let x = n as f64;
        if let Some((least, greatest)) = *column {
            let is_level = least == greatest && last.is_none_or(|last| last == least);
            if !is_level || n % every == 0 {
                raster.line((x, y(least)), (x, y(greatest)), 1, ink);
                if let Some(last) = last.filter(|_| !is_level || every == 1) {
                    raster.line((x - 1.0, y(last)), (x, y(least)), 1, ink);
                }
            }
        }
        last = column.map(|(least, _)| least);
    }
}

/// A length of time in its own unit.
fn length_words(length: Moment) -> String {
    match length.as_secs() {
        s if s % 3600 == 0 => format!("{} h", s / 3600),
        s if s % 60 == 0 => format!("{} min", s / 60),
        s => format!("{s} s"),
    }
}
