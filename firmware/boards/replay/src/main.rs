//! Repeats recorded calls of the robot's program on an emulated `ATmega2560`.
//!
//! The emulator feeds the calls through one general-purpose register and takes the results from another. No pin and no
//! interrupt is used, so each difference from the host is a fault of the compiler.
#![no_std]
#![no_main]
#![feature(asm_experimental_arch)]

#[path = "../../probe/src/multiply.rs"]
mod multiply;

use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

use sr04_firmware::robot::Robot;
use sr04_replay::Port;

/// GPIOR0: the emulator's next byte.
const CALLS: *const u8 = 0x3E as *const u8;

/// GPIOR1: a byte to the emulator.
const RESULTS: *mut u8 = 0x4A as *mut u8;

/// GPIOR2: a write ends the run.
const PANIC: *mut u8 = 0x4B as *mut u8;

/// A static for the robot, so that `avr-size` counts it; on the stack it would not be counted.
struct Place(UnsafeCell<MaybeUninit<Robot>>);

// SAFETY: the chip has one core, and no interrupt is ever enabled.
unsafe impl Sync for Place {}

static PLACE: Place = Place(UnsafeCell::new(MaybeUninit::uninit()));

struct Registers;

impl Port for Registers {
    fn read(&mut self) -> u8 {
        // SAFETY: a readable register of this chip.
        unsafe { read_volatile(CALLS) }
    }

    fn write(&mut self, byte: u8) {
        // SAFETY: a writable register of this chip.
        unsafe { write_volatile(RESULTS, byte) }
    }
}

/// Entry point, called by the start-up code of avr-libc.
#[unsafe(no_mangle)]
pub extern "C" fn main() -> ! {
    // SAFETY: `main` is entered once, so this is the only reference to `PLACE`.
    let place = unsafe { &mut *PLACE.0.get() };
    sr04_replay::repeat(place, &mut Registers)
}

/// Ends the run. Using the argument would link `core::fmt`, which this target miscompiles.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        // SAFETY: a writable register of this chip.
        unsafe { write_volatile(PANIC, 1) }
    }
}
