//! Floor that the robot has seen and never visited, while it prowls where it has been.

use groundwave_mapping::{Compass, Destination};
use groundwave_protocol::status_codes::Mode;

use super::{Situation, Suggestion, is_on_route};
use crate::event::{Figure, Moment, SuggestionCode};
use crate::request::Request;

/// Time of prowling before the first look, and between two: the robot finds most floor by itself.
const LOOK_EVERY: Moment = Moment::from_mins(5);

/// Least area that is worth a route, square feet.
const LEAST_SQ_FT: f64 = 12.0;

/// When a visit is suggested.
#[derive(Clone, Debug, Default)]
pub(super) struct Unvisited {
    looked_at: Option<Moment>,
    suggestion: Option<Suggestion>,
}

impl Unvisited {
    /// Looks for such floor from time to time.
    pub(super) fn watch(&mut self, it: &Situation<'_>, compass: &Compass) {
        if it.robot.mode() != Some(Mode::Prowl) || is_on_route(it) {
            *self = Self::default();
            return;
        }
        let looked_at = *self.looked_at.get_or_insert(it.now);
        if it.now >= looked_at + LOOK_EVERY {
            self.looked_at = Some(it.now);
            self.suggestion = look(it, compass);
        }
    }

    /// The suggestion of the latest look.
    pub(super) fn suggestion(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref()
    }
}

fn look(it: &Situation<'_>, compass: &Compass) -> Option<Suggestion> {
    if !compass.maps_well() {
        return None;
    }
    let ((x_in, y_in), area_sq_ft) = compass.unvisited()?;
    if area_sq_ft < LEAST_SQ_FT {
        return None;
    }
    let route = compass
        .route(Destination::True(x_in, y_in), it.robot.list_capacity())
        .ok()
        .filter(|route| !route.waypoints.is_empty())?;
    Some(Suggestion {
        code: SuggestionCode::Unvisited,
        requests: vec![Request::Route(route.waypoints)],
        target_in: Some(route.target_in),
        figures: vec![Figure {
            code: "never-visited".to_owned(),
            value: area_sq_ft,
            half: None,
            unit: "sq ft".to_owned(),
        }],
    })
}
