//! Plots over time. A gap in the telemetry is a gap in the plot; an outage is shaded.
//!
//! Left and right differ without colours: the left trace is solid, the right one dotted, and each ends with its letter.
//! Ordered values are faint dots. With ASCII only, traces are letters.

use groundwave_protocol::telemetry::Reading;
use ratatui::buffer::Buffer;
use ratatui::layout::Rect;
use ratatui::text::{Line, Span};

use super::raster::{Ink, Raster};
use super::{Screen, put, put_right, split_right, split_top};
use crate::event::Moment;
use crate::model::plots::{self, Figure, Trace};
use crate::model::robot::{STATE_STALE, STATUS_STALE};
use crate::model::{Limits, Panel};

/// Width of names and figures at the left, columns.
const LABEL_COLUMNS: u16 = 15;

/// Minimum height of a plot, rows.
const ROWS_MIN: u16 = 3;

/// Width of the trace letters at the right, columns.
const LETTER_COLUMNS: u16 = 2;

/// The last label of a time axis.
const NOW: &str = "now|";

/// Minimum width for close time labels, columns.
const CLOSE_LABELS_WIDTH: u16 = 44;

/// A plot of one quantity, or of a pair.
pub(super) struct Plot {
    name: &'static str,
    unit: &'static str,
    /// Lower end of the axis, and the minimum upper end.
    low: i16,
    high: i16,
    /// Divisor of the displayed values.
    divisor: i16,
    traces: &'static [(&'static str, Trace, Ink)],
    /// Limits of the alarms, drawn as faint lines; a single limit is given twice.
    limits: Option<fn(&Limits) -> [i16; 2]>,
    /// The reading that the plot needs, if any.
    needs: Option<Reading>,
}

/// Traces from bottom to top: ordered under measured, left under right.
const WHEELS: Plot = Plot {
    name: "wheels",
    unit: "in/s",
    low: -12,
    high: 12,
    divisor: 1,
    traces: &[
        ("", Trace::OrderLeft, Ink::Furniture),
        ("", Trace::OrderRight, Ink::Furniture),
        ("L", Trace::WheelLeft, Ink::Left),
        ("R", Trace::WheelRight, Ink::Right),
    ],
    limits: None,
    needs: None,
};

const SONAR: Plot = Plot {
    name: "sonar",
    unit: "in",
    low: 0,
    high: 60,
    divisor: 1,
    traces: &[
        ("L", Trace::SonarLeft, Ink::Left),
        ("R", Trace::SonarRight, Ink::Right),
    ],
    limits: None,
    needs: Some(Reading::Sonars),
};

const DARKNESS: Plot = Plot {
    name: "darkness",
    unit: "%",
    low: 0,
    high: 100,
    divisor: 1,
    traces: &[
        ("L", Trace::DarkLeft, Ink::Left),
        ("R", Trace::DarkRight, Ink::Right),
    ],
    limits: None,
    needs: None,
};

const BATTERY: Plot = Plot {
    name: "battery",
    unit: "V",
    low: 105,
    high: 138,
    divisor: 10,
    traces: &[("", Trace::Battery, Ink::Trail)],
    limits: Some(|limits| [limits.battery_critical_dv, limits.battery_low_dv].map(whole)),
    needs: Some(Reading::Battery),
};

const LOSS: Plot = Plot {
    name: "not intact",
    unit: "%",
    low: 0,
    high: 20,
    divisor: 1,
    traces: &[("", Trace::Loss, Ink::Trail)],
    limits: Some(|limits| [i16::from(limits.loss_pct); 2]),
    needs: None,
};

const DAMAGED: Plot = Plot {
    name: "damaged",
    unit: "/ 20 s",
    low: 0,
    high: 10,
    divisor: 1,
    traces: &[("", Trace::Damaged, Ink::Trail)],
    limits: None,
    needs: None,
};

