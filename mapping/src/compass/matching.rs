//! Matching of the walls just seen with walls of the map, by translation alone: the heading is known.
//!
//! Correlative scan matching (Olson, "Real-time correlative scan matching", 2009): every displacement on a grid gets the
//! likelihood of the walls seen, and the mean and covariance of the posterior are the result. A wall seen is the foot of its
//! normal, and only walls that face the same way are compared.

/// How finely walls are compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scale {
    /// Side of a cell and step of the displacements, inches.
    pub(super) cell_in: f64,
    /// Standard deviation of a wall's distance, inches.
    pub(super) deviation_in: f64,
    /// Cells before and behind a foot in which the map would have shown another wall.
    pub(super) window: i64,
}

/// The scale of a stretch and the map around it: a window of 36 in.
const FINE: Scale = Scale {
    cell_in: 2.0,
    deviation_in: 2.5,
    window: 18,
};

/// Half of the length along a wall for which a foot speaks, inches.
const HALF_LENGTH_IN: f64 = 12.0;

/// Cells on either side of a foot over which its deviation spreads it.
const SPREAD: i64 = 4;

/// Number of feet, spread over the window, that stand for walls that the map has missed; and the least ratio of likelihoods.
const UNKNOWN: f32 = 2.0;
const LEAST_RATIO: f32 = 0.1;

/// Furthest displacement tried, inches, and its greatest squared Mahalanobis distance.
const REACH_IN: f64 = 80.0;
const GATE: f64 = 12.0;

/// Margin around the map's part that is compared, inches.
const MARGIN_IN: f64 = 12.0;

/// Greatest width of the part that is compared, inches; a stretch without end is not matched.
const WIDTH_MAX_IN: f64 = 900.0;

/// Power of the likelihood: neighbouring echoes repeat each other.
const POWER: f64 = 0.12;

/// Share of the posterior that has the prior's shape whatever the map says.
const DOUBT: f64 = 0.02;

/// Variance that no match takes away, square inches: a map has errors of its own.
const KEPT: f64 = 25.0;

/// A matrix of two rows.
pub(super) type Matrix = [[f64; 2]; 2];

/// The foot of a wall's normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Foot {
    /// Side of the house that the sonar faced: quarter turns from +Y.
    pub(crate) facing: usize,
    pub(crate) x_in: f64,
    pub(crate) y_in: f64,
    pub(crate) weight: f64,
}

impl Foot {
    /// The foot after a displacement.
    pub(crate) fn moved(self, (x_in, y_in): (f64, f64)) -> Self {
        Self {
            x_in: self.x_in + x_in,
            y_in: self.y_in + y_in,
            ..self
        }
    }
}

/// Displacement of the feet seen, and how much of its prior covariance a match takes away.
#[derive(Clone, Copy, Debug)]
pub(super) struct Match {
    pub(super) shift_in: (f64, f64),
    pub(super) taken: Matrix,
}

/// Inverse of a covariance; `None` if it has none.
pub(super) fn inverse(matrix: Matrix) -> Option<Matrix> {
    let [[a, b], [c, d]] = matrix;
    let determinant = a * d - b * c;
    (determinant > 1e-9).then(|| {
        [
            [d / determinant, -b / determinant],
            [-c / determinant, a / determinant],
        ]
    })
}

/// Logarithms of likelihood ratios, for each facing: a wall here against a wall anywhere.
pub(super) struct Evidence {
    scale: Scale,
    from: (f64, f64),
    pub(super) columns: usize,
    rows: usize,
    pub(super) ratios: [Vec<f32>; 4],
}

impl Evidence {
    /// The evidence of a map's feet in a rectangle, for the facings that were seen.
    pub(super) fn new(
        scale: Scale,
        seen: &[Foot],
        map: &[Foot],
        from: (f64, f64),
        to: (f64, f64),
    ) -> Self {
        let cells = |from: f64, to: f64| ((to - from) / scale.cell_in) as usize + 2;
        let mut it = Self {
            scale,
            from,
            columns: cells(from.0, to.0),
            rows: cells(from.1, to.1),
            ratios: Default::default(),
        };
        it.ratios = std::array::from_fn(|facing| {
            let is_seen = seen.iter().any(|foot| foot.facing == facing);
            let map: &[Foot] = if is_seen { map } else { &[] };
            it.ratios_of(map, facing)
        });
        it
    }

