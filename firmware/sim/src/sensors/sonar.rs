//! A Polaroid sonar ranger: the first echo of a fan of rays.
//!
//! A smooth wall reflects sound like a mirror unless the sound arrives nearly square. An oblique wall is silent or
//! answers by way of another wall, at too great a distance.

use sr04_firmware::board::Side;

use super::View;
use crate::geometry::Vec2;
use crate::rng::Rng;
use crate::scene::Scene;

const MOUNT_DEG: f64 = 7.5;
const BEAM_DEG: f64 = 15.0;
const RAYS: u32 = 11;
const BOUNCES: u32 = 4;
const RIGHT_IN: f64 = 1.5;
const AHEAD_IN: f64 = 5.0;
const NEAR_IN: f64 = 3.0;
const FAR_IN: f64 = 420.0;
/// Maximum echo distance before noise, a little above [`FAR_IN`], inches.
const HEARD_IN: f64 = 440.0;
/// Standard deviation of the noise as a share of the range.
const NOISE: f64 = 0.01;
/// Share of pings without an echo.
const DEAF: f64 = 0.005;
/// Distance from the transducer within which a returning ray is heard, inches.
const APERTURE_IN: f64 = 2.5;

/// Speed of sound, inches per millisecond.
const SOUND_IN_MS: f64 = 13.5;
/// Share of the other ranger's late echoes that a ranger hears.
const HEARS_NEIGHBOUR: f64 = 0.5;

/// Both rangers. A late echo of one ranger's ping may be taken by the other for its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sonars {
    /// The last ping: its side, its time and the distance its sound travels.
    last: Option<(Side, u64, f64)>,
}

impl Sonars {
    /// Pings at `now_ms` and returns the reported range in inches.
    pub(crate) fn ping(
        &mut self,
        scene: &Scene,
        view: View,
        side: Side,
        now_ms: u64,
        rng: &mut Rng,
    ) -> Option<u16> {
        let own = ping(scene, view, side, rng);
        let before = self.last;
        self.last = own.map(|range_in| (side, now_ms, 2.0 * f64::from(range_in)));
        let foreign = before.and_then(|(other, sent_ms, path_in)| {
            let left_in = path_in - (now_ms - sent_ms) as f64 * SOUND_IN_MS;
            (other != side && left_in > 0.0 && rng.chance(HEARS_NEIGHBOUR))
                .then_some((left_in / 2.0).max(NEAR_IN) as u16)
        });
        own.into_iter().chain(foreign).min()
    }
}

/// Distance of the first echo in whole inches; `None` without an echo.
fn ping(scene: &Scene, view: View, side: Side, rng: &mut Rng) -> Option<u16> {
    let sign = match side {
        Side::Left => -1.0,
        Side::Right => 1.0,
    };
    let eye = view.point(sign * RIGHT_IN, AHEAD_IN);
    // The noise is always drawn, so that one ping never changes the noise of the next.
    let (jitter, noise, deaf) = (rng.unit(), rng.normal(), rng.chance(DEAF));
    let spacing_deg = BEAM_DEG / f64::from(RAYS);
    let first = (0..RAYS)
        .filter_map(|ray| {
            let across_deg = (f64::from(ray) + jitter) * spacing_deg - BEAM_DEG / 2.0;
            let direction = view.direction((sign * MOUNT_DEG + across_deg).to_radians());
            echo(scene, eye, direction)
        })
        .min_by(f64::total_cmp)?;
    if deaf {
        return None;
    }
    let range_in = (first * (1.0 + NOISE * noise)).round().max(NEAR_IN);
    (range_in <= FAR_IN).then_some(range_in as u16)
}

/// Half of the distance that sound travels along one ray and back to the transducer.
fn echo(scene: &Scene, eye: Vec2, direction: Vec2) -> Option<f64> {
    let (mut origin, mut direction) = (eye, direction);
    let mut travelled_in = 0.0;
    for bounce in 0..=BOUNCES {
        let left_in = 2.0 * HEARD_IN - travelled_in;
        let hit = scene.cast(origin, direction, left_in, |surface| surface.sound);
        let free_in = hit.map_or(left_in, |hit| hit.distance_in);
        if bounce > 0
            && let Some(path_in) = passes(origin, direction, free_in, eye)
        {
            return Some(f64::midpoint(travelled_in, path_in));
        }
        let hit = hit?;
        travelled_in += hit.distance_in;
        let surface = hit.material.surface();
        let squareness = -direction.dot(hit.normal);
        if squareness >= libm::cos(surface.echo_cone_deg.to_radians()) {
            return (travelled_in <= surface.echo_reach_in.min(HEARD_IN)).then_some(travelled_in);
        }
        if !surface.mirrors {
            return None;
        }
        origin = origin + direction * hit.distance_in + hit.normal * 0.01;
        direction += hit.normal * (2.0 * squareness);
    }
    None
}

