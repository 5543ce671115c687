//! The display: position, heading, mode, battery and route on two lines of an HD44780, written through four data wires.
//! Without the feature `lcd` it is nothing.

use sr04_firmware::board::Inputs;
use sr04_firmware::robot::Robot;

#[cfg(feature = "lcd")]
pub use wired::Display;

/// No display.
#[cfg(not(feature = "lcd"))]
pub struct Display;

#[cfg(not(feature = "lcd"))]
impl Display {
    /// Does nothing.
    pub fn start() -> Self {
        Self
    }

    /// Does nothing.
    #[expect(clippy::unused_self, reason = "as with a display")]
    pub fn show(&mut self, _: &Robot, _: &Inputs) {}

    /// Does nothing.
    #[expect(clippy::unused_self, reason = "as with a display")]
    pub fn step(&mut self) {}
}

#[cfg(feature = "lcd")]
mod wired {
    use super::{Inputs, Robot};
    use crate::registers::{H, wait_10_us};

    /// D6 to D9: the data wires D4 to D7 of the display.
    const DATA: u8 = 0b0111_1000;
    /// D17: data instead of a command.
    const IS_DATA: u8 = 1;
    /// D16: the display takes the data wires when it falls.
    const ENABLE: u8 = 1 << 1;

    const COLUMNS: usize = 16;

    /// Ticks from one picture to the next.
    const TICKS: u8 = 5;

    /// Half bytes that start the display with four wires, then commands: two lines, on, clear, to the right. The first
    /// wait 40 ms, and each one repeats to take the time it needs.
    const WAKE: [u8; 6] = [0x3, 0x3, 0x3, 0x3, 0x3, 0x2];
    const COMMANDS: [u8; 4] = [0x28, 0x0C, 0x01, 0x06];
    const WAIT_STEPS: u8 = 25;

    /// Commands that go to the begin of a line.
    const LINES: [u8; 2] = [0x80, 0xC0];

    /// The display. A step every 2 ms gives it time for any command.
    pub struct Display {
        text: [[u8; COLUMNS]; 2],
        steps: u8,
        /// Next column, 0 for the command before it.
        column: u8,
        line: u8,
        ticks: u8,
    }

    impl Display {
        /// Sets up the pins.
        pub fn start() -> Self {
            H.output.change(DATA | IS_DATA | ENABLE, 0);
            H.direction.change(0, DATA | IS_DATA | ENABLE);
            Self {
                text: [[b' '; COLUMNS]; 2],
                steps: 0,
                column: 0,
                line: 0,
                ticks: 0,
            }
        }

        /// Composes the text: `+0123 -0045 270` are x, y and heading, `P 12.4V 03/20` mode, battery and points of the route.
        #[inline(never)]
        pub fn show(&mut self, robot: &Robot, inputs: &Inputs) {
            self.ticks += 1;
            if self.ticks < TICKS {
                return;
            }
            self.ticks = 0;
            let [first, second] = &mut self.text;
            let pose = robot.pose();
            signed(first, 0, pose.x_tenths_in() / 10);
            signed(first, 6, pose.y_tenths_in() / 10);
            digits(first, 12, 3, pose.theta_deg());
            put(second, 0, robot.mode().letter());
            let dv = u16::from(inputs.battery_dv);
            digits(second, 2, 2, dv / 10);
            put(second, 4, b'.');
            digits(second, 5, 1, dv % 10);
            put(second, 6, b'V');
            digits(second, 8, 2, robot.driven());
            put(second, 10, b'/');
            digits(second, 11, 2, robot.lists().active().len() as u16);
        }

        /// Sends the next command or character.
        pub fn step(&mut self) {
            if self.steps < WAIT_STEPS {
                self.steps += 1;
                return;
            }
            let started = usize::from(self.steps - WAIT_STEPS);
            if let Some(&half) = WAKE.get(started) {
                self.steps += 1;
                send_half(half, 0);
            } else if let Some(&command) = COMMANDS.get(started - WAKE.len()) {
                self.steps += 1;
                send(command, 0);
            } else {
                self.send_next();
            }
        }

        fn send_next(&mut self) {
            let line = usize::from(self.line);
            if self.column == 0 {
                send(LINES.get(line).copied().unwrap_or_default(), 0);
            } else if let Some(&character) = self
                .text
                .get(line)
                .and_then(|text| text.get(usize::from(self.column) - 1))
            {
                send(character, IS_DATA);
            }
            self.column += 1;
            if usize::from(self.column) > COLUMNS {
                self.column = 0;
                self.line ^= 1;
            }
        }
    }

    fn send(byte: u8, kind: u8) {
        send_half(byte >> 4, kind);
        send_half(byte & 0xF, kind);
    }

    fn send_half(half: u8, kind: u8) {
        H.output.change(DATA | IS_DATA, half << 3 | kind | ENABLE);
        wait_10_us();
        H.output.change(ENABLE, 0);
        wait_10_us();
    }

    fn put(text: &mut [u8; COLUMNS], column: usize, character: u8) {
        if let Some(place) = text.get_mut(column) {
            *place = character;
        }
    }

    /// Writes the last digits of a number.
    fn digits(text: &mut [u8; COLUMNS], column: usize, count: usize, number: u16) {
        let mut rest = number;
        for place in (column..column + count).rev() {
            put(text, place, b'0' + (rest % 10) as u8);
            rest /= 10;
        }
    }

    /// Writes a sign and four digits.
    fn signed(text: &mut [u8; COLUMNS], column: usize, number: i32) {
        put(text, column, if number < 0 { b'-' } else { b'+' });
        digits(text, column + 1, 4, number.unsigned_abs() as u16);
    }
}
