//! The SR04 on a Raspberry Pi Pico: docs/mega.md of the repository compares it with the Mega.
//!
//! | what | pins |
//! |---|---|
//! | radio: to it, from it | GP0, GP1 |
//! | motors: pulse widths left, right; directions | GP2, GP3; GP4 to GP7 |
//! | encoders left, right | GP8, GP9 |
//! | infrared LEDs, servo, beeper | GP10, GP12, GP14 |
//! | sonars: triggers left, right; echoes | GP13, GP15; GP16, GP17 (behind a divider: 3.3 V) |
//! | infrared receivers left, right | GP18, GP19 |
//! | bumper left, centre, right | GP20, GP21, GP22 |
//! | photocells left, right; battery | GP26, GP27; GP28 |
//! | front edge | GP11 |
#![no_std]
#![no_main]

mod config;
mod edges;
mod memory;

use core::panic::PanicInfo;

use cortex_m::asm;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::pwm::SetDutyCycle;
use embedded_hal_0_2::adc::OneShot;
use rp2040_hal::adc::AdcPin;
use rp2040_hal::clocks::{Clock, init_clocks_and_plls};
use rp2040_hal::fugit::{ExtU32, RateExtU32};
use rp2040_hal::gpio::Pins;
use rp2040_hal::pwm::Slices;
use rp2040_hal::uart::{DataBits, StopBits, UartConfig, UartPeripheral};
use rp2040_hal::watchdog::ScratchRegister;
use rp2040_hal::{Adc, Sio, Timer, Watchdog, pac};
use sr04_firmware::board::{
    BASE_HZ, BASE_PER_LOOK, BASE_PER_TICK, CountScaler, Echo, Edges, Identity, Inputs, Restart,
    Side, Switches,
};
use sr04_firmware::robot::Robot;

use memory::Memory;

/// The second stage of the boot, for the Pico's flash chip.
#[unsafe(link_section = ".boot2")]
#[used]
// SAFETY: the section is the one that the chip's boot program reads, and this is its content.
pub static BOOT2_FIRMWARE: [u8; 256] = rp2040_boot2::BOOT_LOADER_W25Q080;

const CRYSTAL_HZ: u32 = 12_000_000;

/// Microseconds of a period of the clock.
const BASE_US: u64 = 1_000_000 / BASE_HZ as u64;

/// Microseconds of a byte: start, eight bits, stop.
const BYTE_US: u64 = 10_000_000 / config::BAUD as u64;

/// Content of a register that survives a reset, after a panic.
const PANICKED: u32 = 0x9A71_B0A7;

/// Content of another one once the program has begun.
const RUNNING: u32 = 0x57C4_10D6;

/// Time of the watchdog: erasing a sector of the flash takes up to 400 ms.
const WATCHDOG_MS: u32 = 500;

/// Lowest tone of the beeper.
const LEAST_HZ: u16 = 20;

/// Carrier of the infrared LEDs.
const CARRIER_HZ: u32 = 38_000;
/// Period of the servo's pulses, and the pulses with the arm stowed and raised.
const SERVO_PERIOD_US: u16 = 20_000;
const SERVO_STOWED_US: u16 = 1000;
const SERVO_RAISED_US: u16 = 2000;

/// Ticks from a ping to its echo.
const ECHO_TICKS: u8 = 2;

fn is_high(pin: &mut impl InputPin) -> bool {
    matches!(pin.is_high(), Ok(true))
}

fn set(pin: &mut impl OutputPin, level: bool) {
    // These pins cannot fail.
    let _ = pin.set_state(level.into());
}

fn set_width(channel: &mut impl SetDutyCycle, width: u16) {
    // A width above the top is full.
    let _ = channel.set_duty_cycle(width);
}

