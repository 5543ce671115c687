//! Low battery: the call for the operator, and the drive to the dock.

use super::home::{DOCK_AT, pose_from};
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success};
use crate::run::{Run, Setup};
use groundwave_protocol::status_codes::Mode;
use groundwave_protocol::telemetry::Body;
use sr04_firmware::parameters::Parameter;
use sr04_firmware::song::Song;

pub(super) const ALL: &[&Experiment] = &[&CALL, &BY_ITSELF];

/// Limit in tenths of a volt.
const LOW_DV: u8 = Parameter::LowBattery.definition().default as u8;

/// Range of the charge at the start, some minutes of driving above the limit.
const CHARGE: (f64, f64) = (0.18, 0.26);

/// Number of ticks of readings below the limit after which the battery is low.
const LOW_TICKS: u32 = 200;

/// Number of ticks for the line and the song to arrive after other lines.
const CALL_TICKS: u32 = 60;

/// Time within which the battery becomes low, seconds.
const DRIVE_S: f64 = 3600.0;

const CALL: Experiment = Experiment {
    name: "battery-call",
    trials: [8, 100],
    run: call,
    claims: &[Claim {
        part: "foraging",
        says: "prowling in the house until the battery is low, foraging off: no part of the call unless the mean of 3 s was below \
                   the limit within the last 3 s; line T with the call, the song's line and its notes within 3 s after 10 s of \
                   readings below it",
        figure: Figure::Share,
        required: Required::AtLeast(100.0),
        shortfall: None,
    }],
};

const BY_ITSELF: Experiment = Experiment {
    name: "battery-dock",
    trials: [8, 100],
    run: by_itself,
    claims: &[
        Claim {
            part: "foraging",
            says: "wandering in the flat until the battery is low, foraging on, calibrated by the square: the robot \
                   starts for its dock",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same: charging within 15 min after the start",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same with uncalibrated wheels and track",
            figure: Figure::Share,
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// Which parts of the call were received.
#[derive(Default)]
struct Heard {
    text: bool,
    song: bool,
    notes: bool,
}

impl Heard {
    fn listen(&mut self, run: &Run) {
        for body in run.received() {
            match body {
                Body::Text(text) => self.text |= text.as_str().starts_with("my battery is low"),
                Body::Song(song) => {
                    let notes = Song::LowBattery.notes();
                    self.song |= song
                        .notes()
                        .map(|note| (note.hz, note.ticks))
                        .eq(notes.iter().copied());
                }
                _ => {}
            }
        }
        self.notes |= run.simulation.outputs().note_hz > 0;
    }

    const fn any(&self) -> bool {
        self.text || self.song || self.notes
    }

    const fn all(&self) -> bool {
        self.text && self.song && self.notes
    }
}

fn call(trial: &Trial) -> Vec<Option<Reading>> {
    let house = arena("house");
    let mut rng = trial.rng();
    let start = house.somewhere(&mut rng);
    let mut setup = Setup::new(trial, house.started_at(start));
    setup.config.conditions.charge = rng.between(CHARGE.0, CHARGE.1);
    let mut run = setup.start();
    let mut heard = Heard::default();
    let (mut is_early, mut low_ticks) = (false, 0);
    // Readings averaged over 3 s, as starting motors pull the voltage down.
    let (mut average_dv, mut ticks_since_below) = (130.0, u32::MAX);
    for _ in 0..(DRIVE_S * 20.0) as u32 {
        run.tick();
        let is_below = run.simulation.inputs().battery_dv < LOW_DV;
        let was_heard = heard.any();
        heard.listen(&run);
        // After these 10 s the readings no longer matter.
        if is_below || low_ticks >= LOW_TICKS {
            low_ticks += 1;
        } else {
            low_ticks = 0;
        }
        average_dv += (f64::from(run.simulation.inputs().battery_dv) - average_dv) / 64.0;
        ticks_since_below = if average_dv < f64::from(LOW_DV) {
            0
        } else {
            ticks_since_below.saturating_add(1)
        };
        is_early |= !was_heard && heard.any() && ticks_since_below > CALL_TICKS;
        if heard.all() || low_ticks >= LOW_TICKS + CALL_TICKS {
            return vec![success(heard.all() && !is_early)];
        }
    }
    vec![is_early.then_some(Reading::Success(false))]
}

fn by_itself(trial: &Trial) -> Vec<Option<Reading>> {
    let (set_out, docked) = forage(trial, true);
    let (_, docked_as_built) = forage(&trial.untraced(), false);
    vec![
        success(set_out),
        docked.and_then(success),
        docked_as_built.and_then(success),
    ]
}

/// Whether the robot has started for its dock, and whether it then reached the dock in time.
fn forage(trial: &Trial, is_calibrated: bool) -> (bool, Option<bool>) {
    let flat = arena("flat");
    let mut rng = trial.rng();
    let start = flat.somewhere(&mut rng);
    let wander_s = Parameter::Wander.definition().most;
    let mut setup = Setup::new(trial, flat.started_at(start));
    if is_calibrated {
        setup = setup.calibrated();
    }
    setup = setup
        .with(Parameter::Forage, 1)
        .with(Parameter::Wander, wander_s)
        .mode(Mode::Wander);
    setup.config.conditions.charge = rng.between(CHARGE.0, CHARGE.1);
    let mut run = setup.start();
    run.must(pose_from(DOCK_AT, start));
    let set_out = run.until(f64::from(wander_s), |simulation| {
        simulation.robot().mode() == Mode::Forage
    });
    let docked = set_out.map(|_| {
        run.until(15.0 * 60.0, |simulation| simulation.truth().is_docked)
            .is_some()
    });
    (set_out.is_some(), docked)
}
