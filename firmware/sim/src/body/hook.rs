//! Cords and shoes that catch on the bumper and hold a switch closed.

use sr04_firmware::board::Switches;

use crate::dimensions::RADIUS_IN;
use crate::geometry::{Vec2, heading};
use crate::rng::Rng;
use crate::scene::Scene;
use crate::time::TICK_MS;
use crate::world::Snag;

/// Angles along the bumper where an object may catch, in degrees from its middle.
const CATCH_ANGLES_DEG: [f64; 5] = [0.0, -30.0, 30.0, -60.0, 60.0];
/// Distance below the bumper's edge within which an object catches.
const REACH_IN: f64 = 0.3;
/// Minimum forward speed at which an object catches, in/s.
const AHEAD_IN_S: f64 = 0.5;
/// Bumper movement that frees the object: minimum, and range above it.
const WORK_IN: (f64, f64) = (10.0, 20.0);
/// Movement that one reversal of the drive or the turn counts as, inches.
const JERK_IN: f64 = 3.0;
/// Minimum speed that has a direction, in/s.
const STILL_IN_S: f64 = 0.5;

/// Speeds of the body: forward, and of the bumper around the centre, clockwise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BumperSpeed {
    pub(crate) ahead_in_s: f64,
    pub(crate) around_in_s: f64,
}

/// State of an object caught on the bumper.
#[derive(Clone, Debug, Default)]
pub(crate) struct Hook {
    /// Angle from the bumper's middle in degrees, and the movement left until it is free.
    held: Option<(f64, f64)>,
    /// Whether the object below the robot has already been drawn for.
    was_tried: bool,
    /// Latest direction of driving and of turning, 1 or -1.
    ahead: f64,
    around: f64,
}

impl Hook {
    /// Advances one tick.
    pub(crate) fn step(
        &mut self,
        scene: &Scene,
        center: Vec2,
        theta_rad: f64,
        speed: BumperSpeed,
        rng: &mut Rng,
    ) {
        let jerks =
            turned(&mut self.ahead, speed.ahead_in_s) + turned(&mut self.around, speed.around_in_s);
        if let Some((at_deg, work_in)) = self.held {
            let turned_in = speed.around_in_s.abs() * TICK_MS as f64 / 1000.0;
            let left_in = work_in - turned_in - JERK_IN * jerks;
            self.held = (left_in > 0.0).then_some((at_deg, left_in));
            return;
        }
        let is_over = |snag: &Snag| snag.solid.approach(center).0 < RADIUS_IN + REACH_IN;
        self.was_tried &= scene.snags.iter().any(is_over);
        if self.was_tried || speed.ahead_in_s < AHEAD_IN_S {
            return;
        }
        let caught = CATCH_ANGLES_DEG.iter().find_map(|&at_deg| {
            let edge = center + heading(theta_rad + at_deg.to_radians()) * RADIUS_IN;
            let mut snags = scene.snags.iter();
            let snag = snags.find(|snag| snag.solid.approach(edge).0 < REACH_IN)?;
            Some((at_deg, snag.chance))
        });
        let Some((at_deg, chance)) = caught else {
            return;
        };
        self.was_tried = true;
        if rng.chance(chance) {
            let (least, more) = WORK_IN;
            self.held = Some((at_deg, least + more * rng.unit()));
        }
    }

    /// Whether an object is caught.
    pub(crate) const fn holds(&self) -> bool {
        self.held.is_some()
    }

    /// Closes the switch at the caught object.
    pub(crate) fn press(&self, switches: &mut Switches) {
        if let Some((at_deg, _)) = self.held {
            switches.left |= at_deg < 0.0;
            switches.center |= at_deg == 0.0;
            switches.right |= at_deg > 0.0;
        }
    }
}

/// 1 if a speed has reversed since it last had a direction, else 0.
fn turned(direction: &mut f64, speed_in_s: f64) -> f64 {
    if speed_in_s.abs() < STILL_IN_S {
        return 0.0;
    }
    let before = core::mem::replace(direction, speed_in_s.signum());
    f64::from(u8::from(before * speed_in_s < 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::docking;

    const AHEAD: BumperSpeed = BumperSpeed {
        ahead_in_s: 6.0,
        around_in_s: 0.0,
    };

    /// Drives the nose over the cord; returns the hook if it caught.
    fn caught(scene: &Scene, seed: u64) -> Option<(Hook, Rng)> {
        let mut hook = Hook::default();
        let mut rng = Rng::new(seed, Stream::Snags);
        for tick in 0..40 {
            let center = Vec2::new(120.0, 80.0 + 0.3 * f64::from(tick));
            hook.step(scene, center, 0.0, AHEAD, &mut rng);
        }
        hook.holds().then_some((hook, rng))
    }

    fn with_a_cord() -> Scene {
        docking("[[clutter]]\nkind = \"cord\"\nat = [120, 90]\n")
    }

    #[test]
    fn one_cord_crossing_in_four_catches() {
        let scene = with_a_cord();
        let count = (0..400)
            .filter(|&seed| caught(&scene, seed).is_some())
            .count();
        assert!((70..130).contains(&count), "{count}");
    }

    #[test]
    fn caught_cord_holds_the_switch_until_worked_free() {
        let scene = with_a_cord();
        let (mut hook, mut rng) = (0..40)
            .find_map(|seed| caught(&scene, seed))
            .expect("one of 40 seeds catches");
        let away = Vec2::new(120.0, 40.0);
        let mut go = |ahead_in_s: f64, around_in_s: f64, ticks: u32| {
            for _ in 0..ticks {
                let speed = BumperSpeed {
                    ahead_in_s,
                    around_in_s,
                };
                hook.step(&scene, away, 0.0, speed, &mut rng);
            }
            let mut switches = Switches::default();
            hook.press(&mut switches);
            switches
        };
        // A robot that backs off drags the cord along.
        assert!(go(-6.0, 0.0, 100).any());
        for twist in 0..10 {
            go(0.0, if twist % 2 == 0 { 5.0 } else { -5.0 }, 8);
        }
        assert!(!go(6.0, 0.0, 1).any());
    }
}
