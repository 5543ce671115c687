//! The operator's view of the map: the part shown, the cursor and the draft of a route.

use std::f64::consts::SQRT_2;

use groundwave_protocol::{WAYPOINT_LIMIT_IN, Waypoint};

use super::bounds::Bounds;
use super::chart::{Chart, Pose};
use super::draft::{Draft, Edit};

/// Distance that one press of an arrow moves the cursor, inches.
const CURSOR_STEP_IN: i16 = 6;

/// Minimum and maximum side of the floor shown by zooming, inches.
const SIDE_IN: [f64; 2] = [72.0, 20_000.0];

/// The part of the floor in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Focus {
    /// The robot, its route and its target.
    #[default]
    Follow,
    /// The robot, in the middle of an area with a width and height chosen by zooming, inches.
    Robot((f64, f64)),
    /// Everything known.
    Everything,
    /// A part of the floor chosen by the operator.
    Floor(Bounds),
}

/// The operator's view of the map.
#[derive(Clone, Debug, Default)]
pub(crate) struct MapView {
    /// The route that the operator is editing; the robot does not have it.
    pub(crate) draft: Draft,
    pub(crate) cursor: Option<Waypoint>,
    pub(crate) truth_hidden: bool,
    pub(crate) focus: Focus,
    /// Bounds of all drafts of the session.
    drafted: Option<Bounds>,
}

impl MapView {
    /// The part of the floor to show, without the area around the cursor.
    pub(crate) fn shown(&self, chart: &Chart) -> Bounds {
        match self.focus {
            Focus::Follow => {
                let draft = self.draft.waypoints().iter().map(|waypoint| {
                    Bounds::at((f64::from(waypoint.x_in), f64::from(waypoint.y_in)))
                });
                let followed = chart.followed.unwrap_or(chart.bounds);
                draft.fold(followed, Bounds::union)
            }
            Focus::Robot(extent) => Bounds::around(chart.near, extent),
            Focus::Everything => self.everything(chart),
            Focus::Floor(bounds) => bounds,
        }
    }

    fn everything(&self, chart: &Chart) -> Bounds {
        let drafted = self.drafted.unwrap_or(chart.bounds);
        chart.bounds.union(drafted)
    }

    /// Follows the robot; if the map follows it already, shows everything.
    pub(super) fn toggle_follow(&mut self) {
        self.focus = match self.focus {
            Focus::Follow => Focus::Everything,
            Focus::Robot(_) | Focus::Everything | Focus::Floor(_) => Focus::Follow,
        };
    }

    /// Zooms in by steps. A followed robot stays in the picture.
    pub(super) fn zoom_by(&mut self, chart: &Chart, steps: i8) {
        let shown = self.shown(chart);
        let (width_in, height_in) = shown.extent();
        let [least, greatest] = SIDE_IN.map(|side_in| side_in / width_in.max(height_in));
        let factor = SQRT_2.powi(-i32::from(steps)).max(least).min(greatest);
        let extent = (width_in * factor, height_in * factor);
        self.focus = match self.focus {
            Focus::Follow | Focus::Robot(_) => Focus::Robot(extent),
            Focus::Everything | Focus::Floor(_) => {
                Focus::Floor(Bounds::around(shown.middle(), extent))
            }
        };
    }

    /// Moves the picture by eighths of its size.
    pub(super) fn pan(&mut self, chart: &Chart, east: f64, north: f64) {
        let shown = self.shown(chart);
        let (x_in, y_in) = shown.middle();
        let (width_in, height_in) = shown.extent();
        let step_in = width_in.max(height_in) / 8.0;
        let Bounds { min, max } = self.everything(chart);
        let middle = (
            (x_in + east * step_in).clamp(min.0, max.0),
            (y_in + north * step_in).clamp(min.1, max.1),
        );
        self.focus = Focus::Floor(Bounds::around(middle, (width_in, height_in)));
    }

    /// Moves the cursor; it starts at the last waypoint of the draft, else at the robot.
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

    /// Adds a waypoint at the cursor; returns `false` when the list is full.
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
