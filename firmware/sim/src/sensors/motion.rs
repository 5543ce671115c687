//! Two passive infrared detectors on the raised arm; one looks left, one right, and both see the middle.
//!
//! Behind its Fresnel lens a detector sees zones. It fires when a warm body crosses from one zone to the next: it
//! responds to the angular speed of a body, not to its approach.

use sr04_firmware::board::Sides;

use super::View;
use crate::dimensions::ARM_BEHIND_IN;
use crate::geometry::{Vec2, bearing, wrap_deg};
use crate::rng::Rng;
use crate::scene::Scene;
use crate::time::TICK_MS;

/// Angle of each axis from the nose, and half of each field: both see the middle 30 degrees.
const MOUNT_DEG: f64 = 25.0;
const HALF_FIELD_DEG: f64 = 40.0;
/// Reach as a multiple of a body's radius: a person at 20 ft, a cat at 12 ft.
const REACH_RADII: f64 = 40.0;
/// Sweep that makes a detector fire, about one zone, and its random spread, degrees.
const ZONE_DEG: f64 = 4.0;
const ZONE_SPREAD: f64 = 0.15;
/// Share of the sweep kept after a tick: a body must cross a zone within about a second.
const KEPT: f64 = 0.95;
/// Duration of an output pulse.
const PULSE_TICKS: f64 = 20.0;
/// Ticks that the detectors need to settle after the robot or the arm has moved, and the chance of firing at the first
/// of them.
const UNSETTLED_TICKS: u32 = 10_000 / TICK_MS as u32;
const UNSETTLED_FIRES: f64 = 0.08;
/// Chance of a false alarm per tick, from draughts and heaters: one in ten hours for each detector.
const FALSE_ALARM: f64 = TICK_MS as f64 / (10.0 * 3_600_000.0);

/// State of the robot that carries the detectors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carrier {
    pub(crate) view: View,
    /// Whether the arm is raised and at rest.
    pub(crate) arm_is_up: bool,
    pub(crate) robot_moves: bool,
}

/// State of both detectors.
#[derive(Clone, Debug, Default)]
pub(crate) struct MotionDetectors {
    /// Bearing of every warm body at the last tick.
    bearings_deg: Vec<f64>,
    left: Detector,
    right: Detector,
    unsettled_ticks: u32,
}

impl MotionDetectors {
    /// Advances one tick.
    pub(crate) fn step(&mut self, scene: &Scene, carrier: Carrier, rng: &mut Rng) {
        if !carrier.arm_is_up || carrier.robot_moves {
            self.unsettled_ticks = UNSETTLED_TICKS;
        }
        if !carrier.arm_is_up {
            // The bumper is opaque to body heat.
            self.left = Detector::default();
            self.right = Detector::default();
            self.bearings_deg.clear();
            return;
        }
        let calm = f64::from(self.unsettled_ticks) / f64::from(UNSETTLED_TICKS);
        self.unsettled_ticks = self.unsettled_ticks.saturating_sub(1);
        let alarm = FALSE_ALARM + UNSETTLED_FIRES * calm;
        let (left_deg, right_deg) = self.sweeps(scene, carrier.view);
        self.left.step(left_deg, alarm, rng);
        self.right.step(right_deg, alarm, rng);
    }

    /// Angle that warm bodies have swept through each field since the last tick, degrees.
    fn sweeps(&mut self, scene: &Scene, view: View) -> (f64, f64) {
        let eye = view.point(0.0, -ARM_BEHIND_IN);
        let is_new = self.bearings_deg.len() != scene.walkers.len();
        self.bearings_deg.resize(scene.walkers.len(), 0.0);
        let (mut left, mut right) = (0.0, 0.0);
        for (walker, before) in scene.walkers.iter().zip(&mut self.bearings_deg) {
            let offset = walker.center() - eye;
            let now = wrap_deg((bearing(offset) - view.theta_rad).to_degrees());
            let swept = wrap_deg(now - *before).abs();
            *before = now;
            if is_new || swept < 1e-6 || !is_detected(scene, eye, offset, walker.radius_in()) {
                continue;
            }
            if (now + MOUNT_DEG).abs() < HALF_FIELD_DEG {
                left += swept;
            }
            if (now - MOUNT_DEG).abs() < HALF_FIELD_DEG {
                right += swept;
            }
        }
        (left, right)
    }

    /// Outputs of the detectors.
    pub(crate) fn sides(&self) -> Sides {
        Sides {
            left: self.left.pulse_ticks > 0,
            right: self.right.pulse_ticks > 0,
        }
    }
}

/// Whether a warm body is large enough in view and not hidden.
fn is_detected(scene: &Scene, eye: Vec2, offset: Vec2, radius_in: f64) -> bool {
    let distance = offset.length();
    distance < REACH_RADII * radius_in
        && (distance < radius_in
            || scene
                .cast(eye, offset / distance, distance, |surface| {
                    surface.hides_warmth
                })
                .is_none())
}

#[derive(Clone, Debug, Default)]
struct Detector {
    swept_deg: f64,
    pulse_ticks: u32,
}

