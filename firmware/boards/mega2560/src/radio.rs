//! The radio at serial port 1, with a clock of byte times: the robot is asked for a byte in each, idle ones too.

use crate::CLOCK_HZ;
use crate::config::BAUD;
use crate::registers::{self, CYCLES_PER_COUNT, can_send, counts, wake_at, wake_when_sent};

/// Cycles of a bit are eight times this.
const BIT_DIVISOR: u32 = (CLOCK_HZ / 8 + BAUD / 2) / BAUD;

/// Cycles of a byte: start, eight bits, stop.
const BYTE_CYCLES: u32 = BIT_DIVISOR * 8 * 10;
const BYTE_COUNTS: u16 = (BYTE_CYCLES / CYCLES_PER_COUNT) as u16;
const BYTE_REST: u8 = (BYTE_CYCLES % CYCLES_PER_COUNT) as u8;

/// The sending side.
pub struct Radio {
    /// Time at which the next byte is due, in counts, and its rest in cycles.
    due: u16,
    rest: u8,
}

impl Radio {
    /// Starts the port.
    pub fn start() -> Self {
        registers::start_radio((BIT_DIVISOR - 1) as u16);
        let radio = Self {
            due: counts(),
            rest: 0,
        };
        wake_at(radio.due);
        radio
    }

    /// Whether the robot must be asked for a byte now.
    pub fn is_due(&mut self) -> bool {
        let late = counts().wrapping_sub(self.due);
        if late as i16 >= 0 {
            if can_send() {
                self.advance(late);
                return true;
            }
            wake_when_sent();
        }
        false
    }

    fn advance(&mut self, late: u16) {
        if late > BYTE_COUNTS {
            // More than the slack of a byte: the line was idle.
            self.due = self.due.wrapping_add(late);
        }
        self.due = self.due.wrapping_add(BYTE_COUNTS);
        self.rest += BYTE_REST;
        if u32::from(self.rest) >= CYCLES_PER_COUNT {
            self.rest -= CYCLES_PER_COUNT as u8;
            self.due = self.due.wrapping_add(1);
        }
        wake_at(self.due);
    }

    /// Whether nothing is to be sent before the next interrupt.
    pub fn is_idle(&self) -> bool {
        (counts().wrapping_sub(self.due) as i16) < 0 || !can_send()
    }
}
