//! The robot's odometer, as reported in lines A.

use std::time::Duration;

use groundwave_protocol::decoder::Received;
use groundwave_protocol::life::Life;
use groundwave_protocol::status_codes::Drive;
use groundwave_protocol::telemetry::{Body, SEQUENCE_MODULUS};

/// Maximum speed of the robot, inches per second; a faster step is an odometer reset.
const SPEED_MAX_IN_S: f64 = 24.0;

/// Number of long lines per second at 2400 baud.
const LINES_PER_S: f64 = 3.0;

/// The robot's way from one position to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// The first position.
    First,
    /// The robot drove there.
    Driven,
    /// The odometer was reset: the robot rebooted or its position was set.
    Reset,
}

/// A position of the robot, its time and the sequence of its line.
#[derive(Clone, Copy, Debug)]
struct Fix {
    at: Duration,
    sequence: u8,
    place: (f64, f64),
}

/// Distance driven and resets of the odometer.
#[derive(Clone, Debug, Default)]
pub(super) struct Odometer {
    life: Life,
    /// Whether the robot has rebooted since the latest position.
    has_rebooted: bool,
    last: Option<Fix>,
    /// Distance driven, inches.
    pub(super) distance_in: f64,
    /// Number of resets after the first position.
    pub(super) resets: u32,
}

impl Odometer {
    /// Takes a line; for a line A, returns the step to its position and the position, inches.
    pub(super) fn take(&mut self, at: Duration, received: &Received) -> Option<(Step, (f64, f64))> {
        self.has_rebooted |= self.life.take(received);
        let Received::Line(line, _) = received else {
            return None;
        };
        let Body::State(state) = &line.body else {
            return None;
        };
        let x_in = f64::from(state.x_tenths_in) / 10.0;
        let fix = Fix {
            at,
            sequence: line.sequence,
            place: (x_in, f64::from(state.y_tenths_in) / 10.0),
        };
        let is_reset =
            std::mem::take(&mut self.has_rebooted) || state.drive == Drive::OdometerReset;
        let step = match self.last.replace(fix) {
            None => Step::First,
            Some(last) if !is_reset && fix.is_reachable_from(&last) => {
                self.distance_in += distance_in(last.place, fix.place);
                Step::Driven
            }
            Some(_) => {
                self.resets += 1;
                Step::Reset
            }
        };
        Some((step, fix.place))
    }
}

impl Fix {
    /// Whether the robot can have driven here from the position before.
    fn is_reachable_from(&self, last: &Self) -> bool {
        // Raw text has no pauses, and a live link delivers several lines at once.
        let slots = (self.sequence + SEQUENCE_MODULUS - last.sequence) % SEQUENCE_MODULUS;
        let by_sequence_s = f64::from(slots) / LINES_PER_S;
        let passed_s = self.at.saturating_sub(last.at).as_secs_f64();
        distance_in(last.place, self.place) <= passed_s.max(by_sequence_s) * SPEED_MAX_IN_S
    }
}

/// Distance between two places, inches.
pub(super) fn distance_in(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}
