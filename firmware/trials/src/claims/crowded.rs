//! Crowded houses: furniture stands close together and before doorways, and a stairwell is open. Judged by truth.

use super::home::pose_from;
use super::whole::Covered;
use crate::arena::{Arena, seen_from};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::{Setup, distance_in};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::{Layer, LayerMask, Mode};
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Pose, World};

pub(super) const ALL: &[&Experiment] = &[&SURVIVAL, &EVERY_LAYER, &ROUTE, &HOME, &DOCK, &DAY];

/// A claim that is only reported.
const fn reported(part: &'static str, says: &'static str, figure: Figure) -> Claim {
    Claim {
        part,
        says,
        figure,
        required: Required::Nothing,
        shortfall: None,
    }
}

/// A share of successes that must not fall below what the robot had reached when the limit was set, rounded down to 5 %.
const fn kept(part: &'static str, says: &'static str, least_percent: f64) -> Claim {
    Claim {
        required: Required::AtLeast(least_percent),
        ..reported(part, says, Figure::Share)
    }
}

const FEET: Figure = Figure::Median {
    unit: "sq ft",
    digits: 0,
};

const SURVIVAL: Experiment = Experiment {
    name: "crowded",
    trials: [1, 20],
    run: |trial| {
        survival(
            trial,
            LayerMask::ALL.without(Layer::Photo).without(Layer::Motion),
        )
    },
    claims: &[
        kept(
            "whole robot",
            "8 h on a bench supply, each trial in another crowded house with an open stairwell: never stuck",
            80.0,
        ),
        Claim {
            part: "whole robot",
            says: "the same: falls per hour",
            figure: Figure::PerHour,
            required: Required::AtMost(0.0),
            shortfall: None,
        },
        reported("whole robot", "the same: floor covered, median", FEET),
        reported(
            "whole robot",
            "the same: floor covered, worst",
            Figure::Least {
                unit: "sq ft",
                digits: 0,
            },
        ),
    ],
};

const EVERY_LAYER: Experiment = Experiment {
    name: "every-layer",
    trials: [1, 20],
    run: |trial| survival(trial, LayerMask::ALL),
    claims: &[
        kept(
            "whole robot",
            "the same with every layer allowed, where bumps make the robot hide: never stuck",
            85.0,
        ),
        Claim {
            part: "whole robot",
            says: "every layer: falls per hour",
            figure: Figure::PerHour,
            required: Required::AtMost(0.0),
            shortfall: None,
        },
        reported("whole robot", "every layer: floor covered, median", FEET),
        reported(
            "whole robot",
            "every layer: floor covered, worst",
            Figure::Least {
                unit: "sq ft",
                digits: 0,
            },
        ),
    ],
};

const ROUTE: Experiment = Experiment {
    name: "crowded-route",
    trials: [8, 100],
    run: route,
    claims: &[
        kept(
            "7 Dead reckoning",
            "3 points within 10 ft of the start in a crowded house, calibrated by the square: the robot believes within 10 min that \
             it has reached the last one",
            70.0,
        ),
        kept(
            "7 Dead reckoning",
            "the same, judged by truth: and is within 12 in of it",
            55.0,
        ),
    ],
};

const HOME: Experiment = Experiment {
    name: "crowded-home",
    trials: [8, 100],
    run: home,
    claims: &[
        kept(
            "7 Dead reckoning",
            "3 min of wandering in a crowded house, calibrated by the square, and home: believed at home within 15 min more",
            70.0,
        ),
        kept(
            "7 Dead reckoning",
            "the same, judged by truth: and within 24 in of it",
            45.0,
        ),
    ],
};

const DOCK: Experiment = Experiment {
    name: "crowded-dock",
    trials: [8, 100],
    run: dock,
    claims: &[kept(
        "foraging",
        "10 min of wandering from the dock of a crowded house, calibrated by the square, then foraging: truly charging within \
         15 min",
        70.0,
    )],
};

const DAY: Experiment = Experiment {
    name: "generated-day",
    trials: [0, 12],
    run: day,
    claims: &[
        kept(
            "foraging",
            "24 h from the dock of a generated house, each trial in another one, whole robot with foraging, calibrated by the square: \
             the battery is never empty",
            55.0,
        ),
        reported(
            "foraging",
            "the same: hours to the first empty battery",
            Figure::HoursTo,
        ),
    ],
};

fn house(trial: &Trial) -> Arena {
    Arena::new(World::crowded(trial.seed.value()))
}

