//! Calls of the robot's program as bytes. A host records the calls of a run; a chip reads them from a [`Port`],
//! repeats them and writes every result, which must equal the host's byte for byte.
#![no_std]

use core::mem::MaybeUninit;

use groundwave_protocol::status_codes::LayerMask;
use sr04_firmware::board::{
    Duplex, Echo, Edges, Identity, Inputs, Outputs, Restart, Side, Sides, Switches,
};
use sr04_firmware::parameters::{Parameter, Parameters};
use sr04_firmware::robot::Robot;

/// First byte of [`Call::Boot`].
pub const BOOT: u8 = b'B';
/// First byte of [`Call::Tick`].
pub const TICK: u8 = b'T';
const INFRARED: u8 = b'I';
const UPLINK: u8 = b'U';
/// The byte of [`Call::Downlink`].
pub const DOWNLINK: u8 = b'D';

/// A stream of bytes in both directions.
pub trait Port {
    /// The next byte of the calls.
    fn read(&mut self) -> u8;

    /// Takes a byte of the results.
    fn write(&mut self, byte: u8);
}

/// A call of the robot's program.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Call<'a> {
    /// Power-on with these kept parameters.
    Boot(Identity, &'a Parameters),
    /// A call of [`Robot::tick`].
    Tick(&'a Inputs),
    /// A call of [`Robot::infrared_sample`].
    Infrared(Sides),
    /// A call of [`Robot::handle_uplink`].
    Uplink(u8),
    /// A call of [`Robot::poll_downlink`].
    Downlink,
}

impl Call<'_> {
    /// Writes the call's bytes.
    pub fn write(&self, port: &mut impl Port) {
        match *self {
            Self::Boot(identity, parameters) => {
                port.write(BOOT);
                port.write(identity.robot_id);
                write_pair(port, identity.boots);
                write_pair(port, identity.rng_seed as u16);
                write_pair(port, (identity.rng_seed >> 16) as u16);
                port.write(match identity.duplex {
                    Duplex::Full => 0,
                    Duplex::Half { patience_bytes } => patience_bytes,
                });
                port.write(identity.fitted.bits());
                port.write(identity.restart as u8);
                write_parameters(port, parameters);
            }
            Self::Tick(inputs) => {
                port.write(TICK);
                write_inputs(port, inputs);
            }
            Self::Infrared(seen) => {
                port.write(INFRARED);
                port.write(bits_of_sides(seen));
            }
            Self::Uplink(byte) => {
                port.write(UPLINK);
                port.write(byte);
            }
            Self::Downlink => port.write(DOWNLINK),
        }
    }
}

/// Repeats calls forever. The first call must be a boot.
pub fn repeat(place: &mut MaybeUninit<Robot>, port: &mut impl Port) -> ! {
    // The kind of the first call.
    port.read();
    loop {
        let robot = boot(place, port);
        while perform(robot, port) {}
    }
}

/// Reads the bytes of a boot after the first and creates the robot in its place. A separate function keeps a second robot off the caller's stack.
#[inline(never)]
pub fn boot<'a>(place: &'a mut MaybeUninit<Robot>, port: &mut impl Port) -> &'a mut Robot {
    let identity = Identity {
        robot_id: port.read(),
        boots: read_pair(port),
        rng_seed: u32::from(read_pair(port)) | u32::from(read_pair(port)) << 16,
        duplex: match port.read() {
            0 => Duplex::Full,
            patience_bytes => Duplex::Half { patience_bytes },
        },
        fitted: LayerMask::from_bits(port.read()),
        restart: match port.read() {
            0 => Restart::PowerOn,
            1 => Restart::BrownOut,
            2 => Restart::Watchdog,
            _ => Restart::Panic,
        },
    };
    let mut parameters = Parameters::DEFAULT;
    for &parameter in Parameter::ALL {
        parameters.set(parameter, read_pair(port) as i16);
    }
    place.write(Robot::restored(identity, parameters))
}

/// Repeats one call and writes its result; returns `false` if the call is a boot.
pub fn perform(robot: &mut Robot, port: &mut impl Port) -> bool {
    match port.read() {
        BOOT => return false,
        TICK => tick(robot, port),
        INFRARED => {
            let seen = sides(port.read());
            let leds_on = robot.infrared_sample(seen.left, seen.right);
            write_leds(port, leds_on);
        }
        UPLINK => robot.handle_uplink(port.read()),
        _ => {
            let byte = robot.poll_downlink();
            write_downlink(port, byte);
        }
    }
    true
}

