//! The map of the house: walls seen in stretches of driving, and how certain the places of the stretches are.
//!
//! Each stretch is a small rigid submap (Bosse and others, "SLAM in large-scale cyclic environments using the Atlas
//! framework", 2004). The headings are known, so the rest is linear: a Kalman filter holds the robot's position and the
//! origins of all submaps with their joint covariance (Smith, Self and Cheeseman, 1990), and a match of one place corrects
//! all places that depend on it.

use std::fmt;
use std::sync::Arc;

use super::matching::{Foot, Match, Matrix, compare, inverse};
use super::symmetric::Symmetric;
use crate::pose::Pose;
use crate::sensors::Readings;
use crate::trail::View;

/// Path over which the error of the heading changes, inches.
const CORRELATED_IN: f64 = 600.0;

/// Variance of the position, square inches: per inch driven (encoders, curves between two lines), and per contact second.
const PER_IN: f64 = 0.01;
const PER_CONTACT_S: f64 = 1.0;

/// Maximum submaps: with 48, positions are off by a fifth more; a replay keeps the map of hundreds of moments.
const SUBMAPS_MAX: usize = 64;

/// Least feet of a submap.
const FEET_LEAST: usize = 6;

/// Variance, square inches, of a distance up to which two submaps stand together.
const TOGETHER: f64 = 64.0;

/// Distance of submaps that see the same walls, and length over which the nearer ones count more, inches.
const NEAR_IN: f64 = 120.0;
const WEIGHT_IN: f64 = 60.0;

/// Error of a submap's own shape, square inches.
const SHAPE: f64 = 4.0;

/// Shares of matches in which the map says nothing: with the stretches just driven, and with places of long ago, where
/// another room may look alike.
const IDLE_RECENT: f64 = 0.1;
const IDLE_EARLIER: f64 = 0.3;

/// Least number of submaps at a place of long ago.
const EARLIER_LEAST: usize = 2;

/// Maximum patches: 20 min of driving before the first is dropped. With at most 128 views of 14 bytes they take 172 kB, usually half.
/// Copies of a map share them.
const PATCHES_MAX: usize = 96;

/// State of the robot before the origins of submaps: X, Y and the error of the heading in its deviations.
const ROBOT: usize = 3;
const HEADING: usize = 2;

/// Views of a stretch, placed relative to the submap of its walls.
#[derive(Clone)]
struct Patch {
    views: Arc<[View]>,
    /// The submap; `None` if there was none, and the place is certain.
    submap: Option<usize>,
    /// Origin of the views relative to the origin of the submap, or of the house.
    offset_in: (f64, f64),
}

/// Squared Mahalanobis distance from which the position was less certain than it seemed.
const SURPRISE: f64 = 6.0;

/// Position in the house and the map around it.
#[derive(Clone)]
pub(super) struct Submaps {
    mean: Vec<f64>,
    covariance: Symmetric,
    /// Feet of each submap from its origin.
    feet: Vec<Arc<[Foot]>>,
    /// What was seen, oldest first.
    patches: Vec<Patch>,
}

/// The state is enough to tell two maps apart.
impl fmt::Debug for Submaps {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Submaps")
            .field("mean", &self.mean)
            .finish_non_exhaustive()
    }
}

impl Submaps {
    /// No map, and a position with the same variance in all directions.
    pub(super) fn at((x_in, y_in): (f64, f64), variance: f64) -> Self {
        Self {
            mean: vec![x_in, y_in, 0.0],
            covariance: Symmetric::diagonal(&[variance, variance, 1.0]),
            feet: Vec::new(),
            patches: Vec::new(),
        }
    }

    /// The robot without the map.
    pub(super) fn robot(&self) -> Self {
        Self {
            mean: self.mean[..ROBOT].to_vec(),
            covariance: self.covariance.first(ROBOT),
            feet: Vec::new(),
            patches: Vec::new(),
        }
    }

    pub(super) fn position_in(&self) -> (f64, f64) {
        (self.mean[0], self.mean[1])
    }

