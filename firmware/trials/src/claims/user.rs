//! Layer 0: manual driving.

use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Setup, is_held_by};
use groundwave_protocol::command::{Drive, Message};
use groundwave_protocol::status_codes::Layer;
use sr04_firmware::behaviours::DEAD_MAN_TICKS;
use sr04_firmware::drive::Motion;
use sr04_sim::ChannelSpec;

pub(super) const ALL: &[&Experiment] = &[&HAND, &LOSS];

const HAND: Experiment = Experiment {
    name: "user",
    trials: [20, 200],
    run: hand,
    claims: &[
        Claim {
            part: "0 User",
            says: "at any moment of prowling in the house: the tick after a drive frame, and every tick while frames \
                   arrive, executes its motion",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "0 User",
            says: "manual driving ends exactly 20 ticks after the last drive frame",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

const LOSS: Experiment = Experiment {
    name: "user-loss",
    trials: [20, 200],
    run: lost,
    claims: &[
        Claim {
            part: "0 User",
            says: "driven by radio with four frames a second; the radio fails in both directions while the station keeps \
                   sending: manual driving ends within 1 s",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "0 User",
            says: "the same: duration",
            figure: Figure::Mean {
                unit: "s",
                digits: 2,
            },
            required: Required::Nothing,
            shortfall: None,
        },
        Claim {
            part: "0 User",
            says: "only the downlink fails: time until manual driving ends",
            figure: Figure::Mean {
                unit: "s",
                digits: 2,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// Number of ticks between two drive frames while a key is held.
const FRAME_TICKS: u32 = 5;

/// Time limit of one second.
const GONE_TICKS: u32 = 20;

/// Failed directions of the radio.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Lost {
    BothWays,
    Hearing,
}

fn lost(trial: &Trial) -> Vec<Option<Reading>> {
    let [both, hearing] = [Lost::BothWays, Lost::Hearing].map(|lost| lose(trial, lost));
    vec![
        both.and_then(|ticks| success(ticks <= GONE_TICKS)),
        both.and_then(|ticks| value(f64::from(ticks) / 20.0)),
        hearing.and_then(|ticks| value(f64::from(ticks) / 20.0)),
    ]
}

/// Number of ticks from the failure until manual driving ends, at most 200; `None` if layer 0 did not control the motors.
fn lose(trial: &Trial, lost: Lost) -> Option<u32> {
    const PATIENCE_TICKS: u32 = 200;
    let mut rng = trial.rng();
    let house = arena("house");
    let start = house.somewhere(&mut rng);
    let mut run = Setup::new(trial, house.started_at(start)).start();
    run.seconds(rng.between(2.0, 60.0));
    run.open();
    let lost_at = 40 + rng.below(20) as u32;
    let mut heard = 0;
    for tick in 0..lost_at + PATIENCE_TICKS {
        if tick < lost_at || lost == Lost::BothWays {
            heard = run.heard();
        }
        if tick % FRAME_TICKS == 0 {
            run.transmit(&Message::Drive(Drive {
                velocity_in_s: 4,
                rotation_in_s: 1,
                heard,
                count: (tick / FRAME_TICKS % 16) as u8,
            }));
        }
        if tick == lost_at {
            if !is_held_by(&run.simulation, Layer::User) {
                return None;
            }
            if lost == Lost::BothWays {
                run.simulation.set_channel(&ChannelSpec {
                    outages_ms: std::iter::once(0..u64::MAX).collect(),
                    ..ChannelSpec::default()
                });
            }
        }
        run.tick();
        if tick >= lost_at && !is_held_by(&run.simulation, Layer::User) {
            return Some(tick - lost_at);
        }
    }
    Some(PATIENCE_TICKS)
}

fn hand(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let house = arena("house");
    let start = house.somewhere(&mut rng);
    let mut run = Setup::new(trial, house.started_at(start)).start();
    run.seconds(rng.between(2.0, 60.0));
    run.open();
    let mut obeyed = true;
    for count in 1..=8 {
        let (velocity_in_s, rotation_in_s) = (rng.below(17) as i8 - 8, rng.below(17) as i8 - 8);
        run.send(&Message::Drive(Drive {
            velocity_in_s,
            rotation_in_s,
            heard: run.heard(),
            count,
        }));
        let wanted = Motion::new(velocity_in_s.into(), rotation_in_s.into());
        for _ in 0..5 {
            run.tick();
            let robot = run.simulation.robot();
            obeyed &= is_held_by(&run.simulation, Layer::User) && robot.motion() == wanted;
        }
    }
    let mut held_ticks = 5;
    while is_held_by(&run.simulation, Layer::User) && held_ticks < 100 {
        run.tick();
        held_ticks += 1;
    }
    let released = held_ticks == u32::from(DEAD_MAN_TICKS) + 1;
    vec![success(obeyed), success(released)]
}
