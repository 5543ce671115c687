//! A broken encoder: power without counts.

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::Setup;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::board::Side;
use sr04_sim::Faults;

pub(super) const ALL: &[&Experiment] = &[&BROKEN, &WORN];

/// Time within which the robot has to stop, seconds.
const LIMIT_S: f64 = 60.0;

const BROKEN: Experiment = Experiment {
    name: "encoder-broken",
    trials: [20, 500],
    run: broken,
    claims: &[
        Claim {
            part: "encoders",
            says: "one encoder without counts, start anywhere in the house, prowling with every layer: the robot recognizes it and \
                   stops within a minute",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "encoders",
            says: "the same: time until it stops",
            figure: Figure::Mean {
                unit: "s",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "encoders",
            says: "the same: longest",
            figure: Figure::Greatest {
                unit: "s",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

const HOURS: f64 = 2.0;

const WORN: Experiment = Experiment {
    name: "encoder-worn",
    trials: [2, 100],
    run: worn,
    claims: &[Claim {
        part: "encoders",
        says: "2 h in the house with worn sensors, on a bench supply: stops for an encoder that is not broken, per hour",
        figure: Figure::PerHour,
        required: Required::AtMost(0.0),
        shortfall: None,
    }],
};

fn stops_s(trial: &Trial, faults: Faults, limit_s: f64) -> Option<f64> {
    let mut setup = Setup::anywhere(trial, "house");
    setup.config.conditions.supply_v = Some(12.4);
    setup.config.conditions.faults = faults;
    let mut run = setup.start();
    run.until(limit_s, |simulation| {
        simulation.robot().mode() == Mode::Stop
    })
}

fn broken(trial: &Trial) -> Vec<Option<Reading>> {
    let side = [Side::Left, Side::Right][trial.index % 2];
    let faults = Faults {
        dead_encoder: Some(side),
        ..Faults::default()
    };
    let stopped_s = stops_s(trial, faults, 300.0);
    vec![
        success(stopped_s.is_some_and(|seconds| seconds <= LIMIT_S)),
        value(stopped_s.unwrap_or(300.0)),
        value(stopped_s.unwrap_or(300.0)),
    ]
}

fn worn(trial: &Trial) -> Vec<Option<Reading>> {
    let stopped_s = stops_s(trial, Faults::WORN, HOURS * 3600.0);
    vec![Some(Reading::Events {
        count: u32::from(stopped_s.is_some()),
        hours: stopped_s.map_or(HOURS, |seconds| seconds / 3600.0),
    })]
}