const AIR_DOWN: Plot = Plot {
    name: "airtime down",
    unit: "%",
    low: 0,
    high: 100,
    divisor: 1,
    traces: &[("", Trace::AirDown, Ink::Trail)],
    limits: None,
    needs: None,
};

const AIR_UP: Plot = Plot {
    name: "airtime up",
    unit: "%",
    low: 0,
    high: 100,
    divisor: 1,
    traces: &[("", Trace::AirUp, Ink::Trail)],
    limits: None,
    needs: None,
};

/// The plots of the panel.
const PLOTS: [&Plot; 5] = [&WHEELS, &SONAR, &DARKNESS, &BATTERY, &LOSS];

/// Plots under the sensors, the most important first.
pub(super) const OF_SENSORS: [&Plot; 4] = [&SONAR, &WHEELS, &BATTERY, &DARKNESS];

/// Plots under the link's figures, the most important first.
pub(super) const OF_LINK: [&Plot; 4] = [&LOSS, &DAMAGED, &AIR_DOWN, &AIR_UP];

fn whole(value: u16) -> i16 {
    i16::try_from(value).unwrap_or(i16::MAX)
}

impl Screen<'_> {
    pub(super) fn plots(&self, buffer: &mut Buffer, area: Rect) {
        let room = area.height.saturating_sub(2);
        let plots = self.drawable(&PLOTS);
        let together = (room / ROWS_MIN).clamp(1, plots.len() as u16);
        let pages = plots.len().div_ceil(usize::from(together));
        let page = self.page_of(Panel::Plots, pages);
        let turn = if pages > 1 {
            format!("  <turn-page-more> {}/{pages}", page + 1)
        } else {
            String::new()
        };
        let note = self.plot_window_words() + &self.with_keys(&turn);
        let note = Span::styled(note, self.theme.dim);
        let title = self.titled(Panel::Plots, "plots");
        let below = self.panel(buffer, area, &title, Some(note));
        let shown = plots.iter().skip(page * usize::from(together));
        let shown: Vec<_> = shown.take(usize::from(together)).copied().collect();
        self.plots_with_axis(buffer, below, &shown, together);
    }

    /// The plots for which the robot has the readings.
    fn drawable<'p>(&self, plots: &[&'p Plot]) -> Vec<&'p Plot> {
        let is_there = |plot: &&&Plot| plot.needs.is_none_or(|it| self.facts.robot.measures(it));
        plots.iter().filter(is_there).copied().collect()
    }

    /// Draws as many plots as fit, with their time axis.
    pub(super) fn plots_below(&self, buffer: &mut Buffer, area: Rect, plots: &[&Plot]) {
        let plots = self.drawable(plots);
        let together = (area.height.saturating_sub(1) / ROWS_MIN).min(plots.len() as u16);
        if together > 0 {
            let shown = &plots[..usize::from(together)];
            self.plots_with_axis(buffer, area, shown, together);
        }
    }

    fn plots_with_axis(&self, buffer: &mut Buffer, area: Rect, plots: &[&Plot], together: u16) {
        let rows = area.height.saturating_sub(1) / together;
        let mut below = area;
        for plot in plots {
            let (here, rest) = split_top(below, rows);
            self.plot(buffer, here, plot);
            below = rest;
        }
        // The axis and possibly empty rows follow.
        let (axis, _) = split_top(below, 1);
        let (_, axis) = split_picture(axis);
        self.time_labels(buffer, axis);
    }

    /// The time span of the plots, and the key that changes it, as text.
    pub(super) fn plot_window_words(&self) -> String {
        let window = length_words(self.plot_span().length());
        self.with_keys(&format!("<next-plot-window>: {window}"))
    }

    /// The time span of the plots.
    pub(super) fn plot_span(&self) -> plots::Span {
        self.facts.plots.span(self.ui.plot_window, self.now)
    }

    fn plot(&self, buffer: &mut Buffer, area: Rect, plot: &Plot) {
        let (label, picture) = split_picture(area);
        let dots = usize::from(picture.width) * 2;
        let plots = &self.facts.plots;
        let span = self.plot_span();
        let traces: Vec<_> = plot
            .traces
            .iter()
            .map(|&(letter, trace, ink)| (letter, plots.columns(trace, span, self.now, dots), ink))
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
        let limits = plot.limits.map(|limits| limits(&self.ui.config.limits));
        for limit in limits.into_iter().flatten() {
            let y = y(limit);
            raster.line((0.0, y), (dots as f64, y), 6, Ink::Furniture);
        }
        self.shade_outages(&mut raster, picture);
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

    /// Shades the outages, as `info` lists them.
    pub(super) fn shade_outages(&self, raster: &mut Raster, picture: Rect) {
        let dots = usize::from(picture.width) * 2;
        let bottom = f64::from(picture.height) * 4.0 - 1.0;
        let outages = self.facts.plots.outages(self.plot_span(), self.now, dots);
        for (begin, end) in outages {
            // Every other column; of an outage shorter than a column, the first.
            let (first, last) = (begin.floor() as usize, end.ceil() as usize);
            for x in (first..last.max(first + 1)).step_by(2) {
                raster.line((x as f64, 2.0), (x as f64, bottom), 4, Ink::Furniture);
            }
        }
    }

    /// Draws a plot's name, newest figures and range.
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
        if let Some(limits) = plot.limits
            && area.height > ROWS_MIN
        {
            let [limit, other] = limits(&self.ui.config.limits);
            let words = if limit == other {
                format!("limit {}", figure(limit))
            } else {
                format!("low {}, {}", figure(other), figure(limit))
            };
            put(buffer, area, 2, &Line::styled(words, theme.dim));
        }
        let last = area.height.saturating_sub(1).max(2);
        put(buffer, area, last, &Line::styled(range, theme.dim));
    }

    /// Draws the time axis.
    pub(super) fn time_labels(&self, buffer: &mut Buffer, area: Rect) {
        let window = self.plot_span().length();
        let every = label_step(window, area.width >= CLOSE_LABELS_WIDTH);
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
            // A label that would touch the last one is left out.
            if words.len() + 1 + NOW.len() <= usize::from(here.width) {
                put(buffer, here, 0, &Line::styled(words, self.theme.dim));
            }
            ago = ago.saturating_sub(every);
        }
        put_right(buffer, area, 0, &Line::styled(NOW, self.theme.dim));
    }
}

