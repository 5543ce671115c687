//! The motors: a TB6612 or another driver with two direction inputs and a pulse width for each motor.
//!
//! The pulses come at 31 kHz, above what people hear. An L298 wants them slower: clock 3 of timer 1 gives 490 Hz.

use crate::registers::{A, B, OCR1A, OCR1B, TCCR1A, TCCR1B};

/// D11 and D12: pulse widths, left and right.
const WIDTHS: u8 = 1 << 5 | 1 << 6;

/// D22 to D25: forward and backward, left and right.
const LEFT_FORWARD: u8 = 1;
const LEFT_BACKWARD: u8 = 1 << 1;
const RIGHT_FORWARD: u8 = 1 << 2;
const RIGHT_BACKWARD: u8 = 1 << 3;
const DIRECTIONS: u8 = LEFT_FORWARD | LEFT_BACKWARD | RIGHT_FORWARD | RIGHT_BACKWARD;

/// Timer 1: phase-correct pulses of eight bits on both outputs, without a prescaler.
const PULSES: u8 = 0b1010_0001;
const CLOCK: u8 = 1;

/// Makes the pins outputs, with the motors off.
pub fn start() {
    switch_off();
    A.direction.change(0, DIRECTIONS);
    B.direction.change(0, WIDTHS);
    TCCR1A.write(PULSES);
    TCCR1B.write(CLOCK);
}

/// Drives both motors with pulse widths of -255 to 255.
pub fn drive(left: i16, right: i16) {
    let direction = |width: i16, forward, backward| match width {
        1.. => forward,
        0 => 0,
        _ => backward,
    };
    let directions = direction(left, LEFT_FORWARD, LEFT_BACKWARD)
        | direction(right, RIGHT_FORWARD, RIGHT_BACKWARD);
    A.output.change(DIRECTIONS, directions);
    OCR1A.write(left.unsigned_abs());
    OCR1B.write(right.unsigned_abs());
}

/// Switches both motors off.
pub fn switch_off() {
    A.output.change(DIRECTIONS, 0);
    OCR1A.write(0);
    OCR1B.write(0);
}
