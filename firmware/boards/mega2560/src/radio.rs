//! The radio at serial port 1. While the robot sends, the port sets the pace and asks for a byte ahead; idle byte times
//! are counted by the clock.

use crate::CLOCK_HZ;
use crate::config::BAUD;
use crate::registers::{self, CYCLES_PER_COUNT, can_send, counts};

/// Cycles of a bit are eight times this.
const BIT_DIVISOR: u32 = (CLOCK_HZ / 8 + BAUD / 2) / BAUD;

/// Counts of a byte: start, eight bits, stop.
const BYTE_COUNTS: u16 = (BIT_DIVISOR * 8 * 10 / CYCLES_PER_COUNT) as u16;

/// Byte times of delay that are made up for.
const LATE_BYTES: u16 = 4;

/// The sending side.
pub struct Radio {
    /// Whether the latest byte time is idle, and when it ends.
    is_idle: bool,
    end: u16,
}

impl Radio {
    /// Starts the port.
    pub fn start() -> Self {
        registers::start_radio((BIT_DIVISOR - 1) as u16);
        Self {
            is_idle: true,
            end: counts(),
        }
    }

    /// Whether the robot must be asked for a byte now.
    pub fn is_due(&self) -> bool {
        if self.is_idle {
            counts().wrapping_sub(self.end) as i16 >= 0
        } else {
            can_send()
        }
    }

    /// Sends what the robot has answered.
    pub fn take(&mut self, byte: Option<u8>) {
        let now = counts();
        let late = now.wrapping_sub(self.end);
        if !self.is_idle || late > LATE_BYTES * BYTE_COUNTS {
            self.end = now;
        }
        self.end = self.end.wrapping_add(BYTE_COUNTS);
        self.is_idle = byte.is_none();
        if let Some(byte) = byte {
            registers::send(byte);
        }
    }
}
