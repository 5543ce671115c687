//! The chip: its registers, its interrupts and the memory that interrupts share with the program. All `unsafe` code of
//! this board is here. Addresses are those of the ATmega2560's data space.

use core::arch::asm;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::ptr::{addr_of, addr_of_mut};

use sr04_firmware::board::{Restart, Side};
use sr04_firmware::robot::Robot;

use crate::Board;

/// A register of one byte.
#[derive(Clone, Copy)]
pub struct Register(u16);

impl Register {
    /// The register's value.
    pub fn read(self) -> u8 {
        // SAFETY: every `Register` below is the address of a readable register of this chip.
        unsafe { (self.0 as *const u8).read_volatile() }
    }

    /// Writes the register. Motors, memory safety and the stack depend on none of the registers below.
    pub fn write(self, value: u8) {
        // SAFETY: every `Register` below is the address of a writable register of this chip, and none is a pointer.
        unsafe { (self.0 as *mut u8).write_volatile(value) }
    }

    /// Sets and clears bits; interrupts change none of the registers for which this is called.
    pub fn change(self, clear: u8, set: u8) {
        self.write(self.read() & !clear | set);
    }
}

/// A register of two bytes, behind a buffer that all of them share.
#[derive(Clone, Copy)]
pub struct Pair(u16);

impl Pair {
    /// The register's value.
    pub fn read(self) -> u16 {
        without_interrupts(|| {
            // The low byte first: it fills the buffer.
            let low = Register(self.0).read();
            u16::from_le_bytes([low, Register(self.0 + 1).read()])
        })
    }

    /// Writes the register.
    pub fn write(self, value: u16) {
        let [low, high] = value.to_le_bytes();
        without_interrupts(|| {
            // The high byte first: it waits in the buffer.
            Register(self.0 + 1).write(high);
            Register(self.0).write(low);
        });
    }
}

/// A port of eight pins: inputs, directions and outputs.
#[derive(Clone, Copy)]
pub struct Pins {
    /// Levels of the pins.
    pub input: Register,
    /// Pins that are outputs.
    pub direction: Register,
    /// Levels of the outputs, and pull-ups of the inputs.
    pub output: Register,
}

const fn pins(address: u16) -> Pins {
    Pins {
        input: Register(address),
        direction: Register(address + 1),
        output: Register(address + 2),
    }
}

/// D22 to D29 are bits 0 to 7.
pub const A: Pins = pins(0x20);
/// D50 to D53 are bits 3 to 0, D10 to D13 bits 4 to 7.
pub const B: Pins = pins(0x23);
/// D37 to D30 are bits 0 to 7.
pub const C: Pins = pins(0x26);
/// D2, D3 and D5 are bits 4, 5 and 3.
pub const E: Pins = pins(0x2C);
/// D4 is bit 5.
pub const G: Pins = pins(0x32);
#[cfg(feature = "lcd")]
/// D16 and D17 are bits 1 and 0, D6 to D9 bits 3 to 6.
pub const H: Pins = pins(0x100);
/// A8 to A15 are bits 0 to 7.
pub const K: Pins = pins(0x106);
/// D49 to D42 are bits 0 to 7.
pub const L: Pins = pins(0x109);

