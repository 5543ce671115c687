//! Beeper, servo and the infrared LEDs.

use crate::CLOCK_HZ;
use crate::config::{SERVO_RAISED_US, SERVO_STOWED_US};
use crate::registers::{
    B, E, G, ICR3, OCR0A, OCR2A, OCR3A, TCCR0A, TCCR0B, TCCR2A, TCCR2B, TCCR3A, TCCR3B,
};

/// D4: the beeper.
const BEEPER: u8 = 1 << 5;

/// D5: the servo.
const SERVO: u8 = 1 << 3;

/// D10: the infrared LEDs.
const LEDS: u8 = 1 << 4;

/// Timers 0 and 2 count up to their top.
const TO_TOP: u8 = 1 << 1;
/// Timer 0 inverts D4 at each turn, timer 2 D10.
const TONE: u8 = 1 << 4 | TO_TOP;
const CARRIER: u8 = 1 << 6 | TO_TOP;
const PRESCALER_1: u8 = 1;
const PRESCALER_64: u8 = 3;
const PRESCALER_256: u8 = 4;

/// Carrier of the infrared LEDs.
const CARRIER_HZ: u32 = 38_000;

/// Timer 3: fast pulses up to ICR3, at 2 counts per microsecond.
const SERVO_PULSES: u8 = 0b1000_0010;
const SERVO_CLOCK: u8 = 0b0001_1010;
const SERVO_PERIOD_US: u16 = 20_000;

/// Starts all three, silent, stowed and dark.
pub fn start() {
    G.direction.change(0, BEEPER);
    beep(0);
    ICR3.write(SERVO_PERIOD_US * 2 - 1);
    raise_arm(false);
    TCCR3A.write(SERVO_PULSES);
    TCCR3B.write(SERVO_CLOCK);
    E.direction.change(0, SERVO);
    OCR2A.write((CLOCK_HZ / 2 / CARRIER_HZ - 1) as u8);
    TCCR2B.write(PRESCALER_1);
    light(false);
    B.direction.change(0, LEDS);
}

/// Sounds a tone; 0 is silence.
pub fn beep(note_hz: u16) {
    // The lowest tone of the faster clock.
    const LEAST_HZ: u32 = CLOCK_HZ / 2 / 64 / 256;
    if note_hz == 0 {
        TCCR0A.write(TO_TOP);
        TCCR0B.write(0);
        return;
    }
    let hz = u32::from(note_hz);
    let (clock, divisor) = if hz > LEAST_HZ {
        (PRESCALER_64, 64)
    } else {
        (PRESCALER_256, 256)
    };
    let top = (CLOCK_HZ / 2 / divisor / hz).clamp(1, 256) - 1;
    OCR0A.write(top as u8);
    TCCR0A.write(TONE);
    TCCR0B.write(clock);
}

/// Moves the servo.
pub fn raise_arm(is_up: bool) {
    let pulse_us = if is_up {
        SERVO_RAISED_US
    } else {
        SERVO_STOWED_US
    };
    OCR3A.write(pulse_us * 2 - 1);
}

/// Switches the infrared LEDs' carrier.
pub fn light(is_on: bool) {
    TCCR2A.write(if is_on { CARRIER } else { TO_TOP });
}
