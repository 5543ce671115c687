//! A battery that runs low: the call for the operator, and the way to the dock by itself.

use super::home::{DOCK_AT, pose_from};
use super::success;
use crate::arena::arena;
use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial};
use crate::run::{Run, Setup};
use groundwave_protocol::letters::Mode;
use groundwave_protocol::telemetry::Body;
use sr04_firmware::parameters::Parameter;
use sr04_firmware::song::Song;

pub(super) const ALL: &[&Experiment] = &[&CALL, &BY_ITSELF];

/// The limit, in tenths of a volt.
const LOW_DV: u8 = Parameter::LowBattery.definition().default as u8;

/// The charge at the start, some minutes of driving before the limit.
const CHARGE: (f64, f64) = (0.18, 0.26);

/// The battery is surely low when its readings have been below the limit for so long.
const LOW_TICKS: u32 = 200;

/// The line and the song have this long to arrive: other lines may be due.
const CALL_TICKS: u32 = 60;

/// The battery is low by then.
const DRIVE_S: f64 = 3600.0;

const CALL: Experiment = Experiment {
    name: "battery-call",
    trials: [8, 100],
    run: call,
    claims: &[
        Claim {
            part: "foraging",
            says: "prowling in the house until the battery is low, foraging off: line T with the call, the song's \
                   line and its notes, at the latest 3 s after 10 s of readings below the limit",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same: no call before the first reading below the limit",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
    ],
};

const BY_ITSELF: Experiment = Experiment {
    name: "battery-dock",
    trials: [8, 100],
    run: by_itself,
    claims: &[
        Claim {
            part: "foraging",
            says: "wandering in the flat until the battery is low, foraging on, calibrated by the square: it goes to \
                   its dock by itself",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same: charged within 15 min of setting out",
            figure: Figure::Share,
            required: Required::AtLeast(95.0),
            shortfall: None,
        },
        Claim {
            part: "foraging",
            says: "the same with wheels and track as they came",
            figure: Figure::Share,
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// What has been heard of the call.
#[derive(Default)]
struct Heard {
    text: bool,
    song: bool,
    notes: bool,
}

impl Heard {
    fn listen(&mut self, run: &Run) {
        for body in run.said() {
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

    const fn anything(&self) -> bool {
        self.text || self.song || self.notes
    }

    const fn everything(&self) -> bool {
        self.text && self.song && self.notes
    }
}

fn call(trial: &Trial) -> Vec<Option<Reading>> {
    let house = arena("house");
    let mut dice = trial.dice();
    let start = house.somewhere(&mut dice);
    let mut setup = Setup::new(trial, house.started_at(start));
    setup.config.conditions.charge = dice.between(CHARGE.0, CHARGE.1);
    let mut run = setup.start();
    let mut heard = Heard::default();
    let (mut was_below, mut is_early, mut low_ticks) = (false, false, 0);
    for _ in 0..(DRIVE_S * 20.0) as u32 {
        run.tick();
        let is_below = run.simulation.inputs().battery_dv < LOW_DV;
        was_below |= is_below;
        heard.listen(&run);
        is_early |= heard.anything() && !was_below;
        // From the last tick of these 10 s on the readings no longer matter.
        if is_below || low_ticks >= LOW_TICKS {
            low_ticks += 1;
        } else {
            low_ticks = 0;
        }
        if heard.everything() || low_ticks >= LOW_TICKS + CALL_TICKS {
            return vec![success(heard.everything()), success(!is_early)];
        }
    }
    vec![None, success(!is_early)]
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

/// Whether it has set out, and whether it then came to its dock in time.
fn forage(trial: &Trial, is_calibrated: bool) -> (bool, Option<bool>) {
    let flat = arena("flat");
    let mut dice = trial.dice();
    let start = flat.somewhere(&mut dice);
    let wander_s = Parameter::Wander.definition().most;
    let mut setup = Setup::new(trial, flat.started_at(start));
    if is_calibrated {
        setup = setup.calibrated();
    }
    setup = setup
        .with(Parameter::Forage, 1)
        .with(Parameter::Wander, wander_s)
        .mode(Mode::Wander);
    setup.config.conditions.charge = dice.between(CHARGE.0, CHARGE.1);
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
