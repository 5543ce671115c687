//! True outlines of simulated houses, and maps laid over them.

use std::collections::HashSet;

use sr04_sim::Outline;

/// A wall is found by a cell whose middle is this close, inches: one cell and half of its diagonal.
pub const FOUND_IN: f64 = 5.2;

/// X and Y, inches.
pub type Place = (f64, f64);

/// The straight edges of the true outlines.
pub fn edges(outlines: &[Outline]) -> Vec<[Place; 2]> {
    let ring = |corners: &[Place]| -> Vec<[Place; 2]> {
        let next = corners.iter().cycle().skip(1);
        corners
            .iter()
            .zip(next)
            .map(|(from, to)| [*from, *to])
            .collect()
    };
    let edges = outlines.iter().flat_map(|outline| match outline {
        Outline::Segment { from, to, .. } => vec![[(from.x_in, from.y_in), (to.x_in, to.y_in)]],
        Outline::Block { from, to } => ring(&[
            (from.x_in, from.y_in),
            (to.x_in, from.y_in),
            (to.x_in, to.y_in),
            (from.x_in, to.y_in),
        ]),
        Outline::Circle {
            center, radius_in, ..
        } => {
            let corners: Vec<Place> = (0..8)
                .map(|eighth| {
                    let (sin, cos) = (f64::from(eighth) * std::f64::consts::FRAC_PI_4).sin_cos();
                    (center.x_in + radius_in * cos, center.y_in + radius_in * sin)
                })
                .collect();
            ring(&corners)
        }
    });
    edges.collect()
}

/// Points on an edge, about an inch apart.
pub fn along([from, to]: [Place; 2]) -> impl Iterator<Item = Place> {
    let steps = distance_in(from, to).ceil().max(1.0) as u32;
    (0..=steps).map(move |step| {
        let share = f64::from(step) / f64::from(steps);
        (
            from.0 + (to.0 - from.0) * share,
            from.1 + (to.1 - from.1) * share,
        )
    })
}

pub fn distance_in(one: Place, other: Place) -> f64 {
    (one.0 - other.0).hypot(one.1 - other.1)
}

/// A turn around the origin, then a shift, that lays a map over the true one.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// Degrees clockwise.
    pub turn_deg: i32,
    pub shift_in: Place,
}

impl Fit {
    /// The fit with which most cells are near a surface: up to 13 degrees and 6 in for each step, and 3 in more.
    pub fn best(cells: &[Place], surfaces: &[Place], steps: i32) -> Self {
        let inch = |place: Place| (place.0.round() as i32, place.1.round() as i32);
        let reach = FOUND_IN as i32;
        let near: HashSet<(i32, i32)> = surfaces
            .iter()
            .flat_map(|place| {
                let (x, y) = inch(*place);
                (-reach..=reach)
                    .flat_map(move |dx| (-reach..=reach).map(move |dy| (x + dx, y + dy)))
            })
            .collect();
        let count = |fit: &Self| {
            let places = cells.iter().map(|cell| fit.true_place(*cell));
            places.filter(|place| near.contains(&inch(*place))).count()
        };
        // Coarse steps first, then fine ones around the best.
        let mut best = Self {
            turn_deg: 0,
            shift_in: (0.0, 0.0),
        };
        for (turns, steps, step_in) in [(6, steps, 6.0), (1, 1, 3.0)] {
            let (turn, (x, y)) = (best.turn_deg, best.shift_in);
            let shifts =
                move |from: f64| (-steps..=steps).map(move |at| from + f64::from(at) * step_in);
            let tries = (-turns..=turns).flat_map(|at| {
                let turn_deg = turn + at * if turns > 1 { 2 } else { 1 };
                shifts(x).flat_map(move |x| {
                    shifts(y).map(move |y| Self {
                        turn_deg,
                        shift_in: (x, y),
                    })
                })
            });
            best = tries.max_by_key(count).unwrap_or(best);
        }
        best
    }

    /// The true place of a place on the map.
    pub fn true_place(&self, (x, y): Place) -> Place {
        let (sin, cos) = f64::from(self.turn_deg).to_radians().sin_cos();
        let (shift_x, shift_y) = self.shift_in;
        (x * cos + y * sin + shift_x, y * cos - x * sin + shift_y)
    }
}