    pub(super) fn covariance(&self) -> Matrix {
        let p = |row, column| self.covariance.at(row, column);
        [[p(0, 0), p(0, 1)], [p(1, 0), p(1, 1)]]
    }

    /// Adds a movement with the standard deviation of its direction.
    pub(super) fn advance(
        &mut self,
        (x_in, y_in): (f64, f64),
        deviation_rad: f64,
        path_in: f64,
        contact_s: f64,
    ) {
        let keep = libm::exp(-path_in / CORRELATED_IN);
        // A heading error turns the movement to its right.
        let lever = [y_in * deviation_rad, -x_in * deviation_rad];
        let heading = self.mean[HEADING];
        self.mean[0] += x_in + lever[0] * heading;
        self.mean[1] += y_in + lever[1] * heading;
        self.mean[HEADING] = keep * heading;
        let p = &mut self.covariance;
        for at in ROBOT..self.mean.len() {
            let heading = p.at(HEADING, at);
            p.add(0, at, lever[0] * heading);
            p.add(1, at, lever[1] * heading);
            p.add(HEADING, at, (keep - 1.0) * heading);
        }
        let heading = [0, 1, HEADING].map(|at| p.at(HEADING, at));
        for row in 0..2 {
            for column in 0..=row {
                let both = lever[row] * heading[column] + lever[column] * heading[row];
                let turned = lever[row] * lever[column] * heading[HEADING];
                p.add(row, column, both + turned);
            }
            let with_heading = heading[row] + lever[row] * heading[HEADING];
            p.add(HEADING, row, keep * with_heading - heading[row]);
            p.add(row, row, PER_IN * path_in + PER_CONTACT_S * contact_s);
        }
        p.add(
            HEADING,
            HEADING,
            (keep * keep - 1.0) * (heading[HEADING] - 1.0),
        );
    }

    /// Matches the feet of a stretch, from the robot's position at its end, and adds them to the map.
    pub(super) fn take(&mut self, feet: Vec<Foot>) {
        let here = self.position_in();
        let distance_in = |it: &Self, at: usize| {
            let origin = it.origin(at);
            libm::hypot(origin.0 - here.0, origin.1 - here.1)
        };
        let near = (0..self.feet.len()).filter(|at| {
            let reach_in = NEAR_IN + 2.0 * libm::sqrt(self.variance(0, state(*at)));
            distance_in(self, *at) < reach_in
        });
        let (recent, earlier): (Vec<usize>, Vec<usize>) =
            near.partition(|at| self.variance(0, state(*at)) < TOGETHER);
        self.match_with(&feet, &recent, IDLE_RECENT);
        let nearest = earlier
            .iter()
            .copied()
            .min_by(|one, other| distance_in(self, *one).total_cmp(&distance_in(self, *other)));
        if let Some(nearest) = nearest {
            let group: Vec<usize> = earlier
                .into_iter()
                .filter(|at| self.variance(state(nearest), state(*at)) < TOGETHER)
                .collect();
            if group.len() >= EARLIER_LEAST {
                self.match_with(&feet, &group, IDLE_EARLIER);
            }
        }
        if feet.len() >= FEET_LEAST {
            self.add(feet);
        }
    }