/// Entry point.
#[rp2040_hal::entry]
fn main() -> ! {
    let Some(mut pac) = pac::Peripherals::take() else {
        restart();
    };
    // Zero after a reset by the hardware.
    let by_watchdog = pac.WATCHDOG.reason().read().bits() != 0;
    let mut watchdog = Watchdog::new(pac.WATCHDOG);
    let reason = reason(&mut watchdog, by_watchdog);
    let Ok(clocks) = init_clocks_and_plls(
        CRYSTAL_HZ,
        pac.XOSC,
        pac.CLOCKS,
        pac.PLL_SYS,
        pac.PLL_USB,
        &mut pac.RESETS,
        &mut watchdog,
    ) else {
        restart();
    };
    let timer = Timer::new(pac.TIMER, &mut pac.RESETS, &clocks);
    let sio = Sio::new(pac.SIO);
    let pins = Pins::new(
        pac.IO_BANK0,
        pac.PADS_BANK0,
        sio.gpio_bank0,
        &mut pac.RESETS,
    );
    let clock_hz = clocks.system_clock.freq().to_Hz();

    // Motors: 8 bits at 31 kHz.
    let slices = Slices::new(pac.PWM, &mut pac.RESETS);
    let mut motors = slices.pwm1;
    motors.set_top(254);
    motors.set_div_int((clock_hz / 255 / 31_000) as u8);
    motors.channel_a.output_to(pins.gpio2);
    motors.channel_b.output_to(pins.gpio3);
    set_width(&mut motors.channel_a, 0);
    set_width(&mut motors.channel_b, 0);
    motors.enable();
    let mut left = [
        pins.gpio4.into_push_pull_output().into_dyn_pin(),
        pins.gpio5.into_push_pull_output().into_dyn_pin(),
    ];
    let mut right = [
        pins.gpio6.into_push_pull_output().into_dyn_pin(),
        pins.gpio7.into_push_pull_output().into_dyn_pin(),
    ];

    let mut leds = slices.pwm5;
    let carrier_top = (clock_hz / CARRIER_HZ - 1) as u16;
    leds.set_top(carrier_top);
    leds.channel_a.output_to(pins.gpio10);
    set_width(&mut leds.channel_a, 0);
    leds.enable();
    let mut servo = slices.pwm6;
    servo.set_div_int((clock_hz / 1_000_000) as u8);
    servo.set_top(SERVO_PERIOD_US - 1);
    servo.channel_a.output_to(pins.gpio12);
    set_width(&mut servo.channel_a, SERVO_STOWED_US);
    servo.enable();
    let mut beeper = slices.pwm7;
    beeper.set_div_int((clock_hz / 1_000_000) as u8);
    beeper.channel_a.output_to(pins.gpio14);
    set_width(&mut beeper.channel_a, 0);
    beeper.enable();

    let mut triggers = [
        pins.gpio13.into_push_pull_output().into_dyn_pin(),
        pins.gpio15.into_push_pull_output().into_dyn_pin(),
    ];
    edges::start(
        timer,
        [
            pins.gpio8.into_pull_up_input().into_dyn_pin(),
            pins.gpio9.into_pull_up_input().into_dyn_pin(),
        ],
        [
            pins.gpio16.into_pull_down_input().into_dyn_pin(),
            pins.gpio17.into_pull_down_input().into_dyn_pin(),
        ],
    );
    let mut edge = pins.gpio11.into_pull_up_input();
    let mut receivers = [
        pins.gpio18.into_pull_up_input().into_dyn_pin(),
        pins.gpio19.into_pull_up_input().into_dyn_pin(),
    ];
    let mut bumper = [
        pins.gpio20.into_pull_up_input().into_dyn_pin(),
        pins.gpio21.into_pull_up_input().into_dyn_pin(),
        pins.gpio22.into_pull_up_input().into_dyn_pin(),
    ];
    let mut adc = Adc::new(pac.ADC, &mut pac.RESETS);
    let (Ok(mut photo_left), Ok(mut photo_right), Ok(mut battery)) = (
        AdcPin::new(pins.gpio26.into_floating_input()),
        AdcPin::new(pins.gpio27.into_floating_input()),
        AdcPin::new(pins.gpio28.into_floating_input()),
    ) else {
        restart();
    };
    let format = UartConfig::new(config::BAUD.Hz(), DataBits::Eight, None, StopBits::One);
    let radio_pins = (pins.gpio0.into_function(), pins.gpio1.into_function());
    let Ok(mut radio) = UartPeripheral::new(pac.UART0, radio_pins, &mut pac.RESETS)
        .enable(format, clocks.peripheral_clock.freq())
    else {
        restart();
    };
    // With its queue the radio would take bytes long before it sends them.
    radio.set_fifos(false);

    let boots = memory::count_boot();
    let (mut memory, parameters) = Memory::open();
    let identity = Identity {
        robot_id: config::ROBOT_ID,
        boots,
        rng_seed: u32::from(boots).wrapping_mul(0x9E37_79B1),
        duplex: config::DUPLEX,
        fitted: config::FITTED,
        restart: reason,
    };
    let mut robot = Robot::restored(identity, parameters);
    let mut scalers =
        [(); 2].map(|()| CountScaler::new(config::EDGES_PER_TURN, config::WHEEL_IN_1000));
    let mut counted = [0; 2];
    let mut ping: Option<(Side, u8)> = None;
    let begin_us = timer.get_counter().ticks();
    let (mut looked, mut ticked, mut byte_us) = (0, 0, begin_us);
    let mut is_idle = true;
    watchdog.start(WATCHDOG_MS.millis());
    loop {
        let now_us = timer.get_counter().ticks();
        let base = (now_us - begin_us) / BASE_US;
        if base - looked >= u64::from(BASE_PER_LOOK) {
            looked = base;
            let [left, right] = &mut receivers;
            let is_lit = robot.infrared_sample(!is_high(left), !is_high(right));
            set_width(
                &mut leds.channel_a,
                if is_lit { carrier_top / 2 } else { 0 },
            );
        }
        if base - ticked >= u64::from(BASE_PER_TICK) {
            let is_late = base - ticked >= 2 * u64::from(BASE_PER_TICK);
            ticked += u64::from(BASE_PER_TICK);
            watchdog.feed();
            let counts = [Side::Left, Side::Right].map(|side| {
                let (scaler, counted) = (&mut scalers[side as usize], &mut counted[side as usize]);
                let edges = edges::count(side);
                let new = edges.wrapping_sub(*counted);
                *counted = edges;
                scaler.counts(new)
            });
            let sonar = match ping {
                Some((side, 1)) => {
                    ping = None;
                    Some(Echo::after_us(side, edges::echo_us(side)))
                }
                Some((side, ticks)) => {
                    ping = Some((side, ticks - 1));
                    None
                }
                None => None,
            };
            let photo = |reading: Result<u16, _>| reading.ok().map(|reading| (reading >> 4) as u8);
            let battery_dv = adc.read(&mut battery).map_or(0, |reading: u16| {
                (u32::from(reading) * config::BATTERY_FULL_DV) >> 12
            });
            let [bumper_left, bumper_center, bumper_right] = &mut bumper;
            let inputs = Inputs {
                counts_left: counts[0],
                counts_right: counts[1],
                bumper: Switches {
                    left: !is_high(bumper_left),
                    center: !is_high(bumper_center),
                    right: !is_high(bumper_right),
                },
                sonar,
                photo_left: photo(adc.read(&mut photo_left)),
                photo_right: photo(adc.read(&mut photo_right)),
                battery_dv: battery_dv as u8,
                cliff: Some(if is_high(&mut edge) {
                    Edges::AHEAD
                } else {
                    Edges::NONE
                }),
                is_late,
                ..Inputs::default()
            };
            let outputs = robot.tick(&inputs);
            drive(&mut left, &mut motors.channel_a, outputs.pwm_left);
            drive(&mut right, &mut motors.channel_b, outputs.pwm_right);
            set_width(
                &mut servo.channel_a,
                if outputs.arm_up {
                    SERVO_RAISED_US
                } else {
                    SERVO_STOWED_US
                },
            );
            let period_us = 1_000_000 / u32::from(outputs.note_hz.max(LEAST_HZ));
            beeper.set_top((period_us - 1) as u16);
            let has_tone = outputs.note_hz > 0;
            set_width(
                &mut beeper.channel_a,
                if has_tone { (period_us / 2) as u16 } else { 0 },
            );
            if let Some(side) = outputs.ping {
                edges::expect_echo(side);
                let trigger = &mut triggers[side as usize];
                set(trigger, true);
                asm::delay(clock_hz / 100_000);
                set(trigger, false);
                ping = Some((side, ECHO_TICKS));
            }
            if outputs.keep_parameters {
                memory.keep(robot.parameters());
            }
        }
        let mut byte = [0];
        if radio.uart_is_readable() && radio.read_raw(&mut byte).is_ok() {
            robot.handle_uplink(byte[0]);
        }
        // While the robot sends, the radio sets the pace; idle byte times are counted by the clock.
        if radio.uart_is_writable() && (!is_idle || now_us >= byte_us) {
            let sent = robot.poll_downlink();
            byte_us = if is_idle { byte_us } else { now_us } + BYTE_US;
            is_idle = sent.is_none();
            if let Some(byte) = sent {
                // It is writable.
                let _ = radio.write_raw(&[byte]);
            }
        }
    }
}

