//! Layer 4: the doorway, and the misleading oblique wall.

use crate::arena::{arena, on_plan};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, loss, success};
use crate::run::Setup;
use groundwave_protocol::status_codes::Layer;
use sr04_sim::Pose;

pub(super) const ALL: &[&Experiment] = &[&DOORWAY, &OBLIQUE];

/// Middle of the doorway in its world, and the two faces of the wall, inches.
const DOOR_X_IN: f64 = 126.0;
const WALL_SOUTH_IN: f64 = 186.0;
const WALL_NORTH_IN: f64 = 192.0;

/// Inner face of the hall's east wall.
const EAST_IN: f64 = 474.0;

const DOORWAY: Experiment = Experiment {
    name: "sonar-doorway",
    trials: [30, 300],
    run: doorway,
    claims: &[Claim {
        part: "4 Sonar",
        says: "doorway 3 ft wide, 8 ft away, up to 10 degrees off its axis and 10 degrees off the nose, bumpers and \
               sonar only: through within 60 s",
        figure: Figure::Share,
        required: Required::AtLeast(80.0),
        shortfall: None,
    }],
};

const OBLIQUE: Experiment = Experiment {
    name: "sonar-oblique",
    trials: [30, 300],
    run: oblique,
    claims: &[
        Claim {
            part: "4 Sonar",
            says: "along a smooth wall 18 to 30 in away, turned 15 to 35 degrees to it, sonar alone: collision within \
                   20 s (claimed without a figure; the limit of 50 % is our own)",
            figure: Figure::Share,
            required: Required::AtLeast(50.0),
            shortfall: None,
        },
        Claim {
            part: "4 Sonar",
            says: "the same with IR: collision (the limit of 5 % is our own)",
            figure: Figure::Share,
            required: Required::AtMost(5.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "oblique wall: cost of switching IR off",
            figure: Figure::Mean {
                unit: "points",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: None,
        },
    ],
};

fn doorway(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let bearing_deg = rng.between(-10.0, 10.0);
    let (sin, cos) = bearing_deg.to_radians().sin_cos();
    let start = Pose {
        x_in: DOOR_X_IN - 96.0 * sin,
        y_in: WALL_SOUTH_IN - 96.0 * cos,
        theta_deg: bearing_deg + rng.between(-10.0, 10.0),
    };
    let mut run = Setup::new(trial, arena("doorway").started_at(start))
        .only(&[Layer::Bumpers, Layer::Sonar])
        .start();
    let through = run.until(60.0, |simulation| {
        on_plan(start, simulation.truth().pose).y_in > WALL_NORTH_IN + 6.0
    });
    vec![success(through.is_some())]
}

fn oblique(trial: &Trial) -> Vec<Option<Reading>> {
    let [alone, with_infrared] = [
        &[Layer::Sonar] as &[Layer],
        &[Layer::Infrared, Layer::Sonar],
    ]
    .map(|layers| runs_into_it(trial, layers));
    vec![
        success(alone),
        success(with_infrared),
        loss(!with_infrared, !alone),
    ]
}

fn runs_into_it(trial: &Trial, layers: &[Layer]) -> bool {
    let mut rng = trial.rng();
    let start = Pose {
        x_in: EAST_IN - rng.between(18.0, 30.0),
        y_in: rng.between(60.0, 240.0),
        theta_deg: rng.between(15.0, 35.0),
    };
    let mut run = Setup::new(trial, arena("hall").started_at(start))
        .only(layers)
        .start();
    let touched = run.until(20.0, |simulation| simulation.truth().is_touching);
    touched.is_some()
}
