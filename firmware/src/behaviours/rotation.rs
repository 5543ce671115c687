//! Layer 2: turns by an angle, and scans, on request.
//!
//! A higher layer that takes the motors ends the turn: after a bump the robot is elsewhere, and a scan from two positions
//! is useless. The result reports it.

use super::behaviour::Behaviour;
use super::panorama::{Panorama, SAMPLES};
use crate::angle::Angle;
use crate::arbiter::Request;
use crate::drive::Motion;
use crate::sensors::Senses;
use crate::units::{cps, ticks};

/// Rotation of a scan, 45 degrees per second: pi/4 of the track of 10 inches.
const SCAN_CPS: i16 = 126;

/// Rotation of a turn: twice as fast, because it takes no samples.
const TURN_CPS: i16 = 2 * SCAN_CPS;

/// Minimum rotation, 11 degrees per second: below it the wheels begin to stick.
const CREEP_CPS: i16 = cps(2);

/// Angle left per count a second below which the turn slows down: from 45 degrees per second at 15 degrees.
const SLOW_DOWN_PER_CPS: i32 = 0x1_0000 * 15 / 360 / SCAN_CPS as i32;

/// Remaining angle at which the turn ends: one degree, about what the wheels need to stop.
const ARRIVED: i32 = 0x1_0000 / 360;

/// A full turn.
const FULL_TURN: i32 = 0x1_0000;

/// Angle between samples, 7.5 degrees.
const SAMPLE_STEP: i32 = FULL_TURN / SAMPLES as i32;

/// Maximum duration: a scan takes 9 s and a turn no longer, unless the robot is held.
const PATIENCE_TICKS: u16 = ticks(16);

/// Current job.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Job {
    #[default]
    Idle,
    /// Turns, clockwise positive.
    Turn(Progress),
    /// Turns right and takes samples.
    Scan(Progress),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Progress {
    /// Angle left.
    left: i32,
    /// Heading at the latest tick; `None` before the first.
    heading: Option<Angle>,
    ticks: u16,
}

impl Progress {
    const fn of(angle: i32) -> Self {
        Self {
            left: angle,
            heading: None,
            ticks: 0,
        }
    }

    /// Subtracts the turn of a tick.
    fn advance(&mut self, heading: Angle) {
        let before = self.heading.replace(heading).unwrap_or(heading);
        self.left -= i32::from(heading.minus(before));
        self.ticks += 1;
    }

    fn motion(&self, most_cps: i16) -> Motion {
        let size = (self.left.abs() / SLOW_DOWN_PER_CPS)
            .clamp(i32::from(CREEP_CPS), i32::from(most_cps)) as i16;
        Motion {
            velocity_cps: 0,
            rotation_cps: if self.left > 0 { size } else { -size },
        }
    }
}

/// Result of a turn or scan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// The turn is complete.
    Turned,
    /// The scan is complete: see [`Rotation::panorama`].
    Scanned,
    /// Ended by a bump, the operator, or wheels that do not turn.
    BrokenOff,
}

/// State of the layer.
#[derive(Clone, Debug, Default)]
pub struct Rotation {
    job: Job,
    ending: Option<Ending>,
    panorama: Panorama,
}

impl Rotation {
    /// Starts a turn by an angle, clockwise positive, with a full turn of 65,536. Replaces the current job.
    pub const fn turn_by(&mut self, angle: i32) {
        self.job = Job::Turn(Progress::of(angle));
        self.ending = None;
    }

    /// Starts a scan. Replaces the current job.
    pub fn scan(&mut self) {
        self.job = Job::Scan(Progress::of(FULL_TURN));
        self.ending = None;
        self.panorama = Panorama::default();
    }

    /// Ends the current job early.
    pub const fn break_off(&mut self) {
        if !matches!(self.job, Job::Idle) {
            self.job = Job::Idle;
            self.ending = Some(Ending::BrokenOff);
        }
    }

    /// Whether a scan is running.
    #[must_use]
    pub const fn is_scanning(&self) -> bool {
        matches!(self.job, Job::Scan(_))
    }

    /// Result of the latest job, returned once.
    pub const fn take_ending(&mut self) -> Option<Ending> {
        self.ending.take()
    }

    /// The latest scan.
    #[must_use]
    pub const fn panorama(&self) -> &Panorama {
        &self.panorama
    }
}