    /// Corrects all places by a match of feet, from the robot's position, with some submaps.
    fn match_with(&mut self, feet: &[Foot], group: &[usize], idle: f64) {
        let here = self.position_in();
        let mut weights: Vec<f64> = group
            .iter()
            .map(|at| {
                let origin = self.origin(*at);
                let far = libm::hypot(origin.0 - here.0, origin.1 - here.1) / WEIGHT_IN;
                self.feet[*at].len() as f64 * libm::exp(-far * far / 2.0) + 1e-6
            })
            .collect();
        let sum: f64 = weights.iter().sum();
        for weight in &mut weights {
            *weight /= sum;
        }
        // Covariance of all places with the distance of the robot from the submaps, on each axis.
        let size = self.mean.len();
        let from_group = |row: &dyn Fn(usize) -> f64, axis: usize| {
            let pairs = group.iter().zip(&weights);
            row(axis) - pairs.map(|(at, w)| w * row(state(*at) + axis)).sum::<f64>()
        };
        let across: Vec<[f64; 2]> = (0..size)
            .map(|at| [0, 1].map(|axis| from_group(&|other| self.covariance.at(at, other), axis)))
            .collect();
        let mut prior =
            [0, 1].map(|row| [0, 1].map(|axis| from_group(&|at| across[at][axis], row)));
        prior[0][0] += SHAPE;
        prior[1][1] += SHAPE;
        let map: Vec<Foot> = group
            .iter()
            .flat_map(|at| {
                let origin = self.origin(*at);
                self.feet[*at].iter().map(move |foot| foot.moved(origin))
            })
            .collect();
        let seen: Vec<Foot> = feet.iter().map(|foot| foot.moved(here)).collect();
        let Some(inverse) = inverse(prior) else {
            return;
        };
        if map.is_empty() {
            return;
        }
        let Some(found) = compare(&seen, &map, prior, idle) else {
            return;
        };
        self.correct(&across, inverse, found);
    }

    /// Corrects all places by a displacement: `across` is its covariance with each, `inverse` the inverse of its own.
    fn correct(&mut self, across: &[[f64; 2]], inverse: Matrix, found: Match) {
        let by = |row: [f64; 2], matrix: Matrix| {
            [0, 1].map(|axis| row[0] * matrix[0][axis] + row[1] * matrix[1][axis])
        };
        let gains: Vec<[f64; 2]> = across.iter().map(|row| by(*row, inverse)).collect();
        for (at, gain) in gains.iter().enumerate() {
            self.mean[at] += gain[0] * found.shift_in.0 + gain[1] * found.shift_in.1;
            let taken = by(*gain, found.taken);
            for (value, other) in self.covariance.row_mut(at).iter_mut().zip(&gains) {
                *value -= taken[0] * other[0] + taken[1] * other[1];
            }
        }
    }

    /// Squared Mahalanobis distance of a position that is measured with a variance on each axis, off by as much from the robot's.
    fn surprise(&self, off: (f64, f64), variance: f64) -> f64 {
        let p = self.covariance();
        let seen = inverse([[p[0][0] + variance, p[0][1]], [p[1][0], p[1][1] + variance]]);
        seen.map_or(0.0, |it| {
            off.0 * off.0 * it[0][0] + 2.0 * off.0 * off.1 * it[0][1] + off.1 * off.1 * it[1][1]
        })
    }

    /// Takes the robot's position as measured with a variance on each axis, and corrects all places; with trust in the map, a surprise
    /// moves the robot alone.
    pub(super) fn fix(&mut self, measured: (f64, f64), variance: f64, trusts_map: bool) {
        let here = self.position_in();
        let off = (measured.0 - here.0, measured.1 - here.1);
        if trusts_map && self.surprise(off, variance) > SURPRISE {
            let square = off.0 * off.0 + off.1 * off.1;
            self.covariance.add(0, 0, square);
            self.covariance.add(1, 1, square);
        }
        let across: Vec<[f64; 2]> = (0..self.mean.len())
            .map(|at| [0, 1].map(|axis| self.covariance.at(at, axis)))
            .collect();
        let prior = self.covariance();
        let mut sum = prior;
        sum[0][0] += variance;
        sum[1][1] += variance;
        let (Some(inverse), Some(of_sum)) = (inverse(prior), inverse(sum)) else {
            return;
        };
        let times = |one: Matrix, other: Matrix| {
            [0, 1].map(|row: usize| {
                [0, 1].map(|column: usize| {
                    one[row][0] * other[0][column] + one[row][1] * other[1][column]
                })
            })
        };
        let gain = times(prior, of_sum);
        let found = Match {
            shift_in: (
                gain[0][0] * off.0 + gain[0][1] * off.1,
                gain[1][0] * off.0 + gain[1][1] * off.1,
            ),
            taken: times(gain, prior),
        };
        self.correct(&across, inverse, found);
    }

