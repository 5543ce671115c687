//! The simulated world at the pins of the emulated board, a millisecond a step.

use std::path::Path;

use groundwave_protocol::decoder::{Decoder, Received};
use groundwave_protocol::telemetry::{Ack, Body, Line};
use sr04_firmware::board::{ECHO_US_PER_IN, Echo, Edges, Inputs, Outputs, Side, Sides};
use sr04_sim::{Conditions, Plant, SAMPLE_MS, TICK_MS, World};

use super::at_pins::AtPins;
use super::emulator::{Emulator, Pins, Step};
use super::mirror::Mirror;
use crate::chip::Figures;

/// Pulse of a sonar that hears no echo.
const NO_ECHO_US: u32 = 65_000;

/// Millivolts at full scale of an analogue input.
const FULL_MV: u32 = 5000;

/// Pulse of the servo from which the arm is up.
const UP_US: u16 = 1500;

/// What the infrared receivers take for their carrier: a TSSP4038's band.
const CARRIER_HZ: std::ops::Range<u16> = 36_000..40_000;

/// The house, the board in it and a robot on the host that gets what the board got.
pub(crate) struct House {
    plant: Plant,
    pub(crate) emulator: Emulator,
    mirror: Mirror,
    pins: Pins,
    at_pins: AtPins,
    leds_on: bool,
    /// Milliseconds since the start, and the first one before the chip's ticks.
    pub(crate) now_ms: u64,
    phase_ms: u64,
    has_ticked: bool,
    decoder: Decoder,
    /// Bytes to the radio, between two resets, and the lines in them.
    pub(crate) sent: Vec<Vec<u8>>,
    pub(crate) lines: Vec<(u64, Line)>,
    pub(crate) ack: Option<Ack>,
    /// Awake cycles of the current tick, and of the longest.
    awake_cycles: u64,
    worst_cycles: u64,
    all_cycles: u64,
    /// Whether the motors have power.
    pub(crate) drives: bool,
    pub(crate) hand: Hand,
}

/// What a hand does to the robot.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hand {
    /// Changes what the plant's sensors read.
    pub(crate) on_sensors: fn(&mut Inputs),
    /// Sides at which it reflects infrared.
    pub(crate) before: Sides,
    /// Wheels that it turns.
    pub(crate) turns: Sides,
}

impl Hand {
    /// A hand that does nothing.
    pub(crate) const OFF: Self = Self {
        on_sensors: |_| {},
        before: Sides {
            left: false,
            right: false,
        },
        turns: Sides {
            left: false,
            right: false,
        },
    };
}

/// Milliseconds from one edge of an encoder to the next while a hand turns its wheel.
const TURNED_MS: u64 = 8;

impl House {
    pub(crate) fn new(
        world: &str,
        seed: u64,
        emulator: &Path,
        program: &Path,
    ) -> Result<Self, String> {
        let world = World::open(world).map_err(|error| error.to_string())?;
        Ok(Self {
            plant: Plant::new(&world, &Conditions::default(), seed),
            emulator: Emulator::start(emulator, program)?,
            mirror: Mirror::new(),
            pins: Pins {
                edges: [0; 2],
                port_c: 0,
                port_l: 0xFF,
                port_k: 0,
                analog_mv: [0; 3],
            },
            at_pins: AtPins::default(),
            leds_on: false,
            now_ms: 0,
            phase_ms: 0,
            has_ticked: false,
            decoder: Decoder::default(),
            sent: vec![Vec::new()],
            lines: Vec::new(),
            ack: None,
            awake_cycles: 0,
            worst_cycles: 0,
            all_cycles: 0,
            drives: false,
            hand: Hand::OFF,
        })
    }