    /// The ratio at a foot; `None` outside of the rectangle.
    pub(super) fn ratio(&self, foot: &Foot) -> Option<f32> {
        let (column, row) = self.cell(foot)?;
        let ratios = &self.ratios[foot.facing];
        Some(ratios[row * self.columns + column])
    }

    fn cell(&self, foot: &Foot) -> Option<(usize, usize)> {
        let (column, row) = (
            (foot.x_in - self.from.0) / self.scale.cell_in,
            (foot.y_in - self.from.1) / self.scale.cell_in,
        );
        let is_inside =
            column >= 0.0 && row >= 0.0 && column < self.columns as f64 && row < self.rows as f64;
        is_inside.then_some((column as usize, row as usize))
    }

    fn ratios_of(&self, map: &[Foot], facing: usize) -> Vec<f32> {
        let size = self.columns * self.rows;
        let mut feet = vec![0.0_f32; size];
        let mut is_empty = true;
        for foot in map.iter().filter(|foot| foot.facing == facing) {
            if let Some((column, row)) = self.cell(foot) {
                feet[row * self.columns + column] += foot.weight as f32;
                is_empty = false;
            }
        }
        let mut ratios = vec![0.0; size];
        if is_empty {
            return ratios;
        }
        // Steps and numbers of cells across and along the walls.
        let (x, y) = ((1, self.columns), (self.columns, self.rows));
        let ((across, acrosses), (along, alongs)) = if facing % 2 == 1 { (x, y) } else { (y, x) };
        let Scale {
            cell_in,
            deviation_in,
            window,
        } = self.scale;
        let half = (HALF_LENGTH_IN / cell_in) as usize;
        let mut walls = vec![0.0_f32; size];
        for line in 0..acrosses {
            let at = |cell: usize| line * across + cell * along;
            let mut sum = 0.0;
            for cell in 0..alongs + half {
                if cell < alongs {
                    sum += feet[at(cell)];
                }
                if cell > 2 * half {
                    sum -= feet[at(cell - 2 * half - 1)];
                }
                if cell >= half {
                    walls[at(cell - half)] = sum;
                }
            }
        }
        let kernel: Vec<f32> = (-SPREAD..=SPREAD)
            .map(|off| {
                let off = off as f64 * cell_in / deviation_in;
                libm::exp(-off * off / 2.0) as f32
            })
            .collect();
        let whole = kernel.iter().sum::<f32>();
        let width = (2 * window + 1) as f32;
        let mut sums = vec![0.0; acrosses + 1];
        for line in 0..alongs {
            let at = |cell: usize| line * along + cell * across;
            for cell in 0..acrosses {
                sums[cell + 1] = sums[cell] + walls[at(cell)];
            }
            if sums[acrosses] < 0.1 {
                continue;
            }
            let clamped = |cell: i64| cell.clamp(0, acrosses as i64) as usize;
            for cell in 0..acrosses {
                let middle = cell as i64;
                let count = sums[clamped(middle + window + 1)] - sums[clamped(middle - window)];
                if count < 0.1 {
                    continue;
                }
                let here: f32 = (-SPREAD..=SPREAD)
                    .zip(&kernel)
                    .filter(|(off, _)| (0..acrosses as i64).contains(&(middle + off)))
                    .map(|(off, weight)| weight / whole * walls[at((middle + off) as usize)])
                    .sum();
                let ratio = (here * width + UNKNOWN) / (count + UNKNOWN);
                ratios[at(cell)] = libm::logf(ratio.max(LEAST_RATIO));
            }
        }
        ratios
    }
}

