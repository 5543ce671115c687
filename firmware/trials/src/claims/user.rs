//! Layer 0: the operator's hand.

use super::success;
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Setup, is_held_by};
use groundwave_protocol::command::{Drive, Message};
use groundwave_protocol::letters::Layer;
use sr04_firmware::behaviours::DEAD_MAN_TICKS;
use sr04_firmware::drive::Motion;

pub(super) const ALL: &[&Experiment] = &[&HAND];

const HAND: Experiment = Experiment {
    name: "user",
    trials: [20, 200],
    run: hand,
    claims: &[
        Claim {
            part: "0 User",
            says: "at any moment of a prowl in the house: the tick after a drive frame does what it says, and \
                   all others while frames come",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "0 User",
            says: "after the last frame the hand is gone in exactly the dead man's 20 ticks",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

fn hand(trial: &Trial) -> Vec<Option<Reading>> {
    let mut dice = trial.dice();
    let house = arena("house");
    let start = house.somewhere(&mut dice);
    let mut run = Setup::new(trial, house.started_at(start)).start();
    run.seconds(dice.between(2.0, 60.0));
    run.open();
    let mut obeyed = true;
    for count in 1..=8 {
        let (velocity_in_s, rotation_in_s) = (dice.below(17) as i8 - 8, dice.below(17) as i8 - 8);
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