/// Drives a motor: forward and backward pins, and the pulse width.
fn drive(pins: &mut [impl OutputPin; 2], width: &mut impl SetDutyCycle, pwm: i16) {
    let [forward, backward] = pins;
    set(forward, pwm > 0);
    set(backward, pwm < 0);
    set_width(width, pwm.unsigned_abs());
}

/// Reason of this boot. A brown-out counts as power: the chip has one flag for both, and it stays set over resets by the
/// watchdog.
fn reason(watchdog: &mut Watchdog, by_watchdog: bool) -> Restart {
    let has_panicked = watchdog.read_scratch(ScratchRegister::Scratch0) == PANICKED;
    let has_bitten = watchdog.read_scratch(ScratchRegister::Scratch1) == RUNNING;
    watchdog.write_scratch(ScratchRegister::Scratch0, 0);
    watchdog.write_scratch(ScratchRegister::Scratch1, RUNNING);
    if by_watchdog && has_panicked {
        Restart::Panic
    } else if by_watchdog && has_bitten {
        Restart::Watchdog
    } else {
        Restart::PowerOn
    }
}

/// Resets the chip: all its pins float, and the motors stop.
fn restart() -> ! {
    const TRIGGER: u32 = 1 << 31;
    // SAFETY: the program does not come back, so nothing else uses the watchdog's registers.
    let watchdog = unsafe { &*pac::WATCHDOG::ptr() };
    // SAFETY: any bits are a scratch value.
    watchdog
        .scratch0()
        .write(|bits| unsafe { bits.bits(PANICKED) });
    // SAFETY: the bit resets the chip at once.
    watchdog.ctrl().write(|bits| unsafe { bits.bits(TRIGGER) });
    loop {
        asm::nop();
    }
}

/// Resets the board; the robot tells it after the boot.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    restart()
}
