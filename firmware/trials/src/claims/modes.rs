//! Modes Reactive and Passive.

use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Run, Setup, bearing_deg, is_held_by, turn_deg};
use groundwave_protocol::status_codes::{Layer, Mode};
use sr04_firmware::drive::Motion;
use sr04_firmware::parameters::Parameter;
use sr04_sim::{Pose, Simulation};

pub(super) const ALL: &[&Experiment] = &[&REST, &LAMP, &STEP_IN, &PASSIVE, &STARTED];

/// Layers that move the robot because of sensors.
const SENSORS: [Layer; 4] = [Layer::Bumpers, Layer::Infrared, Layer::Sonar, Layer::Photo];

/// Difference of the photocells below which the robot counts them as equal.
const PHOTO_DEADZONE: i16 = Parameter::PhotoDeadzone.definition().default;

/// Number of ticks without motion that count as rest.
const REST_TICKS: u32 = 200;

const REST: Experiment = Experiment {
    name: "reactive-rest",
    trials: [16, 200],
    run: rest,
    claims: &[Claim {
        part: "reactive",
        says: "from anywhere in the living room, bumpers, IR, sonar and photo: rest for 10 s within 5 min",
        figure: Figure::Share,
        required: Required::AtLeast(90.0),
        shortfall: None,
    }],
};

const LAMP: Experiment = Experiment {
    name: "reactive-lamp",
    trials: [16, 200],
    run: lamp,
    claims: &[Claim {
        part: "reactive",
        says: "at rest in the dark room: the other lamp goes on, a photocell changes by more than two deadzones, and \
               the robot moves within 2 s",
        figure: Figure::Share,
        required: Required::AtLeast(99.0),
        shortfall: None,
    }],
};

/// Time at which the person in the world `step-in` starts walking, seconds; by then the robot has come to rest.
const SETS_OUT_S: f64 = 60.0;

/// Distance and angle from the nose within which the person stands before the robot, with a gap of a foot and a half, inches.
const BEFORE_IN: f64 = 30.0;
const BEFORE_DEG: f64 = 45.0;

const STEP_IN: Experiment = Experiment {
    name: "reactive-step-in",
    trials: [24, 300],
    run: step_in,
    claims: &[Claim {
        part: "reactive",
        says: "at rest, bumpers, IR and sonar: a person steps before the robot, within 45 degrees of the nose and 30 in \
               from its middle, and the robot moves within 2 s",
        figure: Figure::Share,
        required: Required::AtLeast(99.0),
        shortfall: None,
    }],
};

const PASSIVE: Experiment = Experiment {
    name: "passive",
    trials: [16, 200],
    run: passive,
    claims: &[Claim {
        part: "passive",
        says: "from anywhere in the living room: the robot scans, stops, sings, and waits with its arm raised within \
               3 min",
        figure: Figure::Share,
        required: Required::AtLeast(95.0),
        shortfall: None,
    }],
};

/// Time in which bumps may start the mode, seconds.
const PROWL_S: f64 = 1800.0;

const STARTED: Experiment = Experiment {
    name: "passive-started",
    trials: [8, 100],
    run: started,
    claims: &[
        Claim {
            part: "passive",
            says: "prowling in the living room, every layer allowed but photo: bumps start the mode within 30 min",
            figure: Figure::Share,
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "passive",
            says: "the same: time until then",
            figure: Figure::Mean {
                unit: "min",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "passive",
            says: "the same: the robot then scans, stops, sings, and waits with its arm raised within 3 min",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: None,
        },
    ],
};

/// Whether the robot has rested long enough; call it at every tick.
fn at_rest(quiet_ticks: &mut u32, simulation: &Simulation) -> bool {
    let is_quiet = simulation.robot().motion() == Motion::STILL;
    *quiet_ticks = if is_quiet { *quiet_ticks + 1 } else { 0 };
    *quiet_ticks >= REST_TICKS
}

fn rest(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "living-room")
        .only(&SENSORS)
        .mode(Mode::Reactive)
        .start();
    let mut quiet_ticks = 0;
    let rested = run.until(300.0, |simulation| at_rest(&mut quiet_ticks, simulation));
    vec![success(rested.is_some())]
}