impl Behaviour for Rotation {
    fn decide(&mut self, senses: &Senses) -> Request {
        let (progress, most_cps, done) = match &mut self.job {
            Job::Idle => return Request::QUIET,
            Job::Turn(progress) => (progress, TURN_CPS, Ending::Turned),
            Job::Scan(progress) => (progress, SCAN_CPS, Ending::Scanned),
        };
        if senses.bumper.any() || progress.ticks >= PATIENCE_TICKS {
            self.break_off();
            return Request::QUIET;
        }
        progress.advance(senses.pose.heading);
        if done == Ending::Scanned {
            let turned = FULL_TURN - progress.left;
            self.panorama.take_sample(senses, turned / SAMPLE_STEP);
        }
        if progress.left.abs() <= ARRIVED {
            self.job = Job::Idle;
            self.ending = Some(done);
            return Request::raise(Motion::STILL);
        }
        Request::raise(progress.motion(most_cps))
    }

    fn rest(&mut self) {
        self.break_off();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Switches;
    use crate::odometry::Odometer;
    use groundwave_protocol::Waypoint;

    /// A robot that turns exactly and at once.
    #[derive(Default)]
    struct Turntable {
        layer: Rotation,
        heading: u32,
        turned_deg: f64,
        ticks: u32,
    }

    impl Turntable {
        fn tick(&mut self, bumper: Switches) -> Request {
            let mut odometer = Odometer::default();
            let origin = Waypoint { x_in: 0, y_in: 0 };
            odometer.set(origin, Angle((self.heading >> 16) as u16));
            let request = self.layer.decide(&Senses {
                pose: odometer.pose(),
                bumper,
                ..Senses::idle()
            });
            // Difference of counts in a tick, 1004 per turn.
            let turns = f64::from(request.motion.rotation_cps) / 20.0 / 1004.0;
            self.heading = self
                .heading
                .wrapping_add((turns * 4_294_967_296.0) as i64 as u32);
            self.turned_deg += turns * 360.0;
            self.ticks += 1;
            request
        }

        fn run(&mut self) -> Option<Ending> {
            while self.ticks < 1000 && self.tick(Switches::default()).flag {}
            self.layer.take_ending()
        }
    }

    #[test]
    fn scan_is_a_full_turn_at_45_degrees_per_second() {
        let mut table = Turntable::default();
        table.layer.scan();
        assert!(table.layer.is_scanning());
        assert_eq!(table.run(), Some(Ending::Scanned));
        assert!(
            (table.turned_deg - 360.0).abs() <= 1.5,
            "{}",
            table.turned_deg
        );
        // 8 s, and slowing down.
        assert!((160..200).contains(&table.ticks), "{}", table.ticks);
        assert!(!table.layer.is_scanning());
        assert_eq!(table.tick(Switches::default()), Request::QUIET);
        assert_eq!(table.layer.take_ending(), None);
    }

    #[test]
    fn turn_reaches_its_angle_in_both_directions() {
        for degrees in [90, -90, 180, -180, 7, 540, 0] {
            let mut table = Turntable::default();
            table.layer.turn_by(degrees * FULL_TURN / 360);
            assert_eq!(table.run(), Some(Ending::Turned), "{degrees}");
            let error = table.turned_deg - f64::from(degrees);
            assert!(error.abs() <= 1.5, "{degrees}: {}", table.turned_deg);
        }
    }

    #[test]
    fn bump_ends_the_scan_within_the_tick() {
        let mut table = Turntable::default();
        table.layer.scan();
        for _ in 0..50 {
            assert!(table.tick(Switches::default()).flag);
        }
        let bumped = Switches {
            center: true,
            ..Switches::default()
        };
        assert_eq!(table.tick(bumped), Request::QUIET);
        assert_eq!(table.layer.take_ending(), Some(Ending::BrokenOff));
        assert_eq!(table.tick(Switches::default()), Request::QUIET);
    }

    #[test]
    fn blocked_wheels_end_the_turn() {
        let mut layer = Rotation::default();
        layer.turn_by(FULL_TURN / 4);
        let ticks = (0..1000).take_while(|_| layer.decide(&Senses::idle()).flag);
        assert_eq!(ticks.count(), usize::from(PATIENCE_TICKS));
        assert_eq!(layer.take_ending(), Some(Ending::BrokenOff));
    }

    #[test]
    fn rest_reports_the_broken_job_once() {
        let mut layer = Rotation::default();
        layer.rest();
        assert_eq!(layer.take_ending(), None);
        layer.scan();
        layer.rest();
        layer.rest();
        assert_eq!(layer.take_ending(), Some(Ending::BrokenOff));
        assert_eq!(layer.take_ending(), None);
    }
}
