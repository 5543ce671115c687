//! The clock of the simulation: every step is one millisecond.

use sr04_firmware::board::{INFRARED_SAMPLE_HZ, TICK_HZ};

/// Time between two ticks of the robot's program, milliseconds.
pub const TICK_MS: u64 = 1000 / TICK_HZ as u64;

/// Time between two infrared samples, milliseconds.
pub const SAMPLE_MS: u64 = 1000 / INFRARED_SAMPLE_HZ as u64;
