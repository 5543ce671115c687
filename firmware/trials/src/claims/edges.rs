//! Approaches to edges of every shape from every direction.

use std::fmt::Write as _;
use std::sync::OnceLock;

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::Setup;
use crate::seeds::Rng;
use groundwave_protocol::command::{Drive, Message};
use groundwave_protocol::status_codes::Layer;
use sr04_firmware::board::Edges;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Faults, Pose, World};

pub(super) const ALL: &[&Experiment] = &[
    &PERFECT,
    &WORN,
    &HALF_BLIND,
    &ROTTEN,
    &STAIRWELL,
    &STAIRWELL_HALF_BLIND,
];

const fn falls(says: &'static str) -> Claim {
    Claim {
        part: "cliff",
        says,
        figure: Figure::Share,
        required: Required::AtMost(0.0),
        shortfall: None,
    }
}

const fn falls_per_hour(says: &'static str) -> Claim {
    Claim {
        figure: Figure::PerHour,
        ..falls(says)
    }
}

const PERFECT: Experiment = Experiment {
    name: "edges",
    trials: [400, 130_000],
    run: |trial| {
        let (kind, fell) = approach(trial, Faults::default());
        let of = |row: Kind| fell.filter(|_| row == kind);
        let kinds = [Kind::Stairwell, Kind::Acute, Kind::Rounded, Kind::Concave];
        [fell].into_iter().chain(kinds.map(of)).collect()
    },
    claims: &[
        falls(
            "approaches from every direction, prowling or driven by hand in any arc, ahead and backward, at 4 to 12 in/s, \
             to edges of the shapes below: falls",
        ),
        falls(
            "of these, to the sides and the convex corners of 90 degrees of a stairwell, straight and diagonal: falls",
        ),
        falls("of these, to the sides and the convex corners of a wedge of 45 degrees: falls"),
        falls("of these, to rounded edges, convex and concave, with radii of 9 to 48 in: falls"),
        falls("of these, to the sides and the corners of an L, one of them concave: falls"),
    ],
};

const WORN: Experiment = Experiment {
    name: "edges-worn",
    trials: [400, 120_000],
    run: |trial| vec![approach(trial, Faults::WORN).1],
    claims: &[falls(
        "the same with worn sensors (edge sensors miss 5 % of their ticks, drop out 20 times an hour for up to 2 s and \
         see a false edge in 0.01 %; bumpers miss 5 %; encoders miss and invent 0.2 %): falls",
    )],
};

const HALF_BLIND: Experiment = Experiment {
    name: "edges-half-blind",
    trials: [400, 40_000],
    run: |trial| vec![approach(trial, half_blind()).1],
    claims: &[falls(
        "the same with edge sensors that miss half of their ticks and see a false edge in 1 % (29 sensors, so a false one \
         in every fourth tick): falls",
    )],
};

fn half_blind() -> Faults {
    Faults {
        edge_misses: 0.5,
        edge_false: 0.01,
        ..Faults::default()
    }
}

const ROTTEN: Experiment = Experiment {
    name: "edges-rotten",
    trials: [400, 20_000],
    run: |trial| vec![approach(trial, Faults::ROTTEN).1],
    claims: &[Claim {
        required: Required::Nothing,
        ..falls(
            "the same with rotten sensors (edge sensors miss 50 % of their ticks, drop out 60 times an hour and see a \
             false edge in 0.1 %; bumpers miss 30 %; encoders miss and invent 1 %): falls",
        )
    }],
};

const HOURS: f64 = 4.0;

const STAIRWELL: Experiment = Experiment {
    name: "stairwell-hours",
    trials: [1, 250],
    run: |trial| stairwell(trial, Faults::WORN),
    claims: &[falls_per_hour(
        "4 h of prowling around a stairwell whose corners point into the room, whole robot with worn sensors on a bench \
         supply: falls per hour",
    )],
};

const STAIRWELL_HALF_BLIND: Experiment = Experiment {
    name: "stairwell-half-blind",
    trials: [1, 50],
    run: |trial| stairwell(trial, half_blind()),
    claims: &[falls_per_hour(
        "the same with edge sensors that miss half of their ticks and see a false edge in 1 %: falls per hour",
    )],
};

fn stairwell(trial: &Trial, faults: Faults) -> Vec<Option<Reading>> {
    let mut setup = Setup::anywhere(trial, "stairwell");
    setup.config.conditions.supply_v = Some(12.4);
    setup.config.conditions.faults = faults;
    let fallen_s = setup
        .start()
        .until(HOURS * 3600.0, |simulation| simulation.truth().has_fallen);
    vec![Some(Reading::Events {
        count: u32::from(fallen_s.is_some()),
        hours: fallen_s.map_or(HOURS, |seconds| seconds / 3600.0),
    })]
}

/// Side of the floors in inches, each with a drop in its middle.
const SIZE_IN: usize = 160;

/// Number of turns of each shape.
const TURNS: usize = 8;

/// Whether there is no floor at a place, relative to the middle of the drop.
type Shape = fn(f64, f64) -> bool;

/// Kinds of shapes with a row of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Stairwell,
    Acute,
    Rounded,
    Concave,
}

const SHAPES: [(Kind, Shape); 6] = [
    // 30 by 60 in: straight edges and convex corners.
    (Kind::Stairwell, |x, y| x.abs() < 15.0 && y.abs() < 30.0),
    // An acute corner of 45 degrees.
    (Kind::Acute, |x, y| {
        (-20.0..30.0).contains(&y) && x.abs() < (y + 20.0) * 0.414
    }),
    (Kind::Rounded, |x, y| x.hypot(y) < 25.0),
    (Kind::Rounded, |x, y| x.hypot(y) < 9.0),
    (Kind::Concave, |x, y| {
        x.abs() < 35.0 && y.abs() < 35.0 && (x > -10.0 || y > -10.0)
    }),
    // A ring around an island on which the robot may start.
    (Kind::Rounded, |x, y| (36.0..48.0).contains(&x.hypot(y))),
];

