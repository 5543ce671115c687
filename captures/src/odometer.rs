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
    /// Uptime in the latest line C before it, in the same life; seconds.
    uptime_s: Option<u32>,
    place: (f64, f64),
}

/// A way that the robot can have driven only if more lines were lost than the sequence shows. The next line C decides.
#[derive(Clone, Copy, Debug)]
struct Jump {
    /// Uptime in the latest line C before it, seconds.
    since_s: u32,
    /// The position after it.
    to: (f64, f64),
    distance_in: f64,
}

/// Distance driven and resets of the odometer.
#[derive(Clone, Debug, Default)]
pub(super) struct Odometer {
    life: Life,
    /// Uptime in the latest line C of this life, seconds.
    uptime_s: Option<u32>,
    /// The jump since that line C.
    jump: Option<Jump>,
    /// Whether the robot has rebooted since the latest position.
    has_rebooted: bool,
    last: Option<Fix>,
    /// Distance driven, inches.
    pub(super) distance_in: f64,
    /// Number of resets after the first position.
    pub(super) resets: u32,
}

impl Odometer {
    /// Takes a line; for a line A, returns the step to its position and the position, inches. For a line C that shows an earlier
    /// reset, returns the step and position after that.
    pub(super) fn take(&mut self, at: Duration, received: &Received) -> Option<(Step, (f64, f64))> {
        if self.life.take(received) {
            self.has_rebooted = true;
            self.uptime_s = None;
            self.jump = None;
        }
        if let Some(uptime_s) = received.uptime_s() {
            return self.take_uptime(uptime_s);
        }
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
            uptime_s: self.uptime_s,
            place: (x_in, f64::from(state.y_tenths_in) / 10.0),
        };
        let is_reset =
            std::mem::take(&mut self.has_rebooted) || state.drive == Drive::OdometerReset;
        let step = match self.last.replace(fix) {
            None => Step::First,
            Some(last) if !is_reset && self.is_driven(&last, &fix) => {
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

    /// Whether the robot drove from a position to the next, until a line C shows that it did not.
    fn is_driven(&mut self, last: &Fix, fix: &Fix) -> bool {
        if fix.is_reachable_from(last) {
            return true;
        }
        let Some(since_s) = last.uptime_s else {
            // Without a clock, hundreds of lines may be missing wherever one is.
            return fix.lines_since(last) > 1;
        };
        let jump = self.jump.get_or_insert(Jump {
            since_s,
            to: fix.place,
            distance_in: 0.0,
        });
        jump.distance_in += distance_in(last.place, fix.place);
        true
    }

    /// Takes the uptime in a line C; returns a jump for which there was no time.
    fn take_uptime(&mut self, uptime_s: u32) -> Option<(Step, (f64, f64))> {
        self.uptime_s = Some(uptime_s);
        let jump = self.jump.take()?;
        // The uptime has whole seconds, and wraps around.
        let passed_s = uptime_s.checked_sub(jump.since_s)? + 1;
        if jump.distance_in <= f64::from(passed_s) * SPEED_MAX_IN_S {
            return None;
        }
        self.distance_in -= jump.distance_in;
        self.resets += 1;
        Some((Step::Reset, jump.to))
    }
}

impl Fix {
    /// Whether the robot can have driven here from the position before.
    fn is_reachable_from(&self, last: &Self) -> bool {
        // Raw text has no pauses, and a live link delivers several lines at once.
        let by_sequence_s = f64::from(self.lines_since(last)) / LINES_PER_S;
        let passed_s = self.at.saturating_sub(last.at).as_secs_f64();
        distance_in(last.place, self.place) <= passed_s.max(by_sequence_s) * SPEED_MAX_IN_S
    }

    /// Number of lines since the position before, modulo 100.
    fn lines_since(&self, last: &Self) -> u8 {
        (self.sequence + SEQUENCE_MODULUS - last.sequence) % SEQUENCE_MODULUS
    }
}

/// Distance between two places, inches.
pub(super) fn distance_in(a: (f64, f64), b: (f64, f64)) -> f64 {
    (a.0 - b.0).hypot(a.1 - b.1)
}