    /// Adds views from the robot's position, beside the newest submap.
    pub(super) fn add_views(&mut self, views: Arc<[View]>) {
        let submap = self.feet.len().checked_sub(1);
        let (here, origin) = (self.position_in(), self.origin_or_house(submap));
        self.add_patch(Patch {
            views,
            submap,
            offset_in: (here.0 - origin.0, here.1 - origin.1),
        });
    }

    /// Adds views in the house's frame, before there are submaps.
    pub(super) fn add_first_views(&mut self, views: Arc<[View]>) {
        self.add_patch(Patch {
            views,
            submap: None,
            offset_in: (0.0, 0.0),
        });
    }

    /// Adds a patch. If there are too many, the older one of the two whose origins are closest to each other is dropped.
    fn add_patch(&mut self, patch: Patch) {
        if patch.views.is_empty() {
            return;
        }
        if self.patches.len() == PATCHES_MAX {
            let places: Vec<(f64, f64)> = self.patches.iter().map(|it| self.place(it)).collect();
            let mut closest = (f64::MAX, 0);
            for (at, one) in places.iter().enumerate() {
                for two in &places[at + 1..] {
                    let distance_in = libm::hypot(one.0 - two.0, one.1 - two.1);
                    if distance_in < closest.0 {
                        closest = (distance_in, at);
                    }
                }
            }
            self.patches.remove(closest.1);
        }
        self.patches.push(patch);
    }

    /// What was seen, in the house's frame, oldest first.
    pub(super) fn views(&self) -> impl Iterator<Item = (Pose, Readings)> {
        self.patches.iter().flat_map(|patch| {
            let place = self.place(patch);
            let views = patch.views.iter();
            views.map(move |view| (view.pose().moved(place), view.readings))
        })
    }

    /// Feet of all submaps, in the house's frame.
    pub(super) fn feet(&self) -> impl Iterator<Item = Foot> {
        let submaps = self.feet.iter().enumerate();
        submaps.flat_map(|(at, feet)| {
            let origin = self.origin(at);
            feet.iter().map(move |foot| foot.moved(origin))
        })
    }

    fn place(&self, patch: &Patch) -> (f64, f64) {
        let origin = self.origin_or_house(patch.submap);
        (origin.0 + patch.offset_in.0, origin.1 + patch.offset_in.1)
    }

    fn origin_or_house(&self, submap: Option<usize>) -> (f64, f64) {
        submap.map_or((0.0, 0.0), |at| self.origin(at))
    }

    /// Adds a submap whose origin is the robot's position.
    fn add(&mut self, feet: Vec<Foot>) {
        if self.feet.len() == SUBMAPS_MAX {
            self.drop_redundant();
        }
        let (x_in, y_in) = self.position_in();
        self.mean.extend([x_in, y_in]);
        self.covariance.push_copy_of(0);
        self.covariance.push_copy_of(1);
        self.feet.push(feet.into());
    }

    /// Drops the newer one of the two submaps whose origins are closest to each other.
    fn drop_redundant(&mut self) {
        let mut closest = (f64::MAX, 0, 0);
        for at in 0..self.feet.len() {
            for other in 0..at {
                let (one, two) = (self.origin(at), self.origin(other));
                let distance_in = libm::hypot(one.0 - two.0, one.1 - two.1);
                if distance_in < closest.0 {
                    closest = (distance_in, at, other);
                }
            }
        }
        let (_, dropped, kept) = closest;
        let (from, to) = (self.origin(kept), self.origin(dropped));
        for patch in &mut self.patches {
            match &mut patch.submap {
                Some(submap) if *submap == dropped => {
                    *submap = kept;
                    patch.offset_in.0 += to.0 - from.0;
                    patch.offset_in.1 += to.1 - from.1;
                }
                Some(submap) if *submap > dropped => *submap -= 1,
                _ => {}
            }
        }
        let states = state(dropped)..state(dropped) + 2;
        self.feet.remove(dropped);
        self.mean.drain(states.clone());
        self.covariance.remove(&states);
    }

    fn origin(&self, at: usize) -> (f64, f64) {
        (self.mean[state(at)], self.mean[state(at) + 1])
    }