#[inline(never)]
fn tick(robot: &mut Robot, port: &mut impl Port) {
    let outputs = robot.tick(&read_inputs(port));
    write_outputs(port, outputs, robot.parameters());
}

/// Writes the result of [`Call::Tick`]: the outputs, and the parameters if the board must keep them.
pub fn write_outputs(port: &mut impl Port, outputs: Outputs, parameters: &Parameters) {
    write_pair(port, outputs.pwm_left as u16);
    write_pair(port, outputs.pwm_right as u16);
    write_pair(port, outputs.note_hz);
    let ping = match outputs.ping {
        None => 0,
        Some(Side::Left) => 1,
        Some(Side::Right) => 2,
    };
    port.write(ping | u8::from(outputs.arm_up) << 2 | u8::from(outputs.keep_parameters) << 3);
    if outputs.keep_parameters {
        write_parameters(port, parameters);
    }
}

/// Reads the outputs that [`write_outputs`] wrote.
pub fn read_outputs(port: &mut impl Port) -> Outputs {
    let (pwm_left, pwm_right) = (read_pair(port) as i16, read_pair(port) as i16);
    let note_hz = read_pair(port);
    let flags = port.read();
    Outputs {
        pwm_left,
        pwm_right,
        note_hz,
        ping: match flags & 3 {
            1 => Some(Side::Left),
            2 => Some(Side::Right),
            _ => None,
        },
        arm_up: flags & 4 != 0,
        keep_parameters: flags & 8 != 0,
    }
}

/// Writes the result of [`Call::Infrared`].
pub fn write_leds(port: &mut impl Port, leds_on: bool) {
    port.write(u8::from(leds_on));
}

/// Writes the result of [`Call::Downlink`]: the number of bytes, 0 for an idle line, and the byte.
pub fn write_downlink(port: &mut impl Port, byte: Option<u8>) {
    port.write(u8::from(byte.is_some()));
    if let Some(byte) = byte {
        port.write(byte);
    }
}

fn write_parameters(port: &mut impl Port, parameters: &Parameters) {
    for &parameter in Parameter::ALL {
        write_pair(port, parameters.get(parameter) as u16);
    }
}

fn write_inputs(port: &mut impl Port, inputs: &Inputs) {
    write_pair(port, inputs.counts_left);
    write_pair(port, inputs.counts_right);
    let bumper = inputs.bumper;
    let flags = [
        bumper.left,
        bumper.center,
        bumper.right,
        inputs.top_hat,
        inputs.is_docked,
        inputs.is_late,
    ];
    port.write(bits(&flags));
    match inputs.sonar {
        None => port.write(0),
        Some(echo) => {
            let is_right = echo.side == Side::Right;
            port.write(bits(&[true, is_right, echo.range_in.is_some()]));
            write_pair(port, echo.range_in.unwrap_or_default());
        }
    }
    for reading in [
        inputs.photo_left,
        inputs.photo_right,
        Some(inputs.battery_dv),
        inputs.cliff.map(Edges::bits),
        inputs.motion.map(bits_of_sides),
        inputs.beacon.map(bits_of_sides),
    ] {
        port.write(u8::from(reading.is_some()));
        port.write(reading.unwrap_or_default());
    }
}

/// Reads the inputs of [`Call::Tick`].
pub fn read_inputs(port: &mut impl Port) -> Inputs {
    let (counts_left, counts_right) = (read_pair(port), read_pair(port));
    let flags = port.read();
    let flag = |bit: u8| flags >> bit & 1 != 0;
    let echo = port.read();
    let sonar = (echo != 0).then(|| {
        let range_in = read_pair(port);
        Echo {
            side: if echo & 2 == 0 {
                Side::Left
            } else {
                Side::Right
            },
            range_in: (echo & 4 != 0).then_some(range_in),
        }
    });
    Inputs {
        counts_left,
        counts_right,
        bumper: Switches {
            left: flag(0),
            center: flag(1),
            right: flag(2),
        },
        sonar,
        photo_left: read_reading(port),
        photo_right: read_reading(port),
        battery_dv: read_reading(port).unwrap_or_default(),
        cliff: read_reading(port).map(Edges::from_bits),
        motion: read_reading(port).map(sides),
        top_hat: flag(3),
        beacon: read_reading(port).map(sides),
        is_docked: flag(4),
        is_late: flag(5),
    }
}

