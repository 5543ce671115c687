//! The calibration square, before and after calibrating with it.

use crate::calibration::{Miss, both_directions, corrected};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use sr04_firmware::parameters::Parameters;

pub(super) const ALL: &[&Experiment] = &[&SQUARE];

const SQUARE: Experiment = Experiment {
    name: "odometry",
    trials: [8, 100],
    run: square,
    claims: &[
        Claim {
            part: "odometry",
            says: "square of 157 in, the worse of both directions, wheels up to 0.4 % and track up to 1 % off: true error \
                   before calibration, share of the path",
            figure: Figure::Mean {
                unit: "%",
                digits: 2,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "odometry",
            says: "the same after calibration: at most 1 % of the path",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "odometry",
            says: "the same after calibration: true error, share of the path",
            figure: Figure::Mean {
                unit: "%",
                digits: 2,
            },
            required: Required::AtMost(1.0),
            shortfall: None,
        },
        Claim {
            part: "odometry",
            says: "improvement (worse direction, mean error before over mean error after)",
            figure: Figure::MeanRatio {
                unit: "times",
                digits: 1,
            },
            required: Required::AtLeast(5.0),
            shortfall: None,
        },
    ],
};

fn square(trial: &Trial) -> Vec<Option<Reading>> {
    let no_readings = vec![None; 4];
    let Some([right, left]) = both_directions(trial, &Parameters::DEFAULT) else {
        return no_readings;
    };
    let Some(after) = both_directions(trial, &corrected(right, left)) else {
        return no_readings;
    };
    let worse = |misses: [Miss; 2]| misses.map(Miss::percent).into_iter().fold(0.0, f64::max);
    let (before, after) = (worse([right, left]), worse(after));
    vec![
        value(before),
        success(after <= 1.0),
        value(after),
        Some(Reading::Pair(before, after)),
    ]
}
