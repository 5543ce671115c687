//! The path of a run as reported by the robot, in bounded memory.

use std::time::Duration;

use groundwave_protocol::decoder::{Counters, Decoder, Received};
use groundwave_protocol::telemetry::Body;

use crate::bumps::Bumps;
use crate::chunk::counters_until;
use crate::odometer::{Odometer, Step, distance_in};
pub use crate::runs::figures::Place;
use crate::{Capture, CaptureError};

/// Maximum number of points; a longer path is stored with wider spacing.
const POINTS_MAX: usize = 4096;

/// Initial distance between two points, inches.
const SPACING_IN: f64 = 1.0;

/// The path since the last odometer reset (earlier positions are in another frame), and distance and bumps of
/// the whole run.
#[derive(Clone, Debug)]
pub struct Course {
    points: Vec<Place>,
    spacing_in: f64,
    /// First and last position of the path.
    ends: Option<(Place, Place)>,
    odometer: Odometer,
    bumps: Bumps,
}

impl Default for Course {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            spacing_in: SPACING_IN,
            ends: None,
            odometer: Odometer::default(),
            bumps: Bumps::default(),
        }
    }
}

impl Course {
    /// Reads a whole capture; returns its course, the decoder's totals, and the reason if reading was incomplete.
    pub fn read(capture: &mut Capture) -> (Self, Counters, Option<CaptureError>) {
        let mut course = Self::default();
        let mut decoder = Decoder::default();
        let read = capture.for_each_line(&mut decoder, |at, received| {
            course.take(at, received);
            Ok::<(), CaptureError>(())
        });
        (
            course,
            counters_until(&decoder, capture.latest()),
            read.err(),
        )
    }