/// Compares feet with a map's, both in the house's frame; `None` if nothing can be compared. The prior is the covariance of
/// the displacement. `idle` is the share of matches in which the map says nothing.
pub(super) fn compare(seen: &[Foot], map: &[Foot], prior: Matrix, idle: f64) -> Option<Match> {
    let inverse = inverse(prior)?;
    let steps =
        |variance: f64| ((3.0 * libm::sqrt(variance)).min(REACH_IN) / FINE.cell_in) as usize;
    let (columns, rows) = (steps(prior[0][0]), steps(prior[1][1]));
    let reach_in = |steps: usize| steps as f64 * FINE.cell_in + MARGIN_IN;
    let (mut low, mut high) = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    for foot in seen {
        low = (low.0.min(foot.x_in), low.1.min(foot.y_in));
        high = (high.0.max(foot.x_in), high.1.max(foot.y_in));
    }
    let from = (low.0 - reach_in(columns), low.1 - reach_in(rows));
    let to = (high.0 + reach_in(columns), high.1 + reach_in(rows));
    if seen.is_empty() || to.0 - from.0 > WIDTH_MAX_IN || to.1 - from.1 > WIDTH_MAX_IN {
        return None;
    }
    let evidence = Evidence::new(FINE, seen, map, from, to);
    let width = 2 * columns + 1;
    let mut sums = vec![0.0_f32; width * (2 * rows + 1)];
    for foot in seen {
        let Some((column, row)) = evidence.cell(foot) else {
            continue;
        };
        let ratios = &evidence.ratios[foot.facing];
        for (line, sums) in sums.chunks_exact_mut(width).enumerate() {
            let at = (row + line - rows) * evidence.columns + column - columns;
            for (sum, ratio) in sums.iter_mut().zip(&ratios[at..at + width]) {
                *sum += foot.weight as f32 * ratio;
            }
        }
    }
    let place = |at: usize| {
        let (column, row) = (at % width, at / width);
        let step = |cell: usize, middle: usize| (cell as f64 - middle as f64) * FINE.cell_in;
        (step(column, columns), step(row, rows))
    };
    let expected = |(x, y): (f64, f64)| {
        let distance = x * x * inverse[0][0] + 2.0 * x * y * inverse[0][1] + y * y * inverse[1][1];
        if distance > GATE {
            0.0
        } else {
            libm::exp(-distance / 2.0)
        }
    };
    let prior: Vec<f64> = (0..sums.len()).map(|at| expected(place(at))).collect();
    let likelihood: Vec<f64> = sums
        .iter()
        .zip(&prior)
        .map(|(sum, weight)| {
            if *weight > 0.0 {
                libm::exp((POWER * f64::from(*sum)).min(50.0))
            } else {
                0.0
            }
        })
        .collect();
    let pairs = || prior.iter().zip(&likelihood);
    let mean = pairs().map(|(w, l)| w * l).sum::<f64>() / prior.iter().sum::<f64>();
    let posterior = pairs().map(|(w, l)| w * ((1.0 - idle) * (l + DOUBT * mean) + idle));
    let before = moments(
        prior
            .iter()
            .enumerate()
            .map(|(at, weight)| (place(at), *weight)),
    );
    let after = moments(
        posterior
            .enumerate()
            .map(|(at, weight)| (place(at), weight)),
    );
    let less = [0, 1].map(|row| [0, 1].map(|axis| before.1[row][axis] - after.1[row][axis]));
    Some(Match {
        shift_in: after.0,
        taken: without_kept(less),
    })
}

/// A reduction of the variance less what remains of it on each of its own axes. Other axes could leave less than no variance
/// of correlated coordinates.
fn without_kept(less: Matrix) -> Matrix {
    let mean = f64::midpoint(less[0][0], less[1][1]);
    let half = (less[0][0] - less[1][1]) / 2.0;
    let radius = libm::hypot(half, less[0][1]);
    let rest = |value: f64| value - KEPT.min(value.max(0.0));
    let (long, short) = (rest(mean + radius), rest(mean - radius));
    let mean = f64::midpoint(long, short);
    let scale = if radius > 0.0 {
        (long - short) / 2.0 / radius
    } else {
        0.0
    };
    let both = less[0][1] * scale;
    [[mean + half * scale, both], [both, mean - half * scale]]
}

