//! The wheels' speed control.

use super::{success, value};
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::Setup;
use sr04_firmware::board::COUNTS_PER_IN;
use sr04_firmware::parameters::Parameter;

pub(super) const ALL: &[&Experiment] = &[&INSIDE, &OUTSIDE];

/// The envelope that the control must hold its speed in.
const SUPPLY_V: (f64, f64) = (10.8, 13.8);
const LOAD_SHARE: (f64, f64) = (0.05, 0.25);

/// Speed has settled by then.
const SETTLE_S: f64 = 3.0;
const MEASURE_S: f64 = 10.0;

const INSIDE: Experiment = Experiment {
    name: "pid-speed",
    trials: [24, 200],
    run: inside,
    claims: &[
        Claim {
            part: "PID",
            says: "mean speed over 10 s within 2 % of the ordered one (2 to 12 in/s), supply 10.8 to 13.8 V, \
                   load 5 to 25 %, real wheels",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "PID",
            says: "the same: how far off",
            figure: Figure::Mean {
                unit: "%",
                digits: 2,
            },
            required: Required::AtMost(2.0),
            shortfall: None,
        },
        Claim {
            part: "PID",
            says: "the same: no saturation flag",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

const OUTSIDE: Experiment = Experiment {
    name: "pid-saturation",
    trials: [12, 100],
    run: outside,
    claims: &[Claim {
        part: "PID",
        says: "supply 8 to 9.5 V and load 35 to 50 %, ordered 12 in/s: the saturation flag within 5 s",
        figure: Figure::Share,
        required: Required::AtLeast(100.0),
        shortfall: None,
    }],
};

/// A robot that prowls straight ahead in the empty hall.
fn bench(trial: &Trial, supply_v: f64, load_share: f64) -> Setup<'_> {
    let mut setup = Setup::new(trial, arena("hall").world.clone()).only(&[]);
    setup.config.conditions.supply_v = Some(supply_v);
    setup.config.conditions.load_share = load_share;
    setup
}

fn inside(trial: &Trial) -> Vec<Option<Reading>> {
    let mut dice = trial.dice();
    // The corners of the envelope first, then anywhere in it.
    let corner = |limits: (f64, f64), high: bool| if high { limits.1 } else { limits.0 };
    let (supply_v, load_share) = if trial.index < 12 {
        (
            corner(SUPPLY_V, trial.index & 1 > 0),
            corner(LOAD_SHARE, trial.index & 2 > 0),
        )
    } else {
        (
            dice.between(SUPPLY_V.0, SUPPLY_V.1),
            dice.between(LOAD_SHARE.0, LOAD_SHARE.1),
        )
    };
    let speed_in_s = [12, 6, 2].get(trial.index / 4).copied();
    let speed_in_s = speed_in_s.unwrap_or_else(|| 2 + dice.below(11) as i16);
    let mut run = bench(trial, supply_v, load_share)
        .with(Parameter::TopSpeed, speed_in_s)
        .start();
    run.seconds(SETTLE_S);
    let before_in = run.simulation.truth().path_in;
    let mut is_saturated = false;
    run.until(MEASURE_S, |simulation| {
        is_saturated |= simulation.robot().is_saturated();
        false
    });
    let speed = (run.simulation.truth().path_in - before_in) / MEASURE_S;
    let ordered =
        f64::from(run.simulation.robot().motion().velocity_cps) / f64::from(COUNTS_PER_IN);
    let off = 100.0 * (speed - ordered).abs() / ordered;
    vec![success(off <= 2.0), value(off), success(!is_saturated)]
}

fn outside(trial: &Trial) -> Vec<Option<Reading>> {
    let mut dice = trial.dice();
    let (supply_v, load_share) = (dice.between(8.0, 9.5), dice.between(0.35, 0.5));
    let mut run = bench(trial, supply_v, load_share).start();
    let flagged = run.until(5.0, |simulation| simulation.robot().is_saturated());
    vec![success(flagged.is_some())]
}