    /// Takes a line.
    pub fn take(&mut self, at: Duration, received: &Received) {
        if let Received::Line(line, _) = received {
            match &line.body {
                Body::State(state) => {
                    self.bumps.take_state(state);
                }
                Body::Counters(counters) => self.bumps.take_counters(counters),
                _ => {}
            }
        }
        let Some((step, place)) = self.odometer.take(at, received) else {
            return;
        };
        if step == Step::Reset {
            self.points.clear();
            self.spacing_in = SPACING_IN;
            self.ends = None;
        }
        self.ends = Some(
            self.ends
                .map_or((place, place), |(first, _)| (first, place)),
        );
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

    /// Distance driven in the whole run, inches.
    #[must_use]
    pub const fn distance_in(&self) -> f64 {
        self.odometer.distance_in
    }

    /// Number of odometer resets; each began a new path.
    #[must_use]
    pub const fn odometer_resets(&self) -> u32 {
        self.odometer.resets
    }

    /// Number of contacts of the bumper in the whole run.
    #[must_use]
    pub fn bumps(&self) -> u32 {
        self.bumps.total()
    }

    /// Places of the path in order, evenly spaced.
    #[must_use]
    pub fn points(&self) -> &[Place] {
        &self.points
    }

    /// Distance from the end of the path to its beginning, inches: the odometry error of a closed loop.
    #[must_use]
    pub fn closing_error_in(&self) -> Option<f64> {
        self.ends.map(|(first, last)| distance_in(first, last))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    use groundwave_protocol::status_codes::Drive;
    use groundwave_protocol::telemetry::{Ack, CountersLine, Line, StateLine};

    /// A line A of a robot at a place.
    fn state(sequence: u8, (x_in, y_in): Place) -> Line {
        Line {
            sequence,
            body: Body::State(StateLine {
                x_tenths_in: (x_in * 10.0) as _,
                y_tenths_in: (y_in * 10.0) as _,
                ..StateLine::BLANK
            }),
            ack: Ack::default(),
        }
    }

    fn take(course: &mut Course, at: Duration, line: Line) {
        course.take(at, &Received::Line(line, line.encode()));
    }

    /// A course through places, one a second.
    pub(crate) fn through(places: &[Place]) -> Course {
        let mut course = Course::default();
        for (second, place) in places.iter().enumerate() {
            let at = Duration::from_secs(second as u64);
            take(&mut course, at, state(0, *place));
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
        assert!((course.distance_in() - 37.0).abs() < 1e-9);
        assert_eq!(course.closing_error_in(), Some(3.0));
        assert_eq!(course.odometer_resets(), 0);
    }

    #[test]
    fn a_jump_begins_a_new_path_and_the_distance_is_of_the_whole_run() {
        let course = through(&[(0.0, 0.0), (10.0, 0.0), (200.0, 0.0), (205.0, 0.0)]);
        assert_eq!(course.odometer_resets(), 1);
        assert_eq!(course.points(), [(200.0, 0.0), (205.0, 0.0)]);
        assert!((course.distance_in() - 15.0).abs() < 1e-9);
    }

    #[test]
    fn a_set_position_and_a_reboot_begin_a_new_path_however_near() {
        let mut course = through(&[(0.0, 0.0), (10.0, 0.0)]);
        let mut set = state(0, (11.0, 0.0));
        if let Body::State(state) = &mut set.body {
            state.drive = Drive::OdometerReset;
        }
        take(&mut course, Duration::from_secs(2), set);
        assert_eq!(course.points(), [(11.0, 0.0)]);
        let mut rebooted = state(0, (12.0, 0.0));
        rebooted.ack.boot = 1;
        take(&mut course, Duration::from_secs(3), rebooted);
        assert_eq!(course.points(), [(12.0, 0.0)]);
        assert_eq!(course.odometer_resets(), 2);
        assert!((course.distance_in() - 10.0).abs() < 1e-9);
    }

    #[test]
    fn a_silence_that_a_raw_capture_does_not_contain_is_not_a_jump() {
        let mut course = Course::default();
        take(
            &mut course,
            Duration::from_secs(40),
            state(19, (-8.0, 30.0)),
        );
        take(
            &mut course,
            Duration::from_millis(40_333),
            state(65, (98.0, 30.0)),
        );
        assert_eq!(course.odometer_resets(), 0);
    }

    /// A course in text without times: a line C, a line A at the origin, one 200 in away after 101 lines, and a line C.
    fn after_a_gap(passed_s: u32) -> Course {
        let clock = |sequence, uptime_s| Line {
            sequence,
            body: Body::Counters(CountersLine {
                robot_id: 7,
                uptime_s,
                ..CountersLine::default()
            }),
            ack: Ack::default(),
        };
        let mut course = Course::default();
        for line in [
            clock(10, 100),
            state(11, (0.0, 0.0)),
            state(12, (200.0, 0.0)),
            state(13, (201.0, 0.0)),
            clock(14, 100 + passed_s),
            state(15, (202.0, 0.0)),
        ] {
            take(&mut course, Duration::ZERO, line);
        }
        course
    }

    #[test]
    fn the_robots_clock_tells_a_gap_of_hundreds_of_lines_from_a_reset() {
        let driven = after_a_gap(35);
        assert_eq!(driven.odometer_resets(), 0);
        assert!((driven.distance_in() - 202.0).abs() < 1e-9);
        let reset = after_a_gap(1);
        assert_eq!(reset.odometer_resets(), 1);
        assert!((reset.distance_in() - 2.0).abs() < 1e-9);
        assert_eq!(reset.points(), [(200.0, 0.0), (202.0, 0.0)]);
    }

    #[test]
    fn without_a_clock_a_gap_is_no_reset() {
        let mut course = Course::default();
        take(&mut course, Duration::ZERO, state(11, (0.0, 0.0)));
        take(&mut course, Duration::ZERO, state(13, (200.0, 0.0)));
        assert_eq!(course.odometer_resets(), 0);
        take(&mut course, Duration::ZERO, state(14, (0.0, 0.0)));
        assert_eq!(course.odometer_resets(), 1);
    }

    /// However many lines are cut from raw text, the robot drove no farther and reset nothing.
    #[test]
    fn lines_cut_from_raw_text_are_not_a_reset() {
        let text = include_bytes!("../../house-clean.txt");
        let lines: Vec<Received> = Decoder::default().lines(text).collect();
        let course = |cut: std::ops::Range<usize>| {
            let mut course = Course::default();
            for received in lines[..cut.start].iter().chain(&lines[cut.end..]) {
                course.take(Duration::ZERO, received);
            }
            course
        };
        let all = course(0..0);
        for start in (15..60).step_by(5) {
            for count in [1, 99, 100, 101, 150, 200, 250] {
                let rest = course(start..start + count);
                assert_eq!(rest.odometer_resets(), 0, "{count} lines from {start} on");
                assert!(rest.distance_in() <= all.distance_in() + 1e-6);
            }
        }
    }

    #[test]
    fn a_long_drive_takes_no_more_memory_than_a_short_one() {
        let mut course = Course::default();
        for second in 0..100_000_u32 {
            let angle = f64::from(second) * 0.05;
            let radius_in = 20.0 + f64::from(second) * 0.001;
            let place = (radius_in * angle.cos(), radius_in * angle.sin());
            let at = Duration::from_secs(second.into());
            take(&mut course, at, state(0, place));
        }
        assert_eq!(course.odometer_resets(), 0);
        assert!((POINTS_MAX / 4..POINTS_MAX).contains(&course.points().len()));
    }
}
