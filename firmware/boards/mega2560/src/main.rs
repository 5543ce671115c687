//! The SR04 on an Arduino Mega 2560: docs/mega.md of the repository has its parts, wiring and first steps.
//!
//! Start at [`run`]. `registers` is the chip and has all `unsafe` code; `config` says what is wired.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt, asm_experimental_arch)]

mod analog;
mod config;
mod display;
mod memory;
mod motors;
#[path = "../../probe/src/multiply.rs"]
mod multiply;
mod outputs;
mod radio;
mod registers;
mod sensors;

use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use sr04_firmware::board::{BASE_PER_LOOK, BASE_PER_TICK, Identity, Inputs, Restart, Sides};
use sr04_firmware::parameters::Parameters;
use sr04_firmware::robot::Robot;
use sr04_replay::{Call, Port, write_downlink, write_leds, write_outputs};

use analog::Analog;
use display::Display;
use memory::Memory;
use radio::Radio;
use sensors::Sensors;

/// Cycles of the processor per second.
pub const CLOCK_HZ: u32 = 16_000_000;

/// The calls and results of the robot's program, for an emulator that compares them with a host's.
struct Trace;

impl Port for Trace {
    fn read(&mut self) -> u8 {
        0
    }

    fn write(&mut self, byte: u8) {
        registers::trace(byte);
    }
}

/// Everything around the robot's program.
pub struct Board {
    analog: Analog,
    sensors: Sensors,
    memory: Memory,
    radio: Radio,
    display: Display,
    /// Periods of the clock at the latest tick, look and reading of an analogue input.
    ticked: u8,
    looked: u8,
    converted: u8,
}

/// Runs the robot for ever.
pub fn run(robot: &mut MaybeUninit<Robot>, board: &mut MaybeUninit<Board>, restart: Restart) -> ! {
    motors::start();
    outputs::start();
    let (robot, board) = switch_on(robot, board, restart);
    registers::enable_interrupts();
    registers::start_watchdog();
    loop {
        board.step(robot);
        registers::sleep_while(|| board.is_idle());
    }
}

/// Sets up the board and creates the robot in its static. A separate function keeps a second robot off the main loop's
/// stack.
#[inline(never)]
fn switch_on<'a>(
    robot: &'a mut MaybeUninit<Robot>,
    board: &'a mut MaybeUninit<Board>,
    restart: Restart,
) -> (&'a mut Robot, &'a mut Board) {
    let boots = memory::count_boot();
    let (memory, parameters) = Memory::open();
    let board = board.write(Board {
        analog: Analog::start(),
        sensors: Sensors::start(),
        memory,
        radio: Radio::start(),
        display: Display::start(),
        ticked: 0,
        looked: 0,
        converted: 0,
    });
    registers::start_clock();
    let identity = Identity {
        robot_id: config::ROBOT_ID,
        boots,
        rng_seed: u32::from(boots).wrapping_mul(0x9E37_79B1),
        duplex: config::DUPLEX,
        fitted: config::FITTED,
        restart,
    };
    (create(robot, identity, &parameters), board)
}

#[inline(never)]
fn create<'a>(
    place: &'a mut MaybeUninit<Robot>,
    identity: Identity,
    parameters: &Parameters,
) -> &'a mut Robot {
    Call::Boot(identity, parameters).write(&mut Trace);
    place.write(Robot::restored(identity, parameters.clone()))
}

impl Board {
    /// Does what is due.
    #[inline(never)]
    fn step(&mut self, robot: &mut Robot) {
        let now = registers::base();
        if now.wrapping_sub(self.looked) >= BASE_PER_LOOK {
            self.looked = now;
            look(robot);
        }
        if now != self.converted {
            self.converted = now;
            self.analog.step();
            self.display.step();
        }
        let since = now.wrapping_sub(self.ticked);
        if since >= BASE_PER_TICK {
            self.ticked = self.ticked.wrapping_add(BASE_PER_TICK);
            registers::feed_watchdog();
            self.tick(robot, since >= 2 * BASE_PER_TICK);
        }
        while let Some(byte) = registers::receive() {
            receive(robot, byte);
        }
        if self.radio.is_due() {
            self.send(robot);
        }
        self.memory.step();
    }

    fn is_idle(&self) -> bool {
        registers::base() == self.converted
            && registers::has_none_received()
            && !self.radio.is_due()
    }

    #[inline(never)]
    fn send(&mut self, robot: &mut Robot) {
        Call::Downlink.write(&mut Trace);
        let byte = robot.poll_downlink();
        self.radio.take(byte);
        write_downlink(&mut Trace, byte);
    }

    #[inline(never)]
    fn tick(&mut self, robot: &mut Robot, is_late: bool) {
        let inputs: Inputs = self.sensors.read(&self.analog, is_late);
        Call::Tick(&inputs).write(&mut Trace);
        let outputs = robot.tick(&inputs);
        motors::drive(outputs.pwm_left, outputs.pwm_right);
        outputs::beep(outputs.note_hz);
        outputs::raise_arm(outputs.arm_up);
        if let Some(side) = outputs.ping {
            self.sensors.ping(side);
        }
        if outputs.keep_parameters {
            self.memory.keep(robot.parameters());
        }
        write_outputs(&mut Trace, outputs, robot.parameters());
        self.display.show(robot, &inputs);
    }
}

/// Looks at the infrared receivers for the half cycle that has ended.
fn look(robot: &mut Robot) {
    let Sides { left, right } = sensors::infrared();
    Call::Infrared(Sides { left, right }).write(&mut Trace);
    let leds_on = robot.infrared_sample(left, right);
    outputs::light(leds_on);
    write_leds(&mut Trace, leds_on);
}

#[inline(never)]
fn receive(robot: &mut Robot, byte: u8) {
    Call::Uplink(byte).write(&mut Trace);
    robot.handle_uplink(byte);
}

/// Stops the motors and resets the board. Using the argument would link `core::fmt`, which this target miscompiles.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    registers::panic()
}