/// Mean and covariance of weighted places.
fn moments(places: impl Iterator<Item = ((f64, f64), f64)>) -> ((f64, f64), Matrix) {
    let (mut sum, mut x1, mut y1, mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for ((x, y), weight) in places {
        sum += weight;
        x1 += weight * x;
        y1 += weight * y;
        xx += weight * x * x;
        xy += weight * x * y;
        yy += weight * y * y;
    }
    let (x, y) = (x1 / sum, y1 / sum);
    let both = xy / sum - x * y;
    ((x, y), [[xx / sum - x * x, both], [both, yy / sum - y * y]])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Feet on two walls: one across +Y at a distance, one across +X.
    fn corner(north_in: f64, east_in: f64) -> Vec<Foot> {
        let foot = |facing, x_in, y_in| Foot {
            facing,
            x_in,
            y_in,
            weight: 1.0,
        };
        let along = |at: i32| f64::from(at) * 3.0;
        (0..12)
            .flat_map(|at| [foot(0, along(at), north_in), foot(1, east_in, along(at))])
            .collect()
    }

    proptest! {
        #[test]
        fn corner_gives_both_coordinates(x_in in -15.0..15.0_f64, y_in in -15.0..15.0_f64) {
            let map: Vec<Foot> = (0..3).flat_map(|_| corner(60.0, 50.0)).collect();
            let seen: Vec<Foot> = corner(60.0, 50.0).into_iter().map(|foot| foot.moved((-x_in, -y_in))).collect();
            let result = compare(&seen, &map, [[400.0, 0.0], [0.0, 400.0]], 0.1).unwrap();
            prop_assert!((result.shift_in.0 - x_in).abs() < 6.0, "{result:?}");
            prop_assert!((result.shift_in.1 - y_in).abs() < 6.0, "{result:?}");
            prop_assert!(result.taken[0][0] > 100.0 && result.taken[1][1] > 100.0, "{result:?}");
        }

        /// A wall says nothing along itself, and nothing to walls that face another way.
        #[test]
        fn wall_gives_one_coordinate(off_in in -15.0..15.0_f64) {
            let wall = |facing: usize| -> Vec<Foot> {
                (-60..60).map(|at| Foot { facing, x_in: f64::from(at) * 2.0, y_in: 60.0, weight: 1.0 }).collect()
            };
            let seen: Vec<Foot> = wall(0)[45..75].iter().map(|foot| foot.moved((0.0, -off_in))).collect();
            let prior = [[100.0, 0.0], [0.0, 100.0]];
            let result = compare(&seen, &wall(0), prior, 0.1).unwrap();
            prop_assert!((result.shift_in.1 - off_in).abs() < 3.5, "{result:?}");
            prop_assert!(result.shift_in.0.abs() < 1.0 && result.taken[0][0] < 10.0, "{result:?}");
            let other = compare(&seen, &wall(2), prior, 0.1).unwrap();
            prop_assert!(other.shift_in.1.abs() < 0.1 && other.taken[1][1].abs() < 0.1, "{other:?}");
        }

        /// However uncertain the coordinates are together, a match leaves a covariance.
        #[test]
        fn no_match_takes_more_than_there_is(
            short in 4.0..100.0_f64, long in 100.0..1000.0_f64, tilt_deg in -45.0..45.0_f64
        ) {
            let (sin, cos) = libm::sincos(tilt_deg.to_radians());
            let both = (long - short) * sin * cos;
            let along = [short * cos * cos + long * sin * sin, short * sin * sin + long * cos * cos];
            let prior = [[along[0], both], [both, along[1]]];
            let wall: Vec<Foot> = (-60..60)
                .map(|at| Foot { facing: 0, x_in: f64::from(at) * 2.0, y_in: 60.0, weight: 1.0 })
                .collect();
            let result = compare(&wall[45..75], &wall, prior, 0.1).unwrap();
            let left = [0, 1].map(|row| [0, 1].map(|axis| prior[row][axis] - result.taken[row][axis]));
            let determinant = left[0][0] * left[1][1] - left[0][1] * left[1][0];
            prop_assert!(left[0][0] > 0.0 && left[1][1] > 0.0 && determinant > 0.0, "{left:?}");
        }
    }
}
