//! The error of the odometer's heading, and the wheels that cause it.
//!
//! The direction of the house in the robot's frame is unknown but constant: a static multiple-model filter (Bar-Shalom, Li
//! and Kirubarajan, *Estimation with Applications to Tracking and Navigation*, 2001, chapter 11.6.2) has a Kalman filter
//! for each degree of it. Each filter's state is the heading error, its growth per inch driven (unequal wheels) and its
//! growth per degree turned (track).

use super::walls::DIRECTIONS;

/// Tolerance of the wheels as a standard deviation: growth of the heading error, degrees per inch. Wheels of 5 in that differ by 0.33 %
/// on a track of 10 in turn the robot by 0.019 degrees an inch.
const PER_IN: f64 = 0.025;

/// Tolerance of the track as a standard deviation: growth of the heading error, degrees per degree turned.
const PER_DEG: f64 = 0.008;

/// Share of stretches in which the robot slipped without any sign.
const SLIP_SHARE: f64 = 0.1;

/// Standard deviation of such a slip, degrees.
const SLIP_DEG: f64 = 12.0;

/// Factor on the deviation of the heading: errors of neighbouring stretches, which see the same furniture, are alike.
const ALIKE: f64 = 1.3;

/// Error of the reported heading, which has whole degrees.
const ROUNDING_DEG: f64 = 0.3;

/// Probability of an error by a quarter turn above which the heading is unknown.
const LOST: f64 = 0.03;

/// Weight below which a direction of the house is given up.
const NEGLIGIBLE: f64 = 1e-9;

/// Motion since the last measurement.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    pub(super) path_in: f64,
    pub(super) turn_deg: f64,
    /// Turn of the robot by contacts that the odometer does not see, degrees.
    pub(super) pushed_deg: f64,
    /// Variance of the heading error that has no known cause, square degrees.
    pub(super) variance: f64,
}

type State = [f64; 3];
type Covariance = [[f64; 3]; 3];

/// One filter: the house's direction is given.
#[derive(Clone, Copy, Debug)]
struct Filter {
    weight: f64,
    state: State,
    covariance: Covariance,
}

/// A value and its standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Estimate {
    pub(super) value: f64,
    pub(super) deviation: f64,
}

/// The filters for all directions of the house.
#[derive(Clone, Debug)]
pub(super) struct Drift {
    filters: Vec<Filter>,
    /// Probability that a quarter turn was lost.
    lost: f64,
}

impl Default for Drift {
    fn default() -> Self {
        let mut covariance = [[0.0; 3]; 3];
        covariance[1][1] = PER_IN * PER_IN;
        covariance[2][2] = PER_DEG * PER_DEG;
        Self::of([0.0; 3], covariance)
    }
}

impl Drift {
    fn of(state: State, covariance: Covariance) -> Self {
        let filter = Filter {
            weight: 1.0 / DIRECTIONS as f64,
            state,
            covariance,
        };
        Self {
            filters: vec![filter; DIRECTIONS],
            lost: 0.0,
        }
    }

    /// Begins again with a correct heading, in a frame of a new direction. What is known of the wheels stays.
    pub(super) fn restart(&mut self) {
        let (wheels, track) = (self.estimate(1), self.estimate(2));
        let mut covariance = [[0.0; 3]; 3];
        covariance[1][1] = wheels.deviation * wheels.deviation;
        covariance[2][2] = track.deviation * track.deviation;
        *self = Self::of([0.0, wheels.value, track.value], covariance);
    }

    /// Takes a turn of the odometer's heading without a turn of the robot, degrees.
    pub(super) fn turn(&mut self, turn_deg: f64) {
        for filter in &mut self.filters {
            filter.state[0] -= turn_deg;
        }
    }

    /// Takes the number of quarter turns by which the heading was off: none is lost any more.
    pub(super) fn find(&mut self, quarters: i32) {
        self.turn(-90.0 * f64::from(quarters));
        self.lost = 0.0;
    }

    /// Takes a motion without a measurement.
    pub(super) fn pass(&mut self, motion: Motion) {
        for filter in &mut self.filters {
            *filter = filter.after(motion);
        }
    }

    /// Takes a change of the growth by the wheels' parameters, degrees per inch; `None` if it is unknown.
    pub(super) fn regauge(&mut self, change: Option<f64>) {
        for filter in &mut self.filters {
            if let Some(change) = change {
                filter.state[1] += change;
                continue;
            }
            let p = &mut filter.covariance;
            (p[0][1], p[1][0], p[1][2], p[2][1]) = (0.0, 0.0, 0.0, 0.0);
            p[1][1] = PER_IN * PER_IN;
        }
    }

