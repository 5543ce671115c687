//! Two cadmium-sulphide cells looking left and right, each in a voltage divider.

use super::View;
use crate::geometry::{Vec2, bearing};
use crate::rng::Rng;
use crate::scene::Scene;
use crate::world::Lamp;

const MOUNT_DEG: f64 = 45.0;
/// Height of the cells above the floor, inches.
const HEIGHT_IN: f64 = 5.0;
const M_PER_IN: f64 = 0.0254;
/// Resistance of a cell at [`CELL_LUX`], and the exponent of its fall with light.
const CELL_OHM: f64 = 12_000.0;
const CELL_LUX: f64 = 10.0;
const CELL_GAMMA: f64 = 0.75;
const PULL_UP_OHM: f64 = 10_000.0;

/// Lamps and daylight.
pub(crate) struct Light {
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) daylight_lux: f64,
}

impl Light {
    /// Readings of the left and right cells, 0 very bright to 255 dark.
    pub(crate) fn read(&self, scene: &Scene, view: View, rng: &mut Rng) -> (u8, u8) {
        let (mut left, mut right) = (self.daylight_lux, self.daylight_lux);
        for lamp in self.lamps.iter().filter(|lamp| lamp.on) {
            if scene.is_lit(lamp.center, view.center) {
                let lux = illuminance_lux(lamp, view.center);
                let across_rad = bearing(lamp.center - view.center) - view.theta_rad;
                left += lux * facing(across_rad + MOUNT_DEG.to_radians());
                right += lux * facing(across_rad - MOUNT_DEG.to_radians());
            }
        }
        (divider(left, rng), divider(right, rng))
    }
}

/// Illuminance from an unobstructed lamp, by the inverse square of its distance.
fn illuminance_lux(lamp: &Lamp, at: Vec2) -> f64 {
    let rise_in = lamp.height_in - HEIGHT_IN;
    let distance_m2 = (lamp.center.distance_squared(at) + rise_in * rise_in) * M_PER_IN * M_PER_IN;
    lamp.candela / distance_m2.max(0.01)
}

/// Share of a light that a cell receives at this angle off its axis.
fn facing(across_rad: f64) -> f64 {
    0.5 + 0.5 * libm::cos(across_rad)
}

fn divider(lux: f64, rng: &mut Rng) -> u8 {
    let noise = rng.spread(1.0);
    if lux <= 0.0 {
        return u8::MAX;
    }
    let cell_ohm = CELL_OHM * libm::pow(lux / CELL_LUX, -CELL_GAMMA);
    let reading = 255.0 * cell_ohm / (cell_ohm + PULL_UP_OHM) + noise;
    reading.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::{room, view_at};

    fn lamp(x: f64, y: f64) -> Lamp {
        Lamp {
            name: "test".to_owned(),
            center: Vec2::new(x, y),
            candela: 100.0,
            height_in: HEIGHT_IN,
            on: true,
        }
    }

    /// Illuminance in lux that gives a reading.
    fn lux(reading: u8) -> f64 {
        let share = f64::from(reading) / 255.0;
        let cell_ohm = PULL_UP_OHM * share / (1.0 - share);
        CELL_LUX * libm::pow(cell_ohm / CELL_OHM, -1.0 / CELL_GAMMA)
    }

    fn read(light: &Light, scene: &Scene, view: View) -> (f64, f64) {
        let mut rng = Rng::new(1, Stream::Photocells);
        let mut sum = (0.0, 0.0);
        for _ in 0..100 {
            let (left, right) = light.read(scene, view, &mut rng);
            sum.0 += lux(left) / 100.0;
            sum.1 += lux(right) / 100.0;
        }
        sum
    }

    #[test]
    fn illuminance_falls_with_the_square_of_the_distance() {
        let scene = room(100, &[]);
        let light = Light {
            lamps: vec![lamp(300.0, 300.0)],
            daylight_lux: 0.0,
        };
        let near = read(&light, &scene, view_at(300.0, 260.0, 0.0)).0;
        let far = read(&light, &scene, view_at(300.0, 220.0, 0.0)).0;
        assert!((near / far - 4.0).abs() < 0.2, "{near} {far}");
        let distance_m = 40.0 * M_PER_IN;
        let expected = 100.0 / (distance_m * distance_m) * facing(MOUNT_DEG.to_radians());
        assert!((near / expected - 1.0).abs() < 0.05, "{near} {expected}");
    }

    #[test]
    fn cell_on_the_lamps_side_is_brighter() {
        let scene = room(100, &[]);
        let light = Light {
            lamps: vec![lamp(200.0, 300.0)],
            daylight_lux: 0.0,
        };
        let mut rng = Rng::new(1, Stream::Photocells);
        let (left, right) = light.read(&scene, view_at(300.0, 300.0, 0.0), &mut rng);
        assert!(left + 20 < right, "{left} {right}");
    }

    #[test]
    fn bookcase_throws_a_shadow_and_a_sofa_does_not() {
        let light = Light {
            lamps: vec![lamp(300.0, 500.0)],
            daylight_lux: 1.0,
        };
        let view = view_at(300.0, 200.0, 0.0);
        let mut rng = Rng::new(1, Stream::Photocells);
        let (shaded, _) = light.read(&room(100, &["box", "wood"]), view, &mut rng);
        let (lit, _) = light.read(&room(100, &["box", "soft"]), view, &mut rng);
        assert!(lit + 20 < shaded, "{lit} {shaded}");
    }

    #[test]
    fn reading_in_darkness_is_255() {
        let light = Light {
            lamps: Vec::new(),
            daylight_lux: 0.0,
        };
        let mut rng = Rng::new(1, Stream::Photocells);
        assert_eq!(
            light.read(&room(20, &[]), view_at(60.0, 60.0, 0.0), &mut rng),
            (255, 255)
        );
    }
}
