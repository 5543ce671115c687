//! Comparison of two runs.

use std::time::Duration;

use groundwave_protocol::decoder::Counters;

use super::Course;
use super::course::Place;
use crate::marks::{Marks, with_texts};
use crate::odometer::distance_in;
pub use crate::runs::figures::{Apart, Comparison, Figures};
use crate::statistics::{Damaged, Loss};

/// Maximum number of places compared; the time grows with its square.
const PLACES_MAX: usize = 2048;

impl Figures {
    /// The figures of a run from its course, its capture's start and duration, and the decoder's totals.
    #[must_use]
    pub fn of(
        capture: String,
        start: Option<String>,
        label: super::Label,
        marks: &Marks,
        course: &Course,
        duration: Duration,
        counters: &Counters,
    ) -> Self {
        let recorded = marks.moments().iter().copied().map(Into::into);
        let marks = with_texts(recorded.collect(), &label).len();
        Self {
            capture,
            start,
            name: label.name,
            void: label.void,
            marks,
            duration_s: duration.as_secs_f64(),
            distance_in: course.distance_in(),
            closing_error_in: course.closing_error_in(),
            bumps: course.bumps(),
            restarts: counters.restarts,
            loss: Loss::of(counters),
            // Without an intact line they may be lines of a robot's own.
            damaged: if counters.received() == 0 {
                Damaged::default()
            } else {
                Damaged::of(counters)
            },
            odometer_resets: course.odometer_resets(),
        }
    }
}

impl Apart {
    /// Mean and maximum distance between two courses, over the places of both, in the robot's frame; `None` if a course has no
    /// places.
    #[must_use]
    pub fn between(a: &Course, b: &Course) -> Option<Self> {
        let (a, b) = (places(a), places(b));
        if a.is_empty() || b.is_empty() {
            return None;
        }
        let mut sum_in = 0.0;
        let mut worst = (0.0, a[0]);
        for (own, other) in [(&a, &b), (&b, &a)] {
            for &place in own {
                let apart_in = nearest_in(place, other);
                sum_in += apart_in;
                if apart_in > worst.0 {
                    worst = (apart_in, place);
                }
            }
        }
        Some(Self {
            mean_in: sum_in / (a.len() + b.len()) as f64,
            worst_in: worst.0,
            worst_at_in: worst.1,
        })
    }
}

fn places(course: &Course) -> Vec<Place> {
    let points = course.points();
    let every = points.len().div_ceil(PLACES_MAX).max(1);
    points.iter().copied().step_by(every).collect()
}

/// Distance from a place to a line through other places, inches.
fn nearest_in(place: Place, line: &[Place]) -> f64 {
    let alone = distance_in(place, line[0]);
    line.windows(2)
        .map(|piece| from_piece_in(place, piece[0], piece[1]))
        .fold(alone, f64::min)
}

fn from_piece_in(place: Place, from: Place, to: Place) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let square = dx * dx + dy * dy;
    let part = if square > 0.0 {
        (((place.0 - from.0) * dx + (place.1 - from.1) * dy) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    distance_in(place, (from.0 + part * dx, from.1 + part * dy))
}

#[cfg(test)]
mod tests {
    use super::super::Label;
    use super::super::course::tests::through;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn parallel_courses_are_as_far_apart_as_they_are_drawn() {
        let a = through(&[(0.0, 0.0), (10.0, 0.0), (20.0, 0.0)]);
        let b = through(&[(0.0, 4.0), (10.0, 4.0), (20.0, 4.0)]);
        let apart = Apart::between(&a, &b).unwrap();
        assert!((apart.mean_in - 4.0).abs() < 1e-9);
        assert!((apart.worst_in - 4.0).abs() < 1e-9);
    }

    #[test]
    fn an_excursion_is_found_where_it_was() {
        let a = through(&[(0.0, 0.0), (20.0, 0.0), (40.0, 0.0)]);
        let b = through(&[(0.0, 0.0), (20.0, 12.0), (40.0, 0.0)]);
        let apart = Apart::between(&a, &b).unwrap();
        assert!((apart.worst_in - 12.0).abs() < 1e-9);
        assert_eq!(apart.worst_at_in, (20.0, 12.0));
    }

    proptest! {
        #[test]
        fn a_track_is_nowhere_apart_from_itself_and_both_ways_are_one(
            a in proptest::collection::vec((-20.0..20.0_f64, -20.0..20.0_f64), 1..30),
            b in proptest::collection::vec((-20.0..20.0_f64, -20.0..20.0_f64), 1..30),
        ) {
            let (a, b) = (through(&a), through(&b));
            let own = Apart::between(&a, &a).unwrap();
            prop_assert!(own.worst_in < 1e-9);
            let there = Apart::between(&a, &b).unwrap();
            let back = Apart::between(&b, &a).unwrap();
            prop_assert!((there.worst_in - back.worst_in).abs() < 1e-9);
            prop_assert!(there.mean_in <= there.worst_in + 1e-9);
        }
    }

    #[test]
    fn a_person_reads_what_differs() {
        let a = through(&[(0.0, 0.0), (20.0, 0.0), (0.0, 1.0)]);
        let b = through(&[(0.0, 0.0), (20.0, 0.0), (0.0, 5.0)]);
        let void = Label {
            void: Some("the cat".to_owned()),
            ..Label::default()
        };
        let figures = |capture: &str, label, course| {
            let counters = Counters::default();
            Figures::of(
                capture.into(),
                None,
                label,
                &Marks::default(),
                course,
                Duration::ZERO,
                &counters,
            )
        };
        let comparison = Comparison {
            runs: [
                figures("a.mcap", Label::default(), &a),
                figures("b.mcap", void, &b),
            ],
            apart: Apart::between(&a, &b),
        };
        let mut text = Vec::new();
        comparison.write_text(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        for fact in ["a.mcap", "VOID", "+4.0 in", "the cat", "closing error"] {
            assert!(text.contains(fact), "{fact} is not in\n{text}");
        }
    }
}
