//! Links the robot's whole program for an ATmega2560, to measure its share of the chip's 8 KB of RAM.
//!
//! It calls every entry point, reads every input from a register and writes every output to one, so that nothing is
//! optimised away. It has no timers and no interrupts and cannot drive a robot.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

mod multiply;

use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

use sr04_firmware::board::{Duplex, Echo, Edges, Identity, Inputs, Side, Sides, Switches};
use sr04_firmware::parameters::Parameter;
use sr04_firmware::robot::Robot;

/// Input register of port A, in place of every sensor.
const PIN_A: *const u8 = 0x20 as *const u8;

/// Output register of port C, in place of every actuator.
const PORT_C: *mut u8 = 0x28 as *mut u8;

/// Data register of USART 0.
const USART_0: *mut u8 = 0xC6 as *mut u8;

/// A static for the robot, so that `avr-size` counts it; on the stack it would not be counted.
struct Place(core::cell::UnsafeCell<MaybeUninit<Robot>>);

// SAFETY: the chip has one core, and no interrupt is ever enabled.
unsafe impl Sync for Place {}

static PLACE: Place = Place(core::cell::UnsafeCell::new(MaybeUninit::uninit()));

fn read() -> u8 {
    // SAFETY: a readable register of this chip.
    unsafe { read_volatile(PIN_A) }
}

fn read_pair() -> u16 {
    u16::from_le_bytes([read(), read()])
}

fn write(byte: u8) {
    // SAFETY: a writable register of this chip.
    unsafe { write_volatile(PORT_C, byte) }
}

fn write_pair(word: u16) {
    for byte in word.to_le_bytes() {
        write(byte);
    }
}

fn receive() -> u8 {
    // SAFETY: a readable register of this chip.
    unsafe { read_volatile(USART_0) }
}

fn send(byte: u8) {
    // SAFETY: a writable register of this chip.
    unsafe { write_volatile(USART_0, byte) }
}

/// Entry point, called by the start-up code of avr-libc.
#[unsafe(no_mangle)]
pub extern "C" fn main() -> ! {
    // SAFETY: `main` is entered once, so this is the only reference to `PLACE`.
    let robot = switch_on(unsafe { &mut *PLACE.0.get() });
    loop {
        let outputs = robot.tick(&inputs());
        for pwm in [outputs.pwm_left, outputs.pwm_right] {
            write_pair(pwm as u16);
        }
        write_pair(outputs.note_hz);
        write(u8::from(outputs.arm_up));
        if outputs.keep_parameters {
            for &parameter in Parameter::ALL {
                write_pair(robot.parameters().get(parameter) as u16);
            }
        }
        write(match outputs.ping {
            None => 0,
            Some(Side::Left) => 1,
            Some(Side::Right) => 2,
        });
        let samples = read();
        write(u8::from(
            robot.infrared_sample(samples & 1 != 0, samples & 2 != 0),
        ));
        robot.handle_uplink(receive());
        if let Some(byte) = robot.poll_downlink() {
            send(byte);
        }
    }
}

/// Creates the robot in its static. A separate function keeps a second robot off the main loop's stack.
#[inline(never)]
fn switch_on(place: &mut MaybeUninit<Robot>) -> &mut Robot {
    let duplex = match read() {
        0 => Duplex::Full,
        patience_bytes => Duplex::Half { patience_bytes },
    };
    let seed = u32::from(read_pair());
    place.write(Robot::new(Identity::new(read(), read_pair(), seed, duplex)))
}

fn inputs() -> Inputs {
    let switches = read();
    Inputs {
        counts_left: read_pair(),
        counts_right: read_pair(),
        bumper: Switches {
            left: switches & 1 != 0,
            center: switches & 2 != 0,
            right: switches & 4 != 0,
        },
        sonar: (switches & 8 != 0).then(|| Echo {
            side: if switches & 16 == 0 {
                Side::Left
            } else {
                Side::Right
            },
            range_in: Some(read_pair()),
        }),
        photo_left: Some(read()),
        photo_right: Some(read()),
        battery_dv: read(),
        cliff: Some(edges()),
        motion: Some(sides()),
        top_hat: switches & 64 != 0,
        beacon: Some(sides()),
        is_docked: switches & 128 != 0,
        is_late: switches & 32 != 0,
    }
}

fn sides() -> Sides {
    let bits = read();
    Sides {
        left: bits & 1 != 0,
        right: bits & 2 != 0,
    }
}

fn edges() -> Edges {
    Edges::from_bits(read())
}

/// Stops the robot. Using the argument would link `core::fmt`, which this target miscompiles.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        write(0);
    }
}
