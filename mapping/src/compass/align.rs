//! Alignment of two maps of walls whose places in each other are unknown.
//!
//! Correlative matching as in [`super::matching`] (Olson, "Real-time correlative scan matching", 2009), over all translations
//! and the four quarter turns: both maps are along the walls of a rectangular house. The best placement is taken only if it is
//! clearly better than every other one, as in Lowe's ratio test ("Distinctive image features from scale-invariant
//! keypoints", 2004, section 7.1), and if more walls agree than rooms of another house do by chance.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use super::matching::{Evidence, Foot, Scale};

/// Two maps of one place differ by more than a stretch and the map around it.
const COARSE: Scale = Scale {
    cell_in: 4.0,
    deviation_in: 6.0,
    window: 12,
};

/// Greatest weight of the feet in a cell: a robot that passes a wall often must not outweigh all other walls.
const WEIGHT_MAX: f64 = 4.0;

/// Distance of two placements with the same turn from which they are distinct, inches.
const DISTINCT_IN: f64 = 24.0;

/// Least ratio of the best score to that of the next distinct placement.
const RATIO: f64 = 1.7;

/// Length of a piece of wall, inches. A piece counts once, whatever its number of feet.
const PIECE_IN: f64 = 24.0;

/// Least number of pieces that agree beyond those that contradict: 60 ft of wall, more than one room has.
const PIECES: usize = 30;

/// Logarithm of the likelihood ratio from which a foot agrees, and, negative, from which it contradicts.
const CLEAR: f32 = 0.5;

/// Greatest width of a map that is aligned, inches.
const WIDTH_MAX_IN: f64 = 2400.0;

/// Place of a map in another one, both in the frames of their houses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Alignment {
    /// Clockwise quarter turns of the map.
    pub(crate) quarters: usize,
    /// Shift after the turn, inches.
    pub(crate) shift_in: (f64, f64),
}

impl Alignment {
    /// A foot in the other map.
    pub(crate) fn foot(&self, foot: &Foot) -> Foot {
        turned(foot, self.quarters).moved(self.shift_in)
    }
}

/// Reason why a run has no place on a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPlace {
    /// The run or the map has too few walls.
    TooFewWalls,
    /// No place is clearly better than the others.
    Ambiguous,
    /// Too few walls agree at the best place.
    OtherWalls,
    /// The run or the map is wider than 200 ft.
    TooLarge,
}

impl fmt::Display for NoPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewWalls => "the robot has not passed enough walls to place them on the map",
            Self::Ambiguous => {
                "its walls fit the map at no place clearly better than at others (another house, or too short)"
            }
            Self::OtherWalls => {
                "too few of its walls fit the map (another house, other rooms, or too short)"
            }
            Self::TooLarge => "it or the map is wider than 200 ft",
        })
    }
}

impl std::error::Error for NoPlace {}

/// One foot for each cell and facing, with a limited weight.
pub(crate) fn thinned(feet: &[Foot]) -> Vec<Foot> {
    let mut cells = BTreeMap::<_, (f64, f64, f64)>::new();
    for foot in feet {
        let cell = |at_in: f64| libm::floor(at_in / COARSE.cell_in) as i64;
        let sums = cells
            .entry((foot.facing, cell(foot.x_in), cell(foot.y_in)))
            .or_default();
        sums.0 += foot.weight;
        sums.1 += foot.weight * foot.x_in;
        sums.2 += foot.weight * foot.y_in;
    }
    let feet = cells.iter().map(|((facing, _, _), (weight, x, y))| Foot {
        facing: *facing,
        x_in: x / weight,
        y_in: y / weight,
        weight: weight.min(WEIGHT_MAX),
    });
    feet.collect()
}

