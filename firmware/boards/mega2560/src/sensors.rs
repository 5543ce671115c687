//! The sensors, from their pins to the robot's inputs.

use sr04_firmware::board::{CountScaler, Echo, Edges, Inputs, Side, Sides, Switches};

use crate::analog::Analog;
use crate::config::{EDGE_SENSORS, EDGES_PER_TURN, WHEEL_IN_1000};
use crate::registers::{self, A, C, E, K, L, echo_us, edges, expect_echo};

/// D26 and D27: triggers of the sonars, left and right. Their echoes are captured at D49 and D48.
const TRIGGER_LEFT: u8 = 1 << 4;
const TRIGGER_RIGHT: u8 = 1 << 5;

/// D2 and D3: encoders, left and right.
const ENCODERS: u8 = 1 << 4 | 1 << 5;

/// D47, D46, D45: bumper switches to ground, left, centre and right. D44: the top hat's.
const BUMPER_LEFT: u8 = 1 << 2;
const BUMPER_CENTER: u8 = 1 << 3;
const BUMPER_RIGHT: u8 = 1 << 4;
const TOP_HAT: u8 = 1 << 5;
const SWITCHES: u8 = BUMPER_LEFT | BUMPER_CENTER | BUMPER_RIGHT | TOP_HAT;

/// A8 and A9: infrared receivers, left and right, low while they see the carrier.
const SEEN_LEFT: u8 = 1;
const SEEN_RIGHT: u8 = 1 << 1;

/// A10 and A11: motion detectors, left and right.
const MOTION_LEFT: u8 = 1 << 2;
const MOTION_RIGHT: u8 = 1 << 3;

/// A12 and A13: receivers of the dock's beacon, left and right, low while they see it.
const BEACON_LEFT: u8 = 1 << 4;
const BEACON_RIGHT: u8 = 1 << 5;

/// A14: the charger's contacts.
const DOCKED: u8 = 1 << 6;

/// Ticks from a ping to its echo.
const ECHO_TICKS: u8 = 2;

/// State between two readings.
pub struct Sensors {
    wheels: [Wheel; 2],
    /// Sonar that has pinged, and ticks to its echo.
    ping: Option<(Side, u8)>,
}

struct Wheel {
    scaler: CountScaler,
    edges: u16,
}

impl Wheel {
    const NEW: Self = Self {
        scaler: CountScaler::new(EDGES_PER_TURN, WHEEL_IN_1000),
        edges: 0,
    };

    fn counts(&mut self, side: Side) -> u16 {
        let edges = edges(side);
        let counts = self.scaler.counts(edges.wrapping_sub(self.edges));
        self.edges = edges;
        counts
    }
}

impl Sensors {
    /// Sets up the pins. Unwired inputs of edge sensors read as edges: a cut wire stops the robot.
    pub fn start() -> Self {
        A.direction.change(0, TRIGGER_LEFT | TRIGGER_RIGHT);
        C.output.write(Edges::ALL.bits());
        E.output.change(0, ENCODERS);
        L.output.write(SWITCHES);
        K.output
            .write(SEEN_LEFT | SEEN_RIGHT | BEACON_LEFT | BEACON_RIGHT);
        registers::start_encoders();
        Self {
            wheels: [Wheel::NEW, Wheel::NEW],
            ping: None,
        }
    }

    /// The inputs of a tick.
    pub fn read(&mut self, analog: &Analog, is_late: bool) -> Inputs {
        let [left, right] = &mut self.wheels;
        let closed = !L.input.read();
        let far = K.input.read();
        let photocells = cfg!(feature = "photocells");
        let has_bumpers = cfg!(feature = "bumpers");
        Inputs {
            counts_left: left.counts(Side::Left),
            counts_right: right.counts(Side::Right),
            bumper: Switches {
                left: has_bumpers && closed & BUMPER_LEFT != 0,
                center: has_bumpers && closed & BUMPER_CENTER != 0,
                right: has_bumpers && closed & BUMPER_RIGHT != 0,
            },
            sonar: self.echo(),
            photo_left: photocells.then(|| analog.photo_left()),
            photo_right: photocells.then(|| analog.photo_right()),
            battery_dv: analog.battery_dv(),
            cliff: cfg!(feature = "edges")
                .then(|| Edges::from_bits(C.input.read() & EDGE_SENSORS.bits())),
            motion: cfg!(feature = "motion").then_some(Sides {
                left: far & MOTION_LEFT != 0,
                right: far & MOTION_RIGHT != 0,
            }),
            top_hat: cfg!(feature = "motion") && closed & TOP_HAT != 0,
            beacon: cfg!(feature = "beacon").then_some(Sides {
                left: far & BEACON_LEFT == 0,
                right: far & BEACON_RIGHT == 0,
            }),
            is_docked: cfg!(feature = "beacon") && far & DOCKED != 0,
            is_late,
        }
    }

    fn echo(&mut self) -> Option<Echo> {
        let (side, ticks) = self.ping?;
        if ticks > 1 {
            self.ping = Some((side, ticks - 1));
            return None;
        }
        self.ping = None;
        Some(Echo::after_us(side, echo_us(side)))
    }

    /// Triggers a sonar.
    pub fn ping(&mut self, side: Side) {
        let trigger = match side {
            Side::Left => TRIGGER_LEFT,
            Side::Right => TRIGGER_RIGHT,
        };
        expect_echo(side);
        A.output.change(0, trigger);
        registers::wait_10_us();
        A.output.change(trigger, 0);
        self.ping = Some((side, ECHO_TICKS));
    }
}

/// Infrared receivers that see a reflection.
pub fn infrared() -> Sides {
    let far = K.input.read();
    Sides {
        left: far & SEEN_LEFT == 0,
        right: far & SEEN_RIGHT == 0,
    }
}
