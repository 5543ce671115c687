//! Scans on the spot, and how far apart two of them were made.
//!
//! A scan shows the walls on all sides of one place at their distances along the normals (regions of constant depth, as in
//! [`super::walls`]), and corners, legs and edges at theirs. The displacement between two scans of one room is that at which
//! most echoes of one find a wall or a point of the other, over all translations and small turns (Olson, "Real-time
//! correlative scan matching", 2009). It is taken only if no other displacement explains the echoes as well.

use groundwave_protocol::status_codes::{Layer, LayerState};
use groundwave_protocol::telemetry::StateLine;

use super::drift::Estimate;
use super::lines::{is_touching, position_in};
use crate::pose::{Pose, turned};
use crate::sensors::sonar;

/// Nearest and furthest echo of a scan, inches: in a room, walls are square to the sonar somewhere.
const ECHO_MIN_IN: f64 = 4.0;
const ECHO_MAX_IN: f64 = 200.0;

/// Turn on the spot that is a scan, degrees, from and to: with bit errors its first lines may be lost.
const TURNED_DEG: std::ops::Range<f64> = 300.0..720.0;

/// Fewest echoes of a scan, and most of several at one place.
const ECHOES_LEAST: usize = 12;
const ECHOES_MAX: usize = 120;

/// Distance within which scans are made at one place, inches.
const SAME_PLACE_IN: f64 = 4.0;

/// Half of a sonar's cone, and the angle from a wall's normal up to which it answers, radians.
const CONE_RAD: f64 = 0.131;
const OBLIQUE_RAD: f64 = 0.52;

/// Weight of a wall outside of the cone, and of an echo as a point.
const OBLIQUE: f64 = 0.5;
const POINT: f64 = 0.5;

/// Variance of a wall's distance, square inches, and its share of the squared range: noise of the sonar.
const WALL: f64 = 6.25;
const NOISE: f64 = 0.0002;

/// Distance along a wall over which it goes on, inches.
const ALONG_IN: f64 = 80.0;

/// Variances of a point along the sonar's axis and across it, square inches, and the share of the squared range across it.
const POINT_AHEAD: f64 = 3.0;
const POINT_ASIDE: f64 = 2.0;
const POINT_CONE: f64 = 0.0049;

/// Distance over which walls and points are equally likely anywhere, inches.
const WINDOW_IN: f64 = 100.0;
const DISC_IN: f64 = 60.0;

/// Number of features that stand for those that a scan has missed, and the least ratio of likelihoods.
const UNKNOWN: f64 = 2.0;
const LEAST_RATIO: f64 = 0.1;

/// Power of the likelihood: neighbouring echoes repeat each other.
const POWER: f64 = 0.3;

/// Turns tried, degrees, and their deviation.
const TURNS_DEG: [f64; 3] = [-3.0, 0.0, 3.0];
const TURN_DEG: f64 = 2.0;

/// Steps of the displacement, inches: of all, and of those near the best one. `BLUR` is a variance for the coarse one, square inches.
const COARSE_IN: f64 = 5.0;
const FINE_IN: f64 = 1.5;
const BLUR: f64 = 8.0;

/// Steps of [`FINE_IN`] from the best displacement.
const FINE_STEPS: i32 = 5;

/// Furthest displacement from the expected one, in deviations, and in inches.
const GATE: f64 = 3.0;
const REACH_IN: f64 = 90.0;

/// Distance within which displacements are the same one, inches; the least share of the posterior there, and the least mean logarithm of
/// the likelihood ratio of an echo.
const SAME_IN: f64 = 10.0;
const SHARE: f64 = 0.85;
const SCORE: f64 = 0.45;

/// The sides of a house: east and north components of the normals.
const NORMALS: [(f64, f64); 4] = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];

/// An echo in the odometer's frame.
#[derive(Clone, Copy, Debug)]
struct Echo {
    eye: (f64, f64),
    axis_rad: f64,
    range_in: f64,
}

