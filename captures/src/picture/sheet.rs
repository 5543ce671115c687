//! The sheet of a picture: title, axes in feet, grid, legend and notes around the plot.

use super::Picture;
use super::font::Font;
use super::mark::{self, Symbol};
use super::shape::{Anchor, Color, FRAME, GRID, INK, Layer, PALE_INK, Shape, Spot, Text};
use crate::track::Place;

/// Longer and shorter side of the sheet, pixels. A long legend makes the sheet longer.
const PAPER_LONG: f32 = 1400.0;
const PAPER_SHORT: f32 = 990.0;

/// Minimum width of the sheet for the title, pixels.
const WIDTH_MIN: f32 = 760.0;

/// Minimum height of the plot, pixels.
const PLOT_MIN: f32 = 300.0;

const MARGIN: f32 = 36.0;

/// Height of title and facts, width left of the plot, and height below the plot, pixels.
const HEADER: f32 = 84.0;
const LEFT: f32 = 74.0;
const BELOW: f32 = 58.0;

/// Gap between plot and legend; row height, symbol width and maximum text width of the legend, pixels.
const GUTTER: f32 = 28.0;
const ROW: f32 = 25.0;
const SYMBOL: f32 = 46.0;
const LEGEND_TEXT_MAX: f32 = 400.0;

/// Height of a line of the notes, pixels.
const NOTE_ROW: f32 = 19.0;

/// Sizes of the letters, pixels.
const TITLE: f32 = 27.0;
const PLAIN: f32 = 15.0;
const TICK: f32 = 14.0;
const NOTE: f32 = 13.0;

/// Number of inches per foot.
const FOOT_IN: f32 = 12.0;

/// Minimum width and height of the area shown, inches.
const SPAN_MIN_IN: f32 = 36.0;

/// Minimum distance between two ticks, pixels.
const TICK_MIN: f32 = 84.0;

/// A row of the legend.
pub(super) struct Row {
    pub(super) symbol: Option<Symbol>,
    pub(super) text: String,
    pub(super) is_bold: bool,
}

impl Row {
    pub(super) fn new(symbol: impl Into<Option<Symbol>>, text: impl Into<String>) -> Self {
        Self {
            symbol: symbol.into(),
            text: text.into(),
            is_bold: false,
        }
    }
}

/// Content of a sheet besides its plot.
pub(super) struct Plan {
    pub(super) title: String,
    /// Facts below the title.
    pub(super) facts: Vec<String>,
    /// Blocks of the legend, each of which stays together.
    pub(super) legend: Vec<Vec<Row>>,
    /// Notes below the plot.
    pub(super) notes: Vec<String>,
    /// Minimum and maximum x and y of the plot, inches.
    pub(super) bounds_in: [(f32, f32); 2],
}

/// A plot on its sheet; converts inches to pixels.
pub(super) struct Sheet {
    size: (f32, f32),
    /// Left, top, right and bottom of the plot, pixels.
    plot: [f32; 4],
    pub(super) pixels_per_in: f32,
    /// Position of the plot's top left corner, inches.
    corner_in: Place,
    notes: Vec<String>,
    /// Top left corner of each block of the legend, pixels.
    blocks: Vec<Spot>,
}

impl Sheet {
    /// Lays out a plan in landscape or portrait, whichever shows the plot larger.
    pub(super) fn new(font: &Font, plan: &Plan) -> Self {
        let [landscape, portrait] = [true, false].map(|wide| Self::oriented(font, plan, wide));
        if portrait.pixels_per_in > landscape.pixels_per_in {
            portrait
        } else {
            landscape
        }
    }

