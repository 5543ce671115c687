//! The path of a run as reported by the robot, in bounded memory.

use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::status_codes::Drive;
use groundwave_protocol::telemetry::{Body, StateLine};

use crate::bumps::Bumps;
use crate::odometer::{can_be_driven, seconds_of, slots_between};
pub use crate::runs::figures::Place;
use crate::{Capture, CaptureError};

/// Maximum points; a longer path is kept more coarsely.
const POINTS_MAX: usize = 4096;

/// Initial distance between two points, inches.
const SPACING_IN: f64 = 1.0;

/// The path since the robot's odometer was last reset. Earlier positions are in another frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    points: Vec<Place>,
    spacing_in: f64,
    /// First and last position report.
    ends: Option<(Fix, Fix)>,
    /// Distance driven, inches.
    pub distance_in: f64,
    /// Odometer resets in the middle, each of which began a new course.
    pub restarts: u32,
    bumps: Bumps,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Fix {
    at: Duration,
    sequence: u8,
    place: Place,
}

impl Default for Course {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            spacing_in: SPACING_IN,
            ends: None,
            distance_in: 0.0,
            restarts: 0,
            bumps: Bumps::default(),
        }
    }
}

impl Course {
    /// Reads a whole capture; returns its course, the decoder's totals, and the reason why they are not complete.
    pub fn read(capture: &mut Capture) -> (Self, Counters, Option<CaptureError>) {
        let mut course = Self::default();
        let mut decoder = Decoder::default();
        let read = capture.for_each_line(&mut decoder, |at, received| {
            if let Received::Line(line, _) = received {
                match &line.body {
                    Body::State(state) => course.take(at, line.sequence, state),
                    Body::Counters(counters) => course.bumps.take_counters(counters),
                    _ => {}
                }
            }
            Ok::<(), CaptureError>(())
        });
        (course, *decoder.counters(), read.err())
    }

    /// Takes a line A with its number.
    pub fn take(&mut self, at: Duration, sequence: u8, state: &StateLine) {
        let place = (
            f64::from(state.x_tenths_in) / 10.0,
            f64::from(state.y_tenths_in) / 10.0,
        );
        let fix = Fix {
            at,
            sequence,
            place,
        };
        let step_in = self
            .ends
            .map_or(0.0, |(_, last)| distance_in(last.place, place));
        let could_be_driven = self.ends.is_none_or(|(_, last)| {
            let by_number_s = seconds_of(slots_between(last.sequence, sequence));
            let passed_s = at
                .saturating_sub(last.at)
                .as_secs_f64()
                .max(by_number_s)
                .max(1.0);
            can_be_driven(step_in, passed_s)
        });
        if self.ends.is_some() && (state.drive == Drive::OdometerReset || !could_be_driven) {
            self.bumps.begin_anew();
            *self = Self {
                restarts: self.restarts + 1,
                bumps: std::mem::take(&mut self.bumps),
                ..Self::default()
            };
        } else {
            self.distance_in += step_in;
        }
        self.bumps.take_state(state);
        self.ends = Some(self.ends.map_or((fix, fix), |(first, _)| (first, fix)));
        self.keep(place);
    }

    fn keep(&mut self, place: Place) {
        let far = |last: &Place| distance_in(*last, place) >= self.spacing_in;
        if self.points.last().is_some_and(|last| !far(last)) {
            return;
        }
        self.points.push(place);
        if self.points.len() == POINTS_MAX {
            self.spacing_in *= 2.0;
            let mut number = 0;
            self.points.retain(|_| {
                number += 1;
                number % 2 == 1
            });
        }
    }

    /// Contacts of the bumper.
    #[must_use]
    pub fn bumps(&self) -> u32 {
        self.bumps.total()
    }

    /// Places in order, evenly spaced.
    #[must_use]
    pub fn points(&self) -> &[Place] {
        &self.points
    }

    /// First place.
    #[must_use]
    pub fn start(&self) -> Option<Place> {
        self.ends.map(|(first, _)| first.place)
    }

    /// Last place.
    #[must_use]
    pub fn end(&self) -> Option<Place> {
        self.ends.map(|(_, last)| last.place)
    }

    /// Time from its first report to its last.
    #[must_use]
    pub fn duration(&self) -> Duration {
        self.ends.map_or(Duration::ZERO, |(first, last)| {
            last.at.saturating_sub(first.at)
        })
    }

    /// Distance from its end to its beginning, inches: the error of a closed round.
    #[must_use]
    pub fn closing_error_in(&self) -> Option<f64> {
        self.ends
            .map(|(first, last)| distance_in(first.place, last.place))
    }
}

/// Distance between two places, inches.
pub(super) fn distance_in(a: Place, b: Place) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A line A of a robot at a place.
    fn state(x_in: f64, y_in: f64) -> StateLine {
        StateLine {
            x_tenths_in: (x_in * 10.0) as _,
            y_tenths_in: (y_in * 10.0) as _,
            ..StateLine::BLANK
        }
    }

    /// A course through places, one a second.
    pub(crate) fn through(places: &[Place]) -> Course {
        let mut course = Course::default();
        for (second, place) in places.iter().enumerate() {
            course.take(
                Duration::from_secs(second as u64),
                0,
                &state(place.0, place.1),
            );
        }
        course
    }

    #[test]
    fn a_round_has_a_distance_and_a_closing_error() {
        let course = through(&[
            (0.0, 0.0),
            (10.0, 0.0),
            (10.0, 10.0),
            (0.0, 10.0),
            (0.0, 3.0),
        ]);
        assert!((course.distance_in - 37.0).abs() < 1e-9);
        assert_eq!(course.closing_error_in(), Some(3.0));
        assert_eq!(course.duration(), Duration::from_secs(4));
        assert_eq!(course.restarts, 0);
    }

    #[test]
    fn a_jump_begins_a_new_track() {
        let course = through(&[(0.0, 0.0), (10.0, 0.0), (200.0, 0.0), (205.0, 0.0)]);
        assert_eq!(course.restarts, 1);
        assert_eq!(course.points(), [(200.0, 0.0), (205.0, 0.0)]);
        assert!((course.distance_in - 5.0).abs() < 1e-9);
    }

    #[test]
    fn a_silence_that_a_raw_capture_does_not_know_of_is_no_jump() {
        let mut course = Course::default();
        course.take(Duration::from_secs(40), 19, &state(-8.0, 30.0));
        course.take(Duration::from_millis(40_333), 65, &state(98.0, 30.0));
        assert_eq!(course.restarts, 0);
    }

    #[test]
    fn a_long_drive_takes_no_more_memory_than_a_short_one() {
        let mut course = Course::default();
        for second in 0..100_000_u32 {
            let angle = f64::from(second) * 0.05;
            let radius_in = 20.0 + f64::from(second) * 0.001;
            let place = (radius_in * angle.cos(), radius_in * angle.sin());
            course.take(
                Duration::from_secs(second.into()),
                0,
                &state(place.0, place.1),
            );
        }
        assert_eq!(course.restarts, 0);
        assert!((POINTS_MAX / 4..POINTS_MAX).contains(&course.points().len()));
    }
}
