//! Narrow passages and niches.

use std::fmt::Write as _;
use std::sync::OnceLock;

use crate::arena::on_plan;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Run, Setup};
use crate::seeds::Rng;
use sr04_sim::{Pose, World};

pub(super) const ALL: &[&Experiment] = &[
    &PASSAGE_15,
    &PASSAGE_18,
    &PASSAGE_24,
    &PASSAGE_36,
    &CORNER_18,
    &NICHE,
];

const HOUR_S: f64 = 3600.0;

/// Maximum time for which a passage or a niche may hold the robot, seconds.
const HELD_S: f64 = 300.0;

/// Defines an experiment with a passage of a shape and width.
macro_rules! passage {
    ($shape:expr, $width:literal, $name:literal, $which:literal, $required:expr) => {
        Experiment {
            name: $name,
            trials: [4, 150],
            run: |trial| {
                static PASSAGE: OnceLock<Passage> = OnceLock::new();
                tried(trial, PASSAGE.get_or_init(|| $shape($width)))
            },
            claims: &[
                Claim {
                    part: "whole robot",
                    says: concat!(
                        $which,
                        ", start 2 to 5 ft before its mouth, within 20 degrees of its axis and heading within 15 degrees of the \
                         mouth: out at the other end without going 6 ft away first"
                    ),
                    figure: Figure::Share,
                    required: $required,
                    shortfall: None,
                },
                Claim {
                    part: "whole robot",
                    says: "the same, then an hour of prowling: the robot goes through at least once in that hour",
                    figure: Figure::Share,
                    required: Required::Nothing,
                    shortfall: None,
                },
                Claim {
                    part: "whole robot",
                    says: "the same: times through in the hour",
                    figure: Figure::Mean {
                        unit: "",
                        digits: 1,
                    },
                    required: Required::Nothing,
                    shortfall: None,
                },
                Claim {
                    part: "whole robot",
                    says: "the same: never longer than 5 min in the passage",
                    figure: Figure::Share,
                    required: Required::AtLeast(100.0),
                    shortfall: None,
                },
            ],
        }
    };
}

const HALF: Required = Required::AtLeast(50.0);

const PASSAGE_15: Experiment = passage!(
    straight,
    15,
    "passage-15",
    "a passage 15 in wide and 3 ft long between two rooms",
    Required::Nothing
);
const PASSAGE_18: Experiment = passage!(
    straight,
    18,
    "passage-18",
    "a passage 18 in wide and 3 ft long between two rooms",
    HALF
);
const PASSAGE_24: Experiment = passage!(
    straight,
    24,
    "passage-24",
    "a passage 24 in wide and 3 ft long between two rooms",
    HALF
);
const PASSAGE_36: Experiment = passage!(
    straight,
    36,
    "passage-36",
    "a passage 36 in wide and 3 ft long between two rooms",
    HALF
);
const CORNER_18: Experiment = passage!(
    corner,
    18,
    "passage-corner",
    "a passage 18 in wide with a right angle between two legs of 3 ft",
    HALF
);