fn survival(trial: &Trial, allowed: LayerMask) -> Vec<Option<Reading>> {
    const HOURS: f64 = 8.0;
    let mut setup = Setup::new(trial, World::crowded(trial.seed.value()));
    setup.config.conditions.supply_v = Some(12.4);
    let mut run = setup.start();
    run.must(Order::Layers {
        which: LayerMask::ALL,
        allowed,
    });
    let mut covered = Covered::default();
    let ended_s = run.until(HOURS * 3600.0, |simulation| {
        covered.visit(simulation.truth().pose);
        simulation.is_stuck() || simulation.truth().has_fallen
    });
    let has_fallen = run.simulation.truth().has_fallen;
    vec![
        success(ended_s.is_none() || has_fallen),
        Some(Reading::Events {
            count: u32::from(has_fallen),
            hours: ended_s.map_or(HOURS, |seconds| seconds / 3600.0),
        }),
        Some(covered.reading()),
        Some(covered.reading()),
    ]
}

fn route(trial: &Trial) -> Vec<Option<Reading>> {
    let house = house(trial);
    let mut rng = trial.rng();
    let start = house.somewhere(&mut rng);
    let mut point = || loop {
        let place = house.somewhere(&mut rng);
        if distance_in(place, start) < 120.0 {
            break seen_from(start, place);
        }
    };
    let places = [point(), point(), point()];
    let points = places.map(|place| Waypoint {
        x_in: place.x_in.round() as i16,
        y_in: place.y_in.round() as i16,
    });
    let mut run = Setup::new(trial, house.started_at(start))
        .calibrated()
        .start();
    run.route(&points);
    let ended = run.until(600.0, |simulation| simulation.robot().mode() == Mode::Stop);
    let arrived = ended.is_some() && usize::from(run.simulation.robot().driven()) == points.len();
    let is_near = distance_in(run.pose(), places[2]) <= 12.0;
    vec![success(arrived), success(arrived && is_near)]
}

fn home(trial: &Trial) -> Vec<Option<Reading>> {
    let house = house(trial);
    let start = house.somewhere(&mut trial.rng());
    let mut run = Setup::new(trial, house.started_at(start))
        .calibrated()
        .mode(Mode::Wander)
        .start();
    let ended = run.until(18.0 * 60.0, |simulation| {
        simulation.robot().mode() == Mode::Stop
    });
    let is_near = distance_in(run.pose(), Pose::default()) <= 24.0;
    vec![
        success(ended.is_some()),
        success(ended.is_some() && is_near),
    ]
}

fn dock(trial: &Trial) -> Vec<Option<Reading>> {
    const WANDER_S: f64 = 600.0;
    let Some((place, world)) = from_dock(&World::crowded(trial.seed.value())) else {
        return vec![None];
    };
    let start = world.start();
    let mut run = Setup::new(trial, world)
        .calibrated()
        .with(Parameter::Wander, Parameter::Wander.definition().most)
        .mode(Mode::Wander)
        .start();
    run.must(pose_from(place, start));
    run.seconds(WANDER_S);
    run.must(Order::Mode(Mode::Forage));
    let docked = run.until(900.0, |simulation| simulation.truth().is_docked);
    vec![success(docked.is_some())]
}

/// The place before a world's dock, and the world with a robot there that faces away from it.
fn from_dock(world: &World) -> Option<(Pose, World)> {
    // The robot backs off the dock and turns before it leaves.
    let place = world.before_dock(7.0)?;
    let start = Pose {
        theta_deg: place.theta_deg + 180.0,
        ..place
    };
    Some((place, world.started_at(start)?))
}

/// A day in a generated house, whose furniture leaves room.
fn day(trial: &Trial) -> Vec<Option<Reading>> {
    const HOURS: f64 = 24.0;
    let name = format!("generated:{}", trial.seed.value());
    let world = World::open(&name).unwrap_or_else(|error| panic!("{error}"));
    let Some((place, world)) = from_dock(&world) else {
        return vec![None, None];
    };
    let start = world.start();
    let mut run = Setup::new(trial, world)
        .calibrated()
        .with(Parameter::Forage, 1)
        .start();
    run.must(pose_from(place, start));
    let flat_s = run.until(HOURS * 3600.0, |simulation| {
        simulation.truth().charge <= 0.01
    });
    vec![
        success(flat_s.is_none()),
        Some(Reading::Events {
            count: u32::from(flat_s.is_some()),
            hours: flat_s.map_or(HOURS, |seconds| seconds / 3600.0),
        }),
    ]
}
