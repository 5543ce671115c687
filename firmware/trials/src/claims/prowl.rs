//! Prowl: the approach to a target.

use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::Setup;
use groundwave_protocol::Waypoint;
use groundwave_protocol::status_codes::{Layer, Mode};
use sr04_firmware::parameters::Parameter;

pub(super) const ALL: &[&Experiment] = &[&TARGET];

/// Maximum overshoot beyond the target, inches.
const OVERSHOOT_IN: f64 = 6.0;

/// Maximum number of reversals of the rotation: turning to the target and a few corrections.
const CHANGES_MAX: u32 = 6;

/// Rotation below which a change of sign does not count.
const STEADY_CPS: i16 = 8;

const TARGET: Experiment = Experiment {
    name: "prowl-target",
    trials: [20, 300],
    run: target,
    claims: &[
        Claim {
            part: "prowl",
            says: "target 4 to 16 ft away on open floor, arrival within 2 in: never more than 6 in beyond the target",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "prowl",
            says: "the same: no limit cycle (arrival within the time of the distance at top speed plus 15 s, and at most \
                   6 changes of the sign of the rotation)",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

fn target(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let (distance_in, bearing_deg) = (rng.between(48.0, 190.0), rng.between(-180.0, 180.0));
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
    // The robot coasts to a stop.
    run.until(2.0, |simulation| {
        watch(simulation.truth().pose, 0);
        false
    });
    vec![
        success(beyond_in <= OVERSHOOT_IN),
        success(arrived.is_some() && changes <= CHANGES_MAX),
    ]
}
