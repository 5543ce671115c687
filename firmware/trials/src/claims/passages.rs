//! Narrow passages, niches, and how much of a house the robot sees.

use std::fmt::Write as _;

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, value};
use crate::run::Setup;
use sr04_sim::{Pose, World};

pub(super) const ALL: &[&Experiment] =
    &[&PASSAGE_15, &PASSAGE_18, &PASSAGE_24, &PASSAGE_36, &NICHE];

const HOUR_S: f64 = 3600.0;

/// Experiment with a passage of some width.
macro_rules! passage {
    ($width:literal, $name:literal, $required:expr) => {
        Experiment {
            name: $name,
            trials: [1, 40],
            run: |trial| passage(trial, $width),
            claims: &[
                Claim {
                    part: "whole robot",
                    says: concat!(
                        "1 h of prowling in two rooms joined by a passage ",
                        stringify!($width),
                        " in wide and 3 ft long: tries (the middle of the robot is 6 in inside) that come out at the other end"
                    ),
                    figure: Figure::MeanRatio {
                        unit: "%",
                        digits: 1,
                    },
                    required: $required,
                    shortfall: None,
                },
                Claim {
                    part: "whole robot",
                    says: "the same: tries in the hour",
                    figure: Figure::Mean {
                        unit: "",
                        digits: 1,
                    },
                    required: Required::Nothing,
                    shortfall: None,
                },
                Claim {
                    part: "whole robot",
                    says: "the same: longest stay in the passage",
                    figure: Figure::Mean {
                        unit: "s",
                        digits: 0,
                    },
                    required: Required::AtMost(300.0),
                    shortfall: None,
                },
            ],
        }
    };
}

const PASSAGE_15: Experiment = passage!(15, "passage-15", Required::Nothing);
const PASSAGE_18: Experiment = passage!(18, "passage-18", Required::AtLeast(50.0));
const PASSAGE_24: Experiment = passage!(24, "passage-24", Required::AtLeast(50.0));
const PASSAGE_36: Experiment = passage!(36, "passage-36", Required::AtLeast(50.0));

const NICHE: Experiment = Experiment {
    name: "niche",
    trials: [2, 100],
    run: niche,
    claims: &[
        Claim {
            part: "whole robot",
            says: "start in a niche 18 in wide and 3 ft deep, its end or its mouth ahead: time until the robot is out, at most 5 min",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "whole robot",
            says: "the same: duration",
            figure: Figure::Mean {
                unit: "s",
                digits: 0,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// Size of a cell, and cells across and along a room.
const CELL_IN: usize = 3;
const ACROSS: usize = 40;
const ALONG: usize = 32;

/// Cells from end to end of the passage.
const LONG: usize = 12;

/// Two rooms side by side, or one with a niche, joined to a passage of some width in the middle of their wall.
fn rooms(width_in: usize, is_open: bool) -> World {
    let mut text = format!("name = \"passage\"\ncell_in = {CELL_IN}\nplan = '''\n");
    let (north, wide) = ((ALONG - width_in / CELL_IN) / 2, width_in / CELL_IN);
    for row in 0..ALONG {
        let is_passage = (north..north + wide).contains(&row);
        let line: String = (0..2 * ACROSS + LONG)
            .map(|column| {
                let from_end = column.min(2 * ACROSS + LONG - 1 - column);
                let is_between = (ACROSS..ACROSS + LONG).contains(&column);
                let is_end = !is_open && column >= ACROSS + LONG - 1;
                if row == 0
                    || row == ALONG - 1
                    || from_end == 0
                    || is_end
                    || is_between && !is_passage
                {
                    '#'
                } else if (row, column) == (ALONG / 2, 10) {
                    '>'
                } else {
                    '.'
                }
            })
            .collect();
        let _ = writeln!(text, "{line}");
    }
    text.push_str("'''\n");
    World::parse("passage", &text).unwrap_or_else(|error| panic!("{error}"))
}

const WEST_IN: f64 = (ACROSS * CELL_IN) as f64;
const EAST_IN: f64 = ((ACROSS + LONG) * CELL_IN) as f64;
const MIDDLE_IN: f64 = (ALONG * CELL_IN) as f64 / 2.0;

fn passage(trial: &Trial, width_in: usize) -> Vec<Option<Reading>> {
    let world = rooms(width_in, true);
    let mut rng = trial.rng();
    let start = Pose {
        x_in: rng.between(12.0, WEST_IN - 12.0),
        y_in: rng.between(12.0, 2.0 * MIDDLE_IN - 12.0),
        theta_deg: rng.between(0.0, 360.0),
    };
    let Some(world) = world.started_at(start) else {
        return vec![None; 3];
    };
    let mut setup = Setup::new(trial, world);
    setup.config.conditions.supply_v = Some(12.4);
    let mut run = setup.start();
    let (mut tries, mut passes, mut longest_s) = (0, 0, 0.0_f64);
    // Side from which the robot has entered, and when; a try begins 6 in inside.
    let (mut entered, mut from_west, mut is_try) = (None, true, false);
    run.until(HOUR_S, |simulation| {
        let x_in = plan_x(start, simulation.truth().pose);
        let now_s = simulation.now_ms() as f64 / 1000.0;
        if x_in <= WEST_IN || x_in >= EAST_IN {
            if let Some(since_s) = entered.take() {
                longest_s = longest_s.max(now_s - since_s);
                passes += u32::from(is_try && (x_in >= EAST_IN) == from_west);
            }
            from_west = x_in <= WEST_IN;
            is_try = false;
        } else {
            entered.get_or_insert(now_s);
            let inside_in = (x_in - WEST_IN).min(EAST_IN - x_in);
            if !is_try && inside_in >= 6.0 {
                is_try = true;
                tries += 1;
            }
        }
        false
    });
    vec![
        (tries > 0).then(|| Reading::Pair(100.0 * f64::from(passes), f64::from(tries))),
        value(f64::from(tries)),
        value(longest_s),
    ]
}

/// East coordinate on the plan of a pose relative to the start.
fn plan_x(start: Pose, seen: Pose) -> f64 {
    let (sin, cos) = start.theta_deg.to_radians().sin_cos();
    start.x_in + seen.x_in * cos + seen.y_in * sin
}

fn niche(trial: &Trial) -> Vec<Option<Reading>> {
    let world = rooms(18, false);
    let mut rng = trial.rng();
    let facing_deg = if trial.index.is_multiple_of(2) {
        90.0
    } else {
        270.0
    };
    let start = Pose {
        x_in: EAST_IN - 3.0 - rng.between(7.0, 14.0),
        y_in: MIDDLE_IN + rng.between(-2.0, 2.0),
        theta_deg: facing_deg + rng.between(-20.0, 20.0),
    };
    let Some(world) = world.started_at(start) else {
        return vec![None; 2];
    };
    let mut setup = Setup::new(trial, world);
    setup.config.conditions.supply_v = Some(12.4);
    let mut run = setup.start();
    let out_s = run.until(1800.0, |simulation| {
        plan_x(start, simulation.truth().pose) < WEST_IN - 6.0
    });
    vec![
        Some(Reading::Success(
            out_s.is_some_and(|seconds| seconds <= 300.0),
        )),
        value(out_s.unwrap_or(1800.0)),
    ]
}