/// Finds the place of a run's walls on a map. Both are [`thinned`].
///
/// # Errors
/// If there is none, or more than one.
pub(crate) fn align(map: &[Foot], seen: &[Foot]) -> Result<Alignment, NoPlace> {
    if pieces(map.iter()).len() < PIECES || pieces(seen.iter()).len() < PIECES {
        return Err(NoPlace::TooFewWalls);
    }
    let of_map = Bounds::of(map);
    let scores: Vec<Scores> = (0..4)
        .map(|quarters| Scores::new(map, of_map, seen, quarters))
        .collect::<Option<_>>()
        .ok_or(NoPlace::TooLarge)?;
    let best = best_of(&scores, |_| true).ok_or(NoPlace::OtherWalls)?;
    let is_distinct = |other: &Alignment| {
        let (x, y) = (
            other.shift_in.0 - best.0.shift_in.0,
            other.shift_in.1 - best.0.shift_in.1,
        );
        other.quarters != best.0.quarters || libm::hypot(x, y) > DISTINCT_IN
    };
    let next = best_of(&scores, is_distinct).map_or(0.0, |(_, score)| score);
    if f64::from(best.1) < RATIO * f64::from(next) {
        return Err(NoPlace::Ambiguous);
    }
    let (agreeing, contradicting) = compared(map, seen, best.0);
    if agreeing < PIECES + contradicting {
        return Err(NoPlace::OtherWalls);
    }
    Ok(best.0)
}

/// The best placement among those that are wanted, and its score.
fn best_of(scores: &[Scores], is_wanted: impl Fn(&Alignment) -> bool) -> Option<(Alignment, f32)> {
    let all = scores.iter().flat_map(Scores::all);
    let wanted = all.filter(|(alignment, _)| is_wanted(alignment));
    wanted.max_by(|one, other| one.1.total_cmp(&other.1))
}

/// Numbers of pieces of wall that agree with a map and that contradict it.
fn compared(map: &[Foot], seen: &[Foot], alignment: Alignment) -> (usize, usize) {
    let seen: Vec<Foot> = seen.iter().map(|foot| alignment.foot(foot)).collect();
    let bounds = Bounds::of(&seen);
    let evidence = Evidence::new(COARSE, &seen, map, bounds.low, bounds.high);
    let count = |is_so: &dyn Fn(f32) -> bool| {
        let feet = seen
            .iter()
            .filter(|foot| evidence.ratio(foot).is_some_and(is_so));
        pieces(feet).len()
    };
    (
        count(&|ratio| ratio > CLEAR),
        count(&|ratio| ratio < -CLEAR),
    )
}

/// The pieces of wall on which feet are.
fn pieces<'a>(feet: impl Iterator<Item = &'a Foot>) -> BTreeSet<(usize, i64, i64)> {
    let piece = |at_in: f64| libm::floor(at_in / PIECE_IN) as i64;
    feet.map(|foot| (foot.facing, piece(foot.x_in), piece(foot.y_in)))
        .collect()
}

/// A foot after clockwise quarter turns around the origin.
fn turned(foot: &Foot, quarters: usize) -> Foot {
    let (x, y) = (foot.x_in, foot.y_in);
    let (x_in, y_in) = [(x, y), (y, -x), (-x, -y), (-y, x)][quarters % 4];
    Foot {
        facing: (foot.facing + quarters) % 4,
        x_in,
        y_in,
        ..*foot
    }
}

/// The rectangle around feet.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: (f64, f64),
    high: (f64, f64),
}

impl Bounds {
    fn of(feet: &[Foot]) -> Self {
        let none = Self {
            low: (f64::MAX, f64::MAX),
            high: (f64::MIN, f64::MIN),
        };
        feet.iter().fold(none, |it, foot| Self {
            low: (it.low.0.min(foot.x_in), it.low.1.min(foot.y_in)),
            high: (it.high.0.max(foot.x_in), it.high.1.max(foot.y_in)),
        })
    }

    fn size(self) -> (f64, f64) {
        (self.high.0 - self.low.0, self.high.1 - self.low.1)
    }
}

/// Scores of all shifts of a run that is turned.
struct Scores {
    quarters: usize,
    /// The first shift, inches; the others are one cell apart.
    first_in: (f64, f64),
    columns: usize,
    sums: Vec<f32>,
}

