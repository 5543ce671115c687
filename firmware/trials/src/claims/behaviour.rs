//! The behaviour layer, which switches sensors off and on.

use crate::claim::{Claim, Experiment, Figure, Reading, Required, Trial, success, value};
use crate::run::Setup;
use groundwave_protocol::status_codes::{Layer, LayerState, Mode};
use groundwave_protocol::telemetry::Body;

pub(super) const ALL: &[&Experiment] = &[&CHATTER, &REPORTED];

/// Switched sensors.
const SENSORS: [Layer; 3] = [Layer::Infrared, Layer::Sonar, Layer::Photo];

const MINUTES: f64 = 30.0;

/// Number of ticks of a state that must be reported.
const DWELL_TICKS: u32 = 40;

/// Maximum age of a line that has just arrived: 80 bytes at 240 a second, and one tick of waiting.
const LINE_TICKS: u32 = 8;

const CHATTER: Experiment = Experiment {
    name: "behaviour",
    trials: [2, 16],
    run: chatter,
    claims: &[Claim {
        part: "behaviour",
        says: "30 min of prowling in the house: switchings per hour (the limit of 20 is our own)",
        figure: Figure::PerHour,
        required: Required::AtMost(20.0),
        shortfall: None,
    }],
};

/// Worlds and modes in which sensors are switched off for different reasons.
const PLACES: [(&str, Mode); 4] = [
    ("house", Mode::Prowl),
    ("dark-room", Mode::Prowl),
    ("corridor", Mode::Reactive),
    ("living-room", Mode::Reactive),
];

const REPORTED: Experiment = Experiment {
    name: "behaviour-reported",
    trials: [4, 40],
    run: reported,
    claims: &[
        Claim {
            part: "behaviour",
            says: "30 min of prowling in the house and the dark room, and of mode Reactive in the corridor and the \
                   living room: each state of a sensor that lasts 2 s appears in a line A composed and received during it",
            figure: Figure::Share,
            required: Required::AtLeast(100.0),
            shortfall: None,
        },
        Claim {
            part: "behaviour",
            says: "the same: such states per run",
            figure: Figure::Mean {
                unit: "",
                digits: 0,
            },
            required: Required::Nothing,
            shortfall: None,
        },
    ],
};

/// A sensor's state, and its state in line A.
struct Switch {
    layer: Layer,
    is_on: Option<bool>,
    switched: u32,
    /// State that line A must show, its duration, and whether it has been shown.
    shows_on: Option<bool>,
    shown_ticks: u32,
    is_seen: bool,
    /// Number of lasting states, and whether all of them were shown.
    lasting: u32,
    is_reported: bool,
}

impl Switch {
    const fn new(layer: Layer) -> Self {
        Self {
            layer,
            is_on: None,
            switched: 0,
            shows_on: None,
            shown_ticks: 0,
            is_seen: true,
            lasting: 0,
            is_reported: true,
        }
    }

    /// Takes the state of a tick.
    fn follow(&mut self, is_on: bool, shows_on: bool) {
        if let Some(before) = self.is_on.replace(is_on)
            && before != is_on
        {
            self.switched += 1;
        }
        self.shown_ticks += 1;
        if self.shows_on.replace(shows_on) != Some(shows_on) {
            if self.shown_ticks > DWELL_TICKS {
                self.lasting += 1;
                self.is_reported &= self.is_seen;
            }
            self.shown_ticks = 0;
            self.is_seen = false;
        }
    }

    /// Takes a received line A.
    fn read(&mut self, is_on: bool) {
        // A line composed before the switching shows the old state.
        if self.shown_ticks >= LINE_TICKS {
            self.is_seen |= self.shows_on == Some(is_on);
        }
    }
}

fn chatter(trial: &Trial) -> Vec<Option<Reading>> {
    let switches = watched(trial, "house", Mode::Prowl);
    vec![Some(Reading::Events {
        count: switches.iter().map(|switch| switch.switched).sum(),
        hours: MINUTES / 60.0,
    })]
}

fn reported(trial: &Trial) -> Vec<Option<Reading>> {
    let (world, mode) = PLACES[trial.index % PLACES.len()];
    let switches = watched(trial, world, mode);
    let lasting: u32 = switches.iter().map(|switch| switch.lasting).sum();
    vec![
        success(switches.iter().all(|switch| switch.is_reported)),
        value(f64::from(lasting)),
    ]
}

/// The switches after half an hour in a world.
fn watched(trial: &Trial, world: &'static str, mode: Mode) -> [Switch; 3] {
    let mut run = Setup::anywhere(trial, world)
        .only(&[
            Layer::Bumpers,
            Layer::Rotation,
            Layer::Infrared,
            Layer::Sonar,
            Layer::Photo,
            Layer::DeadReckoning,
        ])
        .mode(mode)
        .start();
    let mut switches = SENSORS.map(Switch::new);
    for _ in 0..(MINUTES * 1200.0) as u32 {
        run.tick();
        let robot = run.simulation.robot();
        let (running, is_jammed) = (robot.running(), robot.infrared().is_jammed());
        for switch in &mut switches {
            // Line A does not distinguish sensors that the robot has switched off from jammed ones.
            let is_on = running.contains(switch.layer);
            let shows_on = is_on && !(is_jammed && switch.layer == Layer::Infrared);
            switch.follow(is_on, shows_on);
            for body in run.received() {
                if let Body::State(line) = body {
                    switch.read(line.layers.get(switch.layer) != LayerState::Off);
                }
            }
        }
    }
    switches
}