impl Detector {
    fn step(&mut self, swept_deg: f64, alarm: f64, rng: &mut Rng) {
        self.pulse_ticks = self.pulse_ticks.saturating_sub(1);
        self.swept_deg = self.swept_deg * KEPT + swept_deg;
        let zone = ZONE_DEG * (1.0 + ZONE_SPREAD * rng.normal());
        if self.swept_deg > zone || rng.chance(alarm) {
            self.swept_deg = 0.0;
            self.pulse_ticks = (PULSE_TICKS * (1.0 + rng.spread(0.2))) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::{scene, view_at};
    use crate::walker::STEP_MS;

    const SETTLED: u32 = UNSETTLED_TICKS + 20;

    fn walk(kind: &str, path: &str, rest: &str) -> Scene {
        let row = format!("#{}#\n", ".".repeat(60));
        let text = format!(
            "name = \"t\"\ncell_in = 6\nplan = '''\n{wall}\n{rows}#...^{floor}#\n{row}{row}{wall}\n'''\n\
             [[walker]]\nkind = \"{kind}\"\npath = {path}\n{rest}\n",
            wall = "#".repeat(62),
            rows = row.repeat(54),
            floor = ".".repeat(56),
        );
        scene(&text)
    }

    /// Ticks at which left and right fired in `ticks` settled ticks, with the robot facing north.
    fn fired(scene: &mut Scene, carrier: Carrier, ticks: u32) -> (u32, u32) {
        let mut motion = MotionDetectors::default();
        let mut rng = Rng::new(4, Stream::Motion);
        let (mut left, mut right) = (0, 0);
        for tick in 0..SETTLED + ticks {
            if tick >= SETTLED {
                for walker in &mut scene.walkers {
                    for _ in 0..TICK_MS / STEP_MS {
                        walker.step(carrier.view.center, 5.5);
                    }
                }
            }
            motion.step(scene, carrier, &mut rng);
            if tick >= SETTLED {
                let sides = motion.sides();
                left += u32::from(sides.left);
                right += u32::from(sides.right);
            }
        }
        (left, right)
    }

    fn standing(x_in: f64, y_in: f64) -> Carrier {
        Carrier {
            view: view_at(x_in, y_in, 0.0),
            arm_is_up: true,
            robot_moves: false,
        }
    }

    #[test]
    fn person_passing_by_fires_the_detector_on_that_side() {
        let at = standing(180.0, 60.0);
        let mut on_the_left = walk("person", "[[80, 120], [140, 140]]", "");
        let (left, right) = fired(&mut on_the_left, at, 40);
        assert!(left > 15 && right == 0, "{left} {right}");
        let mut on_the_right = walk("person", "[[280, 120], [220, 140]]", "");
        let (left, right) = fired(&mut on_the_right, at, 40);
        assert!(right > 15 && left == 0, "{left} {right}");
        let mut ahead = walk("cat", "[[174, 130], [186, 130]]", "");
        let (left, right) = fired(&mut ahead, at, 40);
        assert!(left > 15 && right > 15, "{left} {right}");
    }

    #[test]
    fn hidden_distant_and_approaching_people_are_not_detected() {
        let at = standing(180.0, 60.0);
        let mut behind = walk("person", "[[100, 20], [260, 20]]", "");
        assert_eq!(fired(&mut behind, at, 60), (0, 0));
        let mut far = walk("cat", "[[140, 300], [220, 300]]", "");
        assert_eq!(fired(&mut far, at, 60), (0, 0));
        let mut straight = walk("person", "[[180, 280], [180, 100]]", "");
        assert_eq!(fired(&mut straight, at, 60), (0, 0));
        let glass =
            "[[clutter]]\nkind = \"box\"\nat = [180, 90]\nsize_in = [300, 4]\nmade_of = \"glass\"";
        let mut hidden = walk("person", "[[80, 120], [280, 120]]", glass);
        assert_eq!(fired(&mut hidden, at, 60), (0, 0));
    }

    #[test]
    fn stowed_arm_detects_nothing_and_a_moving_robot_fires_falsely() {
        let mut empty = walk("person", "[[20, 300], [340, 300]]", "");
        empty.walkers.clear();
        let at = standing(180.0, 60.0);
        let moving = Carrier {
            robot_moves: true,
            ..at
        };
        let (left, right) = fired(&mut empty, moving, 600);
        assert!(left > 100 && right > 100, "{left} {right}");
        let stowed = Carrier {
            arm_is_up: false,
            ..at
        };
        let mut person = walk("person", "[[80, 120], [280, 120]]", "");
        assert_eq!(fired(&mut person, stowed, 600), (0, 0));
    }

    #[test]
    fn false_alarms_are_rare() {
        let mut empty = walk("person", "[[20, 300], [340, 300]]", "");
        empty.walkers.clear();
        let mut motion = MotionDetectors::default();
        let mut rng = Rng::new(1, Stream::Motion);
        let at = standing(180.0, 60.0);
        let (mut alarms, mut was) = (0, false);
        let hours = 200;
        for tick in 0..hours * 72_000_u32 {
            motion.step(&empty, at, &mut rng);
            let is = motion.sides().any();
            alarms += u32::from(is && !was && tick > SETTLED);
            was = is;
        }
        // Two detectors with one alarm each in ten hours: 40 in 200 hours.
        assert!((20..60).contains(&alarms), "{alarms}");
    }
}