impl Scores {
    /// The scores; `None` if there are too many.
    fn new(map: &[Foot], of_map: Bounds, seen: &[Foot], quarters: usize) -> Option<Self> {
        let seen: Vec<Foot> = seen.iter().map(|foot| turned(foot, quarters)).collect();
        let of_seen = Bounds::of(&seen);
        let (size, room) = (of_seen.size(), of_map.size());
        if [size.0, size.1, room.0, room.1]
            .iter()
            .any(|width| !(..WIDTH_MAX_IN).contains(width))
        {
            return None;
        }
        let cell_in = COARSE.cell_in;
        // The run moves over the map from its lower left corner to its upper right one, and touches it at both.
        let margin_in = 3.0 * cell_in;
        let from = (
            of_map.low.0 - size.0 - margin_in,
            of_map.low.1 - size.1 - margin_in,
        );
        let to = (
            of_map.high.0 + size.0 + margin_in,
            of_map.high.1 + size.1 + margin_in,
        );
        let shifts = |room: f64, size: f64| ((room + size) / cell_in) as usize + 3;
        let evidence = Evidence::new(COARSE, &seen, map, from, to);
        let mut it = Self {
            quarters,
            first_in: (from.0 - of_seen.low.0, from.1 - of_seen.low.1),
            columns: shifts(room.0, size.0),
            sums: Vec::new(),
        };
        it.sums = vec![0.0; it.columns * shifts(room.1, size.1)];
        for foot in &seen {
            let cell = |at_in: f64, low_in: f64| ((at_in - low_in) / cell_in) as usize;
            let row = cell(foot.y_in, of_seen.low.1);
            let column = cell(foot.x_in, of_seen.low.0);
            let ratios = &evidence.ratios[foot.facing];
            for (line, sums) in it.sums.chunks_exact_mut(it.columns).enumerate() {
                let at = (row + line) * evidence.columns + column;
                for (sum, ratio) in sums.iter_mut().zip(&ratios[at..at + it.columns]) {
                    *sum += foot.weight as f32 * ratio;
                }
            }
        }
        Some(it)
    }