    fn oriented(font: &Font, plan: &Plan, is_landscape: bool) -> Self {
        let [x, y] = plan.bounds_in;
        let span_in = |(from, to): (f32, f32)| (to - from).max(SPAN_MIN_IN) * 1.08;
        let (width_in, height_in) = (span_in(x), span_in(y));
        let rows: Vec<usize> = plan.legend.iter().map(Vec::len).collect();
        let texts = plan.legend.iter().flatten();
        let text_width = texts
            .map(|row| font.width(&row.text, PLAIN).min(LEGEND_TEXT_MAX))
            .fold(0.0, f32::max);
        let column = (SYMBOL + text_width + 4.0).ceil();
        let (paper_width, paper_height) = if is_landscape {
            (PAPER_LONG, PAPER_SHORT)
        } else {
            (PAPER_SHORT, PAPER_LONG)
        };
        let aside = if is_landscape { GUTTER + column } else { 0.0 };
        let most_width = paper_width - 2.0 * MARGIN - LEFT - aside;
        let columns = if is_landscape {
            1
        } else {
            ((paper_width - 2.0 * MARGIN) / (column + GUTTER)).max(1.0) as usize
        };
        let (places, legend_height) = blocks(&rows, columns);
        let under = if is_landscape {
            0.0
        } else {
            legend_height + GUTTER
        };
        let notes_in = |width: f32| {
            let notes = plan.notes.iter();
            let lines = notes.flat_map(|note| font.wrap(note, NOTE, width - 2.0 * MARGIN));
            lines.collect::<Vec<String>>()
        };
        let notes_height = notes_in(paper_width).len() as f32 * NOTE_ROW;
        let fixed = 2.0 * MARGIN + HEADER + BELOW + under + notes_height;
        let most_height = (paper_height - fixed).max(PLOT_MIN);
        let pixels_per_in = (most_width / width_in).min(most_height / height_in);
        let least_height = if is_landscape {
            legend_height.max(PLOT_MIN)
        } else {
            PLOT_MIN
        };
        let height = (height_in * pixels_per_in).max(least_height).round();
        let least_width = WIDTH_MIN - 2.0 * MARGIN - LEFT - aside;
        let width = (width_in * pixels_per_in)
            .max(least_width)
            .min(most_width)
            .round();
        let paper_width = width + 2.0 * MARGIN + LEFT + aside;
        let notes = notes_in(paper_width);
        let (left, top) = (MARGIN + LEFT, MARGIN + HEADER);
        let (right, bottom) = (left + width, top + height);
        let legend_at = if is_landscape {
            (right + GUTTER, top)
        } else {
            (MARGIN, bottom + BELOW + GUTTER / 2.0)
        };
        let blocks = places.into_iter().map(|(column_number, row)| {
            let x = legend_at.0 + column_number as f32 * (column + GUTTER);
            (x, legend_at.1 + row as f32 * ROW)
        });
        let notes_height = notes.len() as f32 * NOTE_ROW;
        Self {
            size: (
                paper_width.ceil(),
                (bottom + BELOW + under + notes_height + MARGIN).ceil(),
            ),
            plot: [left, top, right, bottom],
            pixels_per_in,
            corner_in: (
                f32::midpoint(x.0, x.1) - width / pixels_per_in / 2.0,
                f32::midpoint(y.0, y.1) + height / pixels_per_in / 2.0,
            ),
            notes,
            blocks: blocks.collect(),
        }
    }

    /// Converts a place in inches to pixels; +Y is up.
    pub(super) fn spot(&self, (x_in, y_in): Place) -> Spot {
        let (left_in, top_in) = self.corner_in;
        (
            self.plot[0] + (x_in - left_in) * self.pixels_per_in,
            self.plot[1] + (top_in - y_in) * self.pixels_per_in,
        )
    }

    /// Whether a spot is in the plot, at least `margin` from its edge.
    pub(super) fn is_in_plot(&self, (x, y): Spot, margin: f32) -> bool {
        let [left, top, right, bottom] = self.plot;
        let is_between = |at: f32, from: f32, to: f32| from + margin <= at && at <= to - margin;
        is_between(x, left, right) && is_between(y, top, bottom)
    }

    /// The picture of a plan with the layers of its plot.
    pub(super) fn picture(self, font: &Font, plan: Plan, plot: Vec<Layer>) -> Picture {
        let mut layers = Vec::new();
        let mut add = |name, shapes: Vec<Shape>| {
            if !shapes.is_empty() {
                layers.push(Layer { name, shapes });
            }
        };
        let (grid, axes) = self.axes(font);
        add("grid", grid);
        for layer in plot {
            add(layer.name, layer.shapes);
        }
        add("axes", axes);
        add("title", self.title(font, &plan));
        add("legend", self.legend(font, &plan.legend));
        add("notes", self.note_shapes());
        Picture {
            size: self.size,
            title: plan.title,
            layers,
        }
    }

    fn title(&self, font: &Font, plan: &Plan) -> Vec<Shape> {
        let width = self.size.0 - 2.0 * MARGIN;
        let mut title = Text::new(
            (MARGIN, MARGIN + 24.0),
            font.fit(&plan.title, TITLE, width - 2.0),
            TITLE,
            INK,
        );
        title.is_bold = true;
        let facts = font.fit(&plan.facts.join("  ·  "), PLAIN, width);
        let facts = Text::new((MARGIN, MARGIN + 54.0), facts, PLAIN, PALE_INK);
        vec![Shape::Text(title), Shape::Text(facts)]
    }

    fn legend(&self, font: &Font, blocks: &[Vec<Row>]) -> Vec<Shape> {
        let mut shapes = Vec::new();
        for (rows, &(left, top)) in blocks.iter().zip(&self.blocks) {
            for (number, row) in rows.iter().enumerate() {
                let y = top + ROW * (number as f32 + 0.5);
                if let Some(symbol) = row.symbol {
                    mark::draw(&mut shapes, font, symbol, (left + SYMBOL / 2.0 - 5.0, y));
                }
                if row.text.is_empty() {
                    continue;
                }
                let text = font.fit(&row.text, PLAIN, LEGEND_TEXT_MAX);
                let mut text = Text::new((left + SYMBOL, y + 5.0), text, PLAIN, INK);
                text.is_bold = row.is_bold;
                shapes.push(Shape::Text(text));
            }
        }
        shapes
    }