    /// Runs a millisecond in which bytes from the radio begin to come; returns the bytes to the radio.
    pub(crate) fn step(&mut self, received: &[u8]) -> Result<Vec<u8>, String> {
        self.now_ms += 1;
        self.plant.step();
        if self.now_ms % TICK_MS == self.phase_ms {
            self.set_pins();
            // The time before the first tick is the boot's.
            if self.has_ticked {
                self.worst_cycles = self.worst_cycles.max(self.awake_cycles);
            }
            self.awake_cycles = 0;
        }
        let (left, right) = self.plant.edges();
        let Sides { left: l, right: r } = self.hand.turns;
        let turned = |is_turned| u16::from(is_turned && self.now_ms.is_multiple_of(TURNED_MS));
        let edges = [left + turned(l), right + turned(r)];
        for (all, edges) in self.at_pins.edges.iter_mut().zip(edges) {
            *all += u64::from(edges);
        }
        self.pins.edges = edges.map(|edges| u8::try_from(edges).unwrap_or(u8::MAX));
        let step = self.emulator.step(&self.pins, received)?;
        self.follow(&step)?;
        self.hear(&step);
        if !self.has_ticked && step.traced.contains(&sr04_replay::TICK) {
            self.has_ticked = true;
            self.phase_ms = (self.now_ms + TICK_MS - 1) % TICK_MS;
        }
        self.mirror.take(step.traced, self.at_pins);
        if let Some(after) = step.traced_after_reset {
            self.mirror.reset();
            self.sent.push(Vec::new());
            self.mirror.take(after, self.at_pins);
            self.forget();
        }
        Ok(step.sent)
    }

    /// Runs for a time without bytes from the radio.
    pub(crate) fn run_ms(&mut self, ms: u64) -> Result<(), String> {
        for _ in 0..ms {
            self.step(&[])?;
        }
        Ok(())
    }

    /// Forgets the program that has run until now: it hangs or another boot follows.
    pub(crate) fn forget(&mut self) {
        self.ack = None;
        self.has_ticked = false;
    }

    fn hear(&mut self, step: &Step) {
        if let Some(sent) = self.sent.last_mut() {
            sent.extend(&step.sent);
        }
        for received in self.decoder.lines(&step.sent) {
            match received {
                Received::Line(line, _) => {
                    self.ack = Some(line.ack);
                    self.lines.push((self.now_ms, line));
                }
                Received::Ack(line) => self.ack = Some(line.ack),
            }
        }
        self.awake_cycles += u64::from(step.awake_cycles);
        self.all_cycles += u64::from(step.awake_cycles);
    }

    /// Puts the world at the pins, as the board's drivers and dividers do.
    fn set_pins(&mut self) {
        let mut inputs = self.plant.inputs();
        (self.hand.on_sensors)(&mut inputs);
        // A world without a dock has no beacon.
        inputs.beacon.get_or_insert_default();
        let [latest, _] = self.at_pins.sensors;
        self.at_pins.sensors = [inputs, latest];
        let bits = |levels: &[(bool, u8)]| {
            levels
                .iter()
                .fold(0, |bits, &(level, bit)| bits | u8::from(level) << bit)
        };
        let motion = inputs.motion.unwrap_or_default();
        let beacon = inputs.beacon.unwrap_or_default();
        let pins = &mut self.pins;
        pins.port_c = inputs.cliff.map_or(0, Edges::bits);
        pins.port_l = !bits(&[
            (inputs.bumper.left, 2),
            (inputs.bumper.center, 3),
            (inputs.bumper.right, 4),
            (inputs.top_hat, 5),
        ]);
        pins.port_k = pins.port_k & 0b11
            | bits(&[
                (motion.left, 2),
                (motion.right, 3),
                (!beacon.left, 4),
                (!beacon.right, 5),
                (inputs.is_docked, 6),
            ]);
        let photo_mv = |reading: Option<u8>| {
            let tenbit = u32::from(reading.unwrap_or_default()) * 4 + 2;
            (tenbit * FULL_MV / 1023) as u16
        };
        let battery_mv = u16::from(inputs.battery_dv) * 100 / 3;
        pins.analog_mv = [
            photo_mv(inputs.photo_left),
            photo_mv(inputs.photo_right),
            battery_mv,
        ];
    }

