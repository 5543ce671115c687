//! The clock of the simulation: every step is one millisecond.

use sr04_firmware::board::{INFRARED_SAMPLE_HZ, TICK_HZ};

/// Milliseconds per tick of the robot's program.
pub const TICK_MS: u64 = 1000 / TICK_HZ as u64;

/// Milliseconds between two infrared samples.
pub const SAMPLE_MS: u64 = 1000 / INFRARED_SAMPLE_HZ as u64;
