//! Layer 1: the reflex, its escapes, and the office chair.

use crate::arena::{arena, seen_from};
use crate::claim::{
    Claim, Experiment, Figure, Reading, Required, Shortfall, Trial, loss, success, value,
};
use crate::run::{Setup, distance_in};
use groundwave_protocol::status_codes::Layer;
use sr04_firmware::parameters::Parameter;
use sr04_sim::Pose;

pub(super) const ALL: &[&Experiment] = &[&CONTACTS, &CHAIR];

/// Worlds in which contacts are made.
const WORLDS: [&str; 4] = ["living-room", "house", "corners", "chair"];

/// Distance from the contact, with no switch closed, at which the robot is free, inches: about two robots.
const FREE_IN: f64 = 24.0;
const FREE_WITHIN_S: f64 = 60.0;

/// Time for which bumps must repeat before the bumper layer escapes, seconds.
const CAUGHT_S: f64 = 20.0;

/// Position of the chair in its world.
const CHAIR_AT: Pose = Pose {
    x_in: 99.0,
    y_in: 93.0,
    theta_deg: 0.0,
};

/// Time limit for leaving the chair, seconds.
const LEFT_WITHIN_S: f64 = 120.0;

/// Distance of the casters from the post, inches.
const CHAIR_REACH_IN: f64 = 13.0;

const CONTACTS: Experiment = Experiment {
    name: "contacts",
    trials: [80, 1000],
    run: contacts,
    claims: &[
        Claim {
            part: "1 Bumpers",
            says: "fixed contacts in four worlds, bumpers and prowl only, escapes off: within the 20 s after which an \
                   escape would begin, the robot is 24 in from the contact with no switch closed",
            figure: Figure::Share,
            required: Required::Between(92.0, 98.0),
            shortfall: None,
        },
        Claim {
            part: "1 Bumpers",
            says: "the same with escapes, within 60 s",
            figure: Figure::Share,
            required: Required::AtLeast(99.5),
            shortfall: None,
        },
        Claim {
            part: "1 Bumpers",
            says: "the same with escapes: duration",
            figure: Figure::Mean {
                unit: "s",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "contacts: cost of switching escapes off",
            figure: Figure::Mean {
                unit: "points",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: Some(Shortfall {
                reached: 0.0,
                why: "too few contacts: 300 contacts with tuning seeds show 2.0 points (0.4 to 3.6)",
            }),
        },
    ],
};

const CHAIR: Experiment = Experiment {
    name: "office-chair",
    trials: [24, 400],
    run: chair,
    claims: &[
        Claim {
            part: "1 Bumpers",
            says: "five-legged office chair, start within 26 in of the post and heading within 60 degrees of it, whole \
                   robot: 24 in clear of the casters within 2 min",
            figure: Figure::Share,
            required: Required::AtLeast(98.0),
            shortfall: None,
        },
        Claim {
            part: "ablation",
            says: "office chair, bumpers and prowl only: additional time with escapes off",
            figure: Figure::Mean {
                unit: "s",
                digits: 1,
            },
            required: Required::MoreThan(0.0),
            shortfall: None,
        },
    ],
};

fn contacts(trial: &Trial) -> Vec<Option<Reading>> {
    let [without_s, with_s] = [0, 1].map(|escapes| contact(trial, escapes));
    let freed = |taken_s: Option<f64>| taken_s.map(|taken_s| taken_s <= FREE_WITHIN_S);
    let (without, with) = (freed(without_s), freed(with_s));
    vec![
        without_s.and_then(|taken_s| success(taken_s <= CAUGHT_S)),
        with.map(Reading::Success),
        with_s.and_then(value),
        with.zip(without)
            .and_then(|(with, without)| loss(with, without)),
    ]
}

/// Drives straight ahead until a contact; returns the seconds until the robot is free, a second more than allowed if it
/// is not.
fn contact(trial: &Trial, escapes: i16) -> Option<f64> {
    let mut run = Setup::anywhere(trial, WORLDS[trial.index % WORLDS.len()])
        .only(&[Layer::Bumpers])
        .with(Parameter::Escapes, escapes)
        .start();
    run.until(60.0, |simulation| simulation.inputs().bumper.any())?;
    let touched = run.pose();
    let freed = run.until(FREE_WITHIN_S, |simulation| {
        distance_in(simulation.truth().pose, touched) >= FREE_IN
            && !simulation.inputs().bumper.any()
    });
    Some(freed.unwrap_or(FREE_WITHIN_S + 1.0))
}

fn chair(trial: &Trial) -> Vec<Option<Reading>> {
    let left_s = leaves_chair(trial, 1, None);
    // The other sensors turn most robots away before the chair can catch them, so escapes are compared without them.
    let [with_s, without_s] = [1, 0].map(|escapes| {
        leaves_chair(trial, escapes, Some(&[Layer::Bumpers])).unwrap_or(LEFT_WITHIN_S)
    });
    vec![success(left_s.is_some()), value(without_s - with_s)]
}

/// Time until the robot has left the chair, with all or only these layers, seconds; `None` if it does not leave.
fn leaves_chair(trial: &Trial, escapes: i16, layers: Option<&[Layer]>) -> Option<f64> {
    let arena = arena("chair");
    let mut rng = trial.rng();
    let start = loop {
        let (from_deg, distance) = (rng.between(0.0, 360.0), rng.between(0.0, 26.0));
        let (sin, cos) = from_deg.to_radians().sin_cos();
        let start = Pose {
            x_in: CHAIR_AT.x_in - distance * sin,
            y_in: CHAIR_AT.y_in - distance * cos,
            theta_deg: from_deg + rng.between(-60.0, 60.0),
        };
        if arena.has_room(start) {
            break start;
        }
    };
    let chair = seen_from(start, CHAIR_AT);
    let setup = Setup::new(trial, arena.started_at(start)).with(Parameter::Escapes, escapes);
    let mut run = match layers {
        Some(layers) => setup.only(layers).start(),
        None => setup.start(),
    };
    run.until(LEFT_WITHIN_S, |simulation| {
        distance_in(simulation.truth().pose, chair) >= CHAIR_REACH_IN + FREE_IN
    })
}