const EIFR: Register = Register(0x3C);
const EIMSK: Register = Register(0x3D);
const EEDR: Register = Register(0x40);
const EECR: Register = Register(0x3F);
const EEAR: Pair = Pair(0x41);
/// Timer 0: the beeper.
pub const TCCR0A: Register = Register(0x44);
/// Clock of timer 0.
pub const TCCR0B: Register = Register(0x45);
/// Top of timer 0.
pub const OCR0A: Register = Register(0x47);
const GPIOR1: Register = Register(0x4A);
const SMCR: Register = Register(0x53);
const MCUSR: Register = Register(0x54);
const EICRB: Register = Register(0x6A);
const TIMSK4: Register = Register(0x72);
const TIMSK5: Register = Register(0x73);
/// Result of the converter.
pub const ADC: Pair = Pair(0x78);
/// Control of the converter.
pub const ADCSRA: Register = Register(0x7A);
/// Channel and reference of the converter.
pub const ADMUX: Register = Register(0x7C);
/// Timer 1: the motors.
pub const TCCR1A: Register = Register(0x80);
/// Clock of timer 1.
pub const TCCR1B: Register = Register(0x81);
/// Left pulse width.
pub const OCR1A: Pair = Pair(0x88);
/// Right pulse width.
pub const OCR1B: Pair = Pair(0x8A);
/// Timer 3: the servo.
pub const TCCR3A: Register = Register(0x90);
/// Clock of timer 3.
pub const TCCR3B: Register = Register(0x91);
/// Top of timer 3.
pub const ICR3: Pair = Pair(0x96);
/// The servo's pulse.
pub const OCR3A: Pair = Pair(0x98);
const TIFR4: Register = Register(0x39);
const TIFR5: Register = Register(0x3A);
const TCCR4A: Register = Register(0xA0);
const TCCR4B: Register = Register(0xA1);
const TCNT4: Pair = Pair(0xA4);
const ICR4: Pair = Pair(0xA6);
const OCR4A: Pair = Pair(0xA8);
/// Timer 2: the infrared LEDs' carrier.
pub const TCCR2A: Register = Register(0xB0);
/// Clock of timer 2.
pub const TCCR2B: Register = Register(0xB1);
/// Top of timer 2.
pub const OCR2A: Register = Register(0xB3);
const UCSR1A: Register = Register(0xC8);
const UCSR1B: Register = Register(0xC9);
const UCSR1C: Register = Register(0xCA);
const UBRR1: Pair = Pair(0xCC);
const UDR1: Register = Register(0xCE);
const TCCR5A: Register = Register(0x120);
const TCCR5B: Register = Register(0x121);
const ICR5: Pair = Pair(0x126);

/// Bits of the timers' control registers.
const CAPTURES_RISE: u8 = 1 << 6;
const CANCELS_NOISE: u8 = 1 << 7;
const PRESCALER_64: u8 = 3;
/// Bits of the timers' interrupts.
const ON_CAPTURE: u8 = 1 << 5;
const ON_A: u8 = 1 << 1;

/// Cycles of timers 4 and 5 per count.
pub const CYCLES_PER_COUNT: u32 = 64;

/// Counts per period of the program's clock.
const COUNTS_PER_BASE: u16 =
    (crate::CLOCK_HZ / CYCLES_PER_COUNT / sr04_firmware::board::BASE_HZ) as u16;

/// Bits of the serial port's registers.
const DOUBLE_SPEED: u8 = 1 << 1;
const DATA_EMPTY: u8 = 1 << 5;
const ON_RECEIVED: u8 = 1 << 7;
const RECEIVES_AND_SENDS: u8 = 0b0001_1000;
const EIGHT_BITS: u8 = 0b110;

/// Bits of the EEPROM's control register.
const WRITES: u8 = 1 << 1;
const READS: u8 = 1;

/// Bits of the reset's reasons.
const WATCHDOG_RESET: u8 = 1 << 3;
const BROWN_OUT_RESET: u8 = 1 << 2;
const POWER_ON_RESET: u8 = 1;

/// Memory that interrupts share with the program.
struct Shared<T>(UnsafeCell<T>);

// SAFETY: the chip has one core, and every access is made with interrupts off.
unsafe impl<T> Sync for Shared<T> {}

impl<T: Copy> Shared<T> {
    const fn new(value: T) -> Self {
        Self(UnsafeCell::new(value))
    }

    fn change<R>(&self, with: impl FnOnce(&mut T) -> R) -> R {
        // SAFETY: interrupts are off, no closure below calls `change` on the same memory, and no reference leaves it.
        without_interrupts(|| with(unsafe { &mut *self.0.get() }))
    }

    fn get(&self) -> T {
        self.change(|value| *value)
    }
}

/// Runs code that no interrupt may divide.
fn without_interrupts<R>(run: impl FnOnce() -> R) -> R {
    let status: u8;
    // SAFETY: saves the status register and switches interrupts off. The memory clobber, which `asm` has by default, keeps
    // accesses inside.
    unsafe { asm!("in {}, 0x3f", "cli", out(reg) status) };
    let result = run();
    // SAFETY: restores the interrupts as they were.
    unsafe { asm!("out 0x3f, {}", in(reg) status) };
    result
}

/// A static, so that `avr-size` counts it; on the stack it would not be counted.
struct Place<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: only `main` has a reference to it, and no interrupt.
unsafe impl<T> Sync for Place<T> {}