    /// Heading error after a motion, degrees, and whether a quarter turn may have been lost.
    pub(super) fn heading(&self, motion: Motion) -> (Estimate, bool) {
        let moved: Vec<Filter> = self.filters.iter().map(|f| f.after(motion)).collect();
        let mut estimate = mixture(&moved, 0);
        estimate.deviation = libm::hypot(ALIKE * estimate.deviation, ROUNDING_DEG);
        (estimate, self.lost + confusion(&moved) > LOST)
    }

    /// Growth of the heading error, degrees per inch driven.
    pub(super) fn per_in(&self) -> Estimate {
        self.estimate(1)
    }

    /// The likeliest direction of the house in the world, degrees.
    pub(super) fn likeliest_house_deg(&self) -> f64 {
        let weight = |at: &usize| self.filters[*at].weight;
        let best = (0..DIRECTIONS).max_by(|one, other| weight(one).total_cmp(&weight(other)));
        best.unwrap_or_default() as f64
    }

    /// Direction of the house in the world, degrees, next to another one.
    pub(super) fn house(&self, near_deg: f64) -> Estimate {
        self.mixture_of(|at, _| (house_deg(at, near_deg), 0.0))
    }

    /// Direction of the walls in the odometer's frame, degrees, next to the house's direction.
    pub(super) fn walls(&self, near_deg: f64) -> Estimate {
        self.mixture_of(|at, filter| {
            let variance = filter.covariance[0][0].max(0.0);
            (house_deg(at, near_deg) - filter.state[0], variance)
        })
    }

    fn mixture_of(&self, value: impl Fn(usize, &Filter) -> (f64, f64)) -> Estimate {
        let filters = || self.filters.iter().enumerate();
        let mean: f64 = filters().map(|(at, f)| f.weight * value(at, f).0).sum();
        let variance = filters().map(|(at, filter)| {
            let (value, variance) = value(at, filter);
            filter.weight * (variance + (value - mean) * (value - mean))
        });
        Estimate {
            value: mean,
            deviation: libm::sqrt(variance.sum()),
        }
    }

    fn estimate(&self, at: usize) -> Estimate {
        mixture(&self.filters, at)
    }

    /// Takes a motion and the likelihood of the wall's directions after it, degrees in the odometer's frame.
    pub(super) fn update(&mut self, motion: Motion, likelihood: impl Fn(f64) -> f64) {
        self.pass(motion);
        self.lost += confusion(&self.filters);
        let mut sum = 0.0;
        for (direction, filter) in self.filters.iter_mut().enumerate() {
            if filter.weight < NEGLIGIBLE {
                sum += filter.weight;
                continue;
            }
            // A heading error of `error` shows the walls turned back by it.
            let evidence = filter.measure(|error| likelihood(direction as f64 - error));
            filter.weight *= evidence;
            sum += filter.weight;
        }
        for filter in &mut self.filters {
            filter.weight /= sum;
        }
    }
}

impl Filter {
    fn after(self, motion: Motion) -> Self {
        let Motion {
            path_in,
            turn_deg,
            pushed_deg,
            variance,
        } = motion;
        let (state, p) = (self.state, self.covariance);
        let step = [1.0, path_in, turn_deg];
        // The first row of the transition is `step`, the others are those of the identity.
        let row: State = [0, 1, 2].map(|at| (0..3).map(|from| step[from] * p[from][at]).sum());
        let mut covariance = p;
        covariance[0] = [dot(row, step) + variance, row[1], row[2]];
        covariance[1][0] = row[1];
        covariance[2][0] = row[2];
        Self {
            weight: self.weight,
            state: [dot(step, state) + pushed_deg, state[1], state[2]],
            covariance,
        }
    }

    /// Takes the likelihood of heading errors; returns its mean over what was expected.
    fn measure(&mut self, likelihood: impl Fn(f64) -> f64) -> f64 {
        let (mean, variance) = (self.state[0], self.covariance[0][0].max(1e-6));
        let density = |offset: f64, variance: f64| {
            libm::exp(-offset * offset / 2.0 / variance) / libm::sqrt(variance)
        };
        let (mut sum, mut evidence, mut first, mut second) = (0.0, 0.0, 0.0, 0.0);
        let spread = variance + SLIP_DEG * SLIP_DEG;
        // Steps of a degree, or finer if the heading is known better.
        let step = libm::sqrt(variance).min(1.0);
        let reach = (45.0 / step) as i32;
        for at in -reach..=reach {
            let offset = f64::from(at) * step;
            let expected = (1.0 - SLIP_SHARE) * density(offset, variance)
                + SLIP_SHARE * density(offset, spread);
            let weight = expected * likelihood(mean + offset);
            sum += expected;
            evidence += weight;
            first += weight * offset;
            second += weight * offset * offset;
        }
        let shift = first / evidence;
        let after = second / evidence - shift * shift;
        self.condition(shift, after.max(1e-4));
        evidence / sum
    }