/// Notices scans in lines A.
#[derive(Clone, Debug, Default)]
pub(super) struct Scan {
    turned_deg: f64,
    echoes: Vec<Echo>,
    /// The scan before, and where it ended.
    before: Option<(Vec<Echo>, (f64, f64))>,
}

impl Scan {
    /// Takes a line and the turn since the one before, degrees; returns the scan that ended before it, with those made at the same
    /// place.
    pub(super) fn take(&mut self, state: &StateLine, turn_deg: f64) -> Option<Panorama> {
        let is_turning = state.layers.get(Layer::Rotation) == LayerState::Holds
            && state.velocity_in_s == 0
            && state.rotation_in_s > 0
            && !is_touching(state);
        let (x_in, y_in) = position_in(state);
        // The odometer's place is the same one only as long as the robot stays.
        self.before
            .take_if(|(_, at)| libm::hypot(x_in - at.0, y_in - at.1) >= SAME_PLACE_IN);
        if is_turning {
            self.turned_deg += turn_deg;
            let pose = Pose {
                x_in,
                y_in,
                theta_rad: f64::from(state.theta_deg).to_radians(),
            };
            let wheels_in_s = (state.wheel_left_in_s, state.wheel_right_in_s);
            let pinged_at = sonar::pinged_at(pose, wheels_in_s);
            for (side, range_in) in sonar::ranges(state) {
                if self.echoes.len() < ECHOES_MAX && (ECHO_MIN_IN..=ECHO_MAX_IN).contains(&range_in)
                {
                    let (eye, axis_rad) = sonar::eye(pinged_at, side);
                    self.echoes.push(Echo {
                        eye,
                        axis_rad,
                        range_in,
                    });
                }
            }
            return None;
        }
        let turned_deg = std::mem::take(&mut self.turned_deg);
        let mut echoes = std::mem::take(&mut self.echoes);
        if !TURNED_DEG.contains(&turned_deg) {
            return None;
        }
        if let Some((before, _)) = self.before.take()
            && before.len() + echoes.len() <= ECHOES_MAX
        {
            echoes.extend(before);
        }
        self.before = Some((echoes.clone(), (x_in, y_in)));
        for echo in &mut echoes {
            echo.eye = (echo.eye.0 - x_in, echo.eye.1 - y_in);
        }
        (echoes.len() >= ECHOES_LEAST).then_some(Panorama { echoes })
    }
}

/// The echoes of scans at one place, from the robot's position after them and with the odometer's headings.
#[derive(Clone, Debug)]
pub(super) struct Panorama {
    echoes: Vec<Echo>,
}

impl Panorama {
    /// Direction of the walls in the odometer's frame, degrees, from an estimate of it: the one at which most distances agree.
    pub(super) fn direction_deg(&self, near: Estimate) -> f64 {
        let deviation = near.deviation.clamp(1.0, 8.0);
        let values: Vec<(f64, f64)> = (-24..=24)
            .map(|step| {
                let off_deg = f64::from(step) / 2.0;
                (off_deg, self.agreement(near.value + off_deg))
            })
            .collect();
        let count = values.len() as f64;
        let mean = values.iter().map(|(_, value)| value).sum::<f64>() / count;
        let squares = values
            .iter()
            .map(|(_, value)| (value - mean) * (value - mean));
        let spread = libm::sqrt(squares.sum::<f64>() / count).max(1e-9);
        let (mut sum, mut first) = (0.0, 0.0);
        for (off_deg, value) in values {
            let prior = off_deg * off_deg / 2.0 / deviation / deviation;
            let weight = libm::exp(2.0 * (value - mean) / spread - prior);
            sum += weight;
            first += weight * off_deg;
        }
        near.value + first / sum
    }