    fn note_shapes(&self) -> Vec<Shape> {
        let top = self.size.1 - MARGIN - self.notes.len() as f32 * NOTE_ROW;
        let line = |(number, note): (usize, &String)| {
            let y = top + NOTE_ROW * (number as f32 + 0.8);
            Shape::Text(Text::new((MARGIN, y), note, NOTE, PALE_INK))
        };
        self.notes.iter().enumerate().map(line).collect()
    }

    /// The grid, and the axes over the plot.
    fn axes(&self, font: &Font) -> (Vec<Shape>, Vec<Shape>) {
        let [left, top, right, bottom] = self.plot;
        let (mut grid, mut axes) = (Vec::new(), Vec::new());
        let step_ft = step_ft(self.pixels_per_in * FOOT_IN);
        let line = |from: Spot, to: Spot, width: f32, color: Color| {
            Shape::line(vec![from, to], width, color)
        };
        let label = |at: Spot, text: String, anchor: Anchor| {
            let text = Text::new(at, text, TICK, PALE_INK);
            Shape::Text(Text { anchor, ..text })
        };
        let (left_in, top_in) = self.corner_in;
        let right_in = left_in + (right - left) / self.pixels_per_in;
        let bottom_in = top_in - (bottom - top) / self.pixels_per_in;
        for feet in ticks(left_in / FOOT_IN, right_in / FOOT_IN, step_ft) {
            let (x, _) = self.spot((feet * FOOT_IN, 0.0));
            grid.push(line((x, top), (x, bottom), 1.0, GRID));
            axes.push(line((x, bottom), (x, bottom + 6.0), 1.2, FRAME));
            axes.push(label((x, bottom + 22.0), tick_words(feet), Anchor::Middle));
        }
        let mut widest = 0.0_f32;
        for feet in ticks(bottom_in / FOOT_IN, top_in / FOOT_IN, step_ft) {
            let (_, y) = self.spot((0.0, feet * FOOT_IN));
            grid.push(line((left, y), (right, y), 1.0, GRID));
            axes.push(line((left - 6.0, y), (left, y), 1.2, FRAME));
            let words = tick_words(feet);
            widest = widest.max(font.width(&words, TICK));
            axes.push(label((left - 10.0, y + 5.0), words, Anchor::End));
        }
        axes.push(Shape::line(
            vec![
                (left, top),
                (right, top),
                (right, bottom),
                (left, bottom),
                (left, top),
            ],
            1.2,
            FRAME,
        ));
        let middle = (f32::midpoint(left, right), f32::midpoint(top, bottom));
        for (at, words, is_upward) in [
            ((middle.0, bottom + 46.0), "x, feet", false),
            ((left - 22.0 - widest, middle.1), "y, feet", true),
        ] {
            axes.push(Shape::Text(Text {
                anchor: Anchor::Middle,
                is_upward,
                ..Text::new(at, words, PLAIN, PALE_INK)
            }));
        }
        (grid, axes)
    }
}

/// Column and row of each legend block for a number of columns, and the height of the legend, pixels.
fn blocks(rows: &[usize], columns: usize) -> (Vec<(usize, usize)>, f32) {
    let all: usize = rows.iter().sum();
    let most = rows.iter().copied().max().unwrap_or(0);
    let height = |limit: usize| {
        let (mut column, mut used) = (0, 0);
        let mut places = Vec::new();
        for &count in rows {
            if used > 0 && used + count > limit {
                column += 1;
                used = 0;
            }
            places.push((column, used));
            used += count;
        }
        (places, column)
    };
    let limit = (most..=all).find(|limit| height(*limit).1 < columns);
    let limit = limit.unwrap_or(all);
    let (places, _) = height(limit);
    let deepest = places.iter().zip(rows).map(|((_, row), count)| row + count);
    let deepest = deepest.max().unwrap_or(0);
    (places, deepest as f32 * ROW)
}

/// Distance between ticks, feet: 1, 2 or 5 times a power of ten.
fn step_ft(pixels_per_ft: f32) -> f32 {
    let least_ft = (TICK_MIN / pixels_per_ft).max(0.1);
    let power = 10.0_f32.powf(least_ft.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let step = steps.into_iter().find(|step| *step >= least_ft * 0.999);
    step.unwrap_or(10.0 * power)
}

/// The multiples of `step` between two values.
fn ticks(from: f32, to: f32, step: f32) -> impl Iterator<Item = f32> {
    let first = (from / step).ceil() as i32;
    let last = (to / step).floor() as i32;
    (first..=last).map(move |number| number as f32 * step)
}

/// A tick's value with a true minus sign.
fn tick_words(feet: f32) -> String {
    let tenths = (feet * 10.0).round() as i32;
    let sign = if tenths < 0 { "−" } else { "" };
    let (whole, tenth) = (tenths.abs() / 10, tenths.abs() % 10);
    if tenth == 0 {
        format!("{sign}{whole}")
    } else {
        format!("{sign}{whole}.{tenth}")
    }
}
