//! Repeats recorded calls of the robot's program on a micro:bit (Cortex-M0) in QEMU.
//!
//! Semihosting reads the file `calls` of QEMU's folder and writes the file `results`. At the end of the calls it prints
//! the bytes of stack used.
#![no_std]
#![no_main]

use core::arch::{asm, global_asm};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{addr_of, addr_of_mut};

use sr04_firmware::robot::Robot;
use sr04_replay::Port;

// Copies the initial values, clears the rest, paints the stack and calls `main`.
global_asm!(
    ".section .vectors, \"a\"",
    ".word reset + 1",
    ".rept 14",
    ".word fault + 1",
    ".endr",
    ".section .text.reset, \"ax\"",
    ".global reset",
    ".thumb_func",
    "reset:",
    "ldr r0, =data_begin",
    "ldr r1, =data_end",
    "ldr r2, =data_source",
    "b 2f",
    "1: ldr r3, [r2]",
    "str r3, [r0]",
    "adds r0, #4",
    "adds r2, #4",
    "2: cmp r0, r1",
    "blo 1b",
    "ldr r0, =bss_begin",
    "ldr r1, =bss_end",
    "movs r3, #0",
    "b 4f",
    "3: str r3, [r0]",
    "adds r0, #4",
    "4: cmp r0, r1",
    "blo 3b",
    "ldr r1, =stack_top",
    "ldr r3, =0xC5C5C5C5",
    "b 6f",
    "5: str r3, [r0]",
    "adds r0, #4",
    "6: cmp r0, r1",
    "blo 5b",
    "bl main",
    ".thumb_func",
    "fault:",
    "bl fault_handler",
);

/// Byte that fills the stack before the program starts.
const PAINT: u8 = 0xC5;

/// Operations of Arm's semihosting.
const OPEN: usize = 0x01;
const WRITE_TEXT: usize = 0x04;
const WRITE: usize = 0x05;
const READ: usize = 0x06;
const EXIT: usize = 0x18;

/// Reason for [`EXIT`] for a program that has ended as intended.
const APPLICATION_EXIT: usize = 0x2_0026;

/// Reason for [`EXIT`] after a fault.
const INTERNAL_ERROR: usize = 0x2_0024;

/// Modes of [`OPEN`]: read and write in binary.
const READ_BINARY: usize = 1;
const WRITE_BINARY: usize = 5;

const BUFFER_BYTES: usize = 256;

unsafe extern "C" {
    static mut bss_end: u8;
    static mut stack_top: u8;
}

static mut PLACE: MaybeUninit<Robot> = MaybeUninit::uninit();

/// Calls the debugger, which is QEMU.
fn semihost(operation: usize, argument: usize) -> usize {
    let result;
    // SAFETY: every caller passes the arguments of its operation.
    unsafe {
        asm!("bkpt #0xAB", inout("r0") operation => result, in("r1") argument);
    }
    result
}

fn open(name: &[u8], mode: usize) -> usize {
    let arguments = [name.as_ptr() as usize, mode, name.len() - 1];
    semihost(OPEN, arguments.as_ptr() as usize)
}

struct Files {
    calls: usize,
    results: usize,
    read: [u8; BUFFER_BYTES],
    /// Next byte of `read`, and end of the bytes in it.
    next: usize,
    end: usize,
    written: [u8; BUFFER_BYTES],
    /// End of the bytes in `written`.
    length: usize,
}

impl Files {
    fn flush(&mut self) {
        let arguments = [self.results, self.written.as_ptr() as usize, self.length];
        semihost(WRITE, arguments.as_ptr() as usize);
        self.length = 0;
    }
}

impl Port for Files {
    fn read(&mut self) -> u8 {
        if self.next == self.end {
            let arguments = [self.calls, self.read.as_mut_ptr() as usize, BUFFER_BYTES];
            let missing = semihost(READ, arguments.as_ptr() as usize);
            (self.next, self.end) = (0, BUFFER_BYTES - missing.min(BUFFER_BYTES));
            if self.end == 0 {
                self.flush();
                print_stack();
                semihost(EXIT, APPLICATION_EXIT);
            }
        }
        let byte = self.read[self.next % BUFFER_BYTES];
        self.next += 1;
        byte
    }

    fn write(&mut self, byte: u8) {
        self.written[self.length % BUFFER_BYTES] = byte;
        self.length += 1;
        if self.length == BUFFER_BYTES {
            self.flush();
        }
    }
}

/// Prints `stack USED SPARE`, in bytes.
fn print_stack() {
    let (bottom, top) = (addr_of!(bss_end) as usize, addr_of!(stack_top) as usize);
    let mut lowest = bottom;
    // SAFETY: the bytes from `bss_end` to `stack_top` are the painted stack.
    while lowest < top && unsafe { (lowest as *const u8).read_volatile() } == PAINT {
        lowest += 1;
    }
    print(b"stack \0");
    print_number(top - lowest);
    print(b" \0");
    print_number(lowest - bottom);
    print(b"\n\0");
}

fn print(text: &[u8]) {
    semihost(WRITE_TEXT, text.as_ptr() as usize);
}

fn print_number(number: usize) {
    let mut digits = [b'0', b'0', b'0', b'0', b'0', 0];
    let mut rest = number;
    for digit in digits.iter_mut().rev().skip(1) {
        *digit += (rest % 10) as u8;
        rest /= 10;
    }
    print(&digits);
}

/// Called by the start-up code.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let mut files = Files {
        calls: open(b"calls\0", READ_BINARY),
        results: open(b"results\0", WRITE_BINARY),
        read: [0; BUFFER_BYTES],
        next: 0,
        end: 0,
        written: [0; BUFFER_BYTES],
        length: 0,
    };
    // SAFETY: `main` is entered once, so this is the only reference to `PLACE`.
    let place = unsafe { &mut *addr_of_mut!(PLACE) };
    sr04_replay::repeat(place, &mut files)
}

#[unsafe(no_mangle)]
extern "C" fn fault_handler() -> ! {
    loop {
        print(b"fault\n\0");
        semihost(EXIT, INTERNAL_ERROR);
    }
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    loop {
        print(b"panic\n\0");
        semihost(EXIT, INTERNAL_ERROR);
    }
}