/// The floors: each shape in each of its turns.
fn floors() -> &'static [(Kind, World)] {
    static FLOORS: OnceLock<Vec<(Kind, World)>> = OnceLock::new();
    FLOORS.get_or_init(|| {
        let kinds = SHAPES
            .iter()
            .flat_map(|&shape| (0..TURNS).map(move |turn| (shape, turn)));
        kinds
            .map(|((kind, shape), turn)| (kind, floor(shape, turn)))
            .collect()
    })
}

fn floor(shape: Shape, turn: usize) -> World {
    // A step that no symmetry of a shape repeats.
    let (sin, cos) = (turn as f64 * 0.43).sin_cos();
    let mut text = "name = \"edges\"\ncell_in = 1\nplan = '''\n".to_owned();
    for row in 0..SIZE_IN {
        let line: String = (0..SIZE_IN)
            .map(|column| {
                let is_wall = [row, column].iter().any(|&at| at == 0 || at == SIZE_IN - 1);
                let (x, y) = (column as f64 - 80.0 + 0.5, 80.0 - row as f64 - 0.5);
                if is_wall {
                    '#'
                } else if (row, column) == (SIZE_IN - 10, 10) {
                    '^'
                } else if shape(x * cos - y * sin, x * sin + y * cos) {
                    '~'
                } else {
                    '.'
                }
            })
            .collect();
        let _ = writeln!(text, "{line}");
    }
    text.push_str("'''\n");
    // The text is complete and closed.
    World::parse("edges", &text).unwrap_or_default()
}

/// A place with complete floor around the ring of sensors, and an edge 10 to 30 in away in the direction of travel.
fn place(world: &World, rng: &mut Rng, backward: bool) -> Pose {
    let ahead = if backward { -1.0 } else { 1.0 };
    loop {
        let at = Pose {
            x_in: rng.between(12.0, SIZE_IN as f64 - 12.0),
            y_in: rng.between(12.0, SIZE_IN as f64 - 12.0),
            theta_deg: rng.between(0.0, 360.0),
        };
        let along = |distance_in: f64, aside_deg: f64| {
            let (sin, cos) = (at.theta_deg + aside_deg).to_radians().sin_cos();
            world.has_floor(
                at.x_in + ahead * distance_in * sin,
                at.y_in + ahead * distance_in * cos,
            )
        };
        let is_whole = (0..36).all(|step| along(7.5, f64::from(step) * 10.0))
            && (0..12).all(|step| along(4.0, f64::from(step) * 30.0));
        let meets = [-15.0, 0.0, 15.0]
            .into_iter()
            .any(|aside_deg| (5..16).any(|step| !along(f64::from(step) * 2.0, aside_deg)));
        if is_whole && meets {
            return at;
        }
    }
}

/// The kind of edge that a trial approaches, and whether the robot fell; no reading if its sensors met no edge.
fn approach(trial: &Trial, faults: Faults) -> (Kind, Option<Reading>) {
    let mut rng = trial.rng();
    let (kind, world) = &floors()[rng.below(floors().len())];
    let by_hand = rng.below(3) > 0;
    let backward = by_hand && rng.below(3) == 0;
    let start = place(world, &mut rng, backward);
    let speed = if rng.below(2) == 0 {
        12
    } else {
        4 + rng.below(9) as i16
    };
    let Some(world) = world.started_at(start) else {
        return (*kind, None);
    };
    let layers: &[Layer] = if rng.below(2) == 0 {
        &[]
    } else {
        &[Layer::Bumpers]
    };
    let mut setup = Setup::new(trial, world)
        .only(layers)
        .with(Parameter::TopSpeed, speed);
    setup.config.conditions.faults = faults;
    let mut run = setup.start();
    let velocity_in_s = if backward { -speed } else { speed } as i8;
    let rotation_in_s = rng.below(17) as i8 - 8;
    let (mut count, mut met) = (0, false);
    for tick in 0..APPROACH_TICKS {
        if by_hand && tick % 5 == 0 {
            count += 1;
            let heard = run.heard();
            run.send(&Message::Drive(Drive {
                velocity_in_s,
                rotation_in_s,
                heard,
                count,
            }));
        }
        run.tick();
        met |= run.simulation.inputs().cliff.is_some_and(Edges::any);
        if run.simulation.truth().has_fallen {
            return (*kind, success(true));
        }
    }
    (*kind, met.then_some(Reading::Success(false)))
}

/// Time of an approach and of the robot's reaction.
const APPROACH_TICKS: u32 = 8 * 20;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arena::arena;
    use crate::seeds::{Purpose, Seed};

    #[test]
    fn corner_of_a_stairwell_never_passes_between_the_sensors() {
        for faults in [Faults::default(), Faults::WORN] {
            for index in 0..200 {
                let trial = Trial {
                    index,
                    seed: Seed::nth(Purpose::Tuning, index),
                    trace: None,
                    traced: std::cell::Cell::new(0),
                };
                let (_, fell) = approach(&trial, faults);
                assert_ne!(fell, success(true), "trial {index}");
            }
        }
    }

    #[test]
    fn stairwell_is_a_world_with_a_convex_corner() {
        let world = &arena("stairwell").world;
        assert!(!world.has_floor(150.0, 150.0) && world.has_floor(80.0, 80.0));
    }
}
