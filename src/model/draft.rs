//! The draft of a route: a waypoint list that the operator edits and has not sent.

use std::collections::VecDeque;

use groundwave_protocol::{WAYPOINT_LIMIT_IN, WAYPOINTS_MAX, Waypoint};

use super::chart::Pose;

/// Maximum number of changes that can be undone.
const UNDO_MAX: usize = 64;

/// Distance ahead of a new waypoint without a previous leg, inches.
const STEP_IN: f64 = 12.0;

/// Reason why a change of the draft was refused. The text is for [`Keymap::with_keys`](super::keys::Keymap::with_keys).
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum DraftError {
    #[error("the robot's route holds no more than {WAYPOINTS_MAX} waypoints")]
    Full,
    #[error("a waypoint would lie farther than {WAYPOINT_LIMIT_IN} in from the origin")]
    TooFar,
    #[error(
        "the draft is empty: <route/route-append> adds a waypoint, <route/route-ask-to-load> loads a file"
    )]
    Empty,
    #[error("nothing to undo")]
    NothingToUndo,
    #[error("nothing to redo")]
    NothingToRedo,
}

/// A change of the draft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Edit {
    /// Adds a waypoint after the selected one, continuing the last leg.
    Append,
    /// Adds a waypoint halfway between the previous and the selected one.
    Insert,
    /// Adds a waypoint at a place, after the selected one.
    AppendAt(f64, f64),
    Delete,
    /// Moves the selected waypoint, inches east and north.
    Move(f64, f64),
    /// Moves the whole route.
    Shift(f64, f64),
    /// Turns the route about its middle, degrees clockwise.
    Rotate(f64),
    /// Swaps east and west about the route's middle.
    Mirror,
    /// Scales the route about its middle.
    Scale(f64),
    /// Reverses the order of the waypoints.
    Reverse,
    Clear,
}

/// A place on the floor, inches; fractions are kept, because rotations must be reversible.
type Place = (f64, f64);

#[derive(Clone, Debug, Default, PartialEq)]
struct Version {
    places: Vec<Place>,
    selected: usize,
}

/// The draft with its undo and redo history.
#[derive(Clone, Debug, Default)]
pub(crate) struct Draft {
    present: Version,
    waypoints: Vec<Waypoint>,
    past: VecDeque<Version>,
    future: Vec<Version>,
}

impl Draft {
    /// The waypoints as they would be sent.
    pub(crate) fn waypoints(&self) -> &[Waypoint] {
        &self.waypoints
    }

    /// Index of the selected waypoint; `None` when the draft is empty.
    pub(crate) fn selected(&self) -> Option<usize> {
        (!self.waypoints.is_empty()).then_some(self.present.selected)
    }

    /// The selected waypoint.
    pub(crate) fn selected_waypoint(&self) -> Option<Waypoint> {
        self.waypoints.get(self.present.selected).copied()
    }

    /// Moves the selection by `steps`, within the list.
    pub(super) fn select(&mut self, steps: isize) {
        let last = self.waypoints.len().saturating_sub(1);
        self.present.selected = self.present.selected.saturating_add_signed(steps).min(last);
    }

    /// Selects the waypoint with an index.
    pub(super) fn choose(&mut self, n: usize) {
        self.present.selected = n.min(self.waypoints.len().saturating_sub(1));
    }

    /// Index of the waypoint nearest to a place and within `reach_in` inches.
    pub(super) fn nearest(&self, at: Waypoint, reach_in: i16) -> Option<usize> {
        let (x, y) = place(at);
        let distances_in = self.waypoints.iter().copied().map(|waypoint| {
            let (to_x, to_y) = place(waypoint);
            (x - to_x).hypot(y - to_y)
        });
        distances_in
            .enumerate()
            .filter(|(_, distance_in)| *distance_in <= f64::from(reach_in))
            .min_by(|(_, one_in), (_, other_in)| one_in.total_cmp(other_in))
            .map(|(n, _)| n)
    }

