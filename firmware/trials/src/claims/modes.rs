//! The modes without a goal: reactive, passive, and the layer that switches sensors.

use super::success;
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Setup, is_held_by};
use groundwave_protocol::letters::{Layer, LayerMask, Mode};
use sr04_firmware::drive::Motion;
use sr04_firmware::parameters::Parameter;
use sr04_sim::Simulation;

pub(super) const ALL: &[&Experiment] = &[&REST, &LAMP, &PASSIVE, &CHATTER];

/// Layers that pull or push.
const SENSORS: [Layer; 4] = [Layer::Bumpers, Layer::Infrared, Layer::Sonar, Layer::Photo];

/// Photocells that differ by less are equal to the robot.
const PHOTO_DEADZONE: i16 = Parameter::PhotoDeadzone.definition().default;

/// Quiet for this long is at rest.
const REST_TICKS: u32 = 200;

const REST: Experiment = Experiment {
    name: "reactive-rest",
    trials: [16, 200],
    run: rest,
    claims: &[Claim {
        part: "reactive",
        says: "from anywhere in the living room, bumpers, IR, sonar and photo: within 5 min it has rested for 10 s",
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
        says: "at rest in the dark room: the other lamp goes on, a photocell changes by more than two deadzones, \
               and it moves within 2 s",
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
        says: "from anywhere in the living room: it looks all around, stops, sings, and waits with its arm up \
               within 3 min",
        figure: Figure::Share,
        required: Required::AtLeast(95.0),
        shortfall: None,
    }],
};

const CHATTER: Experiment = Experiment {
    name: "behaviour",
    trials: [2, 16],
    run: chatter,
    claims: &[
        Claim {
            part: "behaviour",
            says: "30 min of prowling in the house: no sensor is switched again within 2 s",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "behaviour",
            says: "the same: switches an hour",
            figure: Figure::PerHour,
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// Whether nothing has pulled for a while; to be asked at every tick.
fn at_rest(quiet_ticks: &mut u32, simulation: &Simulation) -> bool {
    let is_quiet = simulation.robot().motion() == Motion::STILL;
    *quiet_ticks = if is_quiet { *quiet_ticks + 1 } else { 0 };
    *quiet_ticks >= REST_TICKS
}

fn rest(trial: &Trial) -> Vec<Option<Reading>> {
    let room = arena("living-room");
    let start = room.somewhere(&mut trial.dice());
    let mut run = Setup::new(trial, room.started_at(start))
        .only(&SENSORS)
        .mode(Mode::Reactive)
        .start();
    let mut quiet_ticks = 0;
    let rested = run.until(300.0, |simulation| at_rest(&mut quiet_ticks, simulation));
    vec![success(rested.is_some())]
}

fn lamp(trial: &Trial) -> Vec<Option<Reading>> {
    let room = arena("dark-room");
    let start = room.somewhere(&mut trial.dice());
    let mut run = Setup::new(trial, room.started_at(start))
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
    assert!(run.simulation.set_lamp("other lamp", true), "it is there");
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

fn passive(trial: &Trial) -> Vec<Option<Reading>> {
    let room = arena("living-room");
    let start = room.somewhere(&mut trial.dice());
    let mut run = Setup::new(trial, room.started_at(start))
        .mode(Mode::Passive)
        .start();
    let (mut turned_deg, mut before_deg) = (0.0_f64, 0.0);
    let (mut has_sung, mut up_ticks) = (false, 0);
    let done = run.until(180.0, |simulation| {
        let now_deg = simulation.truth().pose.theta_deg;
        if is_held_by(simulation, Layer::Rotation) {
            turned_deg += ((now_deg - before_deg + 540.0_f64).rem_euclid(360.0) - 180.0).abs();
        }
        before_deg = now_deg;
        has_sung |= simulation.outputs().note_hz > 0;
        up_ticks = if simulation.truth().arm_raised > 0.99 {
            up_ticks + 1
        } else {
            0
        };
        // Longer than the detectors need to settle.
        turned_deg > 350.0 && has_sung && up_ticks > 20 * 16
    });
    vec![success(done.is_some())]
}

fn chatter(trial: &Trial) -> Vec<Option<Reading>> {
    const MINUTES: f64 = 30.0;
    let house = arena("house");
    let start = house.somewhere(&mut trial.dice());
    let mut run = Setup::new(trial, house.started_at(start))
        .only(&[
            Layer::Bumpers,
            Layer::Rotation,
            Layer::Infrared,
            Layer::Sonar,
            Layer::Photo,
            Layer::DeadReckoning,
        ])
        .start();
    let mut before = LayerMask::ALL;
    let mut since_ticks = [u32::MAX; 8];
    let (mut calm, mut count) = (true, 0);
    run.until(MINUTES * 60.0, |simulation| {
        let now = simulation.robot().running();
        for (layer, since) in Layer::ALL.into_iter().zip(&mut since_ticks) {
            *since = since.saturating_add(1);
            if now.contains(layer) != before.contains(layer) {
                calm &= *since >= 40;
                count += u32::from(*since != u32::MAX);
                *since = 0;
            }
        }
        before = now;
        false
    });
    vec![
        success(calm),
        Some(Reading::Events {
            count,
            hours: MINUTES / 60.0,
        }),
    ]
}
