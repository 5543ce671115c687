//! Two infrared detectors at 45 degrees and the LEDs between them, sampled 250 times a second.

use super::View;
use crate::geometry::{Vec2, bearing};
use crate::rng::Rng;
use crate::scene::Scene;

const MOUNT_DEG: f64 = 45.0;
const RIGHT_IN: f64 = 3.5;
const AHEAD_IN: f64 = 3.5;
/// Maximum distance at which a white wall facing a detector is seen, inches.
const REACH_IN: f64 = 30.0;
/// Reflectivity of a white wall.
const WHITE: f64 = 0.8;
/// Half of a detector's field of view.
const LOBE_DEG: f64 = 55.0;
const RAYS: u32 = 9;
/// Random spread of a single sample's strength.
const NOISE: f64 = 0.1;
/// Movement, or samples while something else moves, after which the strengths are measured again, inches.
const MOVED_IN: f64 = 0.25;
const TURNED_RAD: f64 = 0.025;
const STALE_SAMPLES: u32 = 25;
/// Bursts of ambient infrared: chance that one starts at a sample, and its mean length in samples.
const BURST_CHANCE: f64 = 1.0 / (20.0 * 250.0);
const BURST_SAMPLES: f64 = 30.0;
/// Chance that a detector fires at a sample during a burst.
const BURST_FIRES: f64 = 0.6;

/// State of both detectors.
pub(crate) struct Infrared {
    /// Strength of the reflections, left and right; the threshold is 1.
    strengths: [f64; 2],
    measured: Option<View>,
    age_samples: u32,
    burst_samples: u32,
}

impl Infrared {
    pub(crate) const fn new() -> Self {
        Self {
            strengths: [0.0; 2],
            measured: None,
            age_samples: 0,
            burst_samples: 0,
        }
    }

    /// Readings of the left and right detectors while the LEDs are on or off.
    ///
    /// `clearance_in` is a distance from the robot's centre that is free of fixed obstacles.
    pub(crate) fn sample(
        &mut self,
        scene: &Scene,
        view: View,
        clearance_in: f64,
        lit: bool,
        rng: &mut Rng,
    ) -> (bool, bool) {
        let ambient = self.ambient(rng);
        if !lit {
            return ambient;
        }
        self.refresh(scene, view, clearance_in, rng);
        let [left, right] = self.strengths;
        (ambient.0 | seen(left, rng), ambient.1 | seen(right, rng))
    }

    fn ambient(&mut self, rng: &mut Rng) -> (bool, bool) {
        if self.burst_samples == 0 {
            if rng.chance(BURST_CHANCE) {
                self.burst_samples = 1 + (2.0 * BURST_SAMPLES * rng.unit()) as u32;
            }
            return (false, false);
        }
        self.burst_samples -= 1;
        (rng.chance(BURST_FIRES), rng.chance(BURST_FIRES))
    }

    fn refresh(&mut self, scene: &Scene, view: View, clearance_in: f64, rng: &mut Rng) {
        self.age_samples += 1;
        let is_fresh = self.measured.is_some_and(|measured| {
            measured.center.distance_squared(view.center) < MOVED_IN * MOVED_IN
                && (measured.theta_rad - view.theta_rad).abs() < TURNED_RAD
        });
        if is_fresh && self.age_samples < STALE_SAMPLES {
            return;
        }
        self.measured = Some(view);
        self.age_samples = 0;
        let out_of_reach = REACH_IN + RIGHT_IN + AHEAD_IN;
        let walker_near = scene.walkers.iter().any(|walker| {
            walker.center().distance(view.center) < out_of_reach + walker.radius_in()
        });
        self.strengths = if clearance_in > out_of_reach && !walker_near {
            [0.0; 2]
        } else {
            [
                strength(scene, view, -1.0, rng.unit()),
                strength(scene, view, 1.0, rng.unit()),
            ]
        };
    }
}

fn seen(strength: f64, rng: &mut Rng) -> bool {
    // Far below or above the threshold the noise does not matter.
    if strength < 0.6 {
        false
    } else {
        strength > 2.0 || strength * (1.0 + NOISE * rng.normal()) > 1.0
    }
}

