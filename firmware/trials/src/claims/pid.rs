//! Speed control of the wheels.

use crate::arena::{arena, on_plan};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Run, Setup};
use sr04_firmware::board::COUNTS_PER_IN;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Pose, World};

pub(super) const ALL: &[&Experiment] = &[&INSIDE, &OUTSIDE, &INCLINE, &SILL];

/// Rated ranges of supply voltage and load in which the control must hold its speed.
const SUPPLY_V: (f64, f64) = (10.8, 13.8);
const LOAD_SHARE: (f64, f64) = (0.05, 0.25);

/// Time for the speed to settle, seconds.
const SETTLE_S: f64 = 3.0;
const MEASURE_S: f64 = 10.0;

const INSIDE: Experiment = Experiment {
    name: "pid-speed",
    trials: [24, 200],
    run: inside,
    claims: &[
        Claim {
            part: "PID",
            says: "mean speed over 10 s within 2 % of the commanded one (2 to 12 in/s), supply 10.8 to 13.8 V, \
                   load 5 to 25 %, real wheels",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "PID",
            says: "the same: error",
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
        says: "supply 8 to 9.5 V and load 35 to 50 %, commanded 12 in/s: the saturation flag within 5 s",
        figure: Figure::Share,
        required: Required::AtLeast(100.0),
        shortfall: None,
    }],
};

/// Middles of the inclines in the world `floors`, 5 and 10 percent.
const INCLINES: [Pose; 2] = [plan(100.0, 240.0), plan(380.0, 240.0)];

const INCLINE: Experiment = Experiment {
    name: "pid-incline",
    trials: [24, 200],
    run: incline,
    claims: &[
        Claim {
            part: "PID",
            says: "inclines of 5 and 10 percent, driven in any direction: mean speed over 10 s within 2 % of the \
                   commanded one (2 to 7 in/s), same supply and load",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "PID",
            says: "the same: error",
            figure: Figure::Mean {
                unit: "%",
                digits: 2,
            },
            required: Required::AtMost(2.0),
            shortfall: None,
        },
    ],
};

/// Position and depth of the sill in the world `floors`, across the path north, inches.
const SILL_X_IN: f64 = 240.0;
const SILL_Y_IN: f64 = 240.0;
const SILL_DEPTH_IN: f64 = 3.0;

/// Distance beyond the sill at which it has been climbed, inches: a little more than the track.
const CLIMBED_IN: f64 = 8.0;

/// Speed below which the robot stands, in/s.
const STANDING_IN_S: f64 = 0.1;

/// Number of ticks of standing that count as stopped: half a second.
const STOPPED_TICKS: u32 = 10;

