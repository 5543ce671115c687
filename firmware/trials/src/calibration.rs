//! Calibration of a robot by the square.

use crate::arena::arena;
use crate::claim::Trial;
use crate::run::{Setup, believed};
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::parameters::{Parameter, Parameters};

/// Side of the square, inches: ten turns of the wheel.
const SIDE_IN: i16 = 157;

/// True position minus estimated position: ahead and to the left of the start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Miss {
    ahead_in: f64,
    left_in: f64,
}

impl Miss {
    pub(crate) fn percent(self) -> f64 {
        100.0 * self.ahead_in.hypot(self.left_in) / (4.0 * f64::from(SIDE_IN))
    }
}

impl Setup<'_> {
    /// Uses the wheels and track from a calibration.
    pub(crate) fn calibrated(mut self) -> Self {
        self.config.parameters = calibrated(self.trial);
        self
    }
}

/// Parameters of a robot calibrated by the square in both directions in the hall.
fn calibrated(trial: &Trial) -> Parameters {
    let untraced = trial.untraced();
    both_directions(&untraced, &Parameters::DEFAULT)
        .map_or(Parameters::DEFAULT, |[right, left]| corrected(right, left))
}

pub(crate) fn both_directions(trial: &Trial, parameters: &Parameters) -> Option<[Miss; 2]> {
    Some([drive(trial, parameters, 1)?, drive(trial, parameters, -1)?])
}

/// Drives the square to the right (1) or to the left (-1).
fn drive(trial: &Trial, parameters: &Parameters, direction: i16) -> Option<Miss> {
    let mut setup = Setup::new(trial, arena("hall").world.clone());
    setup.config.parameters = parameters.clone();
    let mut run = setup
        .with(Parameter::Square, direction * SIDE_IN)
        .mode(Mode::Calibrate)
        .start();
    run.until(300.0, |simulation| simulation.robot().mode() == Mode::Stop)?;
    run.seconds(1.0);
    let (really, believed) = (run.pose(), believed(&run.simulation));
    Some(Miss {
        ahead_in: really.y_in - believed.y_in,
        left_in: believed.x_in - really.x_in,
    })
}

/// Track and wheels that explain both errors: `UMBmark` by Borenstein and Feng (1996), averaged over both axes.
pub(crate) fn corrected(right: Miss, left: Miss) -> Parameters {
    let side = f64::from(SIDE_IN);
    let quarter = -4.0 * side;
    // Error of every turn and bend of every side, in radians.
    let turns = f64::midpoint(
        (right.ahead_in + left.ahead_in) / quarter,
        (right.left_in - left.left_in) / quarter,
    );
    let bend = f64::midpoint(
        (right.ahead_in - left.ahead_in) / quarter,
        (right.left_in + left.left_in) / quarter,
    );
    let value = |parameter: Parameter| f64::from(parameter.definition().default);
    let quarter_turn = std::f64::consts::FRAC_PI_2;
    let track = value(Parameter::Track) * quarter_turn / (quarter_turn - turns);
    // Right wheel over left: the radius of the bend against half the track.
    let share = 10.0 / side * (bend / 2.0).sin();
    let ratio = (1.0 + share) / (1.0 - share);
    let mut parameters = Parameters::DEFAULT;
    for (parameter, wanted) in [
        (Parameter::Track, track),
        (
            Parameter::WheelLeft,
            value(Parameter::WheelLeft) * 2.0 / (ratio + 1.0),
        ),
        (
            Parameter::WheelRight,
            value(Parameter::WheelRight) * 2.0 * ratio / (ratio + 1.0),
        ),
    ] {
        let definition = parameter.definition();
        let limited = (wanted.round() as i16).clamp(definition.least, definition.most);
        parameters.set(parameter, limited);
    }
    parameters
}