    /// Moves the world by the board's outputs.
    fn follow(&mut self, step: &Step) -> Result<(), String> {
        let width = |side: usize| {
            let width = i16::from(step.widths[side]);
            match step.port_a >> (2 * side) & 0b11 {
                0b01 => Ok(width),
                0b10 => Ok(-width),
                0 => Ok(0),
                _ => Err("a motor is driven both ways".to_owned()),
            }
        };
        let (pwm_left, pwm_right) = (width(0)?, width(1)?);
        self.drives = pwm_left != 0 || pwm_right != 0;
        self.at_pins.now_ms = self.now_ms;
        self.at_pins.is_reset = step.traced_after_reset.is_some();
        self.at_pins.widths = [pwm_left, pwm_right];
        self.at_pins.tone_hz = step.tone_hz;
        self.at_pins.servo_us = step.servo_us;
        self.plant.apply(Outputs {
            pwm_left,
            pwm_right,
            ping: None,
            note_hz: step.tone_hz,
            arm_up: step.servo_us >= UP_US,
            keep_parameters: false,
        });
        for (number, side) in [Side::Left, Side::Right].into_iter().enumerate() {
            if step.pinged[number] {
                let range_in = self.plant.ping(side);
                let length_us =
                    range_in.map_or(NO_ECHO_US, |range_in| u32::from(range_in) * ECHO_US_PER_IN);
                let echo = Echo::after_us(side, Some(length_us));
                let [latest, _] = self.at_pins.pings;
                self.at_pins.pings = [Some((self.now_ms, echo)), latest];
                self.emulator.echo(number as u8, length_us)?;
            }
        }
        let leds_on = CARRIER_HZ.contains(&step.carrier_hz);
        if leds_on != self.leds_on || self.now_ms.is_multiple_of(SAMPLE_MS) {
            self.leds_on = leds_on;
            let (left, right) = self.plant.infrared(leds_on);
            let mut seen = Sides { left, right };
            if leds_on {
                seen = seen.or(self.hand.before);
            }
            self.pins.port_k =
                self.pins.port_k & !0b11 | u8::from(!seen.left) | u8::from(!seen.right) << 1;
        }
        Ok(())
    }

    /// Distance driven.
    pub(crate) fn path_in(&self) -> f64 {
        self.plant.truth().path_in
    }

    /// Lines whose body is of one kind, with their times.
    pub(crate) fn bodies<T>(&self, of: impl Fn(&Body) -> Option<T>) -> Vec<T> {
        self.lines
            .iter()
            .filter_map(|(_, line)| of(&line.body))
            .collect()
    }

    /// Ends the run; an error if the chip and the host differ.
    pub(crate) fn finish(mut self) -> Result<Figures, String> {
        let figures = self.emulator.figures()?;
        let late_ticks = self
            .bodies(|body| match body {
                Body::Counters(counters) => Some(counters.ticks_late),
                _ => None,
            })
            .into_iter()
            .max()
            .unwrap_or_default();
        let found = self.mirror.finish()?;
        for (boot, (sent, expected)) in self.sent.iter().zip(&found.sent).enumerate() {
            // The newest byte may still be in the chip.
            if !expected.starts_with(sent) || expected.len() > sent.len() + 2 {
                return Err(format!(
                    "boot {boot}: the radio got {} bytes that are not the host's {}",
                    sent.len(),
                    expected.len()
                ));
            }
        }
        if found.sent.len() != self.sent.len() {
            return Err(format!(
                "{} resets, not {}",
                found.sent.len() - 1,
                self.sent.len() - 1
            ));
        }
        Ok(Figures {
            calls: found.calls,
            downlink: self.sent.concat(),
            mean_tick_cycles: self.all_cycles * TICK_MS / self.now_ms.max(1),
            worst_tick_cycles: self.worst_cycles,
            late_ticks: found.late_ticks.max(usize::from(late_ticks)),
            stack_bytes: usize::from(figures.stack_bytes),
            spare_bytes: usize::from(figures.spare_bytes),
        })
    }
}
