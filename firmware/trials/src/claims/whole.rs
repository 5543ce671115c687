//! The whole robot: repeatability and endurance.

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::{Run, Setup};
use sr04_sim::World;

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

/// Hours of one trial.
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
            says: "the same: falls per hour",
            figure: Figure::PerHour,
            required: Required::AtMost(0.0),
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
    let ended_s = run.until(HOURS * 3600.0, |simulation| {
        simulation.is_stuck() || simulation.truth().has_fallen
    });
    let (stuck, fell) = (run.simulation.is_stuck(), run.simulation.truth().has_fallen);
    let hours = ended_s.map_or(HOURS, |seconds| seconds / 3600.0);
    let events = |happened: bool| {
        Some(Reading::Events {
            count: u32::from(happened),
            hours,
        })
    };
    vec![success(!stuck), events(stuck), events(fell)]
}