    /// Replaces the draft.
    pub(super) fn replace(&mut self, waypoints: &[Waypoint]) {
        let places = waypoints.iter().copied().map(place).collect();
        self.change(Version {
            places,
            selected: waypoints.len().saturating_sub(1),
        });
    }

    /// Returns the waypoints to send and empties the draft; undo restores it.
    pub(super) fn take(&mut self) -> Vec<Waypoint> {
        let waypoints = self.waypoints.clone();
        self.change(Version::default());
        waypoints
    }

    /// Changes the draft; the route begins at `robot`.
    ///
    /// # Errors
    /// The reason why the change was refused.
    pub(crate) fn edit(&mut self, edit: Edit, robot: Option<Pose>) -> Result<(), DraftError> {
        let mut next = self.present.clone();
        next.apply(edit, robot)?;
        let limit = f64::from(WAYPOINT_LIMIT_IN) + 0.5;
        let reachable = |(x, y): &Place| x.abs() < limit && y.abs() < limit;
        if !next.places.iter().all(reachable) {
            return Err(DraftError::TooFar);
        }
        self.change(next);
        Ok(())
    }

    /// Undoes the last change.
    ///
    /// # Errors
    /// If there is no such change.
    pub(super) fn undo(&mut self) -> Result<(), DraftError> {
        let before = self.past.pop_back().ok_or(DraftError::NothingToUndo)?;
        let present = self.show(before);
        self.future.push(present);
        Ok(())
    }

    /// Redoes the last undone change.
    ///
    /// # Errors
    /// If there is no such change.
    pub(super) fn redo(&mut self) -> Result<(), DraftError> {
        let after = self.future.pop().ok_or(DraftError::NothingToRedo)?;
        let present = self.show(after);
        self.past.push_back(present);
        Ok(())
    }

    fn change(&mut self, next: Version) {
        if next.places == self.present.places {
            self.present = next;
            return;
        }
        if self.past.len() == UNDO_MAX {
            self.past.pop_front();
        }
        let present = self.show(next);
        self.past.push_back(present);
        self.future.clear();
    }

    /// Replaces the current version and returns it.
    fn show(&mut self, version: Version) -> Version {
        let shown = std::mem::replace(&mut self.present, version);
        self.round();
        shown
    }

    fn round(&mut self) {
        let limit = f64::from(WAYPOINT_LIMIT_IN);
        let whole = |value: f64| value.round().clamp(-limit, limit) as i16;
        self.waypoints = self
            .present
            .places
            .iter()
            .map(|(x, y)| Waypoint {
                x_in: whole(*x),
                y_in: whole(*y),
            })
            .collect();
    }

    /// Lengths of the legs from the robot, if its place is known, through the waypoints, inches.
    pub(crate) fn legs_in(&self, robot: Option<Pose>) -> Vec<f64> {
        let start = robot.map(|pose| (pose.x_in, pose.y_in));
        let mut from = start.or_else(|| self.waypoints.first().copied().map(place));
        self.waypoints
            .iter()
            .copied()
            .map(place)
            .map(|to| {
                let leg = from.map_or(0.0, |(x, y)| (to.0 - x).hypot(to.1 - y));
                from = Some(to);
                leg
            })
            .collect()
    }
}

