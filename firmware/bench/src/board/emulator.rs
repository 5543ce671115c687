//! The emulated Mega with its whole board, a process of its own.

use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout};

use crate::chip;

/// Traced bytes before a reset in a step without one.
const NO_RESET: u16 = u16::MAX;

/// Levels and voltages at the board's inputs for a millisecond.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pins {
    /// Edges of both encoders.
    pub(crate) edges: [u8; 2],
    pub(crate) port_c: u8,
    pub(crate) port_l: u8,
    pub(crate) port_k: u8,
    /// Millivolts at A0 to A2.
    pub(crate) analog_mv: [u16; 3],
}

/// The board's outputs after a millisecond.
#[derive(Debug)]
pub(crate) struct Step {
    /// Pulse widths of both motors.
    pub(crate) widths: [u8; 2],
    pub(crate) port_a: u8,
    /// Carrier of the infrared LEDs; 0 while they are dark.
    pub(crate) carrier_hz: u16,
    /// Sonars triggered.
    pub(crate) pinged: [bool; 2],
    pub(crate) tone_hz: u16,
    /// Pulse of the servo; 0 if pulses do not come 50 times a second.
    pub(crate) servo_us: u16,
    /// Cycles in which the processor did not sleep.
    pub(crate) awake_cycles: u16,
    /// Bytes to the radio.
    pub(crate) sent: Vec<u8>,
    /// Bytes of the program's calls and results, before a reset and after it.
    pub(crate) traced: Vec<u8>,
    pub(crate) traced_after_reset: Option<Vec<u8>>,
}

/// Figures of the program since it started.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ChipFigures {
    pub(crate) stack_bytes: u16,
    pub(crate) spare_bytes: u16,
    /// Received bytes that the program took too late.
    pub(crate) lost_bytes: u16,
    pub(crate) bits_per_s: u16,
}

/// What the chip loses when it is reset in a write of the EEPROM.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Loss {
    /// RAM and the byte that is being written.
    Power = 1,
    /// Nothing: the write goes on.
    Voltage = 4,
}

pub(crate) struct Emulator {
    process: Child,
    to: BufWriter<ChildStdin>,
    from: BufReader<ChildStdout>,
}

impl Emulator {
    pub(crate) fn start(emulator: &Path, program: &Path) -> Result<Self, String> {
        let (process, to, from) = chip::start(emulator, program)?;
        Ok(Self {
            process,
            to: BufWriter::new(to),
            from: BufReader::new(from),
        })
    }

    /// Runs the board for a millisecond; at most 255 bytes come from the radio.
    pub(crate) fn step(&mut self, pins: &Pins, received: &[u8]) -> Result<Step, String> {
        let [left, right] = pins.edges;
        let mut command = vec![b'S', left, right, pins.port_c, pins.port_l, pins.port_k];
        command.extend(pins.analog_mv.into_iter().flat_map(u16::to_le_bytes));
        command.push(received.len() as u8);
        command.extend(received);
        self.send(&command)?;
        let [left, right, port_a, flags] = self.read()?;
        let [carrier_hz, tone_hz] = [self.word()?, self.word()?];
        let [servo_us, awake_cycles] = [self.word()?, self.word()?];
        let sent = self.bytes()?;
        let before = self.word()?;
        let mut traced = self.bytes()?;
        let has_reset = before != NO_RESET;
        let traced_after_reset =
            has_reset.then(|| traced.split_off(usize::from(before).min(traced.len())));
        Ok(Step {
            widths: [left, right],
            port_a,
            carrier_hz,
            pinged: [flags & 1 != 0, flags & 2 != 0],
            tone_hz,
            servo_us,
            awake_cycles,
            sent,
            traced,
            traced_after_reset,
        })
    }

    /// Begins a pulse on an echo pin, 0 left and 1 right.
    pub(crate) fn echo(&mut self, side: u8, length_us: u32) -> Result<(), String> {
        let [a, b, c, d] = length_us.to_le_bytes();
        self.send(&[b'E', side, a, b, c, d])
    }

    /// Power is lost and restored: only the EEPROM keeps its contents.
    pub(crate) fn lose_power(&mut self) -> Result<(), String> {
        self.send(b"P")
    }

    /// The chip is reset in the middle of a write of the EEPROM, 1 for the next one; 0 for none.
    pub(crate) fn lose_in(&mut self, write: u16, loss: Loss) -> Result<(), String> {
        let [low, high] = write.to_le_bytes();
        self.send(&[b'W', low, high, loss as u8])
    }

    /// The supply's voltage drops for a moment.
    pub(crate) fn brown_out(&mut self) -> Result<(), String> {
        self.send(b"B")
    }

    /// The program hangs where it is.
    pub(crate) fn hang(&mut self, interrupts_on: bool) -> Result<(), String> {
        self.send(&[b'H', u8::from(interrupts_on)])
    }

    /// The program calls its function at this address.
    pub(crate) fn call(&mut self, address: u32) -> Result<(), String> {
        let [a, b, c, d] = address.to_le_bytes();
        self.send(&[b'X', a, b, c, d])
    }

    /// Both lines of the display.
    pub(crate) fn display(&mut self) -> Result<String, String> {
        self.send(b"L")?;
        let text = self.read::<32>()?;
        let (first, second) = text.split_at(16);
        Ok([first, second]
            .map(|line| String::from_utf8_lossy(line).trim_end().to_owned())
            .join("\n"))
    }

    pub(crate) fn figures(&mut self) -> Result<ChipFigures, String> {
        self.send(b"F")?;
        Ok(ChipFigures {
            stack_bytes: self.word()?,
            spare_bytes: self.word()?,
            lost_bytes: self.word()?,
            bits_per_s: self.word()?,
        })
    }

    fn send(&mut self, command: &[u8]) -> Result<(), String> {
        self.to
            .write_all(command)
            .and_then(|()| self.to.flush())
            .map_err(|error| format!("the emulator takes no command: {error}"))
    }

    fn read<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        self.from
            .read_exact(&mut bytes)
            .map_err(|error| format!("the emulator does not answer: {error}"))?;
        Ok(bytes)
    }

    fn word(&mut self) -> Result<u16, String> {
        self.read().map(u16::from_le_bytes)
    }

    fn bytes(&mut self) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; usize::from(self.word()?)];
        self.from
            .read_exact(&mut bytes)
            .map_err(|error| format!("the emulator does not answer: {error}"))?;
        Ok(bytes)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
