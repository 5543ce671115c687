//! A robot that is held: it moves, but has not left a small place for minutes. The way out is where it came from.

use std::collections::VecDeque;

use groundwave_mapping::{Compass, CorrectedPose};
use groundwave_protocol::status_codes::Mode;

use super::{Situation, Suggestion, is_on_route, stands};
use crate::event::{Figure, Moment, SuggestionCode};

/// Time for which a robot must have stayed in a place, and the greatest distance in it, inches.
const HELD: Moment = Moment::from_mins(3);
const PLACE_IN: f64 = 24.0;

/// Least distance of the way out, inches.
const OUT_IN: f64 = 60.0;

/// Time between two plans of the way out.
const LOOK_EVERY: Moment = Moment::from_secs(30);

/// Time between two samples of the position.
const SAMPLE_EVERY: Moment = Moment::from_secs(5);

/// Longest time without lines after which it is still known that the robot has not left.
const PAUSE_MAX: Moment = Moment::from_secs(30);

/// Maximum number of remembered places.
const PLACES_MAX: usize = 64;

/// A point, inches.
type Point = (f64, f64);

/// When a way out is suggested.
#[derive(Clone, Debug, Default)]
pub(super) struct Held {
    stay: Stay,
    looked_at: Moment,
    suggestion: Option<Suggestion>,
}

impl Held {
    /// Takes the newest line A.
    pub(super) fn watch(
        &mut self,
        it: &Situation<'_>,
        pose: Option<CorrectedPose>,
        compass: &Compass,
    ) {
        let state = it.robot.state.map(|state| state.value);
        let (Some(state), Some(pose)) = (state, pose) else {
            self.stay.end();
            self.suggestion = None;
            return;
        };
        if state.mode == Mode::Prowl && !is_on_route(it) {
            self.stay
                .take(it.now, (pose.x_in, pose.y_in), !stands(&state));
        } else {
            self.stay.end();
        }
        let held = self.stay.held(it.now);
        if held.is_none() {
            self.suggestion = None;
        } else if it.now >= self.looked_at + LOOK_EVERY {
            self.looked_at = it.now;
            self.suggestion = held.and_then(|(time, out_in)| {
                let figure = Figure {
                    code: "held-for".to_owned(),
                    value: time.as_secs_f64() / 60.0,
                    half: None,
                    unit: "min".to_owned(),
                };
                Suggestion::way(SuggestionCode::Held, out_in, it, compass, figure)
            });
        }
    }

    /// The suggestion of the latest look.
    pub(super) const fn suggestion(&self) -> Option<&Suggestion> {
        self.suggestion.as_ref()
    }
}

/// Where the robot has been.
#[derive(Clone, Debug, Default)]
struct Stay {
    /// Positions far from each other, oldest first.
    places: VecDeque<Point>,
    /// Positions of the last minutes, and whether the robot moved there.
    recent: VecDeque<(Moment, Point, bool)>,
    /// Since when they have been close to each other.
    since: Option<Moment>,
}

impl Stay {
    /// Takes a position, and whether the robot moves.
    fn take(&mut self, now: Moment, here_in: Point, moves: bool) {
        let last = self.places.back();
        if last.is_none_or(|last| far_in(*last, here_in) > PLACE_IN) {
            if self.places.len() == PLACES_MAX {
                self.places.pop_front();
            }
            self.places.push_back(here_in);
        }
        if let Some((at, ..)) = self.recent.back() {
            let pause = now.saturating_sub(*at);
            if pause < SAMPLE_EVERY {
                return;
            }
            if pause > PAUSE_MAX {
                self.end();
            }
        }
        self.recent.push_back((now, here_in, moves));
        let is_over = |at: Moment| now.saturating_sub(at) > HELD;
        while self.recent.get(1).is_some_and(|(at, ..)| is_over(*at)) {
            self.recent.pop_front();
        }
        let is_whole = self.recent.front().is_some_and(|(at, ..)| is_over(*at));
        let moved = self.recent.iter().filter(|(.., moves)| *moves).count();
        let is_held = is_whole
            && moved > self.recent.len() / 2
            && self
                .recent
                .iter()
                .all(|(_, at_in, _)| far_in(*at_in, here_in) < PLACE_IN);
        let begun = self.recent.front().map(|(at, ..)| *at);
        self.since = if is_held { self.since.or(begun) } else { None };
    }

    /// The robot does something else.
    fn end(&mut self) {
        self.recent.clear();
        self.since = None;
    }

    /// How long the robot has been held, and the last place outside; `None` if it is not held. A robot that mostly stands rests.
    fn held(&self, now: Moment) -> Option<(Moment, Point)> {
        let since = self.since?;
        let (_, here_in, _) = self.recent.back()?;
        let is_out = |place: &&Point| far_in(**place, *here_in) > OUT_IN;
        let out_in = self.places.iter().rev().find(is_out)?;
        Some((now.saturating_sub(since), *out_in))
    }
}

fn far_in(one: Point, other: Point) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// A robot that has driven 120 in to the east and then stays within a distance of the end for a time.
    fn stay(within_in: f64, seconds: u64, moves: bool) -> (Stay, Moment) {
        let mut stay = Stay::default();
        let mut ms = 0;
        for step in 0..120 {
            stay.take(Moment::from_millis(ms), (f64::from(step), 0.0), true);
            ms += 333;
        }
        let until = ms + seconds * 1000;
        while ms < until {
            let angle = ms as f64;
            let here_in = (120.0 + within_in * angle.sin(), within_in * angle.cos());
            stay.take(Moment::from_millis(ms), here_in, moves);
            ms += 333;
        }
        (stay, Moment::from_millis(ms))
    }

    proptest! {
        #[test]
        fn the_way_out_is_where_the_robot_came_from(within_in in 0.0..11.0_f64, seconds in 200..900_u64) {
            let (stay, now) = stay(within_in, seconds, true);
            let (time, (x_in, y_in)) = stay.held(now).expect("it is held");
            prop_assert!(time.as_secs() >= seconds - 10 && time.as_secs() < seconds + 10, "{time:?}");
            prop_assert!(x_in > 0.0 && x_in < 60.0 && y_in == 0.0, "{x_in}");
        }
    }

    #[test]
    fn robots_that_rest_or_roam_or_have_just_come_are_not_held() {
        for (what, within_in, seconds, moves) in [
            ("just come", 5.0, 150, true),
            ("rests", 0.0, 600, false),
            ("roams", 40.0, 600, true),
        ] {
            let (stay, now) = stay(within_in, seconds, moves);
            assert!(stay.held(now).is_none(), "{what}");
        }
        let (mut stay, now) = stay(5.0, 600, true);
        let mut after = stay.clone();
        let later = now + Moment::from_mins(4);
        after.take(later, (120.0, 0.0), true);
        assert!(after.held(later).is_none(), "it was not heard");
        stay.end();
        assert!(stay.held(now).is_none(), "it does something else");
    }
}