impl Version {
    fn apply(&mut self, edit: Edit, robot: Option<Pose>) -> Result<(), DraftError> {
        match edit {
            Edit::Append => self.add(self.after(), self.onward(robot))?,
            Edit::AppendAt(x, y) => self.add(self.after(), (x, y))?,
            Edit::Insert => self.add(self.selected, self.halfway(robot))?,
            Edit::Clear => *self = Self::default(),
            _ if self.places.is_empty() => return Err(DraftError::Empty),
            Edit::Delete => {
                self.places.remove(self.selected);
                self.selected = self.selected.min(self.places.len().saturating_sub(1));
            }
            Edit::Move(east, north) => {
                if let Some((x, y)) = self.places.get_mut(self.selected) {
                    (*x, *y) = (*x + east, *y + north);
                }
            }
            Edit::Shift(east, north) => self.map(|(x, y)| (x + east, y + north)),
            Edit::Rotate(deg) => {
                let (sin, cos) = deg.to_radians().sin_cos();
                self.about_middle(|(x, y)| (x * cos + y * sin, y * cos - x * sin));
            }
            Edit::Mirror => self.about_middle(|(x, y)| (-x, y)),
            Edit::Scale(factor) => self.about_middle(|(x, y)| (x * factor, y * factor)),
            Edit::Reverse => {
                self.places.reverse();
                self.selected = self.places.len() - 1 - self.selected;
            }
        }
        Ok(())
    }

    fn add(&mut self, at: usize, place: Place) -> Result<(), DraftError> {
        if self.places.len() >= WAYPOINTS_MAX {
            return Err(DraftError::Full);
        }
        self.places.insert(at, place);
        self.selected = at;
        Ok(())
    }

    fn after(&self) -> usize {
        (self.selected + 1).min(self.places.len())
    }

    /// The place that continues the leg to the selected waypoint; for an empty draft, the robot's place.
    fn onward(&self, robot: Option<Pose>) -> Place {
        let here = robot.map(|pose| (pose.x_in, pose.y_in));
        let Some(&(x, y)) = self.places.get(self.selected) else {
            return here.unwrap_or_default();
        };
        let before = self.selected.checked_sub(1).map(|n| self.places[n]);
        let leg = before.map(|(from_x, from_y)| (x - from_x, y - from_y));
        // The leg from the moving robot does not determine the route's direction.
        let (dx, dy) = leg
            .filter(|(dx, dy)| dx.hypot(*dy) >= 1.0)
            .unwrap_or_else(|| step(robot));
        (x + dx, y + dy)
    }

    fn halfway(&self, robot: Option<Pose>) -> Place {
        let here = robot.map(|pose| (pose.x_in, pose.y_in));
        let Some(&(x, y)) = self.places.get(self.selected) else {
            return here.unwrap_or_default();
        };
        let before = self.selected.checked_sub(1).map(|n| self.places[n]);
        let far = |(from_x, from_y): &Place| (x - from_x).hypot(y - from_y) >= STEP_IN;
        let (from_x, from_y) = before.or(here.filter(far)).unwrap_or_else(|| {
            let (dx, dy) = step(robot);
            (x - 2.0 * dx, y - 2.0 * dy)
        });
        (f64::midpoint(x, from_x), f64::midpoint(y, from_y))
    }

    fn map(&mut self, f: impl Fn(Place) -> Place) {
        for place in &mut self.places {
            *place = f(*place);
        }
    }

    /// Maps every place relative to the middle of the route's bounds.
    fn about_middle(&mut self, f: impl Fn(Place) -> Place) {
        let Some(&first) = self.places.first() else {
            return;
        };
        let (low, high) = self
            .places
            .iter()
            .fold((first, first), |(low, high), &(x, y)| {
                ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
            });
        let (middle_x, middle_y) = (f64::midpoint(low.0, high.0), f64::midpoint(low.1, high.1));
        self.map(|(x, y)| {
            let (x, y) = f((x - middle_x, y - middle_y));
            (x + middle_x, y + middle_y)
        });
    }
}

/// The step of a route without a leg: straight ahead of the robot.
fn step(robot: Option<Pose>) -> Place {
    robot.map_or((0.0, STEP_IN), |pose| {
        let (x, y) = pose.ahead(0.0, STEP_IN);
        (x - pose.x_in, y - pose.y_in)
    })
}

fn place(waypoint: Waypoint) -> Place {
    (f64::from(waypoint.x_in), f64::from(waypoint.y_in))
}

#[cfg(test)]
mod tests;
