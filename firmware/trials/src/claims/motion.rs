//! Layer 6: the arm, detection of a walker, and the charge.

use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::{Setup, bearing_deg, is_held_by};
use groundwave_protocol::status_codes::{Layer, Mode};
use sr04_firmware::drive::Motion;
use sr04_sim::{Pose, Simulation};

pub(super) const ALL: &[&Experiment] = &[&WALKER, &FALSE_ALARMS];

/// Position of the robot in the world `walker`, six feet from the person's path.
const WAIT_AT: (f64, f64) = (183.0, 75.0);

/// Angle from straight ahead within which the direction of the charge does not matter, degrees.
const AHEAD_DEG: f64 = 15.0;

const WALKER: Experiment = Experiment {
    name: "walker",
    trials: [20, 300],
    run: walker,
    claims: &[
        Claim {
            part: "6 Motion",
            says: "a person passes 6 ft away, nearest within 45 degrees of the nose: the robot charges while the person \
                   passes",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: None,
        },
        Claim {
            part: "6 Motion",
            says: "the same, on a charge: toward the side of the person at the detection, or ahead (within 15 degrees of \
                   the nose: any direction)",
            figure: Figure::Share,
            required: Required::AtLeast(90.0),
            shortfall: None,
        },
        Claim {
            part: "6 Motion",
            says: "the same: the motors never run with the arm raised",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

/// Number of hours of one trial in an empty room.
const HOURS: f64 = 4.0;

const FALSE_ALARMS: Experiment = Experiment {
    name: "false-alarms",
    trials: [1, 12],
    run: false_alarms,
    claims: &[Claim {
        part: "6 Motion",
        says: "4 h in an empty room: charges per hour",
        figure: Figure::PerHour,
        required: Required::AtMost(1.0),
        shortfall: None,
    }],
};

/// Whether the robot charges, or turns to charge.
fn charges(simulation: &Simulation) -> bool {
    is_held_by(simulation, Layer::Motion) && simulation.robot().motion() != Motion::STILL
}

fn drives_with_arm_up(simulation: &Simulation) -> bool {
    let outputs = simulation.outputs();
    (outputs.pwm_left != 0 || outputs.pwm_right != 0) && simulation.truth().arm_raised > 0.1
}

fn walker(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let start = Pose {
        x_in: WAIT_AT.0,
        y_in: WAIT_AT.1,
        theta_deg: rng.between(-45.0, 45.0),
    };
    let mut run = Setup::new(trial, arena("walker").started_at(start))
        .only(&[Layer::Motion])
        .mode(Mode::Reactive)
        .start();
    let person_deg = |simulation: &Simulation| {
        let person = simulation.walkers().next();
        person.map_or(0.0, |(person, _)| {
            bearing_deg(simulation.truth().pose, person)
        })
    };
    // The person starts after 45 s and has passed, 26 ft farther, 8 s later.
    let mut is_safe = true;
    let (mut sure_deg, mut was_up) = (None, false);
    let fired = run.until(56.0, |simulation| {
        is_safe &= !drives_with_arm_up(simulation);
        let is_up = simulation.outputs().arm_up;
        if was_up && !is_up {
            sure_deg = Some(person_deg(simulation));
        }
        was_up = is_up;
        charges(simulation)
    });
    let side = fired.and(sure_deg).map(|bearing_deg| {
        let rotation_cps = run.simulation.robot().motion().rotation_cps;
        let direction = f64::from(rotation_cps.signum());
        bearing_deg.abs() <= AHEAD_DEG || direction * bearing_deg > 0.0
    });
    run.until(10.0, |simulation| {
        is_safe &= !drives_with_arm_up(simulation);
        false
    });
    vec![
        success(fired.is_some_and(|seconds| seconds > 45.0)),
        side.map(Reading::Success),
        success(is_safe),
    ]
}

fn false_alarms(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "hall")
        .only(&[Layer::Motion])
        .mode(Mode::Reactive)
        .start();
    let (mut count, mut was_charging) = (0, false);
    run.until(HOURS * 3600.0, |simulation| {
        let is_charging = charges(simulation);
        count += u32::from(is_charging && !was_charging);
        was_charging = is_charging;
        false
    });
    vec![Some(Reading::Events {
        count,
        hours: HOURS,
    })]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arena::seen_from;

    #[test]
    fn person_passes_six_feet_away() {
        let world = &arena("walker").world;
        let start = world.start();
        assert_eq!((start.x_in, start.y_in), WAIT_AT);
        let nearest = seen_from(
            start,
            Pose {
                x_in: 183.0,
                y_in: 147.0,
                theta_deg: 0.0,
            },
        );
        assert!((nearest.y_in - 72.0).abs() < 1e-9);
    }
}
