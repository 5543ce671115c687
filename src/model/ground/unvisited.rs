//! Floor that the robot has seen and never visited, while it prowls where it has been.

use std::collections::VecDeque;

use groundwave_mapping::Compass;
use groundwave_protocol::status_codes::Mode;

use super::{Situation, Suggestion, is_on_route};
use crate::event::{Figure, Moment, SuggestionCode};

/// Time of prowling before the first look, and between two: the robot finds most floor by itself.
const LOOK_EVERY: Moment = Moment::from_mins(5);

/// Least area that is worth a route, square feet.
const LEAST_SQ_FT: f64 = 12.0;

/// Maximum number of remembered places that the robot was sent to.
const TRIED_MAX: usize = 32;

/// When a visit is suggested.
#[derive(Clone, Debug, Default)]
pub(super) struct Unvisited {
    looked_at: Option<Moment>,
    suggestion: Option<Suggestion>,
    /// True points of the accepted suggestions, inches: what was seen there may be no floor, or have no way to it.
    tried_in: VecDeque<(f64, f64)>,
}

impl Unvisited {
    /// Looks for such floor from time to time.
    pub(super) fn watch(&mut self, it: &Situation<'_>, compass: &Compass) {
        if it.robot.mode() != Some(Mode::Prowl) || is_on_route(it) {
            self.looked_at = None;
            self.suggestion = None;
            return;
        }
        let looked_at = *self.looked_at.get_or_insert(it.now);
        if it.now >= looked_at + LOOK_EVERY {
            self.looked_at = Some(it.now);
            self.suggestion = self.look(it, compass);
        }
    }

    /// Takes the acceptance of a visit to a true point, inches.
    pub(super) fn take_accepted(&mut self, target_in: Option<(f64, f64)>) {
        if self.tried_in.len() == TRIED_MAX {
            self.tried_in.pop_front();
        }
        self.tried_in.extend(target_in);
        self.suggestion = None;
    }

    /// The suggestion of the latest look.
    pub(super) fn suggestion(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref()
    }

    fn look(&self, it: &Situation<'_>, compass: &Compass) -> Option<Suggestion> {
        if !compass.maps_well() {
            return None;
        }
        let tried_in = self.tried_in.iter().copied();
        let (place_in, area_sq_ft) = compass.unvisited(tried_in)?;
        let figure = Figure {
            code: "never-visited".to_owned(),
            value: area_sq_ft,
            half: None,
            unit: "sq ft".to_owned(),
        };
        (area_sq_ft >= LEAST_SQ_FT)
            .then(|| Suggestion::way(SuggestionCode::Unvisited, place_in, it, compass, figure))
            .flatten()
    }
}
