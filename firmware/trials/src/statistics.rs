//! Figures with 95 % intervals.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Quantile of the normal distribution for a two-sided 95 % interval.
const Z: f64 = 1.959_963_985;
const LOW: f64 = 0.025;
const HIGH: f64 = 0.975;

/// A figure and the limits of its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Estimate {
    pub(crate) figure: f64,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

/// A share in percent with its Wilson interval.
pub(crate) fn share(successes: usize, trials: usize) -> Estimate {
    let (count, share) = (trials as f64, successes as f64 / trials as f64);
    let middle = share + Z * Z / (2.0 * count);
    let half = Z * (share * (1.0 - share) / count + Z * Z / (4.0 * count * count)).sqrt();
    let scale = 1.0 + Z * Z / count;
    Estimate {
        figure: share * 100.0,
        low: ((middle - half) / scale * 100.0).clamp(0.0, 100.0),
        high: ((middle + half) / scale * 100.0).clamp(0.0, 100.0),
    }
}

/// A mean with its Student interval.
pub(crate) fn mean(values: &[f64]) -> Estimate {
    let count = values.len() as f64;
    let figure = values.iter().sum::<f64>() / count;
    let spread: f64 = values.iter().map(|value| (value - figure).powi(2)).sum();
    let half = StudentsT::new(0.0, 1.0, count - 1.0).map_or(f64::INFINITY, |t| {
        t.inverse_cdf(HIGH) * (spread / (count - 1.0) / count).sqrt()
    });
    Estimate {
        figure,
        low: figure - half,
        high: figure + half,
    }
}

/// A median with the interval of the order statistics; the extremes if there are too few values for one.
pub(crate) fn median(values: &[f64]) -> Estimate {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let count = sorted.len();
    let last = count - 1;
    let below = (count as f64 / 2.0 - Z * (count as f64).sqrt() / 2.0).floor();
    let rank = (below.max(1.0) as usize - 1).min(last);
    Estimate {
        figure: f64::midpoint(sorted[last / 2], sorted[count / 2]),
        low: sorted[rank],
        high: sorted[last - rank],
    }
}

/// The least value; there is no interval.
pub(crate) fn least(values: &[f64]) -> Estimate {
    extreme(values.iter().copied().fold(f64::INFINITY, f64::min))
}

/// The greatest value; there is no interval.
pub(crate) fn greatest(values: &[f64]) -> Estimate {
    extreme(values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
}

const fn extreme(figure: f64) -> Estimate {
    Estimate {
        figure,
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    }
}

/// The mean of the first values divided by the mean of the second, with the Student interval of the pairs' contributions
/// (delta method).
pub(crate) fn ratio_of_means(pairs: &[(f64, f64)]) -> Estimate {
    let count = pairs.len() as f64;
    let (one, other) = pairs
        .iter()
        .fold((0.0, 0.0), |sum, pair| (sum.0 + pair.0, sum.1 + pair.1));
    let figure = one / other;
    let parts: Vec<f64> = pairs
        .iter()
        .map(|pair| (pair.0 - figure * pair.1) / (other / count))
        .collect();
    let around_zero = mean(&parts);
    Estimate {
        figure,
        low: figure + around_zero.low,
        high: figure + around_zero.high,
    }
}

/// Events per hour with the exact Poisson interval.
pub(crate) fn per_hour(events: u32, hours: f64) -> Estimate {
    let limit = |freedom: u32, tail: f64| {
        ChiSquared::new(f64::from(freedom)).map_or(0.0, |chi| chi.inverse_cdf(tail) / 2.0 / hours)
    };
    Estimate {
        figure: f64::from(events) / hours,
        low: limit(2 * events, LOW),
        high: limit(2 * events + 2, HIGH),
    }
}

/// Mean hours per event with the interval of an exponential waiting time. Without any event only the lower limit is
/// known: a third of the hours, because an event would have occurred within three times the limit with 95 %.
pub(crate) fn hours_to(events: u32, hours: f64) -> Estimate {
    if events == 0 {
        return Estimate {
            figure: f64::INFINITY,
            low: hours / 3.0,
            high: f64::INFINITY,
        };
    }
    let rate = per_hour(events, hours);
    Estimate {
        figure: 1.0 / rate.figure,
        low: 1.0 / rate.high,
        high: 1.0 / rate.low,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_near(estimate: Estimate, figure: f64, low: f64, high: f64) {
        let near = |one: f64, other: f64| (one - other).abs() < 0.01;
        assert!(
            near(estimate.figure, figure) && near(estimate.low, low) && near(estimate.high, high),
            "{estimate:?}"
        );
    }

    #[test]
    fn median_has_the_ranks_of_its_interval() {
        // The 5th of 20 values from either end.
        let values: Vec<f64> = (1..=20).map(f64::from).collect();
        let estimate = median(&values);
        assert_eq!(
            (estimate.low, estimate.figure, estimate.high),
            (5.0, 10.5, 16.0)
        );
        assert_eq!(Some(median(&[3.0]).figure), Some(3.0));
        assert_eq!(Some(least(&[3.0, 1.0]).figure), Some(1.0));
    }

    #[test]
    fn figures_match_textbooks() {
        // Newcombe 1998: 81 of 263, Wilson without correction.
        is_near(share(81, 263), 30.80, 25.53, 36.62);
        is_near(share(0, 20), 0.0, 0.0, 16.11);
        // t(0.975, 3) = 3.1824.
        is_near(mean(&[1.0, 2.0, 3.0, 4.0]), 2.5, 0.446, 4.554);
        // Garwood 1936: 10 events.
        is_near(per_hour(10, 1.0), 10.0, 4.795, 18.39);
        is_near(per_hour(0, 1.0), 0.0, 0.0, 3.689);
        let never = hours_to(0, 30.0);
        assert!(never.figure.is_infinite() && (never.low - 10.0).abs() < 1e-9);
        is_near(hours_to(10, 100.0), 10.0, 5.438, 20.85);
    }

    #[test]
    fn ratio_lies_within_its_interval() {
        let ratio = ratio_of_means(&[(10.0, 1.0), (20.0, 2.0), (30.0, 3.0)]);
        is_near(ratio, 10.0, 10.0, 10.0);
        let ratio = ratio_of_means(&[(11.0, 1.0), (9.0, 1.0)]);
        assert!(ratio.low < 9.0 && ratio.high > 11.0, "{ratio:?}");
    }

    #[test]
    fn single_value_has_an_infinite_interval() {
        assert!(mean(&[1.0]).high.is_infinite());
    }
}