/// Distance along a ray at which it passes the transducer; `None` if it misses it.
fn passes(origin: Vec2, direction: Vec2, length_in: f64, eye: Vec2) -> Option<f64> {
    let along = (eye - origin).dot(direction);
    let aside = eye.distance(origin + direction * along);
    (along > 0.0 && along < length_in && aside < APERTURE_IN).then_some(along)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Stream;
    use crate::testing::{room, view_at};

    fn ranges(scene: &Scene, view: View, side: Side) -> Vec<Option<u16>> {
        let mut rng = Rng::new(1, Stream::Sonar);
        (0..200)
            .map(|_| ping(scene, view, side, &mut rng))
            .collect()
    }

    fn median(mut ranges: Vec<Option<u16>>) -> u16 {
        ranges.retain(Option::is_some);
        ranges.sort_unstable();
        ranges[ranges.len() / 2].expect("missing ranges were removed")
    }

    #[test]
    fn range_to_a_square_wall_is_its_distance() {
        // The room's north wall is at y = 594.
        let scene = room(100, &[]);
        for distance_in in [20.0, 60.0, 200.0, 400.0] {
            let view = view_at(300.0, 594.0 - distance_in - AHEAD_IN, 0.0);
            let ranges = ranges(&scene, view, Side::Left);
            let range = f64::from(median(ranges.clone()));
            assert!(
                (range - distance_in).abs() <= 1.0 + distance_in * 0.003,
                "{distance_in}: {range}"
            );
            for range in ranges.into_iter().flatten() {
                let error = (f64::from(range) - distance_in).abs();
                assert!(error <= 0.5 + 0.036 * distance_in, "{distance_in}: {range}");
            }
        }
    }

    #[test]
    fn noise_deviation_is_one_percent() {
        let scene = room(100, &[]);
        let view = view_at(300.0, 594.0 - 400.0 - AHEAD_IN, 0.0);
        let ranges: Vec<f64> = ranges(&scene, view, Side::Right)
            .into_iter()
            .flatten()
            .map(f64::from)
            .collect();
        let mean = ranges.iter().sum::<f64>() / ranges.len() as f64;
        let variance = ranges
            .iter()
            .map(|range| (range - mean) * (range - mean))
            .sum::<f64>()
            / ranges.len() as f64;
        assert!(
            (3.2..4.8).contains(&variance.sqrt()),
            "deviation {}",
            variance.sqrt()
        );
    }

    #[test]
    fn oblique_smooth_wall_is_silent_or_reads_too_far() {
        let scene = room(100, &[]);
        let view = view_at(300.0, 574.0, 50.0);
        let straight_in = 15.0 / libm::cos(50.0_f64.to_radians());
        for range in ranges(&scene, view, Side::Right).into_iter().flatten() {
            assert!(f64::from(range) > 2.0 * straight_in, "{range}");
        }
    }

    #[test]
    fn corner_returns_sound_to_its_source() {
        let scene = room(60, &[]);
        // The north-east corner is at (354, 354); turn the left beam onto it.
        let view = view_at(284.0, 284.0, 45.0 + MOUNT_DEG);
        let apex_in = (70.0_f64 * 2.0_f64.sqrt()) - AHEAD_IN;
        let range = f64::from(median(ranges(&scene, view, Side::Left)));
        assert!((range - apex_in).abs() < 6.0, "{range} for {apex_in}");
    }

    #[test]
    fn range_beyond_reach_is_none() {
        let scene = room(200, &[]);
        let view = view_at(600.0, 600.0, 0.0);
        assert!(ranges(&scene, view, Side::Left).iter().all(Option::is_none));
    }

    #[test]
    fn range_below_three_inches_reads_three() {
        let scene = room(100, &[]);
        let view = view_at(300.0, 594.0 - 6.0, 0.0);
        assert_eq!(median(ranges(&scene, view, Side::Left)), 3);
    }

    #[test]
    fn range_without_noise_is_exact_to_the_inch() {
        let scene = room(100, &[]);
        let mut rng = Rng::for_sensor(1, Stream::Sonar, false);
        for distance_in in 4..=400_u16 {
            let y_in = 594.0 - f64::from(distance_in) - AHEAD_IN;
            let range = ping(&scene, view_at(300.0, y_in, 0.0), Side::Left, &mut rng);
            // The nearest ray of the fan is two thirds of a degree off square.
            assert_eq!(range, Some(distance_in));
        }
    }

    #[test]
    fn quick_pings_hear_each_other_and_slow_ones_do_not() {
        let scene = room(100, &[]);
        // The left ranger sees a wall 400 inches away; the right one pings before its echo has returned.
        let view = view_at(300.0, 594.0 - 400.0 - AHEAD_IN, 0.0);
        let short = |apart_ms: u64| {
            let mut rng = Rng::new(2, Stream::Sonar);
            (0..200)
                .filter(|_| {
                    let mut sonars = Sonars::default();
                    sonars.ping(&scene, view, Side::Left, 0, &mut rng);
                    let range = sonars.ping(&scene, view, Side::Right, apart_ms, &mut rng);
                    range.is_some_and(|range_in| range_in < 100)
                })
                .count()
        };
        assert!((70..130).contains(&short(50)), "{}", short(50));
        assert_eq!(short(100), 0);
    }
}