/// Strength of the strongest reflection in one detector's field of view.
fn strength(scene: &Scene, view: View, side: f64, jitter: f64) -> f64 {
    let eye = view.point(side * RIGHT_IN, AHEAD_IN);
    let axis_rad = (side * MOUNT_DEG).to_radians();
    let mut strongest: f64 = 0.0;
    for ray in 0..RAYS {
        let across_deg = ((f64::from(ray) + jitter) / f64::from(RAYS) * 2.0 - 1.0) * LOBE_DEG;
        let across_rad = across_deg.to_radians();
        let direction = view.direction(axis_rad + across_rad);
        let Some(hit) = scene.cast(eye, direction, REACH_IN, |surface| {
            surface.reflectivity > 0.0
        }) else {
            continue;
        };
        if !hit.is_round {
            let facing = -direction.dot(hit.normal);
            let reflected = hit.material.surface().reflectivity * facing;
            strongest = strongest.max(gain(across_rad) * fall_off(reflected, hit.distance_in));
        }
    }
    scene.near(eye, REACH_IN, |near| {
        let Some(radius_in) = near.radius_in else {
            return;
        };
        let across_rad = angle_between(near.toward, view.direction(axis_rad));
        let distance_in = near.distance_in.max(0.5);
        // A thin leg fills only a part of the field of view.
        let share = (4.0 * radius_in / distance_in).min(1.0);
        let reflected = near.material.surface().reflectivity * share;
        let strength = gain(across_rad) * fall_off(reflected, distance_in);
        if strength > strongest && is_in_sight(scene, eye, near.toward, distance_in) {
            strongest = strength;
        }
    });
    strongest
}

fn is_in_sight(scene: &Scene, eye: Vec2, toward: Vec2, distance_in: f64) -> bool {
    scene
        .cast(eye, toward, distance_in - 0.1, |surface| {
            surface.reflectivity > 0.0
        })
        .is_none()
}

/// Sensitivity of a detector off its axis, as a share.
fn gain(across_rad: f64) -> f64 {
    if across_rad.abs() > LOBE_DEG.to_radians() {
        return 0.0;
    }
    let cos = libm::cos(across_rad);
    cos * cos
}

fn fall_off(reflected: f64, distance_in: f64) -> f64 {
    let nearness = REACH_IN / distance_in.max(0.5);
    reflected / WHITE * nearness * nearness
}

fn angle_between(one: Vec2, other: Vec2) -> f64 {
    crate::geometry::wrap_deg((bearing(one) - bearing(other)).to_degrees()).to_radians()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::{room, view_at};

    /// Share of lit samples at which the left and right detectors fire.
    fn shares(scene: &Scene, view: View) -> (f64, f64) {
        let mut rng = Rng::new(5, Stream::Infrared);
        let mut infrared = Infrared::new();
        let (mut left, mut right) = (0, 0);
        for _ in 0..5000 {
            let (on_left, on_right) = infrared.sample(scene, view, 0.0, true, &mut rng);
            left += u32::from(on_left);
            right += u32::from(on_right);
        }
        (f64::from(left) / 5000.0, f64::from(right) / 5000.0)
    }

    #[test]
    fn white_wall_on_the_axis_is_seen_to_thirty_inches() {
        let scene = room(100, &[]);
        // The left detector's axis points north when the robot faces 45 degrees.
        let at = |distance_in: f64| {
            let mut view = view_at(300.0, 300.0, 45.0);
            let eye = view.point(-RIGHT_IN, AHEAD_IN);
            view.center.y += 594.0 - distance_in - eye.y;
            shares(&scene, view).0
        };
        assert!(at(24.0) > 0.95, "{}", at(24.0));
        assert!(at(36.0) < 0.05, "{}", at(36.0));
    }

    #[test]
    fn both_detectors_see_a_wall_ahead_at_less_distance() {
        let scene = room(100, &[]);
        let near = shares(&scene, view_at(300.0, 594.0 - 15.0, 0.0));
        assert!(near.0 > 0.9 && near.1 > 0.9, "{near:?}");
        let far = shares(&scene, view_at(300.0, 594.0 - 34.0, 0.0));
        assert!(far.0 < 0.1 && far.1 < 0.1, "{far:?}");
    }

    #[test]
    fn wall_on_the_left_is_not_seen_on_the_right() {
        let scene = room(100, &[]);
        let (left, right) = shares(&scene, view_at(20.0, 300.0, 0.0));
        assert!(left > 0.9 && right < 0.05, "{left} {right}");
    }

    #[test]
    fn black_furniture_is_nearly_invisible() {
        let dark = room(100, &["box", "dark"]);
        let view = view_at(300.0, 300.0 - 25.0, 0.0);
        let (left, right) = shares(&dark, view);
        assert!(left < 0.05 && right < 0.05, "{left} {right}");
        let white = room(100, &["box", "wall"]);
        let (left, right) = shares(&white, view);
        assert!(left > 0.9 && right > 0.9, "{left} {right}");
    }

    #[test]
    fn ambient_bursts_fire_with_the_leds_off() {
        let scene = room(100, &[]);
        let mut rng = Rng::new(9, Stream::Infrared);
        let mut infrared = Infrared::new();
        let view = view_at(300.0, 300.0, 0.0);
        let fired = (0..250 * 600)
            .filter(|_| infrared.sample(&scene, view, 0.0, false, &mut rng) != (false, false))
            .count();
        // Ten minutes hold about thirty bursts of about thirty looks.
        assert!((300..2000).contains(&fired), "{fired}");
    }
}
