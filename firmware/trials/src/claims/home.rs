//! Going home, and docking.

use crate::arena::{arena, seen_from};
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Setup, distance_in};
use groundwave_protocol::Waypoint;
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::Mode;
use sr04_firmware::parameters::Parameter;
use sr04_sim::Pose;

pub(super) const ALL: &[&Experiment] = &[&WANDER, &DETOUR, &DOCK, &FORAGE];

const WANDER: Experiment = Experiment {
    name: "wander-home",
    trials: [8, 100],
    run: wander,
    claims: &[
        Claim {
            part: "7 Dead reckoning",
            says: "3 min of wandering in the house, calibrated by the square, the alarm, and home: believed at home \
                   within 15 min more",
            figure: Figure::Share,
            required: Required::AtLeast(60.0),
            shortfall: None,
        },
        Claim {
            part: "7 Dead reckoning",
            says: "the same, judged by truth: believed at home and truly within 24 in of it",
            figure: Figure::Share,
            required: Required::AtLeast(55.0),
            shortfall: None,
        },
        Claim {
            part: "7 Dead reckoning",
            says: "the same, when believed at home: true distance from home",
            figure: Figure::Mean {
                unit: "in",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

const DETOUR: Experiment = Experiment {
    name: "home-detour",
    trials: [8, 100],
    run: detour,
    claims: &[
        Claim {
            part: "7 Dead reckoning",
            says: "home is 8 to 14 ft away behind a wall with an open doorway 15 to 20 ft aside, without help, calibrated \
                   by the square: home within 15 min",
            figure: Figure::Share,
            required: Required::AtLeast(60.0),
            shortfall: None,
        },
        Claim {
            part: "7 Dead reckoning",
            says: "the same with uncalibrated wheels and track",
            figure: Figure::Share,
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// Position of the dock in the flat; it faces south.
pub(super) const DOCK_AT: Pose = Pose {
    x_in: 183.0,
    y_in: 129.0,
    theta_deg: 0.0,
};

const DOCK: Experiment = Experiment {
    name: "dock",
    trials: [20, 300],
    run: dock,
    claims: &[Claim {
        part: "foraging",
        says: "foraging from 9 to 10.5 ft away, anywhere in the hall before the dock: charging within 5 min",
        figure: Figure::Share,
        required: Required::AtLeast(95.0),
        shortfall: None,
    }],
};

const DAY_H: f64 = 24.0;

const FORAGE: Experiment = Experiment {
    name: "forage-day",
    trials: [0, 4],
    run: forage,
    claims: &[
        Claim {
            part: "foraging",
            says: "24 h in the flat, whole robot with foraging: the battery is never empty",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same: hours to the first empty battery",
            figure: Figure::HoursTo,
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

fn wander(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "house")
        .calibrated()
        .mode(Mode::Wander)
        .start();
    let home = run.until((3.0 + 15.0) * 60.0, |simulation| {
        simulation.robot().mode() == Mode::Stop
    });
    let off_in = home.map(|_| distance_in(run.pose(), Pose::default()));
    vec![
        success(home.is_some()),
        success(off_in.is_some_and(|off_in| off_in <= 24.0)),
        off_in.and_then(value),
    ]
}

/// The command that sets the pose of a robot at `start` relative to `origin`, with +Y north.
pub(super) fn pose_from(origin: Pose, start: Pose) -> Order {
    Order::Pose {
        position: Waypoint {
            x_in: (start.x_in - origin.x_in).round() as i16,
            y_in: (start.y_in - origin.y_in).round() as i16,
        },
        theta_deg: start.theta_deg.rem_euclid(360.0).round() as u16 % 360,
    }
}

fn detour(trial: &Trial) -> Vec<Option<Reading>> {
    vec![
        success(comes_home(trial, true)),
        success(comes_home(&trial.untraced(), false)),
    ]
}

fn comes_home(trial: &Trial, is_calibrated: bool) -> bool {
    let mut rng = trial.rng();
    // The wall is at y = 126 to 132, its doorway at x = 276 to 312.
    let x_in = rng.between(60.0, 110.0);
    let start = Pose {
        x_in,
        y_in: 132.0 + rng.between(36.0, 72.0),
        theta_deg: rng.between(0.0, 360.0),
    };
    let home = Pose {
        x_in: x_in + rng.between(-12.0, 12.0),
        y_in: 126.0 - rng.between(54.0, 90.0),
        theta_deg: 0.0,
    };
    let mut setup = Setup::new(trial, arena("two-doors").started_at(start));
    if is_calibrated {
        setup = setup.calibrated();
    }
    let mut run = setup.mode(Mode::Stop).start();
    run.must(pose_from(home, start));
    run.must(Order::Mode(Mode::GoHome));
    let home = seen_from(start, home);
    let arrived = run.until(900.0, |simulation| simulation.robot().mode() == Mode::Stop);
    arrived.is_some() && distance_in(run.pose(), home) < 36.0
}

fn dock(trial: &Trial) -> Vec<Option<Reading>> {
    let flat = arena("flat");
    let mut rng = trial.rng();
    let start = loop {
        let place = flat.somewhere(&mut rng);
        let away_in = distance_in(place, DOCK_AT);
        if (108.0..126.0).contains(&away_in) && place.y_in < DOCK_AT.y_in - 12.0 {
            break place;
        }
    };
    let mut run = Setup::new(trial, flat.started_at(start))
        .mode(Mode::Stop)
        .start();
    run.must(pose_from(DOCK_AT, start));
    run.must(Order::Mode(Mode::Forage));
    let docked = run.until(300.0, |simulation| simulation.truth().is_docked);
    vec![success(docked.is_some())]
}

fn forage(trial: &Trial) -> Vec<Option<Reading>> {
    let flat = arena("flat");
    let start = flat.somewhere(&mut trial.rng());
    let mut run = Setup::new(trial, flat.started_at(start))
        .with(Parameter::Forage, 1)
        .start();
    run.must(pose_from(DOCK_AT, start));
    let flat_s = run.until(DAY_H * 3600.0, |simulation| {
        simulation.truth().charge <= 0.01
    });
    vec![
        success(flat_s.is_none()),
        Some(Reading::Events {
            count: u32::from(flat_s.is_some()),
            hours: flat_s.map_or(DAY_H, |seconds| seconds / 3600.0),
        }),
    ]
}
