//! The whole robot: repeatability and endurance.

use std::collections::BTreeSet;

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::{Run, Setup};
use sr04_sim::{Pose, World};

pub(super) const ALL: &[&Experiment] = &[&DETERMINISM, &SURVIVAL];

const DETERMINISM: Experiment = Experiment {
    name: "determinism",
    trials: [2, 20],
    run: determinism,
    claims: &[Claim {
        part: "whole robot",
        says: "10 min in the house, twice with one seed: equal inputs, outputs and poses in every tick",
        figure: Figure::Share,
        required: Required::AtLeast(100.0),
        shortfall: None,
    }],
};

/// Supply voltage, that of a half-full battery.
const SUPPLY_V: f64 = 12.4;

/// Number of hours of one trial.
const HOURS: f64 = 8.0;

const SURVIVAL: Experiment = Experiment {
    name: "survival",
    trials: [1, 20],
    run: survival,
    claims: &[
        Claim {
            part: "whole robot",
            says: "8 h on a bench supply, each trial in another generated house: never stuck (less than 12 in within 5 min with the motors on)",
            figure: Figure::Share,
            required: Required::AtLeast(90.0),
            shortfall: None,
        },
        Claim {
            part: "whole robot",
            says: "the same: hours until stuck",
            figure: Figure::HoursTo,
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "whole robot",
            says: "the same: floor covered (squares of a foot that the middle of the robot has been in), median",
            figure: Figure::Median {
                unit: "sq ft",
                digits: 0,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "whole robot",
            says: "the same: floor covered, worst",
            figure: Figure::Least {
                unit: "sq ft",
                digits: 0,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

fn determinism(trial: &Trial) -> Vec<Option<Reading>> {
    let start = || Setup::anywhere(trial, "house").start();
    let (mut one, mut other) = (start(), start());
    let look = |run: &Run| {
        let simulation = &run.simulation;
        (
            *simulation.inputs(),
            simulation.outputs(),
            simulation.truth(),
        )
    };
    let same = (0..12_000).all(|_| {
        one.tick();
        other.tick();
        look(&one) == look(&other)
    });
    vec![success(same)]
}

fn survival(trial: &Trial) -> Vec<Option<Reading>> {
    let name = format!("generated:{}", trial.seed.value());
    let world = World::open(&name).unwrap_or_else(|error| panic!("{error}"));
    let mut setup = Setup::new(trial, world);
    // A battery lasts five hours; foraging has trials of its own.
    setup.config.conditions.supply_v = Some(SUPPLY_V);
    let mut run = setup.start();
    let mut covered = Covered::default();
    let ended_s = run.until(HOURS * 3600.0, |simulation| {
        covered.visit(simulation.truth().pose);
        simulation.is_stuck()
    });
    let stuck = ended_s.is_some();
    let events = Reading::Events {
        count: u32::from(stuck),
        hours: ended_s.map_or(HOURS, |seconds| seconds / 3600.0),
    };
    vec![
        success(!stuck),
        Some(events),
        Some(covered.reading()),
        Some(covered.reading()),
    ]
}

/// The square feet that the middle of the robot has visited.
#[derive(Default)]
pub(super) struct Covered(BTreeSet<(i32, i32)>);

impl Covered {
    pub(super) fn visit(&mut self, pose: Pose) {
        let foot = |inches: f64| (inches / 12.0).floor() as i32;
        self.0.insert((foot(pose.x_in), foot(pose.y_in)));
    }

    pub(super) fn reading(&self) -> Reading {
        Reading::Value(self.0.len() as f64)
    }
}