fn read_reading(port: &mut impl Port) -> Option<u8> {
    let is_fitted = port.read() != 0;
    let reading = port.read();
    is_fitted.then_some(reading)
}

fn bits_of_sides(sides: Sides) -> u8 {
    bits(&[sides.left, sides.right])
}

fn sides(bits: u8) -> Sides {
    Sides {
        left: bits & 1 != 0,
        right: bits & 2 != 0,
    }
}

/// The flags as bits, the first one in bit 0.
fn bits(flags: &[bool]) -> u8 {
    flags
        .iter()
        .rev()
        .fold(0, |bits, &flag| bits << 1 | u8::from(flag))
}

fn write_pair(port: &mut impl Port, word: u16) {
    for byte in word.to_le_bytes() {
        port.write(byte);
    }
}

fn read_pair(port: &mut impl Port) -> u16 {
    u16::from_le_bytes([port.read(), port.read()])
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use groundwave_protocol::status_codes::Layer;
    use std::collections::VecDeque;

    impl Port for VecDeque<u8> {
        fn read(&mut self) -> u8 {
            self.pop_front().unwrap()
        }

        fn write(&mut self, byte: u8) {
            self.push_back(byte);
        }
    }

    #[test]
    fn outputs_survive_their_bytes() {
        let all = Outputs {
            pwm_left: -255,
            pwm_right: 17,
            ping: Some(Side::Right),
            note_hz: 0x1234,
            arm_up: true,
            keep_parameters: true,
        };
        let none = Outputs::default();
        let left = Outputs {
            ping: Some(Side::Left),
            ..none
        };
        for outputs in [all, none, left] {
            let mut bytes = VecDeque::new();
            write_outputs(&mut bytes, outputs, &Parameters::DEFAULT);
            assert_eq!(read_outputs(&mut bytes), outputs);
        }
    }

    #[test]
    fn inputs_survive_their_bytes() {
        let all = Inputs {
            counts_left: 0x1234,
            counts_right: 1,
            bumper: Switches {
                left: true,
                center: false,
                right: true,
            },
            sonar: Some(Echo {
                side: Side::Right,
                range_in: Some(419),
            }),
            photo_left: Some(255),
            photo_right: Some(0),
            battery_dv: 128,
            cliff: Some(Edges::FRONT),
            motion: Some(Sides {
                left: false,
                right: true,
            }),
            top_hat: true,
            beacon: Some(Sides {
                left: true,
                right: false,
            }),
            is_docked: true,
            is_late: true,
        };
        let silent = Echo {
            side: Side::Left,
            range_in: None,
        };
        let others = [
            Inputs::default(),
            Inputs {
                sonar: Some(silent),
                ..all
            },
            all,
        ];
        let mut port = VecDeque::new();
        for inputs in others {
            write_inputs(&mut port, &inputs);
            assert_eq!(read_inputs(&mut port), inputs);
            assert!(port.is_empty());
        }
    }

    #[test]
    fn a_boot_from_bytes_equals_a_boot() {
        let identity = Identity {
            robot_id: 4,
            boots: 0x1234,
            rng_seed: 0x8765_4321,
            duplex: Duplex::Half { patience_bytes: 16 },
            fitted: LayerMask::ALL.without(Layer::Infrared),
            restart: Restart::Panic,
        };
        let mut parameters = Parameters::DEFAULT;
        assert!(parameters.set(Parameter::Square, -300));
        let mut port = VecDeque::new();
        Call::Boot(identity, &parameters).write(&mut port);
        assert_eq!(port.read(), BOOT);
        let mut place = MaybeUninit::uninit();
        let robot = boot(&mut place, &mut port);
        let direct = Robot::restored(identity, parameters);
        assert_eq!(std::format!("{robot:?}"), std::format!("{direct:?}"));
        Call::Boot(identity, &Parameters::DEFAULT).write(&mut port);
        assert!(!perform(robot, &mut port), "a boot ends the robot");
    }
}
