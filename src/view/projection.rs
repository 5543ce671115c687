//! The transformation between the floor and the dots of a picture.

use groundwave_protocol::WAYPOINT_LIMIT_IN;
use ratatui::layout::Rect;

use crate::event::Spot;
use crate::model::bounds::Bounds;
use crate::model::chart::Chart;
use crate::model::map::{Focus, MapView};

/// Minimum scale, inches per dot.
const SCALE_MIN_IN: f64 = 0.25;

/// The transformation from floor to screen.
pub(super) struct Projection {
    middle: (f64, f64),
    scale_in: f64,
    area: Rect,
}

impl Projection {
    /// The operator's view of the map.
    pub(super) fn of(chart: &Chart, map: &MapView, area: Rect) -> Self {
        let shown = map.shown(chart);
        let mut projection = Self::over(shown.min, shown.max, area);
        if map.focus == Focus::Follow
            && let Some(plan) = chart.plan()
        {
            projection.stay_inside(&plan);
        }
        if let Some(cursor) = map.cursor {
            projection.show(f64::from(cursor.x_in), f64::from(cursor.y_in));
        }
        projection
    }

    /// The same view with more dots along each cell.
    pub(super) fn finer(&self, times: u16) -> Self {
        Self {
            middle: self.middle,
            scale_in: self.scale_in / f64::from(times),
            area: Rect::new(0, 0, self.area.width * times, self.area.height * times),
        }
    }

    /// The cells of the picture.
    pub(super) const fn area(&self) -> Rect {
        self.area
    }

    /// A view of a whole rectangle of the floor, given by two corners.
    pub(super) fn over(low: (f64, f64), high: (f64, f64), area: Rect) -> Self {
        let (width_in, height_in) = (high.0 - low.0, high.1 - low.1);
        Self {
            middle: (low.0 + width_in / 2.0, low.1 + height_in / 2.0),
            scale_in: fitting((width_in, height_in), area),
            area,
        }
    }

    /// Number of inches per dot.
    pub(super) const fn scale_in(&self) -> f64 {
        self.scale_in
    }

    /// The point of the floor in the lower left cell.
    pub(super) fn corner(&self) -> (f64, f64) {
        let (width, height) = (f64::from(self.area.width), f64::from(self.area.height));
        (
            self.middle.0 - (width - 1.0) * self.scale_in,
            self.middle.1 - (2.0 * height - 2.0) * self.scale_in,
        )
    }

    /// Moves the middle so that as little as possible outside the known floor is shown.
    fn stay_inside(&mut self, known: &Bounds) {
        let half = |cells: u16, dots: f64| f64::from(cells) * dots / 2.0 * self.scale_in;
        let inside = |middle: f64, half_in: f64, low: f64, high: f64| {
            if high - low <= 2.0 * half_in {
                f64::midpoint(low, high)
            } else {
                middle.clamp(low + half_in, high - half_in)
            }
        };
        let (across, up) = (half(self.area.width, 2.0), half(self.area.height, 4.0));
        self.middle = (
            inside(self.middle.0, across, known.min.0, known.max.0),
            inside(self.middle.1, up, known.min.1, known.max.1),
        );
    }

    /// Moves the middle just far enough to show a point.
    fn show(&mut self, x_in: f64, y_in: f64) {
        let reach =
            |cells: u16, dots: f64| (f64::from(cells / 2) - 1.0).max(0.0) * dots * self.scale_in;
        let (reach_x, reach_y) = (reach(self.area.width, 2.0), reach(self.area.height, 4.0));
        self.middle.0 = self.middle.0.clamp(x_in - reach_x, x_in + reach_x);
        self.middle.1 = self.middle.1.clamp(y_in - reach_y, y_in + reach_y);
    }

    /// The dot of a point on the floor, counted from the upper left.
    pub(super) fn dot(&self, (x_in, y_in): (f64, f64)) -> (f64, f64) {
        (
            f64::from(self.area.width) + ((x_in - self.middle.0) / self.scale_in).round(),
            2.0 * f64::from(self.area.height) - ((y_in - self.middle.1) / self.scale_in).round(),
        )
    }

    /// The cell of a point on the floor; `None` off the screen.
    pub(super) fn cell(&self, point: (f64, f64)) -> Option<Rect> {
        let (x, y) = self.dot(point);
        let (column, row) = ((x / 2.0).floor(), (y / 4.0).floor());
        let inside = (0.0..f64::from(self.area.width)).contains(&column)
            && (0.0..f64::from(self.area.height)).contains(&row);
        inside.then(|| Rect::new(self.area.x + column as u16, self.area.y + row as u16, 1, 1))
    }

    /// The point of the floor in the middle of a cell.
    pub(super) fn floor(&self, column: u16, row: u16) -> Option<Spot> {
        let across = 2.0 * f64::from(column.checked_sub(self.area.x)?) + 1.0;
        let down = 4.0 * f64::from(row.checked_sub(self.area.y)?) + 2.0;
        let x_in = self.middle.0 + (across - f64::from(self.area.width)) * self.scale_in;
        let y_in = self.middle.1 + (2.0 * f64::from(self.area.height) - down) * self.scale_in;
        let limit = f64::from(WAYPOINT_LIMIT_IN);
        let is_near = x_in.abs() <= limit && y_in.abs() <= limit;
        is_near.then(|| Spot::Floor {
            x_in: x_in.round() as i16,
            y_in: y_in.round() as i16,
            reach_in: (4.0 * self.scale_in).ceil() as i16,
        })
    }
}

/// The smallest scale that shows a width and height, inches per dot.
fn fitting((width_in, height_in): (f64, f64), area: Rect) -> f64 {
    let (columns, rows) = (f64::from(area.width.max(1)), f64::from(area.height.max(1)));
    let needed_in = (width_in / (2.0 * columns)).max(height_in / (4.0 * rows));
    needed_in.max(SCALE_MIN_IN)
}