/// Splits an area into labels and picture, and leaves room for letters at the right.
pub(super) fn split_picture(area: Rect) -> (Rect, Rect) {
    let (label, picture) = split_right(area, area.width.saturating_sub(LABEL_COLUMNS));
    let width = picture.width.saturating_sub(LETTER_COLUMNS);
    (label, Rect { width, ..picture })
}

/// Draws a line through the known points. Level parts of a right trace are dotted.
pub(super) fn draw_trace<V: Figure>(
    raster: &mut Raster,
    columns: &[Option<(V, V)>],
    ink: Ink,
    y: impl Fn(V) -> f64,
) {
    let every = match ink {
        Ink::Right => 2,
        Ink::Furniture => 4,
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

/// Time between two labels of an axis: a fraction of the window, in whole seconds or, above a minute, whole minutes.
fn label_step(window: Moment, is_close: bool) -> Moment {
    let s = window.as_secs();
    let is_round = |parts: &u64| {
        let step_s = s / parts;
        s.is_multiple_of(*parts) && (step_s < 60 || step_s.is_multiple_of(60))
    };
    let parts = if is_close { [4, 5] } else { [2, 3] };
    let parts = parts.into_iter().find(is_round).unwrap_or(1);
    Moment::from_secs(s / parts)
}

/// A duration in its natural unit.
fn length_words(length: Moment) -> String {
    match length.as_secs() {
        s if s % 3600 == 0 => format!("{} h", s / 3600),
        s if s % 60 == 0 => format!("{} min", s / 60),
        s => format!("{s} s"),
    }
}