    /// How many pairs of walls have the same distance.
    fn agreement(&self, direction_deg: f64) -> f64 {
        let features = self.features(direction_deg);
        let walls: Vec<&Wall> = features.seen.iter().flat_map(|seen| &seen.walls).collect();
        let mut sum = 0.0;
        for (at, one) in walls.iter().enumerate() {
            for other in &walls[at + 1..] {
                let off = (one.distance_in - other.distance_in) / 1.5;
                if one.facing == other.facing && off.abs() < 4.0 {
                    sum += one.weight * other.weight * libm::exp(-off * off / 2.0);
                }
            }
        }
        sum
    }

    /// What was seen, in the house's frame, whose +Y has a direction in the odometer's frame.
    pub(super) fn features(&self, direction_deg: f64) -> Features {
        let bearing_rad = direction_deg.to_radians();
        let seen = self.echoes.iter().map(|echo| {
            let eye = turned(echo.eye, bearing_rad);
            let (sin, cos) = libm::sincos(echo.axis_rad - bearing_rad);
            let walls = NORMALS.iter().enumerate().filter_map(|(facing, normal)| {
                let ahead = sin * normal.0 + cos * normal.1;
                let angle = libm::acos(ahead.clamp(-1.0, 1.0));
                let over = (angle - CONE_RAD).max(0.0);
                let before_in = eye.0 * normal.0 + eye.1 * normal.1;
                (angle < OBLIQUE_RAD).then(|| Wall {
                    facing,
                    distance_in: before_in + echo.range_in * libm::cos(over),
                    along_in: eye.0 * normal.1 - eye.1 * normal.0,
                    weight: if over > 0.0 { OBLIQUE } else { 1.0 },
                    variance: WALL / 2.0 + NOISE * echo.range_in * echo.range_in,
                })
            });
            let square = echo.range_in * echo.range_in;
            let ahead = POINT_AHEAD + NOISE * square;
            let aside = POINT_ASIDE + POINT_CONE * square;
            Seen {
                walls: walls.collect(),
                point: (eye.0 + echo.range_in * sin, eye.1 + echo.range_in * cos),
                covariance: [
                    ahead * sin * sin + aside * cos * cos,
                    (ahead - aside) * sin * cos,
                    ahead * cos * cos + aside * sin * sin,
                ],
            }
        });
        Features {
            seen: seen.collect(),
        }
    }

    /// Displacement of this panorama from another one, in the house's frame, with the direction of the walls in the odometer's frame,
    /// degrees; `None` if it is not clear. The expected displacement has a deviation on each axis, inches.
    pub(super) fn displacement(
        &self,
        from: &Features,
        direction_deg: f64,
        expected_in: (f64, f64),
        deviation_in: f64,
    ) -> Option<(f64, f64)> {
        let steps = ((GATE * deviation_in).min(REACH_IN) / COARSE_IN) as i32;
        let mut places = Vec::new();
        for turn_deg in TURNS_DEG {
            let features = self.features(direction_deg + turn_deg);
            for (x, y) in grid(expected_in, steps, COARSE_IN) {
                let off = libm::hypot(x - expected_in.0, y - expected_in.1) / deviation_in;
                if off > GATE {
                    continue;
                }
                let turn = turn_deg / TURN_DEG;
                let prior = -(off * off + turn * turn) / 2.0;
                let likelihood = from.likelihood(&features, (x, y), BLUR);
                places.push((POWER * likelihood + prior, (x, y), turn_deg));
            }
        }
        let best = *places
            .iter()
            .max_by(|one, other| one.0.total_cmp(&other.0))?;
        let (mut all, mut near, mut turns) = (0.0, 0.0, 0.0);
        for (value, place, turn_deg) in &places {
            let weight = libm::exp(value - best.0);
            all += weight;
            if libm::hypot(place.0 - best.1.0, place.1 - best.1.1) < SAME_IN {
                near += weight;
                turns += weight * turn_deg;
            }
        }
        if near < SHARE * all {
            return None;
        }
        let turn_deg = turns / near;
        let features = self.features(direction_deg + turn_deg);
        let fine: Vec<_> = grid(best.1, FINE_STEPS, FINE_IN)
            .map(|place| (place, from.likelihood(&features, place, 0.0)))
            .collect();
        let most = fine.iter().map(|it| it.1).fold(f64::MIN, f64::max);
        if most < SCORE * self.echoes.len() as f64 {
            return None;
        }
        let (mut sum, mut x_in, mut y_in) = (0.0, 0.0, 0.0);
        for ((x, y), value) in fine {
            let weight = libm::exp(POWER * (value - most));
            sum += weight;
            x_in += weight * x;
            y_in += weight * y;
        }
        Some((x_in / sum, y_in / sum))
    }
}