const SILL: Experiment = Experiment {
    name: "pid-sill",
    trials: [24, 200],
    run: sill,
    claims: &[
        Claim {
            part: "PID",
            says: "door sill, met at up to 30 degrees at 2 to 5 in/s, same supply and load: climbed, and the robot never \
                   stands for half a second",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "PID",
            says: "the same: longest stop",
            figure: Figure::Mean {
                unit: "s",
                digits: 2,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

const fn plan(x_in: f64, y_in: f64) -> Pose {
    Pose {
        x_in,
        y_in,
        theta_deg: 0.0,
    }
}

/// A robot that prowls straight ahead in the empty hall.
fn bench(trial: &Trial, supply_v: f64, load_share: f64) -> Setup<'_> {
    driven(trial, arena("hall").world.clone(), supply_v, load_share)
}

/// A robot that prowls straight ahead in a world.
fn driven(trial: &Trial, world: World, supply_v: f64, load_share: f64) -> Setup<'_> {
    // A laboratory supply needs no protection from discharge.
    let mut setup = Setup::new(trial, world)
        .only(&[])
        .with(Parameter::CriticalBattery, 0);
    setup.config.conditions.supply_v = Some(supply_v);
    setup.config.conditions.load_share = load_share;
    setup
}

fn inside(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    // First the corners of the rated ranges, then anywhere in them.
    let corner = |limits: (f64, f64), high: bool| if high { limits.1 } else { limits.0 };
    let (supply_v, load_share) = if trial.index < 12 {
        (
            corner(SUPPLY_V, trial.index & 1 > 0),
            corner(LOAD_SHARE, trial.index & 2 > 0),
        )
    } else {
        (
            rng.between(SUPPLY_V.0, SUPPLY_V.1),
            rng.between(LOAD_SHARE.0, LOAD_SHARE.1),
        )
    };
    let speed_in_s = [12, 6, 2].get(trial.index / 4).copied();
    let speed_in_s = speed_in_s.unwrap_or_else(|| 2 + rng.below(11) as i16);
    let mut run = bench(trial, supply_v, load_share)
        .with(Parameter::TopSpeed, speed_in_s)
        .start();
    let (off, is_saturated) = off_percent(&mut run);
    vec![success(off <= 2.0), value(off), success(!is_saturated)]
}

/// Deviation of the mean speed from the commanded one in percent, and whether the wheels were saturated.
fn off_percent(run: &mut Run) -> (f64, bool) {
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
    (100.0 * (speed - ordered).abs() / ordered, is_saturated)
}

fn incline(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    // Up and down first, at both ends of the rated ranges.
    let theta_deg = if trial.index < 16 {
        180.0 * f64::from(u8::from(trial.index & 2 > 0))
    } else {
        rng.between(0.0, 360.0)
    };
    let start = Pose {
        theta_deg,
        ..INCLINES[trial.index % 2]
    };
    let (supply_v, load_share) = match trial.index / 4 {
        0 => (SUPPLY_V.0, LOAD_SHARE.1),
        1 => (SUPPLY_V.1, LOAD_SHARE.0),
        _ => (
            rng.between(SUPPLY_V.0, SUPPLY_V.1),
            rng.between(LOAD_SHARE.0, LOAD_SHARE.1),
        ),
    };
    let speed_in_s = 2 + rng.below(6) as i16;
    let world = arena("floors").started_at(start);
    let mut run = driven(trial, world, supply_v, load_share)
        .with(Parameter::TopSpeed, speed_in_s)
        .start();
    let (off, _) = off_percent(&mut run);
    vec![success(off <= 2.0), value(off)]
}

fn sill(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let start = Pose {
        theta_deg: rng.between(-30.0, 30.0),
        ..plan(SILL_X_IN, SILL_Y_IN - 36.0)
    };
    let (supply_v, load_share) = (
        rng.between(SUPPLY_V.0, SUPPLY_V.1),
        rng.between(LOAD_SHARE.0, LOAD_SHARE.1),
    );
    let speed_in_s = 2 + rng.below(4) as i16;
    let world = arena("floors").started_at(start);
    let mut run = driven(trial, world, supply_v, load_share)
        .with(Parameter::TopSpeed, speed_in_s)
        .start();
    run.seconds(1.0);
    let (mut standing_ticks, mut longest_ticks) = (0, 0);
    let climbed = run.until(60.0, |simulation| {
        let truth = simulation.truth();
        let is_standing = truth.speed_in_s.abs() < STANDING_IN_S;
        standing_ticks = if is_standing { standing_ticks + 1 } else { 0 };
        longest_ticks = longest_ticks.max(standing_ticks);
        on_plan(start, truth.pose).y_in > SILL_Y_IN + SILL_DEPTH_IN / 2.0 + CLIMBED_IN
    });
    vec![
        success(climbed.is_some() && longest_ticks < STOPPED_TICKS),
        value(f64::from(longest_ticks) / 20.0),
    ]
}

fn outside(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let (supply_v, load_share) = (rng.between(8.0, 9.5), rng.between(0.35, 0.5));
    let mut run = bench(trial, supply_v, load_share).start();
    let flagged = run.until(5.0, |simulation| simulation.robot().is_saturated());
    vec![success(flagged.is_some())]
}