    fn all(&self) -> impl Iterator<Item = (Alignment, f32)> {
        let sums = self.sums.iter().enumerate();
        sums.map(|(at, sum)| {
            let (column, row) = (at % self.columns, at / self.columns);
            let shift_in = (
                self.first_in.0 + column as f64 * COARSE.cell_in,
                self.first_in.1 + row as f64 * COARSE.cell_in,
            );
            let quarters = self.quarters;
            (Alignment { quarters, shift_in }, *sum)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Feet on the walls of rooms in a row, each with the Y of its south wall, a width and a depth, inches.
    fn house(rooms: &[(f64, f64, f64)]) -> Vec<Foot> {
        let mut feet = Vec::new();
        let mut west = 0.0;
        for (south, width, depth) in rooms {
            let foot = |facing, x_in, y_in| Foot {
                facing,
                x_in,
                y_in,
                weight: 1.0,
            };
            let along = |length: f64| (1..(length / 4.0) as u32).map(|at| f64::from(at) * 4.0);
            feet.extend(
                along(*width)
                    .flat_map(|x| [foot(0, west + x, south + depth), foot(2, west + x, *south)]),
            );
            feet.extend(
                along(*depth)
                    .flat_map(|y| [foot(1, west + width, south + y), foot(3, west, south + y)]),
            );
            west += width + 6.0;
        }
        feet
    }

    const ROOMS: [(f64, f64, f64); 4] = [
        (0.0, 144.0, 200.0),
        (50.0, 96.0, 130.0),
        (-34.0, 180.0, 168.0),
        (-80.0, 120.0, 144.0),
    ];

    /// The placement that undoes a placement.
    fn inverse(alignment: Alignment) -> Alignment {
        let quarters = (4 - alignment.quarters) % 4;
        let foot = Foot {
            facing: 0,
            x_in: -alignment.shift_in.0,
            y_in: -alignment.shift_in.1,
            weight: 1.0,
        };
        let origin = turned(&foot, quarters);
        Alignment {
            quarters,
            shift_in: (origin.x_in, origin.y_in),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// A run in the same rooms, turned and shifted, with errors of its walls, is put back.
        #[test]
        fn run_in_the_same_house_is_put_back(
            quarters in 0..4_usize, x_in in -500.0..500.0_f64, y_in in -500.0..500.0_f64,
            error_in in 0.0..4.0_f64, rooms in 3..5_usize, phase in 0.0..6.3_f64,
        ) {
            let map = house(&ROOMS);
            let away = Alignment { quarters, shift_in: (x_in, y_in) };
            let noise = |at: usize, step: f64| error_in * libm::sin(at as f64 * step + phase);
            let seen: Vec<Foot> = house(&ROOMS[..rooms])
                .iter()
                .enumerate()
                .map(|(at, foot)| away.foot(&foot.moved((noise(at, 2.4), noise(at, 3.7)))))
                .collect();
            let found = align(&thinned(&map), &thinned(&seen)).unwrap();
            let expected = inverse(away);
            prop_assert_eq!(found.quarters, expected.quarters);
            let off_in = libm::hypot(
                found.shift_in.0 - expected.shift_in.0,
                found.shift_in.1 - expected.shift_in.1,
            );
            prop_assert!(off_in < 8.0, "{found:?}, {expected:?}");
        }

        /// A run in other rooms has no place.
        #[test]
        fn run_in_another_house_has_no_place(
            widths in proptest::collection::vec(80.0..240.0_f64, 3), depths in proptest::collection::vec(80.0..240.0_f64, 3),
        ) {
            let rooms: Vec<(f64, f64, f64)> = widths.into_iter().zip(depths).map(|(width, depth)| (0.0, width, depth)).collect();
            let differs = |(_, width, depth): &(f64, f64, f64)| {
                ROOMS.iter().all(|(_, w, d)| {
                    let far = |a: f64, b: f64| (a - b).abs() > 12.0;
                    (far(*width, *w) || far(*depth, *d)) && (far(*width, *d) || far(*depth, *w))
                })
            };
            prop_assume!(rooms.iter().all(differs));
            let found = align(&thinned(&house(&ROOMS)), &thinned(&house(&rooms)));
            prop_assert!(found.is_err(), "{found:?}");
        }
    }

    /// Two equal rooms leave open in which of them a run was.
    #[test]
    fn equal_rooms_are_ambiguous() {
        let map = thinned(&house(&[(0.0, 150.0, 190.0), (0.0, 150.0, 190.0)]));
        let seen = thinned(&house(&[(0.0, 150.0, 190.0)]));
        assert_eq!(align(&map, &seen), Err(NoPlace::Ambiguous));
    }

    /// One room is less than what counts as a place.
    #[test]
    fn one_wall_has_no_place() {
        let seen: Vec<Foot> = house(&ROOMS)
            .into_iter()
            .filter(|foot| foot.facing == 0)
            .collect();
        let found = align(&thinned(&house(&ROOMS)), &thinned(&seen));
        assert_eq!(found, Err(NoPlace::TooFewWalls));
        assert_eq!(align(&[], &[]), Err(NoPlace::TooFewWalls));
    }

    /// Poses from a broken odometer cost no memory.
    #[test]
    fn endless_map_is_refused() {
        let far: Vec<Foot> = house(&ROOMS)
            .iter()
            .map(|foot| foot.moved((9e9, 0.0)))
            .collect();
        let map = thinned(&[house(&ROOMS), far].concat());
        assert_eq!(align(&map, &map), Err(NoPlace::TooLarge));
    }

    /// Many passes along a wall weigh as much as a few.
    #[test]
    fn weight_of_a_cell_is_limited() {
        let foot = Foot {
            facing: 1,
            x_in: 5.0,
            y_in: 6.0,
            weight: 1.0,
        };
        let thin = thinned(&[foot; 100]);
        assert_eq!(thin.len(), 1);
        assert!((thin[0].weight - WEIGHT_MAX).abs() < 1e-9 && (thin[0].x_in - 5.0).abs() < 1e-9);
    }
}
