//! Draws two runs over each other.

use super::drive::{bounds, gap_words, path};
use super::font::Font;
use super::mark::{self, Symbol};
use super::shape::{BLUE, Color, Layer, VERMILION};
use super::sheet::{Plan, Row, Sheet};
use super::{Picture, date_words, feet_words, time_words};
use crate::track::{Place, Point, Track};

/// Colours that colour-blind people can distinguish, and that differ in print.
const COLORS: [Color; 2] = [BLUE, VERMILION];

/// A run to compare.
pub struct Run<'a> {
    /// Name of the run or its capture.
    pub name: String,
    /// Track since the last odometer reset.
    pub track: &'a Track,
    /// Distance from the end of the path to its beginning, inches.
    pub closing_error_in: Option<f64>,
}

pub(super) fn draw(runs: [&Run<'_>; 2]) -> Option<Picture> {
    let font = Font::load();
    let mut places: Vec<Place> = Vec::new();
    for run in runs {
        run.track.points.first()?;
        places.extend(run.track.points.iter().map(|point| point.place));
    }
    let stretches = runs.map(|run| run.track.stretches());
    let plan = Plan {
        title: format!("{} and {}", runs[0].name, runs[1].name),
        facts: vec!["two runs over each other, x and y as each robot reported them".to_owned()],
        legend: (1..)
            .zip(runs)
            .zip(COLORS)
            .map(|((number, run), color)| rows(number, run, color))
            .collect(),
        notes: Vec::new(),
        bounds_in: bounds(&places),
    };
    let sheet = Sheet::new(&font, &plan);
    let mut layers = Vec::new();
    for (stretches, color) in stretches.iter().zip(COLORS) {
        layers.extend(path(&sheet, stretches, |_| color));
    }
    let mut marks = Layer {
        name: "marks",
        shapes: Vec::new(),
    };
    // Starts at one place show as two rings.
    let radii = [mark::START + 4.5, mark::START];
    for ((run, color), radius) in runs.into_iter().zip(COLORS).zip(radii) {
        if let (Some(first), Some(last)) = (run.track.points.first(), run.track.points.last()) {
            mark::start(&mut marks.shapes, sheet.spot(first.place), radius, color);
            let heading_deg = f32::from(run.track.heading_deg);
            mark::end(
                &mut marks.shapes,
                sheet.spot(last.place),
                heading_deg,
                color,
            );
        }
    }
    layers.push(marks);
    Some(sheet.picture(&font, plan, layers))
}

/// The legend of a run.
fn rows(number: u8, run: &Run<'_>, color: Color) -> Vec<Row> {
    let track = run.track;
    let place = |at: Option<&Point>| {
        at.map_or_else(String::new, |point| {
            // Adding turns a negated zero into zero.
            let tenths_ft = |inches: f32| (inches / 1.2).round() / 10.0 + 0.0;
            let (x_in, y_in) = point.place;
            format!("({:.1}, {:.1}) ft", tenths_ft(x_in), tenths_ft(y_in)).replace('-', "−")
        })
    };
    let mut heading = Row::new(Symbol::Path(color), format!("{number}  {}", run.name));
    heading.is_bold = true;
    let mut rows = vec![heading];
    let date = track.start.as_deref().map(date_words);
    rows.extend(date.map(|date| Row::new(None, date)));
    let driven = feet_words(track.distance_in);
    let time = time_words(track.duration);
    rows.push(Row::new(None, format!("{time}, {driven} driven")));
    let start = format!("start {}", place(track.points.first()));
    rows.push(Row::new(Symbol::Start(color), start));
    let end = format!("end {}", place(track.points.last()));
    rows.push(Row::new(Symbol::End(color, 90.0), end));
    if let Some(error_in) = run.closing_error_in {
        rows.push(Row::new(None, format!("closing error {error_in:.1} in")));
    }
    if track.gaps > 0 {
        rows.push(Row::new(Symbol::Gap, gap_words(track)));
    }
    rows.push(Row::new(None, ""));
    rows
}