/// Places around a middle.
fn grid(middle: (f64, f64), steps: i32, cell_in: f64) -> impl Iterator<Item = (f64, f64)> {
    let at = move |step: i32| f64::from(step) * cell_in;
    (-steps..=steps).flat_map(move |row| {
        (-steps..=steps).map(move |column| (middle.0 + at(column), middle.1 + at(row)))
    })
}

/// A wall that an echo may have come from.
#[derive(Clone, Copy, Debug)]
struct Wall {
    facing: usize,
    /// Distance along the normal, and of the sonar along the wall, inches.
    distance_in: f64,
    along_in: f64,
    weight: f64,
    variance: f64,
}

/// What an echo may have come from.
#[derive(Clone, Debug)]
struct Seen {
    walls: Vec<Wall>,
    point: (f64, f64),
    /// Of X, of both, and of Y.
    covariance: [f64; 3],
}

/// What a panorama shows in the house's frame.
#[derive(Clone, Debug)]
pub(super) struct Features {
    seen: Vec<Seen>,
}

impl Features {
    /// Logarithm of the likelihood of other features after a displacement, over that anywhere.
    fn likelihood(&self, other: &Self, shift: (f64, f64), blur: f64) -> f64 {
        let of_echo = |seen: &Seen| {
            let weights: f64 = seen.walls.iter().map(|wall| wall.weight).sum();
            let walls = seen.walls.iter();
            let walls: f64 = walls
                .map(|wall| wall.weight * self.wall_ratio(wall, shift, blur))
                .sum();
            let point = self.point_ratio(seen, shift, blur);
            let ratio = (walls + POINT * point) / (weights + POINT);
            libm::log(ratio.max(LEAST_RATIO))
        };
        other.seen.iter().map(of_echo).sum()
    }

    fn wall_ratio(&self, wall: &Wall, shift: (f64, f64), blur: f64) -> f64 {
        let normal = NORMALS[wall.facing];
        let distance_in = wall.distance_in + shift.0 * normal.0 + shift.1 * normal.1;
        let along_in = wall.along_in + shift.0 * normal.1 - shift.1 * normal.0;
        let (mut here, mut count) = (0.0, 0.0);
        for own in self.seen.iter().flat_map(|seen| &seen.walls) {
            if own.facing != wall.facing || (own.along_in - along_in).abs() > ALONG_IN {
                continue;
            }
            count += own.weight;
            let variance = own.variance + wall.variance + blur;
            let off = own.distance_in - distance_in;
            let squared = off * off / variance;
            if squared < 16.0 {
                here += own.weight * libm::exp(-squared / 2.0) / libm::sqrt(variance);
            }
        }
        (here * WINDOW_IN / 2.5066 + UNKNOWN) / (count + UNKNOWN)
    }