static ROBOT: Place<Robot> = Place(UnsafeCell::new(MaybeUninit::uninit()));
static BOARD: Place<Board> = Place(UnsafeCell::new(MaybeUninit::uninit()));

/// Survives a reset: [`PANICKED`] or [`STUCK`] if the program had to end.
#[unsafe(link_section = ".noinit")]
// SAFETY: `.noinit` is a section of RAM that the start-up code leaves as it is; any bits are a `u32`.
static mut NOTE: MaybeUninit<u32> = MaybeUninit::uninit();

const PANICKED: u32 = 0x9A71_B0A7;
const STUCK: u32 = 0x57C4_10D6;

fn note() -> u32 {
    // SAFETY: any bits are a `u32`, and this is no reference.
    unsafe { addr_of!(NOTE).cast::<u32>().read_volatile() }
}

fn set_note(note: u32) {
    // SAFETY: there is no reference to it, and interrupts use it only when the program does not come back.
    unsafe { addr_of_mut!(NOTE).cast::<u32>().write_volatile(note) }
}

/// Entry point, called by the start-up code of avr-libc.
// SAFETY: the start-up code calls `main`, once, and has no other function of this name.
#[unsafe(no_mangle)]
extern "C" fn main() -> ! {
    let reasons = MCUSR.read();
    MCUSR.write(0);
    // A watchdog stays on through its reset, with its shortest time.
    set_watchdog(0);
    // A bootloader may have cleared the reasons: the note tells of panics and of the watchdog nevertheless.
    let note = note();
    set_note(0);
    let restart = if reasons & POWER_ON_RESET != 0 {
        Restart::PowerOn
    } else if reasons & BROWN_OUT_RESET != 0 {
        Restart::BrownOut
    } else if note == PANICKED {
        Restart::Panic
    } else if note == STUCK || reasons & WATCHDOG_RESET != 0 {
        Restart::Watchdog
    } else {
        Restart::PowerOn
    };
    // SAFETY: `main` is entered once, so these are the only references to `ROBOT` and `BOARD`.
    let (robot, board) = unsafe { (&mut *ROBOT.0.get(), &mut *BOARD.0.get()) };
    crate::run(robot, board, restart)
}

/// Switches the motors off and resets the chip.
pub fn panic() -> ! {
    end(PANICKED)
}

fn end(note: u32) -> ! {
    // SAFETY: the program does not come back, so interrupts must not either.
    unsafe { asm!("cli") };
    crate::motors::switch_off();
    set_note(note);
    set_watchdog(WATCHDOG_RESETS);
    loop {}
}

/// Bits of the watchdog: it resets the chip, after 16 ms; it interrupts first; after 125 ms, two ticks and a half.
const WATCHDOG_RESETS: u8 = 1 << 3;
const WATCHDOG_INTERRUPTS: u8 = 1 << 6;
const WATCHDOG_TICKS: u8 = 0b011;

/// The watchdog: the program has missed its ticks. With interrupts off it resets the chip 125 ms later.
// SAFETY: the name puts it into the interrupt vectors of avr-libc, which call it with this convention.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_12() {
    end(STUCK)
}

fn set_watchdog(control: u8) {
    const CHANGES: u8 = 1 << 4 | WATCHDOG_RESETS;
    without_interrupts(|| {
        feed_watchdog();
        // SAFETY: the chip takes the new value within four cycles of the first write to WDTCSR, its address 0x60.
        unsafe { asm!("sts 0x60, {}", "sts 0x60, {}", in(reg) CHANGES, in(reg) control) };
    });
}

/// Switches the watchdog on. [`feed_watchdog`] is due within 125 ms.
pub fn start_watchdog() {
    set_watchdog(WATCHDOG_RESETS | WATCHDOG_INTERRUPTS | WATCHDOG_TICKS);
}

/// Restarts the watchdog's time.
pub fn feed_watchdog() {
    // SAFETY: an instruction without operands that changes no memory.
    unsafe { asm!("wdr") };
}

/// Switches interrupts on.
pub fn enable_interrupts() {
    // SAFETY: called once everything that interrupts use is set up.
    unsafe { asm!("sei") };
}

