//! Layer 2: the scan.

use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::{Setup, is_held_by, turn_deg};
use groundwave_protocol::command::Order;
use groundwave_protocol::status_codes::{Layer, Mode};

pub(super) const ALL: &[&Experiment] = &[&SCAN, &YIELDS];

const SCAN: Experiment = Experiment {
    name: "scan",
    trials: [20, 300],
    run: scan,
    claims: &[
        Claim {
            part: "2 Rotation",
            says: "scan from rest: the true turn is 360 degrees within 5 (track up to 1 % and wheels up to 0.4 % off)",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: None,
        },
        Claim {
            part: "2 Rotation",
            says: "the same: error",
            figure: Figure::Mean {
                unit: "degrees",
                digits: 1,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

const YIELDS: Experiment = Experiment {
    name: "scan-bump",
    trials: [10, 100],
    run: yields,
    claims: &[Claim {
        part: "2 Rotation",
        says: "scan commanded just before a contact: the bumpers hold the motors in the tick of the contact",
        figure: Figure::Share,
        required: Required::AtLeast(100.0),
        shortfall: None,
    }],
};

fn scan(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let mut run = Setup::new(trial, arena("hall").world.clone())
        .only(&[Layer::Bumpers, Layer::Rotation])
        .mode(Mode::Reactive)
        .start();
    run.seconds(rng.between(1.0, 3.0));
    run.must(Order::Scan);
    let (mut turned_deg, mut before_deg) = (0.0, run.pose().theta_deg);
    let (mut has_begun, mut rest_ticks) = (false, 0);
    run.until(40.0, |simulation| {
        let now_deg = simulation.truth().pose.theta_deg;
        turned_deg += turn_deg(before_deg, now_deg);
        before_deg = now_deg;
        let scans = is_held_by(simulation, Layer::Rotation);
        has_begun |= scans;
        rest_ticks = if has_begun && !scans {
            rest_ticks + 1
        } else {
            0
        };
        rest_ticks > 20
    });
    let off_deg = (turned_deg - 360.0_f64).abs();
    vec![success(off_deg <= 5.0), value(off_deg)]
}

/// A first run finds the time of the contact; the second one gets the scan command shortly before it.
fn yields(trial: &Trial) -> Vec<Option<Reading>> {
    let mut rng = trial.rng();
    let room = arena("living-room");
    let start = room.somewhere(&mut rng);
    let ahead_s = 0.05 * f64::from(rng.below(6) as u8 + 1);
    let begin = || {
        Setup::new(trial, room.started_at(start))
            .only(&[Layer::Bumpers, Layer::Rotation])
            .start()
    };
    let contact_s = begin().until(60.0, |simulation| simulation.inputs().bumper.any());
    let Some(contact_s) = contact_s else {
        return vec![None];
    };
    let mut run = begin();
    run.seconds(contact_s - ahead_s);
    run.must(Order::Scan);
    run.tick();
    if !is_held_by(&run.simulation, Layer::Rotation) {
        return vec![None];
    }
    let mut yielded = None;
    run.until(2.0, |simulation| {
        if simulation.inputs().bumper.any() {
            yielded = Some(is_held_by(simulation, Layer::Bumpers));
        }
        yielded.is_some()
    });
    vec![yielded.map(Reading::Success)]
}
