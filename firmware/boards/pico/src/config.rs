//! What is wired to the board, and its sizes. Change these for a robot of your own.

use groundwave_protocol::status_codes::{Layer, LayerMask};
use sr04_firmware::board::Duplex;

/// Robot number, 1 to 99.
pub const ROBOT_ID: u8 = 4;

/// Speed of the radio in bits per second.
pub const BAUD: u32 = 2400;

/// Turn-taking on the radio.
pub const DUPLEX: Duplex = Duplex::Full;

/// Edges of an encoder per turn of its wheel.
pub const EDGES_PER_TURN: u16 = 251;

/// Diameter of the wheels in 1/1000 inch.
pub const WHEEL_IN_1000: u16 = 5000;

/// Full scale of the battery's input in tenths of a volt: 3.3 V behind a divider of 33 and 10 kiloohms.
pub const BATTERY_FULL_DV: u32 = 142;

/// Layers whose sensors are wired: a Pico has no pins left for the motion detectors.
pub const FITTED: LayerMask = LayerMask::ALL.without(Layer::Motion);
