//! Prowl: the way to one target.

use super::success;
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::Setup;
use groundwave_protocol::Waypoint;
use groundwave_protocol::letters::{Layer, Mode};
use sr04_firmware::parameters::Parameter;

pub(super) const ALL: &[&Experiment] = &[&TARGET];

const OVERSHOOT_IN: f64 = 6.0;

/// A robot that aims well turns to the target, corrects, and corrects once more.
const CHANGES_MAX: u32 = 6;

/// Less rotation than this is no change of mind.
const STEADY_CPS: i16 = 8;

const TARGET: Experiment = Experiment {
    name: "prowl-target",
    trials: [20, 300],
    run: target,
    claims: &[
        Claim {
            part: "prowl",
            says: "a target 4 to 16 ft away on open floor, arrival within 2 in: never more than 6 in beyond it",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "prowl",
            says: "the same: no limit cycle (there in the time of the way at top speed and 15 s; the rotation \
                   changes its sign at most 6 times)",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

fn target(trial: &Trial) -> Vec<Option<Reading>> {
    let mut dice = trial.dice();
    let (distance_in, bearing_deg) = (dice.between(48.0, 190.0), dice.between(-180.0, 180.0));
    let (sin, cos) = bearing_deg.to_radians().sin_cos();
    let mut run = Setup::new(trial, arena("hall").world.clone())
        .only(&[Layer::DeadReckoning])
        .with(Parameter::Arrive, 2)
        .start();
    run.route(&[Waypoint {
        x_in: (distance_in * sin).round() as i16,
        y_in: (distance_in * cos).round() as i16,
    }]);
    let (mut beyond_in, mut changes, mut sign) = (0.0_f64, 0, 0);
    let mut watch = |pose: sr04_sim::Pose, rotation_cps: i16| {
        beyond_in = beyond_in.max(pose.x_in * sin + pose.y_in * cos - distance_in);
        if rotation_cps.abs() > STEADY_CPS {
            changes += u32::from(sign == -rotation_cps.signum());
            sign = rotation_cps.signum();
        }
    };
    let arrived = run.until(distance_in / 12.0 + 15.0, |simulation| {
        let robot = simulation.robot();
        watch(simulation.truth().pose, robot.motion().rotation_cps);
        robot.mode() == Mode::Stop
    });
    // It rolls out.
    run.until(2.0, |simulation| {
        watch(simulation.truth().pose, 0);
        false
    });
    vec![
        success(beyond_in <= OVERSHOOT_IN),
        success(arrived.is_some() && changes <= CHANGES_MAX),
    ]
}