fn lamp(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "dark-room")
        .only(&SENSORS)
        .mode(Mode::Reactive)
        .start();
    let mut quiet_ticks = 0;
    let rested = run.until(300.0, |simulation| at_rest(&mut quiet_ticks, simulation));
    if rested.is_none() {
        return vec![None];
    }
    let cells = |simulation: &Simulation| {
        let inputs = simulation.inputs();
        [inputs.photo_left, inputs.photo_right].map(|cell| i16::from(cell.unwrap_or(0)))
    };
    let before = cells(&run.simulation);
    assert!(
        run.simulation.set_lamp("other lamp", true),
        "the lamp exists"
    );
    let mut is_felt = false;
    let moved = run.until(2.0, |simulation| {
        let changes = before.iter().zip(cells(simulation));
        is_felt |= changes
            .into_iter()
            .any(|(before, now)| (before - now).abs() > 2 * PHOTO_DEADZONE);
        simulation.robot().motion() != Motion::STILL
    });
    vec![is_felt.then_some(Reading::Success(moved.is_some()))]
}

fn step_in(trial: &Trial) -> Vec<Option<Reading>> {
    let room = arena("step-in");
    let mut rng = trial.rng();
    let center = room.world.start();
    let start = Pose {
        x_in: center.x_in + rng.between(-5.0, 5.0),
        y_in: center.y_in + rng.between(-5.0, 5.0),
        theta_deg: rng.between(-30.0, 30.0),
    };
    let mut run = Setup::new(trial, room.started_at(start))
        .only(&[Layer::Bumpers, Layer::Infrared, Layer::Sonar])
        .mode(Mode::Reactive)
        .start();
    let mut quiet_ticks = 0;
    run.until(SETS_OUT_S, |simulation| {
        at_rest(&mut quiet_ticks, simulation);
        false
    });
    if quiet_ticks < REST_TICKS {
        return vec![None];
    }
    let moves = |simulation: &Simulation| simulation.robot().motion() != Motion::STILL;
    // The robot may move before the person is that near; otherwise the person comes to stand there.
    let mut moved = false;
    let came = run.until(20.0, |simulation| {
        moved |= moves(simulation);
        moved || stands_before(simulation)
    });
    if !moved {
        moved = run.until(2.0, moves).is_some();
    }
    vec![came.and_then(|_| success(moved))]
}

fn stands_before(simulation: &Simulation) -> bool {
    let pose = simulation.truth().pose;
    simulation.walkers().any(|(person, _)| {
        let distance_in = (person.x_in - pose.x_in).hypot(person.y_in - pose.y_in);
        distance_in <= BEFORE_IN && bearing_deg(pose, person).abs() <= BEFORE_DEG
    })
}

fn passive(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "living-room")
        .mode(Mode::Passive)
        .start();
    vec![success(hides(&mut run))]
}

fn started(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "living-room")
        .only(&[
            Layer::Bumpers,
            Layer::Rotation,
            Layer::Infrared,
            Layer::Sonar,
            Layer::Motion,
            Layer::DeadReckoning,
        ])
        .start();
    let begun = run.until(PROWL_S, |simulation| {
        simulation.robot().mode() == Mode::Passive
    });
    let hidden = begun.map(|_| hides(&mut run));
    vec![
        success(begun.is_some()),
        begun.and_then(|seconds| value(seconds / 60.0)),
        hidden.map(Reading::Success),
    ]
}

/// Whether the robot completes mode Passive up to waiting within 3 min.
fn hides(run: &mut Run) -> bool {
    let (mut turned_deg, mut before_deg) = (0.0_f64, run.pose().theta_deg);
    let (mut has_sung, mut up_ticks) = (false, 0);
    let done = run.until(180.0, |simulation| {
        let now_deg = simulation.truth().pose.theta_deg;
        if is_held_by(simulation, Layer::Rotation) {
            turned_deg += (turn_deg(before_deg, now_deg)).abs();
        }
        before_deg = now_deg;
        has_sung |= simulation.outputs().note_hz > 0;
        up_ticks = if simulation.truth().arm_raised > 0.99 {
            up_ticks + 1
        } else {
            0
        };
        // Longer than the settling time of the detectors.
        turned_deg > 350.0 && has_sung && up_ticks > 20 * 16
    });
    done.is_some()
}