const NICHE: Experiment = Experiment {
    name: "niche",
    trials: [20, 2000],
    run: niche,
    claims: &[
        Claim {
            part: "whole robot",
            says: "start in a niche 15 to 24 in wide and 1.5 to 5 ft deep between walls or furniture, heading anywhere: out of it \
                   within 5 min",
            figure: Figure::Share,
            required: Required::AtLeast(99.5),
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
        Claim {
            part: "whole robot",
            says: "the same: longest hold",
            figure: Figure::Greatest {
                unit: "s",
                digits: 0,
            },
            required: Required::AtMost(HELD_S),
            shortfall: None,
        },
    ],
};

/// Size of a cell, and cells across and along a room, inches.
const CELL_IN: usize = 3;
const ACROSS: usize = 40;
const ALONG: usize = 32;

/// Number of cells from end to end of a leg of a passage.
const LEG: usize = 12;

/// A plan with a character per cell, first filled with walls.
struct Plan(Vec<Vec<char>>);

impl Plan {
    fn new(columns: usize, rows: usize) -> Self {
        Self(vec![vec!['#'; columns]; rows])
    }

    /// Fills cells from a column and a row; the row counts from the north.
    fn fill(&mut self, column: usize, row: usize, columns: usize, rows: usize, glyph: char) {
        for line in self.0.iter_mut().skip(row).take(rows) {
            line.iter_mut()
                .skip(column)
                .take(columns)
                .for_each(|cell| *cell = glyph);
        }
    }

    fn world(&self) -> World {
        let mut text = format!("name = \"passage\"\ncell_in = {CELL_IN}\nplan = '''\n");
        for line in &self.0 {
            let _ = writeln!(text, "{}", line.iter().collect::<String>());
        }
        text.push_str("'''\n");
        World::parse("passage", &text).unwrap_or_else(|error| panic!("{error}"))
    }
}

/// Two rooms joined by a passage. It begins at the eastern wall of the first room.
struct Passage {
    world: World,
    /// Middle of its mouth in the first room.
    mouth: (f64, f64),
    /// Distance into the passage from its far end; negative in the second room.
    from_end: fn(f64, f64) -> f64,
}

const MOUTH_X_IN: f64 = (ACROSS * CELL_IN) as f64;

fn straight(width_in: usize) -> Passage {
    const END_IN: f64 = ((ACROSS + LEG) * CELL_IN) as f64;
    let wide = width_in / CELL_IN;
    let mut plan = Plan::new(2 * ACROSS + LEG, ALONG);
    plan.fill(1, 1, ACROSS - 1, ALONG - 2, '.');
    plan.fill(ACROSS + LEG, 1, ACROSS - 1, ALONG - 2, '.');
    let north = (ALONG - wide) / 2;
    plan.fill(ACROSS, north, LEG, wide, '.');
    plan.fill(10, ALONG / 2, 1, 1, '>');
    Passage {
        world: plan.world(),
        mouth: (
            MOUTH_X_IN,
            ((ALONG - north) * CELL_IN) as f64 - width_in as f64 / 2.0,
        ),
        from_end: |x_in, _| END_IN - x_in,
    }
}

/// The second room is north-east of the first one.
fn corner(width_in: usize) -> Passage {
    const END_IN: f64 = (ALONG * CELL_IN) as f64;
    let wide = width_in / CELL_IN;
    let mut plan = Plan::new(2 * ACROSS, 2 * ALONG);
    plan.fill(1, ALONG, ACROSS - 1, ALONG - 1, '.');
    plan.fill(ACROSS / 2, 1, 3 * ACROSS / 2 - 1, ALONG - 1, '.');
    // A wall of one leg's length between the rooms.
    plan.fill(1, ALONG, 2 * ACROSS - 2, LEG, '#');
    plan.fill(ACROSS, ALONG + LEG, LEG + wide, wide, '.');
    plan.fill(ACROSS + LEG, ALONG, wide, LEG + wide, '.');
    plan.fill(10, 3 * ALONG / 2, 1, 1, '>');
    Passage {
        world: plan.world(),
        mouth: (
            MOUTH_X_IN,
            ((ALONG - LEG) * CELL_IN) as f64 - width_in as f64 / 2.0,
        ),
        from_end: |_, y_in| END_IN - y_in,
    }
}

/// Runs a robot that aims at the passage, for an hour.
fn tried(trial: &Trial, passage: &Passage) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let bearing_deg = 90.0 + rng.between(-20.0, 20.0);
    let away_in = rng.between(24.0, 60.0);
    let (sin, cos) = bearing_deg.to_radians().sin_cos();
    let start = Pose {
        x_in: passage.mouth.0 - away_in * sin,
        y_in: passage.mouth.1 - away_in * cos,
        theta_deg: bearing_deg + rng.between(-15.0, 15.0),
    };
    let Some(mut run) = start_at(trial, &passage.world, start) else {
        return vec![None; 4];
    };
    let mut first = None;
    let (mut times, mut longest_s) = (0, 0.0_f64);
    let (mut is_in_first, mut entered_s) = (true, None);
    run.until(HOUR_S, |simulation| {
        let at = on_plan(start, simulation.truth().pose);
        let now_s = simulation.now_ms() as f64 / 1000.0;
        let is_second = (passage.from_end)(at.x_in, at.y_in) <= 0.0;
        if is_second || at.x_in <= passage.mouth.0 {
            entered_s = None;
            times += u32::from(is_in_first == is_second);
            is_in_first = !is_second;
            let away_in = (at.x_in - passage.mouth.0).hypot(at.y_in - passage.mouth.1);
            if first.is_none() && (is_second || away_in > 72.0) {
                first = Some(is_second);
            }
        } else {
            longest_s = longest_s.max(now_s - *entered_s.get_or_insert(now_s));
        }
        false
    });
    vec![
        success(first == Some(true)),
        success(times > 0),
        value(f64::from(times)),
        success(longest_s <= HELD_S),
    ]
}

/// A robot at a place of the plan; `None` if it does not fit there.
fn start_at(trial: &Trial, world: &World, start: Pose) -> Option<Run> {
    let mut setup = Setup::new(trial, world.started_at(start)?);
    setup.config.conditions.supply_v = Some(12.4);
    Some(setup.start())
}

/// A room with a niche in its eastern side, its walls of different materials.
fn niche_world(rng: &mut Rng, wide: usize, deep: usize) -> World {
    let mut plan = Plan::new(ACROSS + deep + 8, ALONG);
    plan.fill(1, 1, ACROSS - 1, ALONG - 2, '.');
    let north = (ALONG - wide) / 2;
    let mut material = || ['#', 'w', 's', 'k', '='][rng.below(5)];
    let sides = [material(), material(), material()];
    plan.fill(ACROSS, 1, deep, north - 1, sides[0]);
    plan.fill(
        ACROSS,
        north + wide,
        deep,
        ALONG - 1 - north - wide,
        sides[1],
    );
    plan.fill(ACROSS + deep, north, 7, wide, sides[2]);
    plan.fill(ACROSS, north, deep, wide, '.');
    plan.fill(10, ALONG / 2, 1, 1, '>');
    plan.world()
}

fn niche(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let (wide, deep) = (5 + rng.below(4), 6 + rng.below(15));
    let world = niche_world(&mut rng, wide, deep);
    let deep_in = (deep * CELL_IN) as f64;
    let north = (ALONG - wide) / 2;
    let middle_in = ((2 * (ALONG - north) - wide) * CELL_IN) as f64 / 2.0;
    let start = Pose {
        x_in: MOUTH_X_IN + deep_in - rng.between(6.5, deep_in - 3.0),
        y_in: middle_in + rng.between(-1.0, 1.0),
        theta_deg: rng.between(0.0, 360.0),
    };
    let Some(mut run) = start_at(trial, &world, start) else {
        return vec![None; 3];
    };
    let out_s = run.until(1800.0, |simulation| {
        on_plan(start, simulation.truth().pose).x_in < MOUTH_X_IN - 6.0
    });
    vec![
        success(out_s.is_some_and(|seconds| seconds <= HELD_S)),
        value(out_s.unwrap_or(1800.0)),
        value(out_s.unwrap_or(1800.0)),
    ]
}
