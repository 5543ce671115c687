//! What is wired to the board, and its sizes. Change these for a robot of your own; the features in Cargo.toml say which
//! sensors it has.

use groundwave_protocol::status_codes::{Layer, LayerMask};
use sr04_firmware::board::{Duplex, Edges, HC_12_PATIENCE_BYTES};

/// Robot number, 1 to 99.
pub const ROBOT_ID: u8 = 4;

/// Speed of the radio in bits per second.
pub const BAUD: u32 = 2400;

/// Turn-taking on the radio.
pub const DUPLEX: Duplex = if cfg!(feature = "half-duplex") {
    Duplex::Half {
        patience_bytes: HC_12_PATIENCE_BYTES,
    }
} else {
    Duplex::Full
};

/// Edges of an encoder per turn of its wheel.
pub const EDGES_PER_TURN: u16 = 251;

/// Diameter of the wheels in 1/1000 inch.
pub const WHEEL_IN_1000: u16 = 5000;

/// Inputs with edge sensors; the others count as floor.
pub const EDGE_SENSORS: Edges = Edges::ALL;

/// Full scale of the battery's input in tenths of a volt: 5 V behind a divider of 20 and 10 kiloohms.
pub const BATTERY_FULL_DV: u32 = 150;

/// Pulse of the servo with the arm stowed, in microseconds.
pub const SERVO_STOWED_US: u16 = 1000;
/// Pulse of the servo with the arm raised, in microseconds.
pub const SERVO_RAISED_US: u16 = 2000;

/// Layers whose sensors are wired.
pub const FITTED: LayerMask = {
    let mut fitted = LayerMask::ALL;
    if !cfg!(feature = "bumpers") {
        fitted = fitted.without(Layer::Bumpers);
    }
    if !cfg!(feature = "infrared") {
        fitted = fitted.without(Layer::Infrared);
    }
    if !cfg!(feature = "sonar") {
        fitted = fitted.without(Layer::Sonar);
    }
    fitted
};
