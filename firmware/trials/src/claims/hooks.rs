//! Layer 1: objects caught on the bumper, and the jam sequence that works them free.

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::Setup;
use groundwave_protocol::status_codes::Layer;

pub(super) const ALL: &[&Experiment] = &[&HOOKED];

/// Number of ticks after which a closed switch counts as held: 3 s.
const HELD_TICKS: u32 = 60;

/// Time limit for catching an object, seconds.
const SEARCH_S: f64 = 600.0;
const FREE_WITHIN_S: f64 = 60.0;

const HOOKED: Experiment = Experiment {
    name: "hooked",
    trials: [20, 300],
    run: hooked,
    claims: &[
        Claim {
            part: "1 Bumpers",
            says: "a cord or a shoe caught on the bumper, bumpers and prowl only: the switch opens within 60 s",
            figure: Figure::Share,
            required: Required::AtLeast(99.5),
            shortfall: None,
        },
        Claim {
            part: "1 Bumpers",
            says: "the same with the switch closed for 3 s: the jam sequence begins at that tick",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "1 Bumpers",
            says: "the same: free within 60 s",
            figure: Figure::Share,
            required: Required::AtLeast(99.5),
            shortfall: None,
        },
        Claim {
            part: "1 Bumpers",
            says: "the same: time after the begin of the sequence",
            figure: Figure::Mean {
                unit: "s",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

fn hooked(trial: &Trial) -> Vec<Option<Reading>> {
    let mut run = Setup::anywhere(trial, "snags")
        .only(&[Layer::Bumpers])
        .start();
    let mut closed_ticks = 0;
    let mut count_closed = |is_closed: bool| {
        closed_ticks = if is_closed { closed_ticks + 1 } else { 0 };
        closed_ticks
    };
    let caught = run.until(SEARCH_S, |simulation| {
        count_closed(simulation.inputs().bumper.any());
        simulation.truth().is_hooked
    });
    if caught.is_none() {
        return vec![None; 4];
    }
    let (mut is_exact, mut began_s) = (true, None);
    let (mut was_jammed, mut now_s) = (run.simulation.robot().is_bumper_jammed(), 0.0);
    let freed = run.until(FREE_WITHIN_S, |simulation| {
        let closed = count_closed(simulation.inputs().bumper.any());
        let is_jammed = simulation.robot().is_bumper_jammed();
        // Once begun, the sequence lasts until the switch is open.
        let begins = is_jammed && !was_jammed;
        is_exact &= begins == (closed == HELD_TICKS);
        if begins {
            began_s = Some(now_s);
        }
        was_jammed = is_jammed;
        now_s += 0.05;
        !simulation.truth().is_hooked
    });
    let is_free = success(freed.is_some());
    vec![
        is_free,
        began_s.and_then(|_| success(is_exact)),
        began_s.and(is_free),
        began_s
            .zip(freed)
            .and_then(|(began_s, freed_s)| value(freed_s - began_s)),
    ]
}