    /// Moves the heading error to a new mean and variance, and the rest of the state by its correlation.
    fn condition(&mut self, shift: f64, variance: f64) {
        let p = self.covariance;
        let before = p[0][0].max(1e-6);
        if variance >= before {
            // A slip says nothing of the wheels.
            self.state[0] += shift;
            self.covariance[0][0] = variance;
            return;
        }
        let gain = [1.0, p[1][0] / before, p[2][0] / before];
        for row in 0..3 {
            self.state[row] += gain[row] * shift;
            for column in 0..3 {
                self.covariance[row][column] -= gain[row] * gain[column] * (before - variance);
            }
        }
    }
}

/// The direction of the house of a filter next to another one, degrees.
fn house_deg(filter: usize, near_deg: f64) -> f64 {
    near_deg + (filter as f64 - near_deg + 45.0).rem_euclid(90.0) - 45.0
}

fn dot(one: State, other: State) -> f64 {
    (0..3).map(|at| one[at] * other[at]).sum()
}

/// Mean and standard deviation of a part of the state over all filters.
fn mixture(filters: &[Filter], at: usize) -> Estimate {
    let value: f64 = filters.iter().map(|f| f.weight * f.state[at]).sum();
    let variance = filters.iter().map(|f| {
        let offset = f.state[at] - value;
        f.weight * (f.covariance[at][at].max(0.0) + offset * offset)
    });
    let deviation = libm::sqrt(variance.sum());
    Estimate { value, deviation }
}

/// Probability that the next wall's direction is taken for another one: a heading error that a filter expects is more
/// than an eighth of a turn off.
fn confusion(filters: &[Filter]) -> f64 {
    let each = filters.iter().map(|filter| {
        let deviation = libm::sqrt(filter.covariance[0][0].max(1e-6));
        filter.weight * libm::erfc(45.0 / deviation / std::f64::consts::SQRT_2)
    });
    each.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(32))]

        /// Unequal wheels in a house of any direction, with an error of every measured direction.
        #[test]
        fn growth_and_heading_are_found(
            per_in in -0.05..0.05_f64, house_deg in 0.0..90.0_f64,
            error_deg in 0.0..6.0_f64, phase in 0.0..6.3_f64,
        ) {
            let mut drift = Drift::default();
            let motion = Motion { path_in: 80.0, turn_deg: 30.0, variance: 1.0, ..Motion::default() };
            let mut truth_deg = 0.0;
            for step in 0..60 {
                // Errors without a mean or a trend, from the golden angle.
                let error = error_deg * libm::sin(f64::from(step) * 2.399_963 + phase);
                truth_deg += per_in * motion.path_in;
                let seen_deg = house_deg - truth_deg + error;
                drift.update(motion, |wall_deg| {
                    let off_deg = (wall_deg - seen_deg + 45.0).rem_euclid(90.0) - 45.0;
                    0.1 + 10.0 * libm::exp(-off_deg * off_deg / 2.0 / 16.0)
                });
            }
            let growth = drift.per_in();
            prop_assert!((growth.value - per_in).abs() < 4.0 * growth.deviation, "{growth:?}");
            prop_assert!(growth.deviation < PER_IN / 3.0, "{growth:?}");
            let (heading, is_lost) = drift.heading(Motion::default());
            prop_assert!((heading.value - truth_deg).abs() < 4.0 * heading.deviation && !is_lost, "{heading:?}");
        }

        /// Without walls the statement grows until it is withdrawn, and it never comes back by itself.
        #[test]
        fn heading_without_walls_is_lost(path_in in 50.0..200.0_f64) {
            let mut drift = Drift::default();
            let motion = Motion { path_in, variance: 0.1, ..Motion::default() };
            let mut was_lost = false;
            for _ in 0..60 {
                drift.update(motion, |_| 1.0);
                let (_, is_lost) = drift.heading(Motion::default());
                prop_assert!(is_lost || !was_lost);
                was_lost = is_lost;
            }
            prop_assert!(was_lost);
            let (before, _) = drift.heading(Motion::default());
            drift.find(-1);
            let (after, _) = drift.heading(Motion::default());
            prop_assert!((after.value - before.value + 90.0).abs() < 1e-6, "{after:?}");
            prop_assert!(drift.lost == 0.0);
        }
    }

    #[test]
    fn regauging_shifts_the_growth_or_forgets_it() {
        let mut drift = Drift::default();
        let known = Motion {
            path_in: 100.0,
            ..Motion::default()
        };
        for _ in 0..10 {
            drift.update(known, |wall_deg| {
                if (wall_deg - 10.0).abs() < 5.0 {
                    5.0
                } else {
                    0.1
                }
            });
        }
        let before = drift.per_in();
        assert!(before.deviation < PER_IN / 2.0);
        drift.regauge(Some(0.02));
        assert!((drift.per_in().value - before.value - 0.02).abs() < 1e-9);
        drift.regauge(None);
        assert!(drift.per_in().deviation > 0.9 * PER_IN);
    }
}
