//! Layer 3: the narrow passage, the empty room, and the jam.

use crate::arena::{arena, on_plan};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, loss, success, value};
use crate::run::{Setup, is_held_by};
use groundwave_protocol::status_codes::{Layer, Mode};
use sr04_firmware::infrared::{JAM_TICKS, OFF_TICKS};
use sr04_firmware::parameters::Parameter;
use sr04_sim::Pose;

pub(super) const ALL: &[&Experiment] = &[&GAP, &QUIVER, &JAM];

/// Middle and ends of the passage in the world `gap`, inches.
const GAP_X_IN: f64 = 76.0;
const GAP_SOUTH_IN: f64 = 124.0;
const GAP_NORTH_IN: f64 = 172.0;

/// Time of observation at rest, seconds.
const REST_S: f64 = 300.0;

const GAP: Experiment = Experiment {
    name: "ir-gap",
    trials: [20, 200],
    run: gap,
    claims: &[
        Claim {
            part: "3 IR",
            says: "gap 16 in wide and 4 ft long, start with the nose in its mouth within 10 degrees and 1 in, bumpers and \
                   IR only: through within 2 min",
            figure: Figure::Share,
            required: Required::AtLeast(80.0),
            shortfall: None,
        },
        Claim {
            part: "3 IR",
            says: "the same with max_count fixed at 3",
            figure: Figure::Share,
            required: Required::AtMost(30.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "gap: cost of switching the adaptation off",
            figure: Figure::Mean {
                unit: "points",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: None,
        },
    ],
};

const QUIVER: Experiment = Experiment {
    name: "ir-quiver",
    trials: [10, 100],
    run: quiver,
    claims: &[
        Claim {
            part: "3 IR",
            says: "5 min in reactive mode in the middle of an empty room, IR only: share of the time in which IR moves \
                   the robot (the limit of 1 % is our own)",
            figure: Figure::Mean {
                unit: "%",
                digits: 2,
            },
            required: Required::AtMost(1.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "empty room: factor with max_count fixed at 1",
            figure: Figure::Mean {
                unit: "times",
                digits: 1,
            },
            required: Required::MoreThan(2.0),
            shortfall: None,
        },
    ],
};

const JAM: Experiment = Experiment {
    name: "ir-jam",
    trials: [4, 40],
    run: jam,
    claims: &[
        Claim {
            part: "3 IR",
            says: "standing at a wall: off after exactly 30 s of detection",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "3 IR",
            says: "the same: on again after exactly 30 s",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

fn gap(trial: &Trial) -> Vec<Option<Reading>> {
    let [adaptive, fixed] = [40, 3].map(|most| passes(trial, most));
    vec![success(adaptive), success(fixed), loss(adaptive, fixed)]
}

fn passes(trial: &Trial, most: i16) -> bool {
    let mut rng = trial.rng();
    let start = Pose {
        x_in: GAP_X_IN + rng.between(-1.0, 1.0),
        y_in: GAP_SOUTH_IN - 4.0,
        theta_deg: rng.between(-10.0, 10.0),
    };
    let mut run = Setup::new(trial, arena("gap").started_at(start))
        .only(&[Layer::Bumpers, Layer::Infrared])
        .with(Parameter::InfraredMost, most)
        .start();
    let through = run.until(120.0, |simulation| {
        on_plan(start, simulation.truth().pose).y_in > GAP_NORTH_IN + 6.0
    });
    through.is_some()
}

fn quiver(trial: &Trial) -> Vec<Option<Reading>> {
    let [calm, nervous] = [(3, 40), (1, 1)].map(|(least, most)| {
        let mut run = Setup::new(trial, arena("hall").world.clone())
            .only(&[Layer::Infrared])
            .mode(Mode::Reactive)
            .with(Parameter::InfraredLeast, least)
            .with(Parameter::InfraredMost, most)
            .start();
        let mut moved_ticks = 0;
        run.until(REST_S, |simulation| {
            moved_ticks += u32::from(is_held_by(simulation, Layer::Infrared));
            false
        });
        f64::from(moved_ticks)
    });
    // One tick is added to each: the ratio of a robot that never moves is undefined.
    let times = (nervous + 1.0) / (calm + 1.0);
    vec![value(100.0 * calm / (REST_S * 20.0)), value(times)]
}

fn jam(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    // Eight to twelve inches from the south wall of the hall, facing it.
    let start = Pose {
        x_in: rng.between(100.0, 380.0),
        y_in: 6.0 + rng.between(8.0, 12.0),
        theta_deg: 180.0 + rng.between(-20.0, 20.0),
    };
    let mut run = Setup::new(trial, arena("hall").started_at(start))
        .only(&[Layer::Infrared])
        .mode(Mode::User)
        .start();
    let mut ticks_until = |jammed: bool| {
        let seconds = run.until(40.0, |simulation| {
            simulation.robot().infrared().is_jammed() == jammed
        });
        seconds.map(|seconds| (seconds * 20.0).round() as u16)
    };
    let durations = [true, false, true].map(&mut ticks_until);
    let [_, off, on] = durations;
    // The LEDs are on half a tick after the detectors: the first tick has no detection yet.
    let on_as_told = on.is_some_and(|ticks| (JAM_TICKS..=JAM_TICKS + 1).contains(&ticks));
    vec![success(on_as_told), success(off == Some(OFF_TICKS))]
}