    /// Variance of the distance of two places on the worse axis.
    fn variance(&self, one: usize, other: usize) -> f64 {
        let p = |one, other| self.covariance.at(one, other);
        let axis = |one: usize, other: usize| p(one, one) + p(other, other) - 2.0 * p(one, other);
        // Rounding may leave a little less than none.
        axis(one, other).max(axis(one + 1, other + 1)).max(0.0)
    }
}

/// Place of a submap's X in the state; Y is the next.
const fn state(submap: usize) -> usize {
    ROBOT + 2 * submap
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Feet on the walls of a room of 160 by 120 in, from a position in it.
    fn room((x_in, y_in): (f64, f64)) -> Vec<Foot> {
        let foot = |facing, x_in, y_in| Foot {
            facing,
            x_in,
            y_in,
            weight: 1.0,
        };
        (-4..=4)
            .map(|at| f64::from(at) * 4.0)
            .flat_map(|along| {
                [
                    foot(0, along, 120.0 - y_in),
                    foot(1, 160.0 - x_in, along),
                    foot(2, along, -y_in),
                    foot(3, -x_in, along),
                ]
            })
            .collect()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        /// Rounds in a room with a heading error: reckoned, the position turns away; matched, it stays in its ellipse.
        #[test]
        fn position_stays_in_a_known_room(error_deg in -8.0..8.0_f64, rounds in 3..7_i32) {
            let corners = [(40.0, 40.0), (40.0, 80.0), (120.0, 80.0), (120.0, 40.0)];
            let mut submaps = Submaps::at(corners[0], 1.0);
            let mut reckoned = corners[0];
            let mut truth = corners[0];
            for step in 0..rounds * 4 {
                let next = corners[((step + 1) % 4) as usize];
                let (x_in, y_in) = (next.0 - truth.0, next.1 - truth.1);
                // The first round is nearly right; later the heading is off, and each side is driven too far.
                let error_deg = if step < 4 { 0.0 } else { error_deg };
                let (sin, cos) = libm::sincos(error_deg.to_radians());
                let moved = (x_in * cos + y_in * sin + 1.0, y_in * cos - x_in * sin + 0.5);
                reckoned = (reckoned.0 + moved.0, reckoned.1 + moved.1);
                truth = next;
                submaps.advance(moved, 4.0_f64.to_radians(), libm::hypot(x_in, y_in), 0.0);
                submaps.take(room(truth));
            }
            let position = submaps.position_in();
            let off_in = libm::hypot(position.0 - truth.0, position.1 - truth.1);
            let reckoned_in = libm::hypot(reckoned.0 - truth.0, reckoned.1 - truth.1);
            prop_assert!(off_in < 6.0 + reckoned_in / 4.0, "{off_in} of {reckoned_in}");
            let p = submaps.covariance();
            prop_assert!(p[0][0] > 10.0 && p[1][1] > 10.0 && p[0][0] + p[1][1] < 200.0, "{p:?}");
            let inverse = inverse(p).unwrap();
            let (x, y) = (position.0 - truth.0, position.1 - truth.1);
            let squared = x * x * inverse[0][0] + 2.0 * x * y * inverse[0][1] + y * y * inverse[1][1];
            prop_assert!(squared < 5.991, "{squared}");
        }

        /// A robot on its dock is where the dock is, and the map moves with it as far as its places depend on the robot's.
        #[test]
        fn measured_position_moves_the_map_along(
            x_in in -60.0..60.0_f64, y_in in -60.0..60.0_f64, variance in 16.0..100.0_f64,
        ) {
            let mut submaps = Submaps::at((40.0, 40.0), 1.0);
            submaps.add(room((40.0, 40.0)));
            submaps.advance((300.0, 0.0), 0.2, 300.0, 0.0);
            submaps.add(room((40.0, 40.0)));
            let (first, second, p) = (submaps.origin(0), submaps.origin(1), submaps.covariance());
            let here = submaps.position_in();
            submaps.fix((here.0 + x_in, here.1 + y_in), variance, false);
            let after = submaps.covariance();
            prop_assert!(after[0][0] < p[0][0] && after[1][1] < variance, "{after:?}");
            let moved = submaps.origin(1);
            prop_assert!((moved.0 - submaps.position_in().0).abs() < 1e-6, "the robot stands at it");
            prop_assert!((moved.1 - second.1 - y_in).abs() < 0.1 * y_in.abs() + 1e-6, "{moved:?}");
            let kept = submaps.origin(0);
            prop_assert!((kept.0 - first.0).hypot(kept.1 - first.1) < 3.0, "{kept:?}");
        }

        /// A robot that comes back to a room of two stretches is placed by its first stretch there.
        #[test]
        fn first_stretch_in_an_old_place_is_matched(off_in in -20.0..20.0_f64) {
            let (first, second) = ((40.0, 40.0), (120.0, 40.0));
            let mut submaps = Submaps::at(first, 1.0);
            submaps.take(room(first));
            submaps.advance((80.0, 0.0), 0.02, 80.0, 0.0);
            submaps.take(room(second));
            submaps.advance((-80.0, off_in), 0.25, 80.0, 0.0);
            let before = submaps.covariance();
            submaps.take(room(first));
            let (_, y_in) = submaps.position_in();
            let left_in = (y_in - first.1).abs();
            prop_assert!(left_in < 3.0 + off_in.abs() / 4.0, "{left_in} of {off_in}");
            prop_assert!(submaps.covariance()[1][1] < before[1][1] / 2.0);
        }

        /// Where the map has no walls, a stretch changes nothing.
        #[test]
        fn unknown_place_says_nothing(x_in in 400.0..900.0_f64) {
            let mut submaps = Submaps::at((40.0, 40.0), 1.0);
            submaps.take(room((40.0, 40.0)));
            submaps.advance((x_in, 0.0), 0.05, x_in, 0.0);
            let (position, p) = (submaps.position_in(), submaps.covariance());
            submaps.take(room((40.0, 40.0)));
            prop_assert_eq!(submaps.position_in(), position);
            prop_assert_eq!(submaps.covariance(), p);
        }
    }

    /// Views stay where they were when others are dropped, move with their submap, and are shared by copies.
    #[test]
    fn memory_is_bounded() {
        let mut submaps = Submaps::at((0.0, 0.0), 1.0);
        let mut trail = crate::trail::Trail::default();
        trail.push(
            Pose::default(),
            Readings::of(&groundwave_protocol::telemetry::StateLine::BLANK),
        );
        let views = trail.mapped(|pose| pose);
        for step in 0..PATCHES_MAX + 20 {
            let x_in = if step % 2 == 0 { 400.0 } else { -399.0 };
            submaps.advance((x_in, 0.0), 0.01, 400.0, 0.0);
            submaps.add(room((40.0, 40.0)));
            submaps.add_views(Arc::clone(&views));
            let (newest, _) = submaps.views().last().unwrap();
            assert!((newest.x_in - submaps.position_in().0).abs() < 1e-6);
        }
        assert_eq!(submaps.feet.len(), SUBMAPS_MAX);
        assert_eq!(submaps.mean.len(), state(SUBMAPS_MAX));
        assert_eq!(submaps.covariance.size(), state(SUBMAPS_MAX));
        assert_eq!(submaps.patches.len(), PATCHES_MAX);
        let mut expected: Vec<f64> = submaps.views().map(|(pose, _)| pose.x_in).collect();
        submaps.drop_redundant();
        submaps.mean[state(SUBMAPS_MAX - 2)] += 5.0;
        let (views_before, copy) = (expected.len(), submaps.clone());
        for (at, (pose, _)) in copy.views().enumerate() {
            let moves = submaps.patches[at].submap == Some(SUBMAPS_MAX - 2);
            expected[at] += if moves { 5.0 } else { 0.0 };
            assert!((pose.x_in - expected[at]).abs() < 1e-6, "{at}");
        }
        assert_eq!(copy.views().count(), views_before);
        assert!(Arc::ptr_eq(
            &copy.patches[0].views,
            &submaps.patches[0].views
        ));
    }
}
