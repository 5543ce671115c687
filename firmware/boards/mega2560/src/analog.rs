//! The analogue inputs, converted one after the other: A0 and A1 photocells, A2 the battery.

use crate::config::BATTERY_FULL_DV;
use crate::registers::{ADC, ADCSRA, ADMUX};

/// Reference: the supply of 5 V.
const SUPPLY: u8 = 1 << 6;

/// The converter is on, at 125 kHz; it begins.
const ON: u8 = 0b1000_0111;
const BEGIN: u8 = 1 << 6;

const CHANNELS: usize = 3;

/// Latest readings, 0 to 1023.
pub struct Analog {
    readings: [u16; CHANNELS],
    channel: u8,
}

impl Analog {
    /// Reads every channel once.
    pub fn start() -> Self {
        let mut analog = Self {
            readings: [0; CHANNELS],
            channel: 0,
        };
        analog.begin();
        for _ in 0..CHANNELS {
            while !is_ready() {}
            analog.step();
        }
        analog
    }

    fn begin(&self) {
        ADMUX.write(SUPPLY | self.channel);
        ADCSRA.write(ON | BEGIN);
    }

    /// Takes a finished conversion, 0.1 ms long, and begins that of the next channel.
    pub fn step(&mut self) {
        if !is_ready() {
            return;
        }
        if let Some(reading) = self.readings.get_mut(usize::from(self.channel)) {
            *reading = ADC.read();
        }
        self.channel = (self.channel + 1) % CHANNELS as u8;
        self.begin();
    }

    /// Left photocell, 0 very bright to 255 dark.
    pub fn photo_left(&self) -> u8 {
        self.eight_bits(0)
    }

    /// Right photocell, likewise.
    pub fn photo_right(&self) -> u8 {
        self.eight_bits(1)
    }

    fn eight_bits(&self, channel: usize) -> u8 {
        let [first, second, _] = self.readings;
        let reading = if channel == 0 { first } else { second };
        (reading >> 2) as u8
    }

    /// Battery voltage in tenths of a volt, rounded.
    pub fn battery_dv(&self) -> u8 {
        let [.., reading] = self.readings;
        let dv = (u32::from(reading) * BATTERY_FULL_DV + 512) >> 10;
        u8::try_from(dv).unwrap_or(u8::MAX)
    }
}

fn is_ready() -> bool {
    ADCSRA.read() & BEGIN == 0
}