/// Sleeps until the next interrupt, unless there has been one since `is_idle` was asked.
pub fn sleep_while(is_idle: impl FnOnce() -> bool) {
    const IDLE: u8 = 1;
    // SAFETY: `sei` takes effect after the next instruction, so no interrupt comes between the question and the sleep.
    unsafe { asm!("cli") };
    if is_idle() {
        SMCR.write(IDLE);
        // SAFETY: as above.
        unsafe { asm!("sei", "sleep") };
        SMCR.write(0);
    } else {
        enable_interrupts();
    }
}

/// Waits ten microseconds: the trigger of an HC-SR04.
pub fn wait_10_us() {
    // SAFETY: counts down a register: 53 turns of three cycles.
    unsafe { asm!("1: dec {0}", "brne 1b", inout(reg) 53u8 => _) };
}

/// Tells an emulator a byte of the program's calls and results. Nothing else reads this register.
pub fn trace(byte: u8) {
    GPIOR1.write(byte);
}

// Clock: timer 4 counts 4 us, and its channel A interrupts every 2 ms.

static BASE: Shared<u8> = Shared::new(0);

/// Starts timers 4 and 5, the clock and the captures.
pub fn start_clock() {
    TCCR4A.write(0);
    TCCR4B.write(CANCELS_NOISE | CAPTURES_RISE | PRESCALER_64);
    TCCR5A.write(0);
    TCCR5B.write(CANCELS_NOISE | CAPTURES_RISE | PRESCALER_64);
    OCR4A.write(COUNTS_PER_BASE);
    TIMSK4.write(ON_CAPTURE | ON_A);
    TIMSK5.write(ON_CAPTURE);
}

/// Periods of the clock since the start, modulo 256.
pub fn base() -> u8 {
    BASE.get()
}

/// Counts of 4 us since the start, modulo 65,536.
pub fn counts() -> u16 {
    TCNT4.read()
}

/// Timer 4, channel A: a period of the clock has passed.
// SAFETY: the name puts it into the interrupt vectors of avr-libc, which call it with this convention.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_42() {
    OCR4A.write(OCR4A.read().wrapping_add(COUNTS_PER_BASE));
    BASE.change(|base| *base = base.wrapping_add(1));
}

// Encoders.

static EDGES: [Shared<u16>; 2] = [Shared::new(0), Shared::new(0)];

/// Counts the edges of both encoders from now on.
pub fn start_encoders() {
    const ANY_EDGE_OF_4_AND_5: u8 = 0b0101;
    EICRB.write(ANY_EDGE_OF_4_AND_5);
    EIFR.write(0b0011_0000);
    EIMSK.write(0b0011_0000);
}

/// Edges of an encoder since the start, modulo 65,536.
pub fn edges(side: Side) -> u16 {
    match side {
        Side::Left => EDGES[0].get(),
        Side::Right => EDGES[1].get(),
    }
}

/// Input 4: the left encoder.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_5() {
    EDGES[0].change(|edges| *edges = edges.wrapping_add(1));
}

/// Input 5: the right encoder.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_6() {
    EDGES[1].change(|edges| *edges = edges.wrapping_add(1));
}

// Sonars: an echo pin is high as long as the sound was under way.

/// A pulse on an echo pin, in counts.
#[derive(Clone, Copy)]
struct Pulse {
    began: u16,
    length: Option<u16>,
}

const NO_PULSE: Pulse = Pulse {
    began: 0,
    length: None,
};

static PULSES: [Shared<Pulse>; 2] = [Shared::new(NO_PULSE), Shared::new(NO_PULSE)];

/// Forgets the latest pulse of an echo pin and waits for the next one.
pub fn expect_echo(side: Side) {
    let (pulse, control, flags) = match side {
        Side::Left => (&PULSES[0], TCCR4B, TIFR4),
        Side::Right => (&PULSES[1], TCCR5B, TIFR5),
    };
    pulse.change(|pulse| {
        pulse.length = None;
        control.write(control.read() | CAPTURES_RISE);
        flags.write(ON_CAPTURE);
    });
}

/// Length of the pulse since [`expect_echo`] in microseconds; `None` if none has ended.
pub fn echo_us(side: Side) -> Option<u32> {
    const COUNT_US: u32 = 4;
    let pulse = match side {
        Side::Left => &PULSES[0],
        Side::Right => &PULSES[1],
    };
    pulse
        .get()
        .length
        .map(|counts| u32::from(counts) * COUNT_US)
}

