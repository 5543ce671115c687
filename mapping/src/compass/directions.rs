//! The direction of the walls in the odometer's frame, smoothed over the newest stretches.
//!
//! A hidden Markov model with a state for each degree of a quarter turn, and its forward-backward algorithm (Rabiner, "A
//! tutorial on hidden Markov models", 1989). Later walls correct the headings of earlier stretches, which the filters of the
//! compass cannot: a wheel that slips turns the robot unnoticed until several stretches agree.

use super::drift::Estimate;
use super::walls::DIRECTIONS;

/// Share of stretches with a slip without any sign, and the variance of such a slip, square degrees.
const SLIP_SHARE: f64 = 0.1;
const SLIP_VARIANCE: f64 = 225.0;

/// Least variance of a change, square degrees: the states are a degree apart.
const LEAST: f64 = 0.3;

/// Probability of any change, so that no direction is excluded.
const ANY: f64 = 1e-6;

/// Probability of each direction, whole degrees.
pub(super) type Belief = [f64; DIRECTIONS];

/// Expected change of the direction during a stretch, and the likelihoods of the directions at its end.
#[derive(Clone, Debug)]
pub(super) struct Change {
    /// Mean and variance of the change, degrees and square degrees.
    pub(super) mean_deg: f64,
    pub(super) variance: f64,
    /// `None` without walls.
    pub(super) likelihood: Option<Belief>,
}

/// A belief around an estimate.
pub(super) fn belief(estimate: Estimate) -> Belief {
    let variance = estimate.deviation * estimate.deviation;
    normalized(&std::array::from_fn(|at| {
        let off_deg = off_deg(at as f64, estimate.value);
        libm::exp(-off_deg * off_deg / 2.0 / variance.max(LEAST)) + ANY
    }))
}

/// Beliefs before the first change and after each, from all of them; and the belief from the first change alone.
pub(super) fn smooth(before: &Belief, changes: &[&Change]) -> (Vec<Belief>, Belief) {
    let mut forward = vec![*before];
    for change in changes {
        let moved = moved(
            &forward[forward.len() - 1],
            change.mean_deg,
            change.variance,
        );
        forward.push(weighted(&moved, change));
    }
    let first = forward[forward.len().min(2) - 1];
    let mut later = [1.0; DIRECTIONS];
    for at in (0..forward.len()).rev() {
        forward[at] = normalized(&std::array::from_fn(|deg| forward[at][deg] * later[deg]));
        if at > 0 {
            let change = changes[at - 1];
            later = moved(&weighted(&later, change), -change.mean_deg, change.variance);
        }
    }
    (forward, first)
}

/// Mean next to another direction, and deviation, degrees.
pub(super) fn estimate(belief: &Belief, near_deg: f64) -> Estimate {
    let (mut sin, mut cos) = (0.0, 0.0);
    for (deg, share) in belief.iter().enumerate() {
        let (s, c) = libm::sincos(4.0 * (deg as f64).to_radians());
        sin += share * s;
        cos += share * c;
    }
    let mean_deg = libm::atan2(sin, cos).to_degrees() / 4.0;
    let squares = belief.iter().enumerate().map(|(deg, share)| {
        let off_deg = off_deg(deg as f64, mean_deg);
        share * off_deg * off_deg
    });
    Estimate {
        value: near_deg + off_deg(mean_deg, near_deg),
        deviation: libm::sqrt(squares.sum()),
    }
}

/// A belief after the odometer's frame was turned by whole degrees.
pub(super) fn turned(belief: &Belief, turn_deg: f64) -> Belief {
    let by = turn_deg.rem_euclid(DIRECTIONS as f64) as usize % DIRECTIONS;
    std::array::from_fn(|deg| belief[(deg + DIRECTIONS - by) % DIRECTIONS])
}

/// Difference of two directions, degrees from -45 to 45.
fn off_deg(one: f64, other: f64) -> f64 {
    (one - other + 45.0).rem_euclid(90.0) - 45.0
}

fn moved(belief: &Belief, mean_deg: f64, variance: f64) -> Belief {
    let variance = variance.max(LEAST);
    let kernel: Belief = std::array::from_fn(|change| {
        let off_deg = off_deg(change as f64, mean_deg);
        let density =
            |variance: f64| libm::exp(-off_deg * off_deg / 2.0 / variance) / libm::sqrt(variance);
        (1.0 - SLIP_SHARE) * density(variance)
            + SLIP_SHARE * density(variance + SLIP_VARIANCE)
            + ANY
    });
    let mut moved = [0.0; DIRECTIONS];
    for (from, share) in belief.iter().enumerate() {
        for (change, weight) in kernel.iter().enumerate() {
            moved[(from + change) % DIRECTIONS] += share * weight;
        }
    }
    normalized(&moved)
}

fn weighted(belief: &Belief, change: &Change) -> Belief {
    let mut belief = *belief;
    if let Some(likelihood) = &change.likelihood {
        for (share, weight) in belief.iter_mut().zip(likelihood) {
            *share *= weight;
        }
    }
    normalized(&belief)
}

fn normalized(belief: &Belief) -> Belief {
    let sum = belief.iter().sum::<f64>().max(1e-300);
    belief.map(|share| share / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A stretch whose furniture shows a wrong direction lies between others that show the true one.
        #[test]
        fn later_walls_correct_an_earlier_direction(
            true_deg in 0.0..90.0_f64, wrong_deg in 10.0..40.0_f64, growth_deg in -2.0..2.0_f64,
        ) {
            let changes: Vec<Change> = (1..=4).map(|at| {
                let seen_deg = true_deg + f64::from(at) * growth_deg + if at == 2 { wrong_deg } else { 0.0 };
                let likelihood = belief(Estimate { value: seen_deg, deviation: 4.0 }).map(|share| 0.002 + share);
                Change { mean_deg: growth_deg, variance: 1.0, likelihood: Some(likelihood) }
            }).collect();
            let before = belief(Estimate { value: true_deg, deviation: 3.0 });
            let error = |upto: usize| {
                let changes: Vec<&Change> = changes[..upto].iter().collect();
                let (beliefs, _) = smooth(&before, &changes);
                let now_deg = true_deg + 2.0 * growth_deg;
                (estimate(&beliefs[2], now_deg).value - now_deg).abs()
            };
            prop_assert!(error(4) <= error(2) + 0.1, "{} after {}", error(4), error(2));
            prop_assert!(error(4) < 3.0, "{}", error(4));
        }

        #[test]
        fn turned_frame_turns_the_belief(true_deg in 0..90_i32, turn_deg in -400..400_i32) {
            let before = belief(Estimate { value: f64::from(true_deg), deviation: 5.0 });
            let now_deg = f64::from(true_deg + turn_deg);
            let after = estimate(&turned(&before, f64::from(turn_deg)), now_deg);
            prop_assert!((after.value - now_deg).abs() < 0.1, "{after:?}");
        }
    }
}