    fn point_ratio(&self, seen: &Seen, shift: (f64, f64), blur: f64) -> f64 {
        let (mut here, mut count) = (0.0, 0.0);
        for own in &self.seen {
            let (x, y) = (
                own.point.0 - seen.point.0 - shift.0,
                own.point.1 - seen.point.1 - shift.1,
            );
            if x * x + y * y > DISC_IN * DISC_IN {
                continue;
            }
            count += 1.0;
            let [xx, xy, yy] = [0, 1, 2].map(|at| own.covariance[at] + seen.covariance[at]);
            let (xx, yy) = (xx + blur, yy + blur);
            let determinant = xx * yy - xy * xy;
            let squared = (x * x * yy - 2.0 * x * y * xy + y * y * xx) / determinant;
            if squared < 16.0 {
                here += libm::exp(-squared / 2.0) / libm::sqrt(determinant);
            }
        }
        (here * DISC_IN * DISC_IN / 2.0 + UNKNOWN) / (count + UNKNOWN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use groundwave_protocol::status_codes::Layer;
    use proptest::prelude::*;

    const ROOM_IN: (f64, f64) = (160.0, 120.0);

    /// However long a robot turns, a scan has a limit, and a turn of several rounds is none.
    #[test]
    fn scan_has_a_limit() {
        let mut scan = Scan::default();
        let mut state = StateLine {
            rotation_in_s: 8,
            sonar_left_in: Some(50),
            ..StateLine::BLANK
        };
        state.layers.set(Layer::Rotation, LayerState::Holds);
        for rounds in [1, 100] {
            for _ in 0..rounds * 360 {
                assert!(scan.take(&state, 1.0).is_none());
            }
            assert!(scan.echoes.len() <= ECHOES_MAX);
            let panorama = scan.take(&StateLine::BLANK, 0.0);
            assert_eq!(panorama.is_some(), rounds == 1);
        }
    }

    /// A scan from a place in a room without furniture: echoes of the walls that the sonar faces.
    fn scan((wide_in, long_in): (f64, f64), (x_in, y_in): (f64, f64), begin_deg: f64) -> Panorama {
        let echoes = (0..54).filter_map(|step| {
            let axis_rad = (begin_deg + f64::from(step) * 360.0 / 54.0).to_radians();
            let (sin, cos) = libm::sincos(axis_rad);
            let eye = (5.0 * sin, 5.0 * cos);
            let walls = [
                long_in - y_in - eye.1,
                wide_in - x_in - eye.0,
                y_in + eye.1,
                x_in + eye.0,
            ];
            NORMALS.iter().zip(walls).find_map(|(normal, distance_in)| {
                let angle = libm::acos((sin * normal.0 + cos * normal.1).clamp(-1.0, 1.0));
                let over = (angle - CONE_RAD).max(0.0);
                (angle < 0.4).then(|| Echo {
                    eye,
                    axis_rad,
                    range_in: libm::round(distance_in / libm::cos(over)),
                })
            })
        });
        Panorama {
            echoes: echoes.collect(),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        /// The displacement of two scans of a room, whose walls' directions are known to some degrees.
        #[test]
        fn displacement_is_that_of_the_places(
            x_in in -20.0..20.0_f64, y_in in -20.0..20.0_f64, begin_deg in 0.0..360.0_f64, error_deg in -3.0..3.0_f64,
        ) {
            let home = scan(ROOM_IN, (70.0, 55.0), 0.0).features(0.0);
            let away = scan(ROOM_IN, (70.0 + x_in, 55.0 + y_in), begin_deg);
            let near = Estimate { value: error_deg, deviation: 3.0 };
            let direction_deg = away.direction_deg(near);
            prop_assert!(direction_deg.abs() < 3.5, "{direction_deg}");
            let found = away.displacement(&home, direction_deg, (0.0, 0.0), 15.0);
            let off_in = found.map(|it| libm::hypot(it.0 - x_in, it.1 - y_in));
            prop_assert!(off_in.is_some_and(|off_in| off_in < 5.0), "{found:?}");
        }

        /// A scan in a room of another shape has no displacement.
        #[test]
        fn nothing_is_found_in_another_room(begin_deg in 0.0..360.0_f64) {
            let home = scan(ROOM_IN, (70.0, 55.0), 0.0).features(0.0);
            let away = scan((330.0, 260.0), (150.0, 120.0), begin_deg);
            prop_assert_eq!(away.displacement(&home, 0.0, (0.0, 0.0), 15.0), None);
        }
    }
}
