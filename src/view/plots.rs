//! Figures over time. A gap in the telemetry is a gap in the plot.

use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::raster::{Ink, Raster};
use super::{Screen, put, split_right};
use crate::model::Panel;
use crate::model::plots::{Trace, WINDOWS};

/// Columns of names and figures at the left.
const LABEL_COLUMNS: u16 = 15;

/// Rows of a plot without which it says nothing.
const ROWS_MIN: u16 = 3;

const ROWS_MAX: u16 = 9;

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
            ("L", Trace::WheelLeft, Ink::Trail),
            ("R", Trace::WheelRight, Ink::Draft),
        ],
    },
    Plot {
        name: "sonar",
        unit: "in",
        low: 0,
        high: 60,
        divisor: 1,
        traces: &[
            ("L", Trace::SonarLeft, Ink::Trail),
            ("R", Trace::SonarRight, Ink::Draft),
        ],
    },
    Plot {
        name: "darkness",
        unit: "%",
        low: 0,
        high: 100,
        divisor: 1,
        traces: &[
            ("L", Trace::DarkLeft, Ink::Trail),
            ("R", Trace::DarkRight, Ink::Draft),
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
        let room = area.height.saturating_sub(1);
        let together = (room / ROWS_MIN).clamp(1, PLOTS.len() as u16);
        let pages = PLOTS.len().div_ceil(usize::from(together));
        let page = self.page_of(Panel::Plots, pages);
        let turn = if pages > 1 {
            format!("  PgDn {}/{pages}", page + 1)
        } else {
            String::new()
        };
        let (window, _) = WINDOWS[self.model.plots.window];
        let note = Span::styled(format!("T: {window}{turn}"), self.theme.dim);
        let mut below = self.panel(buffer, area, "plots", Some(note));
        let rows = (room / together).min(ROWS_MAX);
        let shown = PLOTS.iter().skip(page * usize::from(together));
        for plot in shown.take(usize::from(together)) {
            let (here, rest) = super::split_top(below, rows);
            self.plot(buffer, here, plot);
            below = rest;
        }
    }

    fn plot(&self, buffer: &mut Buffer, area: Rect, plot: &Plot) {
        let theme = &self.theme;
        let (label, picture) = split_right(area, area.width.saturating_sub(LABEL_COLUMNS));
        let dots = usize::from(picture.width) * 2;
        let traces: Vec<_> = plot
            .traces
            .iter()
            .map(|&(_, trace, ink)| (self.model.plots.columns(trace, self.now, dots), ink))
            .collect();
        let seen = traces.iter().flat_map(|(columns, _)| columns).flatten();
        let high = seen
            .map(|&(_, greatest)| greatest)
            .max()
            .unwrap_or(plot.high)
            .max(plot.high);
        let lowest = traces.iter().flat_map(|(columns, _)| columns).flatten();
        let low = lowest
            .map(|&(least, _)| least)
            .min()
            .unwrap_or(plot.low)
            .min(plot.low);
        let mut raster = Raster::new(picture);
        let height = f64::from(picture.height) * 4.0 - 1.0;
        let y = |value: i16| {
            let share = f64::from(value) - f64::from(low);
            (height - share / (f64::from(high) - f64::from(low)).max(1.0) * height).round()
        };
        for (columns, ink) in &traces {
            let mut last = None;
            for (x, column) in (0..).zip(columns) {
                let x = f64::from(x);
                if let Some((least, greatest)) = *column {
                    raster.line((x, y(least)), (x, y(greatest)), 1, *ink);
                    if let Some(last) = last {
                        raster.line((x - 1.0, y(last)), (x, y(least)), 1, *ink);
                    }
                }
                last = column.map(|(least, _)| least);
            }
        }
        raster.draw(buffer, picture, theme);
        let figure = |value: i16| match plot.divisor {
            1 => value.to_string(),
            divisor => format!("{:.1}", f64::from(value) / f64::from(divisor)),
        };
        let values = plot
            .traces
            .iter()
            .filter(|(side, ..)| !side.is_empty() || plot.traces.len() == 1);
        let now: Vec<String> = values
            .map(|(side, trace, _)| {
                let newest = self
                    .model
                    .plots
                    .newest(*trace)
                    .map_or("none".to_owned(), figure);
                format!("{side} {newest}").trim().to_owned()
            })
            .collect();
        let name = format!("{} {}", plot.name, plot.unit);
        put(buffer, label, 0, &Line::styled(name, theme.plain));
        put(buffer, label, 1, &Line::styled(now.join(" "), theme.strong));
        let range = format!("{} to {}", figure(low), figure(high));
        let last = label.height.saturating_sub(1).max(2);
        put(buffer, label, last, &Line::styled(range, theme.dim));
    }
}
