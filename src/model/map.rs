//! The operator's view of the map: the part shown, the cursor and the draft of a route.

use groundwave_protocol::{WAYPOINT_LIMIT_IN, Waypoint};

use super::chart::{Bounds, Chart, Pose};
use super::draft::{Draft, Edit};

/// Distance that one press of an arrow moves the cursor, inches.
const CURSOR_STEP_IN: i16 = 6;

const ZOOM_MAX: i8 = 12;

/// The object in the middle of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Focus {
    /// Everything known.
    #[default]
    Everything,
    /// The robot.
    Robot,
    /// This point.
    Point(f64, f64),
}

/// The operator's view of the map.
#[derive(Clone, Debug, Default)]
pub(crate) struct MapView {
    /// The waypoint list that the operator is making; the robot does not have it.
    pub(crate) draft: Draft,
    pub(crate) cursor: Option<Waypoint>,
    pub(crate) truth_hidden: bool,
    /// Steps in from the scale that shows everything.
    pub(crate) zoom: i8,
    pub(crate) focus: Focus,
    /// Around every draft of the session.
    drafted: Option<Bounds>,
}

impl MapView {
    /// The floor shown at zoom 0.
    pub(crate) fn bounds(&self, chart: &Chart) -> Bounds {
        self.drafted
            .map_or(chart.bounds, |drafted| drafted.union(chart.bounds))
    }

    /// The middle of the picture, inches, before it makes room for the cursor.
    pub(crate) fn middle(&self, chart: &Chart) -> (f64, f64) {
        match self.focus {
            Focus::Everything => self.bounds(chart).middle(),
            Focus::Robot => chart.followed,
            Focus::Point(x_in, y_in) => (x_in, y_in),
        }
    }

    pub(super) fn zoom_by(&mut self, steps: i8) {
        self.zoom = (self.zoom + steps).clamp(-4, ZOOM_MAX);
    }

    /// Moves the picture by eighths of the known floor.
    pub(super) fn pan(&mut self, chart: &Chart, east: f64, north: f64) {
        let bounds = self.bounds(chart);
        let (x_in, y_in) = self.middle(chart);
        let (width_in, height_in) = bounds.extent();
        let step_in = width_in.max(height_in) / 8.0 / 1.4_f64.powi(i32::from(self.zoom.max(0)));
        self.focus = Focus::Point(
            (x_in + east * step_in).clamp(bounds.min.0, bounds.max.0),
            (y_in + north * step_in).clamp(bounds.min.1, bounds.max.1),
        );
    }

    /// Moves the cursor, which starts at the last draft waypoint, else at the robot.
    pub(super) fn move_cursor(&mut self, robot: Option<Pose>, east: i16, north: i16) {
        let start = self.cursor.unwrap_or_else(|| self.cursor_start(robot));
        let step = |from: i16, steps: i16| {
            from.saturating_add(steps.saturating_mul(CURSOR_STEP_IN))
                .clamp(-WAYPOINT_LIMIT_IN, WAYPOINT_LIMIT_IN)
        };
        self.cursor = Some(Waypoint {
            x_in: step(start.x_in, east),
            y_in: step(start.y_in, north),
        });
    }

    fn cursor_start(&self, robot: Option<Pose>) -> Waypoint {
        let limit = f64::from(WAYPOINT_LIMIT_IN);
        let whole = |value: f64| value.clamp(-limit, limit).round() as i16;
        self.draft.waypoints().last().copied().unwrap_or_else(|| {
            robot.map_or_else(Waypoint::default, |pose| Waypoint {
                x_in: whole(pose.x_in),
                y_in: whole(pose.y_in),
            })
        })
    }

    /// Adds a waypoint at the cursor; `false` when the list is full.
    pub(super) fn add_waypoint(&mut self, robot: Option<Pose>) -> bool {
        let Some(cursor) = self.cursor else {
            self.move_cursor(robot, 0, 0);
            return true;
        };
        let at = Edit::AppendAt(f64::from(cursor.x_in), f64::from(cursor.y_in));
        self.draft.select(isize::MAX);
        let added = self.draft.edit(at, robot).is_ok();
        self.include_draft();
        added
    }

    pub(super) fn take_draft(&mut self, draft: &[Waypoint]) {
        self.draft.replace(draft);
        self.include_draft();
    }

    /// Extends the floor shown to the whole draft.
    pub(super) fn include_draft(&mut self) {
        for waypoint in self.draft.waypoints() {
            self.drafted
                .get_or_insert_default()
                .include(f64::from(waypoint.x_in), f64::from(waypoint.y_in));
        }
    }
}