fn capture(pulse: &Shared<Pulse>, control: Register, time: Pair, flags: Register) {
    let (now, edge) = (time.read(), control.read());
    control.write(edge ^ CAPTURES_RISE);
    // Changing the edge may raise the interrupt.
    flags.write(ON_CAPTURE);
    pulse.change(|pulse| {
        if edge & CAPTURES_RISE != 0 {
            pulse.began = now;
        } else {
            pulse.length = Some(now.wrapping_sub(pulse.began));
        }
    });
}

/// Capture of timer 4: the left echo.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_41() {
    capture(&PULSES[0], TCCR4B, ICR4, TIFR4);
}

/// Capture of timer 5: the right echo.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_46() {
    capture(&PULSES[1], TCCR5B, ICR5, TIFR5);
}

// Radio: serial port 1.

/// Room for received bytes: at 57,600 bits a second the longest tick receives fewer.
const RING_BYTES: usize = 64;

/// Received bytes that the program has not taken.
#[derive(Clone, Copy)]
struct Ring {
    bytes: [u8; RING_BYTES],
    first: u8,
    count: u8,
}

static RECEIVED: Shared<Ring> = Shared::new(Ring {
    bytes: [0; RING_BYTES],
    first: 0,
    count: 0,
});

/// Starts the serial port with a divisor of the clock: eight times the bit's cycles, less one.
pub fn start_radio(divisor: u16) {
    UCSR1A.write(DOUBLE_SPEED);
    UCSR1C.write(EIGHT_BITS);
    UBRR1.write(divisor);
    UCSR1B.write(RECEIVES_AND_SENDS | ON_RECEIVED);
}

/// Whether the radio can take a byte.
pub fn can_send() -> bool {
    UCSR1A.read() & DATA_EMPTY != 0
}

/// Sends a byte; [`can_send`] must be true. The program is woken when it can send another.
pub fn send(byte: u8) {
    UDR1.write(byte);
    UCSR1B.write(RECEIVES_AND_SENDS | ON_RECEIVED | DATA_EMPTY);
}

/// The next received byte.
pub fn receive() -> Option<u8> {
    RECEIVED.change(|ring| {
        ring.count = ring.count.checked_sub(1)?;
        let byte = ring.bytes.get(usize::from(ring.first)).copied();
        ring.first = (ring.first + 1) % RING_BYTES as u8;
        byte
    })
}

/// Whether no byte has been received that the program has not taken.
pub fn has_none_received() -> bool {
    RECEIVED.change(|ring| ring.count == 0)
}

/// Serial port 1: a byte has been received. A full ring loses it: its line's checksum is then wrong.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_36() {
    let byte = UDR1.read();
    RECEIVED.change(|ring| {
        let place = usize::from(ring.first + ring.count) % RING_BYTES;
        if usize::from(ring.count) < RING_BYTES
            && let Some(room) = ring.bytes.get_mut(place)
        {
            *room = byte;
            ring.count += 1;
        }
    });
}

/// Serial port 1: it can take a byte.
// SAFETY: as above.
#[unsafe(no_mangle)]
extern "avr-interrupt" fn __vector_37() {
    UCSR1B.write(RECEIVES_AND_SENDS | ON_RECEIVED);
}

// EEPROM.

/// Whether the EEPROM has finished its latest write, which takes 3.4 ms.
pub fn eeprom_is_ready() -> bool {
    EECR.read() & WRITES == 0
}

/// A byte of the EEPROM; [`eeprom_is_ready`] must be true.
pub fn read_eeprom(address: u16) -> u8 {
    EEAR.write(address);
    EECR.write(READS);
    EEDR.read()
}

/// Begins to write a byte of the EEPROM; [`eeprom_is_ready`] must be true.
pub fn write_eeprom(address: u16, byte: u8) {
    EEAR.write(address);
    EEDR.write(byte);
    without_interrupts(|| {
        // SAFETY: the chip begins to write if the second bit of EECR is set within four cycles of the third. EEAR and EEDR
        // are set, and no memory of the program changes.
        unsafe { asm!("sbi 0x1f, 2", "sbi 0x1f, 1") };
    });
}
