//! The square path.

use super::value;
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Setup, believed, distance_in};
use groundwave_protocol::Waypoint;
use groundwave_protocol::letters::{Layer, Mode};
use sr04_firmware::parameters::Parameters;

pub(super) const ALL: &[&Experiment] = &[&BEFORE];

/// A side of ten turns of the wheel.
const SIDE_IN: i16 = 157;
const PATH_IN: f64 = 4.0 * SIDE_IN as f64;

const BEFORE: Experiment = Experiment {
    name: "odometry",
    trials: [6, 40],
    run: before,
    claims: &[Claim {
        part: "odometry",
        says: "a square of 157 in, the worse of both ways round, wheels off by up to 0.4 %, track by 1 %: \
               true error before calibration, share of the path",
        figure: Figure::Mean {
            unit: "%",
            digits: 2,
        },
        required: Required::Nothing,
        shortfall: None,
    }],
};

fn before(trial: &Trial) -> Vec<Option<Reading>> {
    let errors = [1, -1].map(|way| error_in(trial, &Parameters::DEFAULT, way));
    let [Some(right), Some(left)] = errors else {
        return vec![None];
    };
    vec![value(100.0 * right.max(left) / PATH_IN)]
}

/// Drives the square to the right (1) or to the left (-1); how far the robot then is from where it
/// believes to be.
fn error_in(trial: &Trial, parameters: &Parameters, way: i16) -> Option<f64> {
    let mut setup = Setup::new(trial, arena("hall").world.clone()).only(&[Layer::DeadReckoning]);
    setup.config.parameters = parameters.clone();
    let mut run = setup.start();
    let corner = |x_in: i16, y_in| Waypoint {
        x_in: way * x_in,
        y_in,
    };
    run.route(&[
        corner(0, SIDE_IN),
        corner(SIDE_IN, SIDE_IN),
        corner(SIDE_IN, 0),
        corner(0, 0),
    ]);
    run.until(180.0, |simulation| simulation.robot().mode() == Mode::Stop)?;
    run.seconds(1.0);
    Some(distance_in(run.pose(), believed(&run.simulation)))
}
